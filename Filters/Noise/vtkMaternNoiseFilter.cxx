// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMaternNoiseFilter.h"

#include "BlockCache.h"
#include "NoiseArrays.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Noise/MaternField.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

using surfsynth::MaternField;
using surfsynth::MaternFieldOptions;
using surfsynth::Surface;

vtkStandardNewMacro(vtkMaternNoiseFilter);

namespace
{
/// Returns true when two sets of options share operators, factor and eigenpairs.
bool SameFactor(const MaternFieldOptions& a, const MaternFieldOptions& b)
{
  return a.Model == b.Model && a.Mode == b.Mode && a.CorrelationRange == b.CorrelationRange &&
    a.Screening == b.Screening && a.NormalizedScreening == b.NormalizedScreening &&
    a.NumberOfEigenpairs == b.NumberOfEigenpairs;
}

/// Returns options with unused fields reset to their defaults, so that a change of them keeps the factor.
MaternFieldOptions WithoutIgnoredFields(MaternFieldOptions options)
{
  const MaternFieldOptions defaults;
  using surfsynth::NoiseModel;
  using surfsynth::ScaleMode;
  const bool hasScale = options.Model == NoiseModel::Matern || options.Model == NoiseModel::Spectral;
  const auto keepFor = [&options, hasScale](ScaleMode mode) { return hasScale && options.Mode == mode; };
  options.CorrelationRange = keepFor(ScaleMode::CorrelationRange) ? options.CorrelationRange : 0.0;
  options.Screening = keepFor(ScaleMode::Screening) ? options.Screening : defaults.Screening;
  options.NormalizedScreening = keepFor(ScaleMode::NormalizedScreening) ? options.NormalizedScreening
                                                                        : defaults.NormalizedScreening;
  options.NumberOfEigenpairs = options.Model == NoiseModel::Spectral ? options.NumberOfEigenpairs
                                                                     : defaults.NumberOfEigenpairs;
  options.Mode = hasScale ? options.Mode : defaults.Mode;
  return options;
}

/// Field on one mesh.
struct PreparedBlock
{
  MaternFieldOptions Options;
  std::unique_ptr<MaternField> Field;
};
} // namespace

/// Random fields of the last update, and their results.
class vtkMaternNoiseFilter::Internals
{
public:
  explicit Internals(vtkMaternNoiseFilter* self)
    : Self(self)
  {}

  void Begin()
  {
    this->EffectiveScreening = this->EffectiveCorrelationRange = this->Gamma = this->RelativeResidual = 0.0;
    this->Blocks.Begin();
  }

  void AddNoise(const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    const surfsynth::SampleRequest request = this->Request(surface);
    const double columns = static_cast<double>(request.NumberOfSamples) * request.NumberOfComponents;
    const double factored = 10.0 / (10.0 + 0.1 * columns); // a factorisation costs about as much as 100 samples
    const MaternField* cached = this->Find(surface);
    const double begin = cached ? 0.0 : factored;
    const MaternField& field = cached ? *cached : this->Build(surface, surfsynth::SubProgress(progress, 0.0, factored));
    this->Sample(field, request, output, surfsynth::SubProgress(progress, begin, 1.0));
    this->EffectiveScreening = field.EffectiveScreening();
    this->EffectiveCorrelationRange = field.EffectiveCorrelationRange();
    this->Gamma = field.Gamma();
    this->RelativeResidual = std::max(this->RelativeResidual, field.RelativeResidual());
  }

  /// Finds the field of this block from an earlier update with the same mesh and options; null otherwise.
  const MaternField* Find(const Surface& surface)
  {
    const auto isCurrent = [options = this->Options()](
                             const PreparedBlock& held) { return SameFactor(held.Options, options); };
    const PreparedBlock* found = this->Blocks.Find(surface, isCurrent);
    return found ? found->Field.get() : nullptr;
  }

  surfsynth::BlockCache<PreparedBlock> Blocks;
  double EffectiveScreening = 0.0;
  double EffectiveCorrelationRange = 0.0;
  double Gamma = 0.0;
  double RelativeResidual = 0.0;
  vtkTypeInt64 NumberOfFactorizations = 0;

private:
  /// Options with unit standard deviation: the deviation only multiplies the samples and is applied to the output.
  MaternFieldOptions Options() const
  {
    MaternFieldOptions options;
    options.Model = static_cast<surfsynth::NoiseModel>(this->Self->NoiseModel);
    options.Mode = static_cast<surfsynth::ScaleMode>(this->Self->ScaleMode);
    options.CorrelationRange = this->Self->CorrelationRange;
    options.Screening = this->Self->Screening;
    options.NormalizedScreening = this->Self->NormalizedScreening;
    options.NumberOfEigenpairs = this->Self->NumberOfEigenpairs;
    return WithoutIgnoredFields(options);
  }

  /// Factor of the samples of unit deviation.
  double Scale() const
  {
    const bool inRangeMode = this->Self->ScaleMode == CORRELATION_RANGE &&
      (this->Self->NoiseModel == MATERN || this->Self->NoiseModel == SPECTRAL);
    if (!inRangeMode && this->Self->NoiseModel != PER_VERTEX)
    {
      return 1.0;
    }
    if (!std::isfinite(this->Self->StandardDeviation))
    {
      throw surfsynth::InvalidInput("StandardDeviation is " + surfsynth::FormatNumber(this->Self->StandardDeviation) +
        "; a finite number of at least 0 is needed.");
    }
    return this->Self->StandardDeviation;
  }

