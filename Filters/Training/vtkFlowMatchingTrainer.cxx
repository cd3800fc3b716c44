// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFlowMatchingTrainer.h"

#include "FileCache.h"
#include "ModelTrainerRun.h"
#include "SurfaceBridge.h"
#include "TrainingInputs.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TimeLimit.h"

#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

using surfsynth::FlowMatchingModel;
using surfsynth::FlowMatchingTrainingOptions;
using surfsynth::SignalDataset;
using surfsynth::TrainingFiles;

vtkStandardNewMacro(vtkFlowMatchingTrainer);

namespace
{
/// The part of the progress in which the time steps of the samples are read.
constexpr double ReadingShare = 0.05;
} // namespace

/// The inputs of one update, the encoder, and the loss of its training.
class vtkFlowMatchingTrainer::Internals
{
public:
  explicit Internals(vtkFlowMatchingTrainer* self)
    : Self(self)
  {}

  /// Reads the inputs, all time steps of them. Errors are thrown by Train(), which has the frame for them: every rank of a
  /// parallel pipeline must take part in updating the filters upstream, and only one trains.
  void Read(vtkInformationVector** inputVector)
  {
    this->Data.reset();
    this->Failure = nullptr;
    try
    {
      if (!this->UsesDatasetFile())
      {
        this->Data = surfsynth::ReadTrainingInputs(this->Self, inputVector, this->Self->SignalArrayName, ReadingShare);
      }
    }
    catch (...)
    {
      this->Failure = std::current_exception();
    }
  }

  void Train(Run& run)
  {
    this->EncoderLoss = std::make_shared<std::atomic<double>>(-1.0);
    if (this->Failure)
    {
      std::rethrow_exception(std::exchange(this->Failure, nullptr));
    }
    if (this->UsesDatasetFile())
    {
      this->Data = surfsynth::ReadSignalDataset(this->Self->GetDatasetFileName());
    }
    if (!this->Data) // of empty inputs
    {
      return;
    }
    const auto stages = std::make_shared<Stages>(this->MakeStages(run));
    run.Train([stages](surfsynth::TrainingWatch& watch) { stages->Train(watch); });
  }

  /// Of the last training, -1 without one.
  double GetEncoderLoss() const { return *this->EncoderLoss; }

private:
  /// The trainings of one update, without VTK.
  struct Stages
  {
    SignalDataset Data;
    FlowMatchingTrainingOptions Options;
    TrainingFiles Files;
    surfsynth::EncodingTrainingOptions Encoding; ///< of the encoder; used where EncoderFiles has a model
    TrainingFiles EncoderFiles;
    std::shared_ptr<std::atomic<double>> EncoderLoss;

    void Train(surfsynth::TrainingWatch& watch)
    {
      const surfsynth::Progress progress = surfsynth::SubProgress(watch.GetProgress(), ReadingShare, 1.0);
      const surfsynth::TimeLimit limit(this->Files.TimeBudget);
      double encoded = 0.0;
      if (!this->EncoderFiles.Model.empty())
      {
        const auto iterations = static_cast<double>(this->Encoding.Iterations);
        encoded = iterations / (iterations + static_cast<double>(this->Options.Iterations));
        if (!this->TrainEncoder(watch, surfsynth::SubProgress(progress, 0.0, encoded)))
        {
          return;
        }
        this->Files.TimeBudget = limit.MinutesLeft();
        this->Options.Encoder = surfsynth::ReadPoissonNet(this->EncoderFiles.Model); // as a later training reads it
      }
      watch.Finish(surfsynth::TrainFlowMatching(std::move(this->Data), this->Options, this->Files,
        watch.ShowProgress(surfsynth::TrainingClock(this->Options.Iterations)),
        surfsynth::SubProgress(progress, encoded, 1.0)));
    }

    /// Writes the encoder. @return false when the time budget has ended its training early.
    bool TrainEncoder(surfsynth::TrainingWatch& watch, const surfsynth::Progress& progress)
    {
      const surfsynth::EncodingTrainer trainer = TrainEncoding(this->Data, this->Encoding, this->EncoderFiles,
        watch.ShowProgress(surfsynth::TrainingClock(this->Encoding.Iterations), "encoder: "), progress);
      *this->EncoderLoss = trainer.History().LastMean();
      return !watch.EndsEarly(trainer, "encoder");
    }
  };

  Stages MakeStages(const Run& run)
  {
    Stages stages;
    stages.Options = this->Options(run);
    stages.Files = this->Files(run);
    stages.EncoderLoss = this->EncoderLoss;
    if (this->Self->EncoderIterations > 0)
    {
      // Errors of the training that follows are thrown now, and not after hours.
      CheckOptions(stages.Options);
      CheckFiles(stages.Files);
      this->RequireEncoderOf(stages.Files, run);
      stages.Encoding = this->Encoding(stages.Options);
      stages.EncoderFiles = this->EncoderFiles(run);
    }
    stages.Data = *std::exchange(this->Data, std::nullopt);
    return stages;
  }

