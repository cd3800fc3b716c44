// SPDX-License-Identifier: BSD-3-Clause
#include "vtkEnsembleStatistics.h"

#include "EnsembleReading.h"
#include "FilterSupport.h"
#include "JointProcessing.h"
#include "SampleMemory.h"
#include "StatisticsOutput.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Statistics/EnsembleStatistics.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTable.h>

#include <algorithm>
#include <string>
#include <utility>

using surfsynth::Ensemble;
using surfsynth::EnsembleSample;
using surfsynth::EnsembleStatistics;
using surfsynth::SharedSurface;

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkStandardNewMacro(vtkEnsembleStatistics);

namespace
{
/// Samples of all connections of a port.
Ensemble ReadConnections(vtkInformationVector* port, const std::string& array)
{
  Ensemble all;
  const int connections = port->GetNumberOfInformationObjects();
  for (int k = 0; k < connections; ++k)
  {
    Ensemble part = surfsynth::ReadEnsemble(vtkDataObject::GetData(port, k), "input", array);
    for (EnsembleSample& sample : part.Samples)
    {
      sample.Name = connections > 1 ? "Input " + std::to_string(k) + ": " + sample.Name : sample.Name;
      all.Samples.push_back(std::move(sample));
    }
  }
  all.Role = "input";
  return all;
}
} // namespace

/// Work of one update, which with time steps lasts for several calls of RequestData.
class vtkEnsembleStatistics::Internals
{
public:
  explicit Internals(vtkEnsembleStatistics* self)
    : Self(self)
  {}

  /// Forgets the time steps so far.
  void Reset()
  {
    this->Step = 0;
    this->Moments = {};
    this->Kept = {};
    this->First = {};
  }

  /// Statistics of the samples on the inputs.
  void Compute(
    vtkInformationVector** inputVector, vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    const Ensemble ensemble = ReadConnections(inputVector[0], this->Self->ArrayName);
    if (ensemble.Samples.empty())
    {
      return;
    }
    const EnsembleSample& first = ensemble.Samples[0];
    const int components = first.Values->GetNumberOfComponents();
    surfsynth::RequireOneTriangulation(ensemble, { first.Surface, "the " + ensemble.NameOf(0) }, components);
    this->Fill(ensemble, components, progress, outputVector);
  }

  /// Adds the samples of the current time step.
  void AddStep(vtkInformationVector** inputVector)
  {
    Ensemble ensemble = ReadConnections(inputVector[0], this->Self->ArrayName);
    if (ensemble.Samples.empty())
    {
      return;
    }
    if (!this->First.Surface)
    {
      this->First = ensemble.Samples[0];
      this->First.Surface = vtkSmartPointer<vtkPolyData>::New();
      this->First.Surface->DeepCopy(ensemble.Samples[0].Surface); // sources may change theirs in place
      this->First.Values = nullptr;
      this->Components = ensemble.Samples[0].Values->GetNumberOfComponents();
      this->RequireMemory(ensemble);
    }
    surfsynth::RequireOneTriangulation(ensemble, { this->First.Surface, "the first sample" }, this->Components);
    const std::vector<surfsynth::SampleValues> values = ensemble.Values();
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      EnsembleSample& sample = ensemble.Samples[k];
      sample.Name = "Time " + std::to_string(this->Step) + ": " + sample.Name;
      sample.Surface = this->First.Surface;
      if (this->KeepsValues())
      {
        const auto copy = vtkSmartPointer<vtkDataArray>::Take(sample.Values->NewInstance());
        copy->DeepCopy(sample.Values);
        sample.Values = copy;
      }
      else
      {
        const vtkIdType size = sample.Values->GetNumberOfTuples() * this->Components;
        this->Moments.Add(values[k], size, this->Components);
        sample.Values = nullptr;
      }
      this->Kept.Samples.push_back(std::move(sample));
    }
  }

  /// Statistics of all time steps.
  void Finish(vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    this->Kept.Role = "input";
    if (this->Kept.Samples.empty())
    {
      return;
    }
    if (this->KeepsValues())
    {
      this->Fill(this->Kept, this->Components, progress, outputVector);
      return;
    }
    this->Write(this->Moments.Finish(), this->Kept, this->Components, outputVector);
  }

  std::vector<double> Times; ///< time steps of the input; empty without UseTimeSteps
  std::size_t Step = 0;      ///< the current one

