// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFlowMatchingTrainer.h"

#include "FileCache.h"
#include "JointProcessing.h"
#include "SurfaceBridge.h"
#include "TrainingReading.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTable.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

using surfsynth::FlowMatchingTrainingOptions;
using surfsynth::SignalDataset;
using surfsynth::TrainingStep;

vtkStandardNewMacro(vtkFlowMatchingTrainer);

namespace
{
/// The part of the progress in which the time steps of the samples are read.
constexpr double ReadingShare = 0.05;

bool IsEmpty(vtkDataObject* data) { return !data || data->GetNumberOfElements(vtkDataObject::POINT) <= 0; }

std::vector<double> TimeSteps(vtkInformation* info)
{
  const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  const double* begin = info && info->Has(key) ? info->Get(key) : nullptr;
  return begin ? std::vector<double>(begin, begin + info->Length(key)) : std::vector<double>();
}

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
    throw surfsynth::InvalidInput("The samples of one of the time steps could not be made; see the errors of what is "
                                  "connected to port 1.");
  }
}

void FillTable(vtkTable* table, const std::vector<TrainingStep>& history)
{
  vtkNew<vtkIdTypeArray> iterations;
  iterations->SetName("iteration");
  iterations->SetNumberOfTuples(static_cast<vtkIdType>(history.size()));
  table->AddColumn(iterations);
  const std::pair<const char*, double TrainingStep::*> columns[] = { { "loss", &TrainingStep::Loss },
    { "vertex_loss", &TrainingStep::VertexLoss }, { "jacobian_loss", &TrainingStep::JacobianLoss },
    { "gradient_norm", &TrainingStep::GradientNorm }, { "learning_rate", &TrainingStep::LearningRate } };
  for (const auto& [name, member] : columns)
  {
    vtkNew<vtkDoubleArray> column;
    column->SetName(name);
    column->SetNumberOfTuples(static_cast<vtkIdType>(history.size()));
    for (std::size_t k = 0; k < history.size(); ++k)
    {
      column->SetValue(static_cast<vtkIdType>(k), history[k].*member);
      iterations->SetValue(static_cast<vtkIdType>(k), static_cast<vtkIdType>(history[k].Iteration));
    }
    table->AddColumn(column);
  }
}
} // namespace

/// What is read, and what came of the last update.
class vtkFlowMatchingTrainer::Internals
{
public:
  explicit Internals(vtkFlowMatchingTrainer* self)
    : Self(self)
  {}

  /// Reads the inputs, all time steps of them. What goes wrong is thrown by Train(), which has the frame for it: every
  /// rank of a parallel pipeline must take part in updating what is upstream, and only one trains.
  void Read(vtkInformationVector** inputVector)
  {
    this->IterationsDone = 0;
    this->DeviceInUse.clear();
    this->Data.reset();
    this->Failure = nullptr;
    try
    {
      if (this->Self->DatasetFileName.empty())
      {
        this->ReadInputs(inputVector);
      }
    }
    catch (...)
    {
      this->Failure = std::current_exception();
    }
  }

  void Train(vtkTable* table, const surfsynth::Progress& progress)
  {
    if (this->Failure)
    {
      std::rethrow_exception(std::exchange(this->Failure, nullptr));
    }
    if (!this->Self->DatasetFileName.empty())
    {
      this->Data = surfsynth::ReadSignalDataset(this->Self->DatasetFileName);
    }
    if (!this->Data) // of empty inputs
    {
      return;
    }
    surfsynth::TrainingClock clock(this->Self->Iterations);
    const auto observe = [&](const TrainingStep& step) {
      clock.Add(step);
      this->Self->SetProgressText(clock.Describe().c_str());
      return true;
    };
    const surfsynth::FlowMatchingTrainer trainer = surfsynth::TrainFlowMatching(
      *std::exchange(this->Data, std::nullopt), this->Options(), this->Files(), observe, progress);
    this->IterationsDone = trainer.Iteration();
    this->DeviceInUse = trainer.DeviceName();
    FillTable(table, trainer.History());
  }

  vtkTypeInt64 IterationsDone = 0;
  std::string DeviceInUse;

private:
  void ReadInputs(vtkInformationVector** inputVector)
  {
    vtkDataObject* sources = vtkDataObject::GetData(inputVector[0]);
    vtkDataObject* samples = vtkDataObject::GetData(inputVector[1]);
    if (!sources || !samples)
    {
      throw surfsynth::InvalidInput(std::string("There is no ") +
        (sources ? "dataset of samples on port 1" : "source") +
        "; a source and samples of it are needed, or a DatasetFileName.");
    }
    const std::vector<double> times = TimeSteps(inputVector[1]->GetInformationObject(0));
    if (IsEmpty(sources) && IsEmpty(samples) && times.size() < 2)
    {
      return;
    }
    // Its surfaces are copied: upstream of both ports may be the same time series.
    surfsynth::TrainingReader reader(sources, this->Self->SignalArrayName);
    if (reader.NumberOfSources() == 0)
    {
      throw surfsynth::InvalidInput("The source is empty; a surface that the samples are on is needed.");
    }
    reader.AddSamples(samples);
    this->ReadLaterTimes(reader, inputVector, times);
    this->Data = reader.Take();
  }