  bool UsesDatasetFile() const { return *this->Self->GetDatasetFileName() != '\0'; }

  /// @throws ModelMismatch when the checkpoint of the model is of an encoder that would be trained on.
  void RequireEncoderOf(const TrainingFiles& model, const Run& run) const
  {
    const std::int64_t iterations = CheckpointIterations(this->EncoderFiles(run));
    if (HasCheckpoint(model) && iterations > 0 && iterations < this->Self->EncoderIterations)
    {
      throw surfsynth::ModelMismatch(model.Checkpoint + ": the checkpoint is of an encoder of " +
        std::to_string(iterations) + " iterations; expected the " + std::to_string(this->Self->EncoderIterations) +
        " of EncoderIterations. Ask for as many as before, or begin the model anew with another checkpoint file.");
    }
  }

  /// The recipe of an encoder of the surfaces that this training is of, as that of the training which is to use it.
  surfsynth::EncodingTrainingOptions Encoding(const FlowMatchingTrainingOptions& recipe) const
  {
    if (this->Data->Sources.size() < 2)
    {
      throw surfsynth::InvalidInput("EncoderIterations is " + std::to_string(this->Self->EncoderIterations) +
        " and there is one source; an encoder tells where on surfaces of different shape a point is, and needs "
        "several. A model of one source is trained with 0.");
    }
    if (recipe.InitialModel)
    {
      throw surfsynth::InvalidInput("EncoderIterations is " + std::to_string(this->Self->EncoderIterations) +
        " and InitialModelFileName is given; expected 0, because that model has its own encoder, or none.");
    }
    if (recipe.WithoutEncoder)
    {
      throw surfsynth::InvalidInput("EncoderIterations is " + std::to_string(this->Self->EncoderIterations) +
        " and WithoutEncoder is on; expected 0, or WithoutEncoder off.");
    }
    surfsynth::EncodingTrainingOptions options;
    static_cast<surfsynth::TrainingOptions&>(options) = recipe;
    options.Iterations = this->Self->EncoderIterations;
    options.Milestones.clear(); // they count the iterations of the other training
    options.Eigenfunctions = this->Self->NumberOfEigenfunctions;
    options.EdgeSplits = this->Self->EncoderEdgeSplits;
    options.BatchSize = recipe.BatchSize;
    return options;
  }

  FlowMatchingTrainingOptions Options(const Run& run)
  {
    const vtkFlowMatchingTrainer& self = *this->Self;
    FlowMatchingTrainingOptions options;
    run.SetSharedOptions(options);
    options.Width = self.Width;
    options.Blocks = self.Blocks;
    options.ComplexLayers = self.ComplexLayers;
    options.InnerProducts = self.InnerProducts;
    if (self.Prediction != AUTOMATIC)
    {
      options.Prediction = static_cast<surfsynth::FlowPrediction>(self.Prediction);
    }
    options.Noise.Model = static_cast<surfsynth::NoiseModel>(self.NoiseModel);
    options.Noise.Screening = self.Screening;
    options.Noise.Smoothing = self.NoiseSmoothing < 0.0 ? surfsynth::ChosenSmoothing : self.NoiseSmoothing;
    options.Noise.Eigenpairs = self.NumberOfEigenpairs;
    options.Noise.Scale = self.NoiseScale;
    if (!self.EncoderFileName.empty() && self.EncoderIterations == 0)
    {
      options.Encoder = *this->EncoderFile.Get(self.EncoderFileName);
    }
    if (!self.InitialModelFileName.empty())
    {
      options.InitialModel = *this->InitialFile.Get(self.InitialModelFileName);
    }
    options.WithoutEncoder = self.WithoutEncoder;
    options.Iterations = self.Iterations;
    options.BatchSize = self.BatchSize;
    options.SourcesPerBatch = self.SourcesPerBatch;
    options.SourceMemory = self.SourceMemory;
    options.Optimizer = static_cast<surfsynth::TrainingOptimizer>(self.Optimizer);
    options.Schedule = static_cast<surfsynth::LearningRateSchedule>(self.LearningRateSchedule);
    options.Milestones.assign(self.Milestones.begin(), self.Milestones.end());
    options.LearningRateFactor = self.LearningRateFactor;
    options.GradientClip = self.GradientClip;
    options.VertexWeight = self.VertexWeight;
    options.JacobianWeight = self.JacobianWeight;
    options.WeightAveraging = self.WeightAveraging;
    return options;
  }

