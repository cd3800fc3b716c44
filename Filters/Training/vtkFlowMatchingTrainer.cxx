// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFlowMatchingTrainer.h"

#include "FileCache.h"
#include "JointProcessing.h"
#include "SurfaceBridge.h"
#include "TrainingInputs.h"
#include "TrainingTable.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTable.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

using surfsynth::FlowMatchingTrainingOptions;
using surfsynth::SignalDataset;
using surfsynth::TrainingFiles;
using surfsynth::TrainingStep;

vtkStandardNewMacro(vtkFlowMatchingTrainer);

namespace
{
/// The part of the progress in which the time steps of the samples are read.
constexpr double ReadingShare = 0.05;
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
    this->EncoderLoss = -1.0;
    this->Data.reset();
    this->Failure = nullptr;
    try
    {
      if (this->Self->DatasetFileName.empty())
      {
        this->Data = surfsynth::ReadTrainingInputs(this->Self, inputVector, this->Self->SignalArrayName, ReadingShare);
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
    FlowMatchingTrainingOptions options = this->Options();
    const TrainingFiles files = this->Files();
    double encoded = 0.0;
    if (this->Self->EncoderIterations > 0)
    {
      // What is wrong with the training that follows is said now, and not after hours.
      CheckOptions(options);
      CheckFiles(files);
      this->RequireEncoderOf(files);
      const double iterations = this->Self->EncoderIterations;
      encoded = iterations / (iterations + static_cast<double>(options.Iterations));
      this->TrainEncoder(options, surfsynth::SubProgress(progress, 0.0, encoded));
      options.Encoder = *this->EncoderFile.Get(this->EncoderFiles().Model); // as a later training reads it
    }
    surfsynth::TrainingClock clock(options.Iterations);
    const surfsynth::FlowMatchingTrainer trainer = surfsynth::TrainFlowMatching(
      *std::exchange(this->Data, std::nullopt), options, files, this->Observer(clock, ""),
      surfsynth::SubProgress(progress, encoded, 1.0));
    this->IterationsDone = trainer.Iteration();
    this->DeviceInUse = trainer.DeviceName();
    surfsynth::FillTable(table, trainer.History());
  }

  vtkTypeInt64 IterationsDone = 0;
  std::string DeviceInUse;
  double EncoderLoss = -1.0;

private:
  /// Shows what @p clock says of each iteration, after @p what.
  surfsynth::TrainingObserver Observer(surfsynth::TrainingClock& clock, const std::string& what)
  {
    return [this, &clock, what](const TrainingStep& step) {
      clock.Add(step);
      this->Self->SetProgressText((what + clock.Describe()).c_str());
      return true;
    };
  }

  /// @throws ModelMismatch when the checkpoint of the model is of an encoder that would be trained on.
  void RequireEncoderOf(const TrainingFiles& model) const
  {
    const std::int64_t iterations = CheckpointIterations(this->EncoderFiles());
    if (HasCheckpoint(model) && iterations > 0 && iterations < this->Self->EncoderIterations)
    {
      throw surfsynth::ModelMismatch(model.Checkpoint + ": the checkpoint is of an encoder of " +
        std::to_string(iterations) + " iterations; expected the " + std::to_string(this->Self->EncoderIterations) +
        " of EncoderIterations. Ask for as many as before, or begin the model anew with another checkpoint file.");
    }
  }

  /// Writes an encoder of the surfaces that this training is of, with the recipe of the training that is to use it.
  void TrainEncoder(const FlowMatchingTrainingOptions& recipe, const surfsynth::Progress& progress)
  {
    if (this->Data->Sources.size() < 2)
    {
      throw surfsynth::InvalidInput("EncoderIterations is " + std::to_string(this->Self->EncoderIterations) +
        " and there is one source; an encoder tells where on surfaces of different shape a point is, and needs "
        "several. A model of one source is trained with 0.");
    }
    surfsynth::EncodingTrainingOptions options;
    static_cast<surfsynth::TrainingOptions&>(options) = recipe;
    options.Iterations = this->Self->EncoderIterations;
    options.Milestones.clear(); // they count the iterations of the other training
    options.Eigenfunctions = this->Self->NumberOfEigenfunctions;
    options.Width = recipe.Width;
    options.Blocks = recipe.Blocks;
    options.ComplexLayers = recipe.ComplexLayers;
    options.InnerProducts = recipe.InnerProducts;
    options.BatchSize = recipe.BatchSize;
    surfsynth::TrainingClock clock(options.Iterations);
    const surfsynth::EncodingTrainer trainer = TrainEncoding(
      *this->Data, options, this->EncoderFiles(), this->Observer(clock, "encoder: "), progress);
    this->EncoderLoss = surfsynth::LastLoss(trainer.History());
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
    options.Noise.Smoothing = self.NoiseSmoothing;
    options.Noise.Eigenpairs = self.NumberOfEigenpairs;
    options.Noise.Scale = self.NoiseScale;
    if (!self.EncoderFileName.empty() && self.EncoderIterations == 0)
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

  TrainingFiles Files() const
  {
    const vtkFlowMatchingTrainer& self = *this->Self;
    if (self.ModelFileName.empty())
    {
      throw surfsynth::InvalidInput("ModelFileName is empty; a path for the model file is needed.");
    }
    TrainingFiles files;
    files.Model = self.ModelFileName;
    files.Checkpoint = self.CheckpointFileName.empty() ? self.ModelFileName + ".checkpoint" : self.CheckpointFileName;
    files.LossTable = self.LossTableFileName;
    files.CheckpointInterval = self.CheckpointInterval;
    files.Resume = self.Resume;
    files.Inputs = { self.DatasetFileName };
    if (self.EncoderIterations > 0)
    {
      const TrainingFiles encoder = this->EncoderFiles();
      files.Inputs.insert(files.Inputs.end(), { encoder.Model, encoder.Checkpoint, encoder.LossTable });
    }
    else
    {
      files.Inputs.push_back(self.EncoderFileName);
    }
    return files;
  }

  TrainingFiles EncoderFiles() const
  {
    const vtkFlowMatchingTrainer& self = *this->Self;
    TrainingFiles files;
    files.Model = self.EncoderFileName.empty() ? self.ModelFileName + ".encoder" : self.EncoderFileName;
    files.Checkpoint = files.Model + ".checkpoint";
    files.LossTable = self.LossTableFileName.empty() ? "" : files.Model + ".csv";
    files.CheckpointInterval = self.CheckpointInterval;
    files.Resume = self.Resume;
    files.Inputs = { self.DatasetFileName };
    return files;
  }

  vtkFlowMatchingTrainer* Self;
  std::optional<SignalDataset> Data;
  std::exception_ptr Failure;
  static surfsynth::PoissonNetModel ReadEncoder(const std::string& path) { return surfsynth::ReadPoissonNet(path); }
  surfsynth::FileCache<surfsynth::PoissonNetModel> EncoderFile{ ReadEncoder,
    "EncoderFileName must name a PoissonNet in safetensors format, as a training with EncoderIterations writes it." };
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

double vtkFlowMatchingTrainer::GetEncoderLoss() const { return this->Impl->EncoderLoss; }

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
  const std::vector<double> times = surfsynth::TimeSteps(samples);
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
  os << indent << "EncoderIterations: " << this->EncoderIterations << "\n";
  os << indent << "NumberOfEigenfunctions: " << this->NumberOfEigenfunctions << "\n";
  os << indent << "Width: " << this->Width << "\n";
  os << indent << "Blocks: " << this->Blocks << "\n";
  os << indent << "ComplexLayers: " << this->ComplexLayers << "\n";
  os << indent << "InnerProducts: " << this->InnerProducts << "\n";
  os << indent << "NoiseModel: " << this->NoiseModel << "\n";
  os << indent << "Screening: " << this->Screening << "\n";
  os << indent << "NoiseSmoothing: " << this->NoiseSmoothing << "\n";
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
  os << indent << "EncoderLoss: " << this->GetEncoderLoss() << "\n";
  os << indent << "DeviceInUse: " << this->GetDeviceInUse() << "\n";
}
