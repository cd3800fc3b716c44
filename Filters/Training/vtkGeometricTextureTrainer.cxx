// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureTrainer.h"

#include "JointProcessing.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>

#include <utility>
#include <vector>

using surfsynth::GeometricTextureTrainingOptions;
using surfsynth::GeometricTextureTrainingStep;
using surfsynth::InvalidInput;
using surfsynth::MultiscaleDataset;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkGeometricTextureTrainer);

namespace
{
/// @param name of the surface, for messages. All points are kept: those of the levels follow one another.
TriangleMesh MeshOf(vtkDataObject* data, const std::string& name)
{
  auto* surface = vtkPolyData::SafeDownCast(data);
  if (!surface)
  {
    throw InvalidInput(name + " is a " + data->GetClassName() +
      "; a vtkPolyData of triangles is needed, as vtkMultiscaleMeshFitter makes it.");
  }
  try
  {
    return surfsynth::ToSurface(surface, surfsynth::GeometricTextureSampler::Requirements()).Mesh;
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(name + ": " + error.what());
  }
}

bool IsEmpty(vtkDataObject* data)
{
  auto* surface = vtkPolyData::SafeDownCast(data);
  return !data || (surface && surface->GetNumberOfPoints() == 0 && surface->GetNumberOfCells() == 0);
}

/// The leaves of @p levels in order, but for empty ones.
std::vector<TriangleMesh> ReadLevels(vtkDataObject* levels)
{
  std::vector<TriangleMesh> meshes;
  const auto add = [&](vtkDataObject* data) {
    if (!IsEmpty(data))
    {
      meshes.push_back(MeshOf(data, "Level " + std::to_string(meshes.size())));
    }
  };
  auto* tree = vtkDataObjectTree::SafeDownCast(levels);
  if (!tree)
  {
    add(levels);
    return meshes;
  }
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    add(place->GetCurrentDataObject());
  }
  return meshes;
}

void FillTable(vtkTable* table, const std::vector<GeometricTextureTrainingStep>& history)
{
  const auto rows = static_cast<vtkIdType>(history.size());
  const auto addColumn = [&](auto* column, const char* name, const auto& member) {
    column->SetName(name);
    column->SetNumberOfTuples(rows);
    for (vtkIdType k = 0; k < rows; ++k)
    {
      column->SetValue(k, history[static_cast<std::size_t>(k)].*member);
    }
    table->AddColumn(column);
  };
  addColumn(vtkNew<vtkIdTypeArray>().Get(), "iteration", &GeometricTextureTrainingStep::Iteration);
  addColumn(vtkNew<vtkIdTypeArray>().Get(), "level", &GeometricTextureTrainingStep::Level);
  addColumn(vtkNew<vtkDoubleArray>().Get(), "critic_loss", &GeometricTextureTrainingStep::CriticLoss);
  addColumn(vtkNew<vtkDoubleArray>().Get(), "gradient_penalty", &GeometricTextureTrainingStep::GradientPenalty);
  addColumn(vtkNew<vtkDoubleArray>().Get(), "adversarial_loss", &GeometricTextureTrainingStep::AdversarialLoss);
  addColumn(vtkNew<vtkDoubleArray>().Get(), "reconstruction_loss", &GeometricTextureTrainingStep::ReconstructionLoss);
  addColumn(vtkNew<vtkDoubleArray>().Get(), "learning_rate", &GeometricTextureTrainingStep::LearningRate);
}
} // namespace

/// What one update trains, and what came of the last.
class vtkGeometricTextureTrainer::Internals
{
public:
  explicit Internals(vtkGeometricTextureTrainer* self)
    : Self(self)
  {}

  void Train(vtkInformationVector** inputVector, vtkTable* table, const surfsynth::Progress& progress)
  {
    const surfsynth::TrainingFiles files = this->Files();
    MultiscaleDataset dataset = this->Dataset(inputVector);
    if (dataset.Levels.empty())
    {
      return;
    }
    const auto iterations = static_cast<std::int64_t>(dataset.Levels.size()) * this->Self->IterationsPerLevel;
    surfsynth::TrainingClock clock(iterations);
    const auto observe = [&](const GeometricTextureTrainingStep& step) {
      surfsynth::TrainingStep line;
      line.Iteration = step.Iteration;
      line.Loss = step.ReconstructionLoss;
      clock.Add(line);
      this->Self->SetProgressText(clock.Describe().c_str());
      return true;
    };
    const surfsynth::GeometricTextureTrainer trainer = surfsynth::TrainGeometricTexture(
      std::move(dataset), this->Options(), files, observe, progress);
    this->IterationsDone = trainer.Iteration();
    this->DeviceInUse = trainer.DeviceName();
    FillTable(table, trainer.History());
  }

  vtkTypeInt64 IterationsDone = 0;
  std::string DeviceInUse;

private:
  /// Without levels when the input is empty.
  MultiscaleDataset Dataset(vtkInformationVector** inputVector) const
  {
    if (!this->Self->DatasetFileName.empty())
    {
      return surfsynth::ReadMultiscaleDataset(this->Self->DatasetFileName);
    }
    vtkDataObject* levels = vtkDataObject::GetData(inputVector[0]);
    if (!levels)
    {
      throw InvalidInput("There are no levels on port 0; a surface at several scales, as vtkMultiscaleMeshFitter makes "
                         "it, or a DatasetFileName is needed.");
    }
    MultiscaleDataset dataset;
    dataset.Levels = ReadLevels(levels);
    vtkDataObject* start = vtkDataObject::GetData(inputVector[1]);
    if (!dataset.Levels.empty() && !IsEmpty(start))
    {
      dataset.Template = MeshOf(start, "The template");
    }
    return dataset;
  }