private:
  bool KeepsValues() const { return !this->Self->Quantiles.empty() || this->Self->NumberOfModes != 0; }

  /// Refuses time steps whose values are larger than the memory.
  void RequireMemory(const Ensemble& step) const
  {
    double bytes = 0.0;
    for (const EnsembleSample& sample : step.Samples)
    {
      bytes += static_cast<double>(sample.Values->GetNumberOfValues()) * sample.Values->GetDataTypeSize();
    }
    bytes *= static_cast<double>(this->Times.size());
    const auto limit = static_cast<double>(surfsynth::DefaultMemoryLimit());
    if (this->KeepsValues() && limit > 0.0 && bytes > limit)
    {
      throw surfsynth::InvalidInput("The values of " + std::to_string(this->Times.size()) + " time steps need " +
        std::to_string(static_cast<std::int64_t>(bytes / 1048576.0)) + " MiB of " +
        std::to_string(static_cast<std::int64_t>(limit / 1048576.0)) +
        "; without Quantiles and with NumberOfModes 0 one step after the other is added up.");
    }
  }

  void Fill(const Ensemble& ensemble, int components, const surfsynth::Progress& progress,
    vtkInformationVector* outputVector) const
  {
    surfsynth::EnsembleStatisticsOptions options;
    options.Quantiles = this->Self->Quantiles;
    options.NumberOfModes = this->Self->NumberOfModes;
    const vtkIdType points = ensemble.Samples[0].Values->GetNumberOfTuples();
    this->Write(surfsynth::ComputeEnsembleStatistics(ensemble.Values(), points, components, options, progress),
      ensemble, components, outputVector);
  }

  void Write(const EnsembleStatistics& statistics, const Ensemble& ensemble, int components,
    vtkInformationVector* outputVector) const
  {
    const surfsynth::StatisticsNames names{ this->Self->ArrayName, this->Self->Quantiles };
    vtkPolyData* surface = vtkPolyData::GetData(outputVector, 0);
    surfsynth::FillStatisticsSurface(surface, ensemble.Samples[0].Surface, statistics, components, names);
    surfsynth::AddModelFields(surface, statistics, static_cast<vtkIdType>(ensemble.Samples.size()), names);
    surfsynth::FillModeTable(vtkTable::GetData(outputVector, 1), statistics);
    surfsynth::FillSampleTable(vtkTable::GetData(outputVector, 2), statistics, ensemble);
  }

  vtkEnsembleStatistics* Self;
  EnsembleSample First; ///< surface of the first sample of all time steps
  int Components = 0;
  Ensemble Kept;
  surfsynth::RunningMoments Moments;
};

vtkEnsembleStatistics::vtkEnsembleStatistics()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfOutputPorts(3);
}

vtkEnsembleStatistics::~vtkEnsembleStatistics() = default;

void vtkEnsembleStatistics::SetArrayName(const char* name) { surfsynth::SetString(this, this->ArrayName, name); }

void vtkEnsembleStatistics::SetNumberOfQuantiles(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->Quantiles.size() != wanted)
  {
    this->Quantiles.resize(wanted, 0.5);
    this->Modified();
  }
}

void vtkEnsembleStatistics::SetQuantile(int index, double probability)
{
  if (index < 0 || index >= this->GetNumberOfQuantiles())
  {
    return;
  }
  double& quantile = this->Quantiles[static_cast<std::size_t>(index)];
  if (quantile != probability)
  {
    quantile = probability;
    this->Modified();
  }
}

double vtkEnsembleStatistics::GetQuantile(int index) const
{
  return index >= 0 && index < this->GetNumberOfQuantiles() ? this->Quantiles[static_cast<std::size_t>(index)] : 0.0;
}

int vtkEnsembleStatistics::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  return surfsynth::AcceptSurfaces(info);
}

int vtkEnsembleStatistics::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPolyData" : "vtkTable");
  return 1;
}

int vtkEnsembleStatistics::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Reset();
  this->Impl->Times.clear();
  vtkInformation* input = inputVector[0]->GetInformationObject(0);
  if (!this->UseTimeSteps || !input || !input->Has(Pipeline::TIME_STEPS()))
  {
    return 1;
  }
  const double* times = input->Get(Pipeline::TIME_STEPS());
  this->Impl->Times.assign(times, times + input->Length(Pipeline::TIME_STEPS()));
  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    outputVector->GetInformationObject(port)->Remove(Pipeline::TIME_STEPS());
    outputVector->GetInformationObject(port)->Remove(Pipeline::TIME_RANGE());
  }
  return 1;
}

int vtkEnsembleStatistics::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  const std::vector<double>& times = this->Impl->Times;
  for (int k = 0; !times.empty() && k < inputVector[0]->GetNumberOfInformationObjects(); ++k)
  {
    inputVector[0]->GetInformationObject(k)->Set(Pipeline::UPDATE_TIME_STEP(), times[this->Impl->Step]);
  }
  return 1;
}

int vtkEnsembleStatistics::RequestData(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  Internals& impl = *this->Impl;
  const std::size_t steps = impl.Times.size();
  bool completed = false; // false after an error and after an abort
  const int success = surfsynth::ProcessJointly(
    this, inputVector, outputVector, [&](const surfsynth::Progress& progress) {
      if (steps == 0)
      {
        impl.Compute(inputVector, outputVector, progress);
        return;
      }
      const double share = 0.5 / static_cast<double>(steps);
      surfsynth::Report(progress, share * static_cast<double>(impl.Step));
      impl.AddStep(inputVector);
      if (++impl.Step == steps)
      {
        impl.Finish(outputVector, surfsynth::SubProgress(progress, 0.5, 1.0));
      }
      completed = true;
    });
  if (completed && impl.Step < steps)
  {
    request->Set(Pipeline::CONTINUE_EXECUTING(), 1);
    return success;
  }
  request->Remove(Pipeline::CONTINUE_EXECUTING());
  impl.Reset();
  return success;
}

void vtkEnsembleStatistics::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ArrayName: " << this->ArrayName << "\n";
  os << indent << "Quantiles:";
  for (const double quantile : this->Quantiles)
  {
    os << " " << quantile;
  }
  os << "\n";
  os << indent << "NumberOfModes: " << this->NumberOfModes << "\n";
  os << indent << "UseTimeSteps: " << this->UseTimeSteps << "\n";
}
