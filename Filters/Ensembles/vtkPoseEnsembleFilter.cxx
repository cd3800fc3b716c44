// SPDX-License-Identifier: BSD-3-Clause
#include "vtkPoseEnsembleFilter.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "EnsembleCopies.h"
#include "FilterSupport.h"
#include "MeshProcessing/Poses/SurfacePoses.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"

#include <vtkAlgorithmOutput.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <utility>

using surfsynth::PointMatrix;
using surfsynth::PoseHandleOptions;
using surfsynth::PoseHandles;
using surfsynth::PoseOptions;
using surfsynth::Surface;
using surfsynth::SurfacePoses;

vtkStandardNewMacro(vtkPoseEnsembleFilter);

namespace
{
const surfsynth::BlockTypes SurfaceToPoses{ { "vtkPolyData" }, "vtkMultiBlockDataSet" };

surfsynth::MeshRequirements Requirements()
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  requirements.SingleComponent = true;
  return requirements;
}

/// Properties that the poses of a block depend on, beside its mesh.
struct PoseKey
{
  std::uint64_t TemplateHash = 0;
  PoseHandleOptions Handles;
  PoseOptions Options;
};

bool Same(const PoseKey& a, const PoseKey& b)
{
  return a.TemplateHash == b.TemplateHash && a.Handles.NumberOfHandles == b.Handles.NumberOfHandles &&
    a.Handles.HandleRadius == b.Handles.HandleRadius && a.Handles.AnchorRadius == b.Handles.AnchorRadius &&
    a.Handles.PivotPosition == b.Handles.PivotPosition && a.Options.MaximumAngle == b.Options.MaximumAngle &&
    a.Options.MaximumTwist == b.Options.MaximumTwist && a.Options.NumberOfIterations == b.Options.NumberOfIterations &&
    a.Options.Stiffness == b.Options.Stiffness;
}

/// Equations on one mesh.
struct PreparedPoses
{
  PoseKey Key;
  std::shared_ptr<const SurfacePoses> Poses;
};
} // namespace

/// Equations of the last update, and the work of one update.
class vtkPoseEnsembleFilter::Internals
{
public:
  explicit Internals(vtkPoseEnsembleFilter* self)
    : Self(self)
  {}

  /// Starts an update with a template, or null.
  void Begin(vtkSmartPointer<vtkPolyData> shape)
  {
    this->Template = std::move(shape);
    this->ConvertedTemplate.reset();
    this->Blocks.Begin();
  }

  /// Ends an update: forgets what it has not used.
  void End()
  {
    this->ConvertedTemplate.reset();
    this->Blocks.DropUnused();
  }

  void MakePoses(const surfsynth::Block& block, const surfsynth::Progress& progress)
  {
    auto* input = vtkPolyData::SafeDownCast(block.Input);
    Surface surface = surfsynth::ToSurface(input, Requirements());
    surface.FlatIndex = block.FlatIndex;
    const SurfacePoses& poses = this->PosesOf(surface, surfsynth::SubProgress(progress, 0.02, 0.1));
    surfsynth::PoseRequest request;
    request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    request.FirstSample = static_cast<std::uint32_t>(this->Self->FirstSample);
    request.NumberOfSamples = static_cast<std::uint32_t>(this->Self->NumberOfSamples);
    request.Stream = block.FlatIndex;
    std::vector<PointMatrix> points(request.NumberOfSamples);
    const auto keep = [&](std::uint32_t sample, PointMatrix pose) {
      points[sample - request.FirstSample] = std::move(pose);
    };
    poses.Sample(request, keep, surfsynth::SubProgress(progress, 0.1, 0.98));
    this->Fill(input, surface, poses, points, vtkMultiBlockDataSet::SafeDownCast(block.Output),
      surfsynth::SubProgress(progress, 0.98, 1.0));
  }

  surfsynth::BlockCache<PreparedPoses> Blocks;
  vtkTypeInt64 NumberOfFactorizations = 0;

private:
  PoseKey KeyOf(const Surface& shape) const
  {
    PoseKey key;
    key.TemplateHash = shape.MeshHash();
    key.Handles.NumberOfHandles = this->Self->NumberOfHandles;
    key.Handles.HandleRadius = this->Self->HandleRadius;
    key.Handles.AnchorRadius = this->Self->AnchorRadius;
    key.Handles.PivotPosition = this->Self->PivotPosition;
    key.Options.MaximumAngle = this->Self->MaximumAngle;
    key.Options.MaximumTwist = this->Self->MaximumTwist;
    key.Options.NumberOfIterations = this->Self->NumberOfIterations;
    key.Options.Stiffness = this->Self->Stiffness;
    return key;
  }

