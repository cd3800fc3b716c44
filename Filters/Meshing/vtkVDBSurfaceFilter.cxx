// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVDBSurfaceFilter.h"

#include "BlockBridge.h"
#include "MeshProcessing/LevelSets/VolumeSurface.h"
#include "Reporting.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "VolumeImages.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <vector>

using surfsynth::Block;
using surfsynth::ImageLattice;
using surfsynth::LevelSetOptions;
using surfsynth::SubProgress;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkVDBSurfaceFilter);

namespace
{
const surfsynth::BlockTypes ImageOrSurfaceToSurface{ { "vtkImageData", "vtkPolyData" }, "vtkPolyData",
  "vtkDataSetSurfaceFilter extracts a surface, vtkResampleToImage an image" };

/// Samples and triangles converted to a surface in a second, for the estimate of progress.
constexpr double SamplesPerSecond = 2e7;
constexpr double TrianglesPerSecond = 2e5;

/// Runs @p make on another thread, which keeps its captures alive. OpenVDB stops soon after the user's abort.
TriangleMesh Interruptible(const std::function<TriangleMesh(const surfsynth::StopFlag&)>& make, double expectedSeconds,
  const surfsynth::Progress& progress)
{
  struct Shared
  {
    surfsynth::StopFlag Stop{ false };
    TriangleMesh Result;
  };
  auto shared = std::make_shared<Shared>();
  try
  {
    surfsynth::RunCancellable([shared, make] { shared->Result = make(shared->Stop); }, expectedSeconds, progress);
  }
  catch (...)
  {
    shared->Stop = true;
    throw;
  }
  return std::move(shared->Result);
}

void RequireFinite(const char* name, double value)
{
  if (!std::isfinite(value))
  {
    throw surfsynth::InvalidInput(
      std::string(name) + " is " + surfsynth::FormatNumber(value) + "; a finite number is needed.");
  }
}

/// Throws for points that are not finite: the only defect that a level set does not accept.
void RequireFinitePoints(const TriangleMesh& mesh)
{
  surfsynth::MeshRequirements none;
  none.ManifoldEdges = false;
  for (const surfsynth::MeshFinding& finding : surfsynth::CheckMesh(mesh, none))
  {
    if (finding.Defect == surfsynth::MeshDefect::NonFinitePoint)
    {
      throw surfsynth::InvalidInput("The mesh has " + surfsynth::DescribeFindings({ finding }));
    }
  }
}
} // namespace

/// Processing of one dataset.
class vtkVDBSurfaceFilter::Internals
{
public:
  explicit Internals(vtkVDBSurfaceFilter* self)
    : Self(self)
  {}

  void Process(const Block& block, const surfsynth::Progress& progress)
  {
    for (const auto& property : { std::make_pair("IsoValue", this->Self->IsoValue),
           std::make_pair("VoxelSize", this->Self->VoxelSize), std::make_pair("Closing", this->Self->Closing),
           std::make_pair("Offset", this->Self->Offset), std::make_pair("Adaptivity", this->Self->Adaptivity) })
    {
      RequireFinite(property.first, property.second);
    }
    auto* output = vtkPolyData::SafeDownCast(block.Output);
    if (auto* image = vtkImageData::SafeDownCast(block.Input))
    {
      this->FromImage(image, block, output, progress);
    }
    else
    {
      this->FromSurface(vtkPolyData::SafeDownCast(block.Input), block, output, progress);
    }
    surfsynth::Report(progress, 1.0);
  }

