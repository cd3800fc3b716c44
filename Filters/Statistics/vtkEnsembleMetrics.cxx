// SPDX-License-Identifier: BSD-3-Clause
#include "vtkEnsembleMetrics.h"

#include "EnsembleReading.h"
#include "FilterSupport.h"
#include "JointProcessing.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"
#include "TableColumns.h"

#include "Core/Common/Errors.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <vector>

using surfsynth::AddColumn;
using surfsynth::Ensemble;
using surfsynth::EnsembleMetrics;

vtkStandardNewMacro(vtkEnsembleMetrics);

namespace
{
void FillMetrics(vtkTable* table, const EnsembleMetrics& metrics)
{
  const auto add = [table](const char* name, double value) {
    AddColumn<vtkDoubleArray>(table, name, std::vector<double>{ value });
  };
  add("MMD", metrics.MMD);
  add("ReverseMMD", metrics.ReverseMMD);
  add("COV", metrics.COV);
  add("OneNearestNeighbourAccuracy", metrics.OneNearestNeighborAccuracy);
  add("MeanError", metrics.MeanError);
  add("GeneratedSpacing", metrics.GeneratedSpacing);
  add("ReferenceSpacing", metrics.ReferenceSpacing);
}

void FillCounts(vtkTable* table, const Ensemble& generated, const Ensemble& reference)
{
  const auto add = [table](const char* name, vtkIdType value) {
    AddColumn<vtkIdTypeArray>(table, name, std::vector<vtkIdType>{ value });
  };
  add("NumberOfGenerated", static_cast<vtkIdType>(generated.Samples.size()));
  add("NumberOfReferences", static_cast<vtkIdType>(reference.Samples.size()));
  add("NumberOfPoints", reference.Samples[0].Values->GetNumberOfTuples());
  add("NumberOfComponents", reference.Samples[0].Values->GetNumberOfComponents());
}

void FillNearest(vtkTable* table, const EnsembleMetrics& metrics, const Ensemble& generated, const Ensemble& reference)
{
  std::vector<vtkIdType> samples;
  std::vector<std::string> names, nearestNames;
  for (const std::int64_t nearest : metrics.NearestReference)
  {
    names.push_back(generated.Samples[samples.size()].Name);
    samples.push_back(static_cast<vtkIdType>(samples.size()));
    nearestNames.push_back(reference.Samples[static_cast<std::size_t>(nearest)].Name);
  }
  AddColumn<vtkIdTypeArray>(table, "Sample", samples);
  AddColumn<vtkIdTypeArray>(table, "NearestReference", metrics.NearestReference);
  AddColumn<vtkStringArray>(table, "SampleName", names);
  AddColumn<vtkStringArray>(table, "NearestReferenceName", nearestNames);
  AddColumn<vtkDoubleArray>(table, "Distance", metrics.DistanceToReference);
}

/// Returns true when both ensembles are empty.
/// @throws InvalidInput when only one of the ensembles is empty
bool NothingToCompare(const Ensemble& generated, const Ensemble& reference)
{
  if (generated.Samples.empty() != reference.Samples.empty())
  {
    const Ensemble& empty = generated.Samples.empty() ? generated : reference;
    throw surfsynth::InvalidInput("The " + empty.Role + " ensemble is empty; at least one sample is needed.");
  }
  return generated.Samples.empty();
}
} // namespace

/// Metrics of the last update.
class vtkEnsembleMetrics::Internals
{
public:
  explicit Internals(vtkEnsembleMetrics* self)
    : Self(self)
  {}

  /// Fills both tables.
  void Compare(
    vtkInformationVector** inputVector, vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    const std::string& array = this->Self->ArrayName;
    const Ensemble generated = surfsynth::ReadEnsemble(vtkDataObject::GetData(inputVector[0]), "generated", array);
    const Ensemble reference = surfsynth::ReadEnsemble(vtkDataObject::GetData(inputVector[1]), "reference", array);
    if (NothingToCompare(generated, reference))
    {
      return;
    }
    const auto source = surfsynth::SurfaceOn(inputVector[2]);
    const surfsynth::SharedSurface shared = source
      ? surfsynth::SharedSurface{ source, "the source" }
      : surfsynth::SharedSurface{ reference.Samples[0].Surface, "the " + reference.NameOf(0) };
    const int components = reference.Samples[0].Values->GetNumberOfComponents();
    surfsynth::RequireOneTriangulation(reference, shared, components);
    surfsynth::RequireOneTriangulation(generated, shared, components);
    this->Metrics = surfsynth::ComputeEnsembleMetrics(
      { generated.Values(), reference.Values(), components }, surfsynth::MassOf(shared), this->Options(), progress);
    vtkTable* table = vtkTable::GetData(outputVector, 0);
    FillMetrics(table, this->Metrics);
    FillCounts(table, generated, reference);
    FillNearest(vtkTable::GetData(outputVector, 1), this->Metrics, generated, reference);
  }

  EnsembleMetrics Metrics;

private:
  surfsynth::EnsembleMetricsOptions Options() const
  {
    surfsynth::EnsembleMetricsOptions options;
    options.Distance = static_cast<surfsynth::SampleDistance>(this->Self->Distance);
    options.RemoveCentroid = this->Self->RemoveCentroid;
    return options;
  }

  vtkEnsembleMetrics* Self;
};

vtkEnsembleMetrics::vtkEnsembleMetrics()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(3);
  this->SetNumberOfOutputPorts(2);
}

vtkEnsembleMetrics::~vtkEnsembleMetrics() = default;

void vtkEnsembleMetrics::SetArrayName(const char* name) { surfsynth::SetString(this, this->ArrayName, name); }

int vtkEnsembleMetrics::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port < 2)
  {
    return surfsynth::AcceptSurfaces(info);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return surfsynth::AcceptSurface(info);
}

int vtkEnsembleMetrics::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Metrics = EnsembleMetrics();
  const auto compare = [&](const surfsynth::Progress& progress) {
    this->Impl->Compare(inputVector, outputVector, progress);
  };
  return surfsynth::ProcessJointly(this, inputVector, outputVector, compare);
}

double vtkEnsembleMetrics::GetMMD() const { return this->Impl->Metrics.MMD; }

double vtkEnsembleMetrics::GetReverseMMD() const { return this->Impl->Metrics.ReverseMMD; }

double vtkEnsembleMetrics::GetCOV() const { return this->Impl->Metrics.COV; }

double vtkEnsembleMetrics::GetOneNearestNeighbourAccuracy() const
{
  return this->Impl->Metrics.OneNearestNeighborAccuracy;
}

double vtkEnsembleMetrics::GetMeanError() const { return this->Impl->Metrics.MeanError; }

void vtkEnsembleMetrics::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ArrayName: " << this->ArrayName << "\n";
  os << indent << "Distance: " << this->Distance << "\n";
  os << indent << "RemoveCentroid: " << this->RemoveCentroid << "\n";
  os << indent << "MMD: " << this->GetMMD() << "\n";
  os << indent << "ReverseMMD: " << this->GetReverseMMD() << "\n";
  os << indent << "COV: " << this->GetCOV() << "\n";
  os << indent << "OneNearestNeighbourAccuracy: " << this->GetOneNearestNeighbourAccuracy() << "\n";
  os << indent << "MeanError: " << this->GetMeanError() << "\n";
}