  const SurfacePoses& PosesOf(const Surface& surface, const surfsynth::Progress& progress)
  {
    const std::shared_ptr<const Surface> pattern = this->TemplateSurface();
    const PoseKey key = this->KeyOf(pattern ? *pattern : surface);
    if (const auto* held = this->Blocks.Find(surface, [&](const PreparedPoses& found) { return Same(found.Key, key); }))
    {
      return *held->Poses;
    }
    this->Blocks.Drop(surface);
    // Shared with the work, which outlives this call when it is cancelled.
    const auto mesh = std::make_shared<const Surface>(surface);
    const auto shape = pattern ? pattern : mesh;
    const auto made = std::make_shared<std::shared_ptr<const SurfacePoses>>();
    const auto work = [mesh, shape, key, made] {
      // Not the function itself: volumes have one of the same name.
      const surfsynth::PlaceFinder finder = [](const surfsynth::TriangleMesh& surface, const PointMatrix& points) {
        return surfsynth::FindNearestPlaces(surface, points);
      };
      const PoseHandles handles(shape->Mesh, *shape->Topology, key.Handles, finder);
      *made = std::make_shared<const SurfacePoses>(mesh->Mesh, handles, key.Options);
    };
    surfsynth::RunCancellable(work, 0.1 + 2e-5 * mesh->Mesh.NumberOfPoints(), progress);
    ++this->NumberOfFactorizations;
    return *this->Blocks.Insert(surface, { key, *made }).Poses;
  }

  /// Returns the template, converted at the first call of an update; null without a template.
  std::shared_ptr<const Surface> TemplateSurface()
  {
    try
    {
      if (this->Template && !this->ConvertedTemplate)
      {
        this->ConvertedTemplate = std::make_shared<const Surface>(surfsynth::ToSurface(this->Template, Requirements()));
      }
      return this->ConvertedTemplate;
    }
    catch (const surfsynth::InvalidInput& error)
    {
      throw surfsynth::InvalidInput(std::string("The template: ") + error.what());
    }
  }

  /// One deformed copy of @p input for each sample.
  void Fill(vtkPolyData* input, const Surface& surface, const SurfacePoses& poses, std::vector<PointMatrix>& points,
    vtkMultiBlockDataSet* output, const surfsynth::Progress& progress) const
  {
    vtkNew<vtkIntArray> regions;
    regions->SetName(this->Self->RegionArrayName.c_str());
    regions->SetNumberOfTuples(input->GetNumberOfPoints());
    std::copy(poses.Regions().begin(), poses.Regions().end(), regions->GetPointer(0));
    const surfsynth::CopyOptions options{ this->Self->DisplacementArrayName, this->Self->FirstSample,
      this->Self->Spread, ComputeBoundingBox(surface.Mesh) };
    const auto addRegions = [&regions](vtkPointSet* pose, std::size_t) { pose->GetPointData()->AddArray(regions); };
    surfsynth::FillWithCopies(output, input, surface.Mesh.Points, points, options, addRegions, progress);
  }

  vtkPoseEnsembleFilter* Self;
  vtkSmartPointer<vtkPolyData> Template;
  std::shared_ptr<const Surface> ConvertedTemplate; ///< of this update
};

vtkPoseEnsembleFilter::vtkPoseEnsembleFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkPoseEnsembleFilter::~vtkPoseEnsembleFilter() = default;

void vtkPoseEnsembleFilter::SetTemplateConnection(vtkAlgorithmOutput* port) { this->SetInputConnection(1, port); }

void vtkPoseEnsembleFilter::SetTemplateData(vtkDataObject* shape) { this->SetInputDataObject(1, shape); }

void vtkPoseEnsembleFilter::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

void vtkPoseEnsembleFilter::SetRegionArrayName(const char* name)
{
  surfsynth::SetString(this, this->RegionArrayName, name);
}

int vtkPoseEnsembleFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 0)
  {
    return surfsynth::AcceptBlocks(info, SurfaceToPoses);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return surfsynth::AcceptSurface(info);
}

int vtkPoseEnsembleFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, SurfaceToPoses);
}

int vtkPoseEnsembleFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  // Points and displacements, in double precision while they are made and afterwards in that of the input.
  const std::string problem = this->DisplacementArrayName.empty() || this->RegionArrayName.empty()
    ? "DisplacementArrayName or RegionArrayName is empty; names for the point arrays are needed."
    : surfsynth::ProblemOfMemory(
        vtkDataObject::GetData(inputVector[0]), { this->NumberOfSamples, 48.0, 0.0, 8192.0, this->MemoryLimit });
  if (!problem.empty())
  {
    surfsynth::ReportError(this, "", problem);
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  this->Impl->Begin(surfsynth::SurfaceOn(inputVector[1]));
  const auto makePoses = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
    this->Impl->MakePoses(block, progress);
  };
  const int success = surfsynth::ProcessBlocks(this, inputVector, outputVector, SurfaceToPoses, makePoses);
  this->Impl->End();
  return success;
}

vtkTypeInt64 vtkPoseEnsembleFilter::GetNumberOfFactorizations() const { return this->Impl->NumberOfFactorizations; }

void vtkPoseEnsembleFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Spread: " << this->Spread << "\n";
  os << indent << "NumberOfHandles: " << this->NumberOfHandles << "\n";
  os << indent << "MaximumAngle: " << this->MaximumAngle << "\n";
  os << indent << "MaximumTwist: " << this->MaximumTwist << "\n";
  os << indent << "HandleRadius: " << this->HandleRadius << "\n";
  os << indent << "AnchorRadius: " << this->AnchorRadius << "\n";
  os << indent << "PivotPosition: " << this->PivotPosition << "\n";
  os << indent << "NumberOfIterations: " << this->NumberOfIterations << "\n";
  os << indent << "Stiffness: " << this->Stiffness << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "RegionArrayName: " << this->RegionArrayName << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
}
