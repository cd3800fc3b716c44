// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGaussianMixtureFilter.h"

#include "BlockCache.h"
#include "NoiseArrays.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Noise/GaussianMixtures.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <utility>
#include <vector>

using surfsynth::GaussianMixtures;
using surfsynth::Surface;

vtkStandardNewMacro(vtkGaussianMixtureFilter);

namespace
{
bool SameMixtures(const surfsynth::GaussianMixtureOptions& a, const surfsynth::GaussianMixtureOptions& b)
{
  return a.NumberOfCenters == b.NumberOfCenters && a.Width == b.Width && a.Separation == b.Separation;
}

/// Mixtures on one mesh.
struct PreparedBlock
{
  surfsynth::GaussianMixtureOptions Options;
  std::unique_ptr<GaussianMixtures> Mixtures;
};
} // namespace

/// Factored meshes of the last update, and their results.
class vtkGaussianMixtureFilter::Internals
{
public:
  explicit Internals(vtkGaussianMixtureFilter* self)
    : Self(self)
  {}

  void Begin()
  {
    this->StandardDeviation = 0.0;
    this->Blocks.Begin();
  }

  /// Finds the mixtures of this block from an earlier update with the same mesh and options; null otherwise.
  const GaussianMixtures* Find(const Surface& surface)
  {
    const auto isCurrent = [options = this->Options()](
                             const PreparedBlock& held) { return SameMixtures(held.Options, options); };
    const PreparedBlock* found = this->Blocks.Find(surface, isCurrent);
    return found ? found->Mixtures.get() : nullptr;
  }

  void AddMixtures(const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    const double factored = 10.0 / (10.0 + 0.1 * this->Self->NumberOfSamples * this->Self->NumberOfCenters);
    const GaussianMixtures* held = this->Find(surface);
    const GaussianMixtures& mixtures = held ? *held
                                            : this->Build(surface, surfsynth::SubProgress(progress, 0.0, factored));
    std::vector<vtkSmartPointer<vtkDoubleArray>> arrays;
    const auto newArray = [&](std::uint32_t sample) {
      arrays.push_back(surfsynth::NewNoiseArray(
        surfsynth::SampleName(this->Self->OutputArrayName, this->Self->NumberOfSamples, sample),
        output->GetNumberOfPoints(), 1));
      return arrays.back()->GetPointer(0);
    };
    mixtures.SampleInto(this->Request(surface), newArray, surfsynth::SubProgress(progress, held ? 0.0 : factored, 1.0));
    surfsynth::AddNoiseArrays(arrays, output);
    this->StandardDeviation = mixtures.StandardDeviation();
  }

  surfsynth::BlockCache<PreparedBlock> Blocks;
  double StandardDeviation = 0.0;
  vtkTypeInt64 NumberOfFactorizations = 0;

private:
  surfsynth::GaussianMixtureOptions Options() const
  {
    surfsynth::GaussianMixtureOptions options;
    options.NumberOfCenters = this->Self->NumberOfCenters;
    options.Width = this->Self->Width;
    options.Separation = this->Self->Separation;
    return options;
  }

  surfsynth::GaussianMixtureRequest Request(const Surface& surface) const
  {
    const int samples = this->Self->NumberOfSamples - surface.Part.Index;
    surfsynth::GaussianMixtureRequest request;
    request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    request.FirstSample = static_cast<std::uint32_t>(this->Self->FirstSample) +
      static_cast<std::uint32_t>(surface.Part.Index);
    request.SampleStep = static_cast<std::uint32_t>(surface.Part.Count);
    request.NumberOfSamples = static_cast<std::uint32_t>((samples + surface.Part.Count - 1) / surface.Part.Count);
    request.Stream = surface.FlatIndex;
    return request;
  }

  const GaussianMixtures& Build(const Surface& surface, const surfsynth::Progress& progress)
  {
    this->Blocks.Drop(surface);
    PreparedBlock prepared;
    prepared.Options = this->Options();
    prepared.Mixtures = std::make_unique<GaussianMixtures>(surface.Mesh, *surface.Topology, prepared.Options, progress);
    ++this->NumberOfFactorizations;
    return *this->Blocks.Insert(surface, std::move(prepared)).Mixtures;
  }

  vtkGaussianMixtureFilter* Self;
};

vtkGaussianMixtureFilter::vtkGaussianMixtureFilter()
  : Impl(std::make_unique<Internals>(this))
{}

vtkGaussianMixtureFilter::~vtkGaussianMixtureFilter() = default;

void vtkGaussianMixtureFilter::SetOutputArrayName(const char* name)
{
  const std::string wanted = name ? name : "";
  if (this->OutputArrayName != wanted)
  {
    this->OutputArrayName = wanted;
    this->Modified();
  }
}

int vtkGaussianMixtureFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurfaces(info);
}

int vtkGaussianMixtureFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!vtkDataObject::GetData(inputVector[0]))
  {
    surfsynth::ReportError(this, "", "There is no input; a vtkPolyData or a composite dataset of them is needed.");
    return 0;
  }
  return surfsynth::RequestSurfaces(vtkDataObject::GetData(inputVector[0]), outputVector);
}

int vtkGaussianMixtureFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (this->OutputArrayName.empty())
  {
    surfsynth::ReportError(this, "", "OutputArrayName is empty; a name for the point array is needed.");
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  this->Impl->Begin();
  const auto addMixtures = [this](const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress) {
    this->Impl->AddMixtures(surface, output, progress);
  };
  const auto isHeld = [this](const Surface& surface) { return this->Impl->Find(surface) != nullptr; };
  const int success = surfsynth::ProcessSurfaces(
    this, inputVector, outputVector, surfsynth::MeshRequirements(), addMixtures, isHeld, this->NumberOfSamples);
  if (success && !this->GetAbortExecute())
  {
    this->Impl->Blocks.DropUnused();
  }
  return success;
}

double vtkGaussianMixtureFilter::GetStandardDeviation() const { return this->Impl->StandardDeviation; }

vtkTypeInt64 vtkGaussianMixtureFilter::GetNumberOfFactorizations() const { return this->Impl->NumberOfFactorizations; }

void vtkGaussianMixtureFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfCenters: " << this->NumberOfCenters << "\n";
  os << indent << "Width: " << this->Width << "\n";
  os << indent << "Separation: " << this->Separation << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "OutputArrayName: " << this->OutputArrayName << "\n";
  os << indent << "StandardDeviation: " << this->GetStandardDeviation() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
}