  double EffectiveIsoValue = 0.0;

private:
  void FromImage(vtkImageData* image, const Block& block, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    bool onCells = false;
    vtkDataArray* scalars = this->Scalars(image, onCells);
    const ImageLattice lattice(image, onCells);
    const surfsynth::ValueRange range = surfsynth::FiniteRange(scalars, SubProgress(progress, 0.0, 0.05));
    const double isoValue = this->Self->ComputeIsoValue
      ? surfsynth::OtsuThreshold(scalars, range, SubProgress(progress, 0.05, 0.1))
      : this->Self->IsoValue;
    this->EffectiveIsoValue = isoValue;
    this->WarnOfLabels(block, scalars);
    const auto samples = std::make_shared<surfsynth::VolumeSamples>(surfsynth::MakeSamples(
      lattice, scalars, isoValue, this->Self->InsideRule == BELOW, range, SubProgress(progress, 0.1, 0.15)));
    TriangleMesh mesh = Interruptible(
      [samples, options = this->Options(false)](
        const surfsynth::StopFlag& stop) { return surfsynth::SurfaceOfVolume(*samples, options, stop); },
      static_cast<double>(samples->Values.size()) / SamplesPerSecond, SubProgress(progress, 0.15, 0.95));
    if (mesh.NumberOfTriangles() == 0)
    {
      if (!this->Self->ComputeIsoValue && (isoValue < range.Lower || isoValue > range.Upper))
      {
        throw surfsynth::InvalidInput("The isovalue " + surfsynth::FormatNumber(isoValue) +
          " lies outside the values of the image, which go from " + surfsynth::FormatNumber(range.Lower) + " to " +
          surfsynth::FormatNumber(range.Upper) + "; no part of it lies inside. An IsoValue between them is needed.");
      }
      this->WarnOfNothing(block,
        "No part of the image lies inside, or none is left: its values go from " +
          surfsynth::FormatNumber(range.Lower) + " to " + surfsynth::FormatNumber(range.Upper) + ", the isovalue is " +
          surfsynth::FormatNumber(isoValue));
      return;
    }
    mesh.Points = lattice.ToWorld(mesh.Points);
    if (lattice.IsMirrored())
    {
      mesh.Triangles.col(1).swap(mesh.Triangles.col(2));
    }
    surfsynth::SetGeometry(output, mesh, true);
    surfsynth::SampleArrays(image, scalars, ImageLattice(image, false), mesh.Points, output->GetPointData());
  }

  void FromSurface(vtkPolyData* input, const Block& block, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    const auto mesh = std::make_shared<TriangleMesh>(surfsynth::ConvertSurface(input).Mesh);
    RequireFinitePoints(*mesh);
    const bool doublePrecision = surfsynth::HasDoublePoints(input);
    const auto places = std::make_shared<std::vector<surfsynth::SurfacePlace>>();
    const TriangleMesh result = Interruptible(
      [mesh, places, options = this->Options(!doublePrecision)](const surfsynth::StopFlag& stop) {
        TriangleMesh made = surfsynth::SurfaceOfMesh(*mesh, options, stop);
        *places = surfsynth::NearestPlaces(*mesh).Find(made.Points);
        return made;
      },
      0.1 + mesh->NumberOfTriangles() / TrianglesPerSecond, SubProgress(progress, 0.0, 0.95));
    if (result.NumberOfTriangles() == 0)
    {
      this->WarnOfNothing(block, "Nothing of the solid is left, or it is smaller than a voxel");
      return;
    }
    surfsynth::SetGeometry(output, result, doublePrecision);
    surfsynth::InterpolateArrays(input->GetPointData(), *mesh, *places, output->GetPointData());
  }

