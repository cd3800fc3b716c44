// SPDX-License-Identifier: BSD-3-Clause
#include "vtkLatentDiffusionTrainer.h"

#include "DataObjects.h"
#include "DistributedSurfaces.h"
#include "LatentDatasets.h"
#include "ModelTrainerRun.h"
#include "Reporting.h"
#include "SurfaceInputs.h"
#include "TextureSampleWriter.h"

#include "Core/Common/Errors.h"
#include "IO/Datasets/LatentDataset.h"
#include "IO/Weights/InstalledModels.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Learning/Training/LatentDiffusionTrainer.h"

#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

using surfsynth::LatentDataset;
using surfsynth::LatentDiffusionOptions;
using surfsynth::LatentDiffusionTrainingOptions;

vtkStandardNewMacro(vtkLatentDiffusionTrainer);

namespace
{
/// Part of the progress that the dataset takes.
constexpr double AfterDataset = 0.1;
/// Default of LearningRate, which is larger than that of the other trainings.
constexpr double DefaultDiffusionRate = 1e-3;
} // namespace

/// Dataset and recipe of one update.
class vtkLatentDiffusionTrainer::Internals
{
public:
  explicit Internals(vtkLatentDiffusionTrainer* self)
    : Self(self)
  {}

  void Train(vtkInformationVector** inputVector, Run& run) const
  {
    const bool isTraining = this->Self->Iterations > 0;
    if (!isTraining && this->Self->EncodedDatasetFileName.empty())
    {
      throw surfsynth::InvalidInput(
        "Iterations is 0 and EncodedDatasetFileName is empty: nothing is trained and nothing "
        "is written. At least one of them is needed.");
    }
    // The files and the recipe are checked before the long work on the dataset.
    surfsynth::TrainingFiles files = isTraining ? run.Files() : surfsynth::TrainingFiles();
    const std::shared_ptr<std::string> problem = isTraining ? this->WriteSamples(inputVector, files) : nullptr;
    const LatentDiffusionTrainingOptions options = this->Options(run);
    if (isTraining)
    {
      CheckOptions(options);
    }
    const auto data = std::make_shared<LatentDataset>(this->Dataset(inputVector, run.GetProgress()));
    if (data->Surfaces.empty())
    {
      return;
    }
    if (!this->Self->EncodedDatasetFileName.empty())
    {
      surfsynth::WriteLatentDataset(this->Self->EncodedDatasetFileName, *data);
    }
    if (!isTraining)
    {
      return;
    }
    const bool inBackground = this->Self->GetBackground();
    run.Train([data, files, options, problem, inBackground](surfsynth::TrainingWatch& watch) {
      const surfsynth::TrainingClock clock(options.Iterations);
      watch.Finish(surfsynth::TrainLatentDiffusion(std::move(*data), options, files, watch.ShowProgress(clock),
        surfsynth::SubProgress(watch.GetProgress(), AfterDataset, 1.0)));
      if (inBackground && !problem->empty())
      {
        throw surfsynth::InvalidInput("The model is trained. " + *problem);
      }
    });
    if (!inBackground && !problem->empty())
    {
      surfsynth::ReportWarning(this->Self, "", *problem);
    }
  }

private:
  /// Adds the samples along the way to the files of a training. @return the text of what went wrong with them, or of nothing
  std::shared_ptr<std::string> WriteSamples(vtkInformationVector** inputVector, surfsynth::TrainingFiles& files) const
  {
    vtkLatentDiffusionTrainer& self = *this->Self;
    files.Inputs.push_back(surfsynth::ModelPath(self.AutoencoderFileName));
    surfsynth::TextureSampleWriter writer;
    if (self.SampleFileName.empty())
    {
      return writer.Problem;
    }
    if (surfsynth::Ranks::Several())
    {
      throw surfsynth::InvalidInput(
        "SampleFileName is set and there are several processes; a training samples along the way in one process only.");
    }
    writer.Mesh = vtkSmartPointer<vtkPolyData>::New();
    writer.Mesh->DeepCopy(this->Surface(inputVector, "a textured surface is needed to sample for SampleFileName"));
    writer.Model = files.Model;
    writer.Autoencoder = self.AutoencoderFileName;
    writer.LabelArrayName = self.LabelArrayName;
    writer.DirectionArrayName = self.DirectionArrayName;
    writer.Seed = self.GetSeed();
    writer.NumberOfSteps = std::min(writer.NumberOfSteps, self.TimeSteps);
    writer.Path = self.SampleFileName;
    files.Sample = self.SampleFileName;
    files.Inputs.push_back(self.EncodedDatasetFileName);
    if (!surfsynth::IsEmpty(writer.Mesh))
    {
      files.AfterWriting = writer;
    }
    return writer.Problem;
  }