  /// The pipeline has made the samples of the first time. The others are asked for here, one by one, and not by
  /// CONTINUE_EXECUTING: that would be an execution for each time, whose progress begins and ends each time and in which
  /// an abort is forgotten, and would never end once upstream has failed.
  void ReadLaterTimes(
    surfsynth::TrainingReader& reader, vtkInformationVector** inputVector, const std::vector<double>& times)
  {
    for (std::size_t k = 1; k < times.size(); ++k)
    {
      this->Self->UpdateProgress(ReadingShare * static_cast<double>(k) / static_cast<double>(times.size()));
      if (this->Self->GetAbortExecute())
      {
        throw surfsynth::Cancelled("Stopped on request.");
      }
      RequestTime(this->Self, times[k]);
      try
      {
        reader.AddSamples(vtkDataObject::GetData(inputVector[1]));
      }
      catch (const surfsynth::InvalidInput& error)
      {
        throw surfsynth::InvalidInput("At time step " + std::to_string(k) + ": " + error.what());
      }
    }
  }

  FlowMatchingTrainingOptions Options()
  {
    const vtkFlowMatchingTrainer& self = *this->Self;
    FlowMatchingTrainingOptions options;
    options.Width = self.Width;
    options.Blocks = self.Blocks;
    options.ComplexLayers = self.ComplexLayers;
    options.InnerProducts = self.InnerProducts;
    options.Noise.Model = static_cast<surfsynth::NoiseModel>(self.NoiseModel);
    options.Noise.Screening = self.Screening;
    options.Noise.Eigenpairs = self.NumberOfEigenpairs;
    options.Noise.Scale = self.NoiseScale;
    if (!self.EncoderFileName.empty())
    {
      options.Encoder = *this->EncoderFile.Get(self.EncoderFileName);
    }
    options.Iterations = self.Iterations;
    options.BatchSize = self.BatchSize;
    options.SourcesPerBatch = self.SourcesPerBatch;
    options.LearningRate = self.LearningRate;
    options.Milestones.assign(self.Milestones.begin(), self.Milestones.end());
    options.LearningRateFactor = self.LearningRateFactor;
    options.GradientClip = self.GradientClip;
    options.VertexWeight = self.VertexWeight;
    options.JacobianWeight = self.JacobianWeight;
    options.WeightAveraging = self.WeightAveraging;
    options.Seed = static_cast<std::uint64_t>(self.Seed);
    options.Device = static_cast<surfsynth::TrainingDevice>(self.Device);
    return options;
  }

  surfsynth::TrainingFiles Files() const
  {
    const vtkFlowMatchingTrainer& self = *this->Self;
    if (self.ModelFileName.empty())
    {
      throw surfsynth::InvalidInput("ModelFileName is empty; a path for the model file is needed.");
    }
    surfsynth::TrainingFiles files;
    files.Model = self.ModelFileName;
    files.Checkpoint = self.CheckpointFileName.empty() ? self.ModelFileName + ".checkpoint" : self.CheckpointFileName;
    files.LossTable = self.LossTableFileName;
    files.CheckpointInterval = self.CheckpointInterval;
    files.Resume = self.Resume;
    return files;
  }

  vtkFlowMatchingTrainer* Self;
  std::optional<SignalDataset> Data;
  std::exception_ptr Failure;
  static surfsynth::PoissonNetModel ReadEncoder(const std::string& path) { return surfsynth::ReadPoissonNet(path); }
  surfsynth::FileCache<surfsynth::PoissonNetModel> EncoderFile{ ReadEncoder,
    "EncoderFileName must name a PoissonNet in safetensors format, as \"surfacesynthesis-train encoding\" writes it." };
};

vtkFlowMatchingTrainer::vtkFlowMatchingTrainer()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkFlowMatchingTrainer::~vtkFlowMatchingTrainer() = default;

void vtkFlowMatchingTrainer::SetText(std::string& property, const char* text)
{
  const std::string wanted = text ? text : "";
  if (property != wanted)
  {
    property = wanted;
    this->Modified();
  }
}

void vtkFlowMatchingTrainer::SetModelFileName(const char* name) { this->SetText(this->ModelFileName, name); }