  GeometricTextureTrainingOptions Options() const
  {
    const vtkGeometricTextureTrainer& self = *this->Self;
    GeometricTextureTrainingOptions options;
    options.Name = self.TextureName;
    options.IterationsPerLevel = self.IterationsPerLevel;
    options.DiscriminatorSteps = self.DiscriminatorSteps;
    options.GeneratorSteps = self.GeneratorSteps;
    options.LearningRate = self.LearningRate;
    options.LearningRateInterval = self.LearningRateInterval;
    options.LearningRateFactor = self.LearningRateFactor;
    options.PenaltyWeight = self.PenaltyWeight;
    options.ReconstructionWeight = self.ReconstructionWeight;
    options.Network.Layers = self.Layers;
    options.Network.StartChannels = self.StartChannels;
    options.Network.MinimumChannels = self.MinimumChannels;
    options.Network.MaximumChannels = self.MaximumChannels;
    options.Network.NoiseAmplitude = self.NoiseAmplitude;
    options.Seed = static_cast<std::uint64_t>(self.Seed);
    options.Device = static_cast<surfsynth::TrainingDevice>(self.Device);
    return options;
  }

  surfsynth::TrainingFiles Files() const
  {
    const vtkGeometricTextureTrainer& self = *this->Self;
    if (self.ModelFileName.empty())
    {
      throw InvalidInput("ModelFileName is empty; a path for the model file is needed.");
    }
    if (self.TextureName.empty())
    {
      throw InvalidInput("TextureName is empty; a name for the texture is needed.");
    }
    surfsynth::TrainingFiles files;
    files.Model = self.ModelFileName;
    files.Checkpoint = self.CheckpointFileName.empty() ? self.ModelFileName + ".checkpoint" : self.CheckpointFileName;
    files.LossTable = self.LossTableFileName;
    files.CheckpointInterval = self.CheckpointInterval;
    files.Resume = self.Resume;
    return files;
  }

  vtkGeometricTextureTrainer* Self;
};

vtkGeometricTextureTrainer::vtkGeometricTextureTrainer()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkGeometricTextureTrainer::~vtkGeometricTextureTrainer() = default;

void vtkGeometricTextureTrainer::SetText(std::string& property, const char* text)
{
  const std::string wanted = text ? text : "";
  if (property != wanted)
  {
    property = wanted;
    this->Modified();
  }
}

void vtkGeometricTextureTrainer::SetModelFileName(const char* name) { this->SetText(this->ModelFileName, name); }

void vtkGeometricTextureTrainer::SetCheckpointFileName(const char* name)
{
  this->SetText(this->CheckpointFileName, name);
}

void vtkGeometricTextureTrainer::SetLossTableFileName(const char* name)
{
  this->SetText(this->LossTableFileName, name);
}

void vtkGeometricTextureTrainer::SetDatasetFileName(const char* name) { this->SetText(this->DatasetFileName, name); }

void vtkGeometricTextureTrainer::SetTextureName(const char* name) { this->SetText(this->TextureName, name); }

vtkTypeInt64 vtkGeometricTextureTrainer::GetNumberOfIterationsDone() const { return this->Impl->IterationsDone; }

const char* vtkGeometricTextureTrainer::GetDeviceInUse() const { return this->Impl->DeviceInUse.c_str(); }

int vtkGeometricTextureTrainer::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in their place
  if (port == 0)
  {
    return surfsynth::AcceptSurfaces(info);
  }
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  return 1;
}

int vtkGeometricTextureTrainer::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->IterationsDone = 0;
  this->Impl->DeviceInUse.clear();
  const int success = surfsynth::ProcessJointly(
    this, inputVector, outputVector, [&](const surfsynth::Progress& progress) {
      this->Impl->Train(inputVector, vtkTable::GetData(outputVector), progress);
    });
  this->SetProgressText(nullptr);
  return success;
}

void vtkGeometricTextureTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "CheckpointFileName: " << this->CheckpointFileName << "\n";
  os << indent << "LossTableFileName: " << this->LossTableFileName << "\n";
  os << indent << "CheckpointInterval: " << this->CheckpointInterval << "\n";
  os << indent << "Resume: " << this->Resume << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
  os << indent << "TextureName: " << this->TextureName << "\n";
  os << indent << "IterationsPerLevel: " << this->IterationsPerLevel << "\n";
  os << indent << "DiscriminatorSteps: " << this->DiscriminatorSteps << "\n";
  os << indent << "GeneratorSteps: " << this->GeneratorSteps << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "LearningRateInterval: " << this->LearningRateInterval << "\n";
  os << indent << "LearningRateFactor: " << this->LearningRateFactor << "\n";
  os << indent << "PenaltyWeight: " << this->PenaltyWeight << "\n";
  os << indent << "ReconstructionWeight: " << this->ReconstructionWeight << "\n";
  os << indent << "Layers: " << this->Layers << "\n";
  os << indent << "StartChannels: " << this->StartChannels << "\n";
  os << indent << "MinimumChannels: " << this->MinimumChannels << "\n";
  os << indent << "MaximumChannels: " << this->MaximumChannels << "\n";
  os << indent << "NoiseAmplitude: " << this->NoiseAmplitude << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "NumberOfIterationsDone: " << this->GetNumberOfIterationsDone() << "\n";
  os << indent << "DeviceInUse: " << this->GetDeviceInUse() << "\n";
}