  /// The surface on port 0. @param needed what is needed where there is none, for the message
  vtkSmartPointer<vtkPolyData> Surface(vtkInformationVector** inputVector, const std::string& needed) const
  {
    if (this->Self->GetNumberOfInputConnections(0) == 0)
    {
      throw surfsynth::InvalidInput("There is no surface on port 0; " + needed + ".");
    }
    vtkSmartPointer<vtkPolyData> mesh = surfsynth::SurfaceOn(inputVector[0]);
    if (!mesh)
    {
      throw surfsynth::InvalidInput("The surface on port 0 is " +
        surfsynth::DescribeInput(vtkDataObject::GetData(inputVector[0])) + "; one vtkPolyData is needed.");
    }
    return mesh;
  }

  /// Without surfaces when the input is empty.
  LatentDataset Dataset(vtkInformationVector** inputVector, const surfsynth::Progress& progress) const
  {
    vtkLatentDiffusionTrainer& self = *this->Self;
    const std::string file = self.GetDatasetFileName();
    if (!file.empty())
    {
      return surfsynth::ReadLatentDataset(file);
    }
    const vtkSmartPointer<vtkPolyData> mesh = this->Surface(
      inputVector, "a textured surface, or a DatasetFileName, is needed");
    if (surfsynth::IsEmpty(mesh))
    {
      return {};
    }
    const surfsynth::FieldLatentModel autoencoder = this->Autoencoder();
    surfsynth::LatentDatasetRequest request;
    request.Mesh = mesh;
    request.Image = this->Image(inputVector[1]);
    request.ColorArrayName = self.ColorArrayName;
    request.LabelArrayName = self.LabelArrayName;
    request.DirectionArrayName = self.DirectionArrayName;
    request.NumberOfTriangulations = self.NumberOfTriangulations;
    request.NumberOfPoints = self.NumberOfPoints;
    request.Seed = static_cast<std::uint64_t>(self.GetSeed());
    request.Autoencoder = &autoencoder;
    request.Warn = [&self](const std::string& text) { surfsynth::ReportWarning(&self, "", text); };
    const double end = self.Iterations > 0 ? AfterDataset : 1.0;
    return surfsynth::MakeLatentDataset(request, surfsynth::SubProgress(progress, 0.0, end));
  }

  surfsynth::FieldLatentModel Autoencoder() const
  {
    if (this->Self->AutoencoderFileName.empty())
    {
      throw surfsynth::InvalidInput(
        "AutoencoderFileName is empty; the path of an autoencoder of field latents is needed.");
    }
    return surfsynth::ReadFieldLatents(surfsynth::ExistingModelPath(this->Self->AutoencoderFileName));
  }

  vtkImageData* Image(vtkInformationVector* port) const
  {
    if (this->Self->GetNumberOfInputConnections(1) == 0)
    {
      return nullptr;
    }
    auto* image = vtkImageData::SafeDownCast(vtkDataObject::GetData(port));
    if (!image)
    {
      throw surfsynth::InvalidInput("The texture image on port 1 is missing; a vtkImageData is needed.");
    }
    return image;
  }

  LatentDiffusionTrainingOptions Options(const Run& run) const
  {
    const vtkLatentDiffusionTrainer& self = *this->Self;
    LatentDiffusionTrainingOptions options;
    run.SetSharedOptions(options);
    options.Network = this->Network();
    options.Iterations = self.Iterations;
    options.BatchSize = self.BatchSize;
    options.Optimizer = static_cast<surfsynth::TrainingOptimizer>(self.Optimizer);
    options.FinalLearningRate = self.FinalLearningRate;
    options.GradientClip = self.GradientClip;
    options.WeightAveraging = self.WeightAveraging;
    options.SnrLimit = self.SnrLimit;
    options.ConditionDropout = self.ConditionDropout;
    options.SampleLatents = self.SampleLatents;
    return options;
  }

  /// Sizes of the preset where a property is 0.
  LatentDiffusionOptions Network() const
  {
    const vtkLatentDiffusionTrainer& self = *this->Self;
    LatentDiffusionOptions network = self.Sizes == PAPER ? LatentDiffusionOptions::Paper()
                                                         : LatentDiffusionOptions::Small();
    const std::pair<int, std::int64_t*> sizes[] = { { self.Channels, &network.Channels },
      { self.CoarseChannels, &network.CoarseChannels }, { self.InputBlocks, &network.InputBlocks },
      { self.CoarseBlocks, &network.CoarseBlocks }, { self.OutputBlocks, &network.OutputBlocks } };
    for (const auto& [given, size] : sizes)
    {
      *size = given > 0 ? given : *size;
    }
    network.EmbeddingDimension = self.EmbeddingDimension;
    network.TimeSteps = self.TimeSteps;
    network.FirstVariance = self.FirstVariance;
    network.LastVariance = self.LastVariance;
    network.Target = self.Target == DATA ? surfsynth::DiffusionTarget::Data
      : self.Target == VELOCITY          ? surfsynth::DiffusionTarget::Velocity
                                         : surfsynth::DiffusionTarget::Noise;
    return network;
  }