void vtkFlowMatchingTrainer::SetCheckpointFileName(const char* name) { this->SetText(this->CheckpointFileName, name); }

void vtkFlowMatchingTrainer::SetLossTableFileName(const char* name) { this->SetText(this->LossTableFileName, name); }

void vtkFlowMatchingTrainer::SetDatasetFileName(const char* name) { this->SetText(this->DatasetFileName, name); }

void vtkFlowMatchingTrainer::SetSignalArrayName(const char* name) { this->SetText(this->SignalArrayName, name); }

void vtkFlowMatchingTrainer::SetEncoderFileName(const char* name) { this->SetText(this->EncoderFileName, name); }

void vtkFlowMatchingTrainer::SetNumberOfMilestones(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->Milestones.size() != wanted)
  {
    this->Milestones.resize(wanted, 0);
    this->Modified();
  }
}

void vtkFlowMatchingTrainer::SetMilestone(int index, int iteration)
{
  if (index < 0 || index >= this->GetNumberOfMilestones())
  {
    return;
  }
  int& milestone = this->Milestones[static_cast<std::size_t>(index)];
  if (milestone != iteration)
  {
    milestone = iteration;
    this->Modified();
  }
}

int vtkFlowMatchingTrainer::GetMilestone(int index) const
{
  return index >= 0 && index < this->GetNumberOfMilestones() ? this->Milestones[static_cast<std::size_t>(index)] : 0;
}

vtkTypeInt64 vtkFlowMatchingTrainer::GetNumberOfIterationsDone() const { return this->Impl->IterationsDone; }

const char* vtkFlowMatchingTrainer::GetDeviceInUse() const { return this->Impl->DeviceInUse.c_str(); }

int vtkFlowMatchingTrainer::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in their place
  return surfsynth::AcceptSurfaces(info);
}

int vtkFlowMatchingTrainer::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  // The table is made of all time steps together and has none itself.
  vtkInformation* output = outputVector->GetInformationObject(0);
  output->Remove(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
  output->Remove(vtkStreamingDemandDrivenPipeline::TIME_RANGE());
  return 1;
}

int vtkFlowMatchingTrainer::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  vtkInformation* samples = inputVector[1]->GetInformationObject(0);
  const std::vector<double> times = TimeSteps(samples);
  if (!times.empty())
  {
    samples->Set(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), times.front());
  }
  return 1;
}

int vtkFlowMatchingTrainer::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Read(inputVector);
  const auto train = [&](const surfsynth::Progress& progress) {
    this->Impl->Train(vtkTable::GetData(outputVector), surfsynth::SubProgress(progress, ReadingShare, 1.0));
  };
  const int success = surfsynth::ProcessJointly(this, inputVector, outputVector, train);
  this->SetProgressText(nullptr);
  return success;
}

void vtkFlowMatchingTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "CheckpointFileName: " << this->CheckpointFileName << "\n";
  os << indent << "LossTableFileName: " << this->LossTableFileName << "\n";
  os << indent << "CheckpointInterval: " << this->CheckpointInterval << "\n";
  os << indent << "Resume: " << this->Resume << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
  os << indent << "SignalArrayName: " << this->SignalArrayName << "\n";
  os << indent << "EncoderFileName: " << this->EncoderFileName << "\n";
  os << indent << "Width: " << this->Width << "\n";
  os << indent << "Blocks: " << this->Blocks << "\n";
  os << indent << "ComplexLayers: " << this->ComplexLayers << "\n";
  os << indent << "InnerProducts: " << this->InnerProducts << "\n";
  os << indent << "NoiseModel: " << this->NoiseModel << "\n";
  os << indent << "Screening: " << this->Screening << "\n";
  os << indent << "NoiseScale: " << this->NoiseScale << "\n";
  os << indent << "NumberOfEigenpairs: " << this->NumberOfEigenpairs << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "BatchSize: " << this->BatchSize << "\n";
  os << indent << "SourcesPerBatch: " << this->SourcesPerBatch << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "Milestones:";
  for (const int milestone : this->Milestones)
  {
    os << " " << milestone;
  }
  os << "\n";
  os << indent << "LearningRateFactor: " << this->LearningRateFactor << "\n";
  os << indent << "GradientClip: " << this->GradientClip << "\n";
  os << indent << "VertexWeight: " << this->VertexWeight << "\n";
  os << indent << "JacobianWeight: " << this->JacobianWeight << "\n";
  os << indent << "WeightAveraging: " << this->WeightAveraging << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "NumberOfIterationsDone: " << this->GetNumberOfIterationsDone() << "\n";
  os << indent << "DeviceInUse: " << this->GetDeviceInUse() << "\n";
}