  TrainingFiles Files(const Run& run) const
  {
    TrainingFiles files = run.Files();
    files.Inputs.push_back(this->Self->InitialModelFileName);
    if (this->Self->EncoderIterations > 0)
    {
      const TrainingFiles encoder = this->EncoderFiles(run);
      files.Inputs.insert(files.Inputs.end(), { encoder.Model, encoder.Checkpoint, encoder.LossTable });
    }
    else
    {
      files.Inputs.push_back(this->Self->EncoderFileName);
    }
    return files;
  }

  /// The files of the training of the encoder, beside those of the model.
  TrainingFiles EncoderFiles(const Run& run) const
  {
    const std::string& encoder = this->Self->EncoderFileName;
    TrainingFiles files = run.Files();
    files.Model = encoder.empty() ? files.Model + ".encoder" : encoder;
    files.Checkpoint = files.Model + ".checkpoint";
    files.LossTable = files.LossTable.empty() ? "" : files.Model + ".csv";
    return files;
  }

  vtkFlowMatchingTrainer* Self;
  std::shared_ptr<std::atomic<double>> EncoderLoss = std::make_shared<std::atomic<double>>(-1.0);
  std::optional<SignalDataset> Data;
  std::exception_ptr Failure;
  static surfsynth::PoissonNetModel ReadEncoder(const std::string& path) { return surfsynth::ReadPoissonNet(path); }
  surfsynth::FileCache<surfsynth::PoissonNetModel> EncoderFile{ ReadEncoder,
    "EncoderFileName must name a PoissonNet in safetensors format, as a training with EncoderIterations writes it." };
  static FlowMatchingModel ReadInitial(const std::string& path) { return surfsynth::ReadFlowMatchingModel(path); }
  surfsynth::FileCache<FlowMatchingModel> InitialFile{
    ReadInitial,
    "InitialModelFileName must name a flow matching model in safetensors format, as vtkFlowMatchingTrainer writes it."
  };
};

vtkFlowMatchingTrainer::vtkFlowMatchingTrainer()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
  this->SetLearningRate(FlowMatchingTrainingOptions().LearningRate);
}

vtkFlowMatchingTrainer::~vtkFlowMatchingTrainer() = default;

void vtkFlowMatchingTrainer::SetSignalArrayName(const char* name) { this->SetText(this->SignalArrayName, name); }

void vtkFlowMatchingTrainer::SetEncoderFileName(const char* name) { this->SetText(this->EncoderFileName, name); }

void vtkFlowMatchingTrainer::SetInitialModelFileName(const char* name)
{
  this->SetText(this->InitialModelFileName, name);
}

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

double vtkFlowMatchingTrainer::GetEncoderLoss() const { return this->Impl->GetEncoderLoss(); }

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

void vtkFlowMatchingTrainer::ReadInputs(vtkInformationVector** inputVector) { this->Impl->Read(inputVector); }

void vtkFlowMatchingTrainer::Train(vtkInformationVector**, Run& run) { this->Impl->Train(run); }

void vtkFlowMatchingTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SignalArrayName: " << this->SignalArrayName << "\n";
  os << indent << "EncoderFileName: " << this->EncoderFileName << "\n";
  os << indent << "InitialModelFileName: " << this->InitialModelFileName << "\n";
  os << indent << "EncoderIterations: " << this->EncoderIterations << "\n";
  os << indent << "NumberOfEigenfunctions: " << this->NumberOfEigenfunctions << "\n";
  os << indent << "EncoderEdgeSplits: " << this->EncoderEdgeSplits << "\n";
  os << indent << "WithoutEncoder: " << this->WithoutEncoder << "\n";
  os << indent << "Width: " << this->Width << "\n";
  os << indent << "Blocks: " << this->Blocks << "\n";
  os << indent << "ComplexLayers: " << this->ComplexLayers << "\n";
  os << indent << "InnerProducts: " << this->InnerProducts << "\n";
  os << indent << "Prediction: " << this->Prediction << "\n";
  os << indent << "NoiseModel: " << this->NoiseModel << "\n";
  os << indent << "Screening: " << this->Screening << "\n";
  os << indent << "NoiseSmoothing: " << this->NoiseSmoothing << "\n";
  os << indent << "NoiseScale: " << this->NoiseScale << "\n";
  os << indent << "NumberOfEigenpairs: " << this->NumberOfEigenpairs << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "BatchSize: " << this->BatchSize << "\n";
  os << indent << "SourcesPerBatch: " << this->SourcesPerBatch << "\n";
  os << indent << "SourceMemory: " << this->SourceMemory << "\n";
  os << indent << "Optimizer: " << this->Optimizer << "\n";
  os << indent << "LearningRateSchedule: " << this->LearningRateSchedule << "\n";
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
  os << indent << "EncoderLoss: " << this->GetEncoderLoss() << "\n";
}