  vtkLatentDiffusionTrainer* Self;
};

vtkLatentDiffusionTrainer::vtkLatentDiffusionTrainer()
{
  this->SetNumberOfInputPorts(2);
  this->SetLearningRate(DefaultDiffusionRate);
}

vtkLatentDiffusionTrainer::~vtkLatentDiffusionTrainer() = default;

void vtkLatentDiffusionTrainer::SetAutoencoderFileName(const char* name)
{
  this->SetText(this->AutoencoderFileName, name);
}

void vtkLatentDiffusionTrainer::SetColorArrayName(const char* name) { this->SetText(this->ColorArrayName, name); }

void vtkLatentDiffusionTrainer::SetLabelArrayName(const char* name) { this->SetText(this->LabelArrayName, name); }

void vtkLatentDiffusionTrainer::SetDirectionArrayName(const char* name)
{
  this->SetText(this->DirectionArrayName, name);
}

void vtkLatentDiffusionTrainer::SetEncodedDatasetFileName(const char* name)
{
  this->SetText(this->EncodedDatasetFileName, name);
}

void vtkLatentDiffusionTrainer::SetSampleFileName(const char* name) { this->SetText(this->SampleFileName, name); }

int vtkLatentDiffusionTrainer::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in its place
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
    return 1;
  }
  return surfsynth::AcceptSurface(info);
}

int vtkLatentDiffusionTrainer::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  if (!this->Superclass::RequestUpdateExtent(request, inputVector, outputVector))
  {
    return 0;
  }
  for (int k = 0; k < inputVector[1]->GetNumberOfInformationObjects(); ++k)
  {
    vtkInformation* image = inputVector[1]->GetInformationObject(k);
    if (image->Has(Pipeline::WHOLE_EXTENT()))
    {
      image->Set(Pipeline::UPDATE_EXTENT(), image->Get(Pipeline::WHOLE_EXTENT()), 6);
    }
  }
  return 1;
}

void vtkLatentDiffusionTrainer::Train(vtkInformationVector** inputVector, Run& run)
{
  Internals(this).Train(inputVector, run);
}

void vtkLatentDiffusionTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "AutoencoderFileName: " << this->AutoencoderFileName << "\n";
  os << indent << "ColorArrayName: " << this->ColorArrayName << "\n";
  os << indent << "LabelArrayName: " << this->LabelArrayName << "\n";
  os << indent << "DirectionArrayName: " << this->DirectionArrayName << "\n";
  os << indent << "NumberOfTriangulations: " << this->NumberOfTriangulations << "\n";
  os << indent << "NumberOfPoints: " << this->NumberOfPoints << "\n";
  os << indent << "EncodedDatasetFileName: " << this->EncodedDatasetFileName << "\n";
  os << indent << "SampleFileName: " << this->SampleFileName << "\n";
  os << indent << "Sizes: " << this->Sizes << "\n";
  os << indent << "Channels: " << this->Channels << "\n";
  os << indent << "CoarseChannels: " << this->CoarseChannels << "\n";
  os << indent << "InputBlocks: " << this->InputBlocks << "\n";
  os << indent << "CoarseBlocks: " << this->CoarseBlocks << "\n";
  os << indent << "OutputBlocks: " << this->OutputBlocks << "\n";
  os << indent << "EmbeddingDimension: " << this->EmbeddingDimension << "\n";
  os << indent << "TimeSteps: " << this->TimeSteps << "\n";
  os << indent << "FirstVariance: " << this->FirstVariance << "\n";
  os << indent << "LastVariance: " << this->LastVariance << "\n";
  os << indent << "SampleLatents: " << this->SampleLatents << "\n";
  os << indent << "Target: " << this->Target << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "BatchSize: " << this->BatchSize << "\n";
  os << indent << "Optimizer: " << this->Optimizer << "\n";
  os << indent << "FinalLearningRate: " << this->FinalLearningRate << "\n";
  os << indent << "GradientClip: " << this->GradientClip << "\n";
  os << indent << "WeightAveraging: " << this->WeightAveraging << "\n";
  os << indent << "SnrLimit: " << this->SnrLimit << "\n";
  os << indent << "ConditionDropout: " << this->ConditionDropout << "\n";
}