  surfsynth::SampleRequest Request(const Surface& surface) const
  {
    const int samples = this->Self->NumberOfSamples - surface.Part.Index;
    surfsynth::SampleRequest request;
    request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    request.FirstSample = static_cast<std::uint32_t>(this->Self->FirstSample) +
      static_cast<std::uint32_t>(surface.Part.Index);
    request.SampleStep = static_cast<std::uint32_t>(surface.Part.Count);
    request.NumberOfSamples = static_cast<std::uint32_t>((samples + surface.Part.Count - 1) / surface.Part.Count);
    request.NumberOfComponents = static_cast<std::uint32_t>(this->Self->NumberOfComponents);
    request.Stream = surface.FlatIndex;
    request.Scale = this->Scale();
    return request;
  }

  const MaternField& Build(const Surface& surface, const surfsynth::Progress& progress)
  {
    this->Blocks.Drop(surface);
    PreparedBlock prepared;
    prepared.Options = this->Options();
    prepared.Field = std::make_unique<MaternField>(surface.Mesh, *surface.Topology, prepared.Options, progress);
    ++this->NumberOfFactorizations;
    this->WarnOfLongEdges(*prepared.Field, surface);
    return *this->Blocks.Insert(surface, std::move(prepared)).Field;
  }

  void WarnOfLongEdges(const MaternField& field, const Surface& surface) const
  {
    const double range = field.EffectiveCorrelationRange();
    if (this->Self->ScaleMode == CORRELATION_RANGE && range > 0.0 && field.LongestEdge() > range / 3.0)
    {
      std::ostringstream text;
      text << "The longest edge is " << field.LongestEdge() << ", more than a third of the correlation range " << range
           << ": the mesh is too coarse to carry the field. Refine it with vtkAdaptiveSubdivisionFilter or choose a "
              "range of at least "
           << 3.0 * field.LongestEdge() << ".";
      surfsynth::ReportWarning(this->Self, surface.Where, text.str());
    }
  }

  void Sample(const MaternField& field, const surfsynth::SampleRequest& request, vtkPolyData* output,
    const surfsynth::Progress& progress) const
  {
    std::vector<vtkSmartPointer<vtkDoubleArray>> arrays;
    const auto newArray = [&](std::uint32_t sample) {
      const int components = static_cast<int>(request.NumberOfComponents);
      arrays.push_back(surfsynth::NewNoiseArray(
        surfsynth::SampleName(this->Self->OutputArrayName, this->Self->NumberOfSamples, sample),
        output->GetNumberOfPoints(), components));
      return arrays.back()->GetPointer(0);
    };
    field.SampleInto(request, newArray, progress);
    surfsynth::AddNoiseArrays(arrays, output);
  }

  vtkMaternNoiseFilter* Self;
};

vtkMaternNoiseFilter::vtkMaternNoiseFilter()
  : Impl(std::make_unique<Internals>(this))
{}

vtkMaternNoiseFilter::~vtkMaternNoiseFilter() = default;

void vtkMaternNoiseFilter::SetOutputArrayName(const char* name)
{
  const std::string wanted = name ? name : "";
  if (this->OutputArrayName != wanted)
  {
    this->OutputArrayName = wanted;
    this->Modified();
  }
}

int vtkMaternNoiseFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurfaces(info);
}

int vtkMaternNoiseFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!vtkDataObject::GetData(inputVector[0]))
  {
    surfsynth::ReportError(this, "", "There is no input; a vtkPolyData or a composite dataset of them is needed.");
    return 0;
  }
  return surfsynth::RequestSurfaces(vtkDataObject::GetData(inputVector[0]), outputVector);
}

int vtkMaternNoiseFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (this->OutputArrayName.empty())
  {
    surfsynth::ReportError(this, "", "OutputArrayName is empty; a name for the point array is needed.");
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  this->Impl->Begin();
  const auto addNoise = [this](const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress) {
    this->Impl->AddNoise(surface, output, progress);
  };
  const auto isCached = [this](const Surface& surface) { return this->Impl->Find(surface) != nullptr; };
  const int success = surfsynth::ProcessSurfaces(
    this, inputVector, outputVector, surfsynth::MeshRequirements(), addNoise, isCached, this->NumberOfSamples);
  if (success && !this->GetAbortExecute())
  {
    this->Impl->Blocks.DropUnused();
  }
  return success;
}

double vtkMaternNoiseFilter::GetEffectiveScreening() const { return this->Impl->EffectiveScreening; }

double vtkMaternNoiseFilter::GetEffectiveCorrelationRange() const { return this->Impl->EffectiveCorrelationRange; }

double vtkMaternNoiseFilter::GetGamma() const { return this->Impl->Gamma; }

double vtkMaternNoiseFilter::GetRelativeResidual() const { return this->Impl->RelativeResidual; }

vtkTypeInt64 vtkMaternNoiseFilter::GetNumberOfFactorizations() const { return this->Impl->NumberOfFactorizations; }

void vtkMaternNoiseFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NoiseModel: " << this->NoiseModel << "\n";
  os << indent << "ScaleMode: " << this->ScaleMode << "\n";
  os << indent << "CorrelationRange: " << this->CorrelationRange << "\n";
  os << indent << "StandardDeviation: " << this->StandardDeviation << "\n";
  os << indent << "Screening: " << this->Screening << "\n";
  os << indent << "NormalizedScreening: " << this->NormalizedScreening << "\n";
  os << indent << "NumberOfEigenpairs: " << this->NumberOfEigenpairs << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfComponents: " << this->NumberOfComponents << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "OutputArrayName: " << this->OutputArrayName << "\n";
  os << indent << "EffectiveScreening: " << this->GetEffectiveScreening() << "\n";
  os << indent << "EffectiveCorrelationRange: " << this->GetEffectiveCorrelationRange() << "\n";
  os << indent << "Gamma: " << this->GetGamma() << "\n";
  os << indent << "RelativeResidual: " << this->GetRelativeResidual() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
}