  /// Finds the array to contour; the flag is true for an array of the cells.
  vtkDataArray* Scalars(vtkImageData* image, bool& onCells) const
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* scalars = this->Self->GetInputArrayToProcess(0, image, association);
    onCells = association == vtkDataObject::FIELD_ASSOCIATION_CELLS;
    const vtkIdType needed = onCells ? image->GetNumberOfCells() : image->GetNumberOfPoints();
    const bool known = onCells || association == vtkDataObject::FIELD_ASSOCIATION_POINTS;
    if (!scalars || !known)
    {
      throw surfsynth::InvalidInput("The image has no such array of numbers on its points or cells; choose the scalars "
                                    "with SetInputArrayToProcess.");
    }
    if (scalars->GetNumberOfComponents() != 1 || scalars->GetNumberOfTuples() != needed)
    {
      throw surfsynth::InvalidInput("The array '" + std::string(scalars->GetName() ? scalars->GetName() : "") +
        "' has " + std::to_string(scalars->GetNumberOfTuples()) + " values of " +
        std::to_string(scalars->GetNumberOfComponents()) + " component(s); " + std::to_string(needed) +
        " of one component are needed. vtkArrayCalculator makes one of several.");
    }
    return scalars;
  }

  LevelSetOptions Options(bool singlePrecision) const
  {
    LevelSetOptions options;
    options.VoxelSize = this->Self->VoxelSize;
    options.Closing = this->Self->Closing;
    options.Smoothing = static_cast<surfsynth::LevelSetSmoothing>(this->Self->Smoothing);
    options.SmoothingIterations = this->Self->SmoothingIterations;
    options.Offset = this->Self->Offset;
    options.Adaptivity = this->Self->Adaptivity;
    options.FillCavities = this->Self->FillCavities;
    options.LargestComponent = this->Self->LargestComponent;
    options.MaximumNumberOfVoxels = this->Self->MaximumNumberOfVoxels;
    options.SinglePrecision = singlePrecision;
    return options;
  }

  /// Warns where a threshold of the histogram is asked for and the values are labels.
  void WarnOfLabels(const Block& block, vtkDataArray* scalars) const
  {
    const std::vector<double> labels = this->Self->ComputeIsoValue ? surfsynth::LabelsOf(scalars)
                                                                   : std::vector<double>();
    if (labels.size() > 2)
    {
      std::ostringstream text;
      text << "The image holds " << labels.size() << " distinct integers from " << labels.front() << " to "
           << labels.back() << ", as label images do, and the isovalue " << this->EffectiveIsoValue
           << " separates some labels from others. Choose an IsoValue (" << 0.5 * (labels[0] + labels[1])
           << " for all labels above " << labels.front() << "), or one label with vtkImageThreshold first.";
      surfsynth::ReportWarning(this->Self, block.Where, text.str());
    }
  }

  void WarnOfNothing(const Block& block, const std::string& what) const
  {
    surfsynth::ReportWarning(this->Self, block.Where, what + ". The output is empty.");
  }

  vtkVDBSurfaceFilter* Self;
};

vtkVDBSurfaceFilter::vtkVDBSurfaceFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

vtkVDBSurfaceFilter::~vtkVDBSurfaceFilter() = default;

vtkPolyData* vtkVDBSurfaceFilter::GetPolyDataOutput()
{
  return vtkPolyData::SafeDownCast(this->GetOutputDataObject(0));
}

int vtkVDBSurfaceFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptBlocks(info, ImageOrSurfaceToSurface);
}

int vtkVDBSurfaceFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, ImageOrSurfaceToSurface);
}

int vtkVDBSurfaceFilter::RequestUpdateExtent(vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* info = inputVector[0]->GetInformationObject(0);
  if (info && info->Has(Pipeline::WHOLE_EXTENT()))
  {
    info->Set(Pipeline::UPDATE_EXTENT(), info->Get(Pipeline::WHOLE_EXTENT()), 6);
  }
  return 1;
}

int vtkVDBSurfaceFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const auto work = [this](const Block& block, const surfsynth::Progress& progress) {
    this->Impl->Process(block, progress);
  };
  return surfsynth::ProcessBlocks(this, inputVector, outputVector, ImageOrSurfaceToSurface, work);
}

double vtkVDBSurfaceFilter::GetEffectiveIsoValue() const { return this->Impl->EffectiveIsoValue; }

void vtkVDBSurfaceFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ComputeIsoValue: " << this->ComputeIsoValue << "\n";
  os << indent << "IsoValue: " << this->IsoValue << "\n";
  os << indent << "InsideRule: " << this->InsideRule << "\n";
  os << indent << "VoxelSize: " << this->VoxelSize << "\n";
  os << indent << "Closing: " << this->Closing << "\n";
  os << indent << "Smoothing: " << this->Smoothing << "\n";
  os << indent << "SmoothingIterations: " << this->SmoothingIterations << "\n";
  os << indent << "Offset: " << this->Offset << "\n";
  os << indent << "Adaptivity: " << this->Adaptivity << "\n";
  os << indent << "FillCavities: " << this->FillCavities << "\n";
  os << indent << "LargestComponent: " << this->LargestComponent << "\n";
  os << indent << "MaximumNumberOfVoxels: " << this->MaximumNumberOfVoxels << "\n";
  os << indent << "EffectiveIsoValue: " << this->GetEffectiveIsoValue() << "\n";
}
