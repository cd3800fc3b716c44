// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGaussianMixtureFilter.h"

#include "FilterSupport.h"
#include "RandomFields.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Noise/GaussianMixtures.h"

#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>

using surfsynth::GaussianMixtureOptions;
using surfsynth::GaussianMixtures;
using surfsynth::Surface;

vtkStandardNewMacro(vtkGaussianMixtureFilter);

namespace
{
bool HaveSameMixtures(const GaussianMixtureOptions& a, const GaussianMixtureOptions& b)
{
  return a.NumberOfCenters == b.NumberOfCenters && a.Width == b.Width && a.Separation == b.Separation;
}
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
    this->Fields.Begin();
  }

  const GaussianMixtures* Find(const Surface& surface) { return this->Fields.Find(surface, this->Options()); }

  void AddField(const Surface& surface, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    const double factored = 10.0 / (10.0 + 0.1 * this->Self->NumberOfSamples * this->Self->NumberOfCenters);
    const GaussianMixtures* held = this->Find(surface);
    const double begin = held ? 0.0 : factored;
    const GaussianMixtures& mixtures = held
      ? *held
      : this->Fields.Build(surface, this->Options(), surfsynth::SubProgress(progress, 0.0, factored));
    const auto request = surfsynth::RequestPart<surfsynth::GaussianMixtureRequest>(this->Series(), surface);
    const auto draw = [&](const surfsynth::SampleDestination& destination) {
      mixtures.SampleInto(request, destination, surfsynth::SubProgress(progress, begin, 1.0));
    };
    surfsynth::AddSamples(this->Series(), draw, output);
    this->StandardDeviation = mixtures.StandardDeviation();
  }

  surfsynth::SampleSeries Series() const
  {
    return { this->Self->OutputArrayName, this->Self->Seed, this->Self->FirstSample, this->Self->NumberOfSamples, 1,
      this->Self->MemoryLimit, this->Self->ActiveResult };
  }

  surfsynth::RandomFieldCache<GaussianMixtures, GaussianMixtureOptions, HaveSameMixtures> Fields;
  double StandardDeviation = 0.0;

private:
  GaussianMixtureOptions Options() const
  {
    GaussianMixtureOptions options;
    options.NumberOfCenters = this->Self->NumberOfCenters;
    options.Width = this->Self->Width;
    options.Separation = this->Self->Separation;
    return options;
  }

  vtkGaussianMixtureFilter* Self;
};

vtkGaussianMixtureFilter::vtkGaussianMixtureFilter()
  : Impl(std::make_unique<Internals>(this))
{}

vtkGaussianMixtureFilter::~vtkGaussianMixtureFilter() = default;

void vtkGaussianMixtureFilter::SetOutputArrayName(const char* name)
{
  surfsynth::SetString(this, this->OutputArrayName, name);
}

int vtkGaussianMixtureFilter::FillInputPortInformation(int, vtkInformation* info)
{
  return surfsynth::AcceptSurfaces(info);
}

int vtkGaussianMixtureFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequireSurfaces(this, inputVector)
    ? surfsynth::RequestSurfaces(vtkDataObject::GetData(inputVector[0]), outputVector)
    : 0;
}

int vtkGaussianMixtureFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::ProcessRandomFields(this, inputVector, outputVector, this->Impl->Series(), *this->Impl);
}

double vtkGaussianMixtureFilter::GetStandardDeviation() const { return this->Impl->StandardDeviation; }

vtkTypeInt64 vtkGaussianMixtureFilter::GetNumberOfFactorizations() const
{
  return this->Impl->Fields.NumberOfFactorizations();
}

void vtkGaussianMixtureFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfCenters: " << this->NumberOfCenters << "\n";
  os << indent << "Width: " << this->Width << "\n";
  os << indent << "Separation: " << this->Separation << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "ActiveResult: " << this->ActiveResult << "\n";
  os << indent << "OutputArrayName: " << this->OutputArrayName << "\n";
  os << indent << "StandardDeviation: " << this->GetStandardDeviation() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
}
