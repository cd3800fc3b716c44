// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingInputs.h"

#include "TrainingReading.h"

#include "Core/Common/Errors.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkStreamingDemandDrivenPipeline.h>

namespace surfsynth
{

namespace
{
bool HasNoPoints(vtkDataObject* data) { return !data || data->GetNumberOfElements(vtkDataObject::POINT) <= 0; }

/// Brings what is connected to port 1 of @p self to @p time.
void RequestTime(vtkAlgorithm* self, double time)
{
  int port = 0;
  vtkAlgorithm* producer = self->GetInputAlgorithm(1, 0, port);
  vtkNew<vtkInformation> wanted;
  wanted->Set(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), time);
  vtkNew<vtkInformationVector> requests;
  requests->SetInformationObject(port, wanted);
  if (!producer->Update(port, requests))
  {
    throw InvalidInput("The samples of one of the time steps could not be made; see the errors of what is "
                       "connected to port 1.");
  }
}

/// The pipeline has made the samples of the first time. The others are asked for here, one by one, and not by
/// CONTINUE_EXECUTING: that would be an execution for each time, whose progress begins and ends each time and in which
/// an abort is forgotten, and would never end once upstream has failed.
void ReadLaterTimes(TrainingReader& reader, vtkAlgorithm* self, vtkInformationVector** inputVector,
  const std::vector<double>& times, double progressShare)
{
  for (std::size_t k = 1; k < times.size(); ++k)
  {
    self->UpdateProgress(progressShare * static_cast<double>(k) / static_cast<double>(times.size()));
    if (self->GetAbortExecute())
    {
      throw Cancelled("Stopped on request.");
    }
    RequestTime(self, times[k]);
    try
    {
      reader.AddSamples(vtkDataObject::GetData(inputVector[1]));
    }
    catch (const InvalidInput& error)
    {
      throw InvalidInput("At time step " + std::to_string(k) + ": " + error.what());
    }
  }
}
} // namespace

std::vector<double> TimeSteps(vtkInformation* info)
{
  const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  const double* begin = info && info->Has(key) ? info->Get(key) : nullptr;
  return begin ? std::vector<double>(begin, begin + info->Length(key)) : std::vector<double>();
}

std::optional<SignalDataset> ReadTrainingInputs(
  vtkAlgorithm* self, vtkInformationVector** inputVector, const std::string& arrayName, double progressShare)
{
  vtkDataObject* sources = vtkDataObject::GetData(inputVector[0]);
  vtkDataObject* samples = vtkDataObject::GetData(inputVector[1]);
  if (!sources || !samples)
  {
    throw InvalidInput(std::string("There is no ") + (sources ? "dataset of samples on port 1" : "source") +
      "; a source and samples of it are needed, or a DatasetFileName.");
  }
  const std::vector<double> times = TimeSteps(inputVector[1]->GetInformationObject(0));
  if (HasNoPoints(sources) && HasNoPoints(samples) && times.size() < 2)
  {
    return {};
  }
  // Its surfaces are copied: upstream of both ports may be the same time series.
  TrainingReader reader(sources, arrayName);
  if (reader.NumberOfSources() == 0)
  {
    throw InvalidInput("The source is empty; a surface that the samples are on is needed.");
  }
  reader.AddSamples(samples);
  ReadLaterTimes(reader, self, inputVector, times, progressShare);
  return reader.Take();
}

} // namespace surfsynth
