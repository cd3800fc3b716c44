// SPDX-License-Identifier: BSD-3-Clause
#include "vtkGeometricTextureTrainer.h"

#include "ModelTrainerRun.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Training/GeometricTextureTrainer.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <utility>
#include <vector>

using surfsynth::GeometricTextureTrainingOptions;
using surfsynth::InvalidInput;
using surfsynth::MultiscaleDataset;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkGeometricTextureTrainer);

namespace
{
/// @param name of the surface, for messages. All points are kept: those of the levels follow one another.
TriangleMesh ReadLevelMesh(vtkDataObject* data, const std::string& name)
{
  const auto surface = vtkSmartPointer<vtkPolyData>(vtkPolyData::SafeDownCast(surfsynth::AsSurfaces(data)));
  if (!surface)
  {
    throw InvalidInput(name + " is " + surfsynth::DescribeInput(data) +
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

bool IsEmptyLevel(vtkDataObject* data)
{
  auto* surface = vtkPolyData::SafeDownCast(data);
  return !data || (surface && surface->GetNumberOfPoints() == 0 && surface->GetNumberOfCells() == 0);
}

/// The leaves of @p levels in order, but for empty ones.
std::vector<TriangleMesh> ReadLevels(vtkDataObject* levels)
{
  std::vector<TriangleMesh> meshes;
  const auto add = [&](vtkDataObject* data) {
    if (!IsEmptyLevel(data))
    {
      meshes.push_back(ReadLevelMesh(data, "Level " + std::to_string(meshes.size())));
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
} // namespace

/// Dataset and recipe of one update.
class vtkGeometricTextureTrainer::Internals
{
public:
  explicit Internals(vtkGeometricTextureTrainer* self)
    : Self(self)
  {}

  void Train(vtkInformationVector** inputVector, Run& run) const
  {
    surfsynth::TrainingFiles files = run.Files();
    const std::vector<std::string> names = this->ReferenceFiles();
    files.Inputs.insert(files.Inputs.end(), names.begin(), names.end());
    if (this->Self->TextureName.empty())
    {
      throw InvalidInput("TextureName is empty; a name for the texture is needed.");
    }
    const auto data = std::make_shared<std::vector<MultiscaleDataset>>(this->References(inputVector));
    if (data->front().Levels.empty())
    {
      return;
    }
    const GeometricTextureTrainingOptions options = this->Options(run);
    const std::vector<std::int64_t> iterations = surfsynth::IterationsOfEachLevel(options, data->front().Levels.size());
    run.Train([data, iterations, files, options](surfsynth::TrainingWatch& watch) {
      const surfsynth::TrainingClock clock(iterations, surfsynth::CostsOfLevels(*data, options.Network));
      watch.Finish(
        surfsynth::TrainGeometricTexture(*data, options, files, watch.ShowProgress(clock), watch.GetProgress()));
    });
  }

private:
  std::vector<std::string> ReferenceFiles() const
  {
    std::vector<std::string> names;
    for (const std::string& name : this->Self->ReferenceFileNames)
    {
      if (!name.empty())
      {
        names.push_back(name);
      }
    }
    return names;
  }

  /// At least one; the first is without levels when the input is empty.
  std::vector<MultiscaleDataset> References(vtkInformationVector** inputVector) const
  {
    const std::string file = this->Self->GetDatasetFileName();
    std::vector<MultiscaleDataset> references;
    if (file.empty())
    {
      references = ConnectedReferences(inputVector);
    }
    else
    {
      references.push_back(surfsynth::ReadMultiscaleDataset(file));
    }
    for (const std::string& name : this->ReferenceFiles())
    {
      references.push_back(surfsynth::ReadMultiscaleDataset(name));
    }
    return references;
  }

  static std::vector<MultiscaleDataset> ConnectedReferences(vtkInformationVector** inputVector)
  {
    std::vector<MultiscaleDataset> references;
    for (int k = 0; k < inputVector[0]->GetNumberOfInformationObjects(); ++k)
    {
      vtkDataObject* levels = vtkDataObject::GetData(inputVector[0], k);
      references.emplace_back();
      references.back().Levels = ReadLevels(levels);
    }
    if (references.empty())
    {
      throw InvalidInput("There are no levels on port 0; a surface at several scales, as vtkMultiscaleMeshFitter makes "
                         "it, or a DatasetFileName is needed.");
    }
    vtkDataObject* start = vtkDataObject::GetData(inputVector[1]);
    if (!references.front().Levels.empty() && !IsEmptyLevel(start))
    {
      references.front().Template = ReadLevelMesh(start, "The template");
    }
    return references;
  }

  GeometricTextureTrainingOptions Options(const Run& run) const
  {
    const vtkGeometricTextureTrainer& self = *this->Self;
    GeometricTextureTrainingOptions options;
    run.SetSharedOptions(options);
    options.Name = self.TextureName;
    options.Objective = static_cast<surfsynth::TextureObjective>(self.Objective);
    options.FlowSteps = self.FlowSteps;
    options.BaseNoiseAmplitude = self.BaseNoiseAmplitude;
    options.BaseSamples = self.NumberOfBaseSamples;
    options.Projections = self.NumberOfProjections;
    options.IterationsPerLevel = self.IterationsPerLevel;
    options.IterationsOfLevels.assign(self.IterationsOfLevels.begin(), self.IterationsOfLevels.end());
    options.DiscriminatorSteps = self.DiscriminatorSteps;
    options.GeneratorSteps = self.GeneratorSteps;
    options.LearningRateInterval = self.LearningRateInterval;
    options.LearningRateFactor = self.LearningRateFactor;
    options.PenaltyWeight = self.PenaltyWeight;
    options.PenaltyInterval = self.PenaltyInterval;
    options.ReconstructionWeight = self.ReconstructionWeight;
    options.Network.Layers = self.Layers;
    options.Network.StartChannels = self.StartChannels;
    options.Network.MinimumChannels = self.MinimumChannels;
    options.Network.MaximumChannels = self.MaximumChannels;
    options.Network.NoiseAmplitude = self.NoiseAmplitude;
    return options;
  }

  vtkGeometricTextureTrainer* Self;
};

vtkGeometricTextureTrainer::vtkGeometricTextureTrainer() { this->SetNumberOfInputPorts(2); }

vtkGeometricTextureTrainer::~vtkGeometricTextureTrainer() = default;

void vtkGeometricTextureTrainer::SetTextureName(const char* name) { this->SetText(this->TextureName, name); }

void vtkGeometricTextureTrainer::SetNumberOfReferenceFileNames(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->ReferenceFileNames.size() != wanted)
  {
    this->ReferenceFileNames.resize(wanted);
    this->Modified();
  }
}

void vtkGeometricTextureTrainer::SetReferenceFileName(int index, const char* name)
{
  if (index >= 0 && index < this->GetNumberOfReferenceFileNames())
  {
    this->SetText(this->ReferenceFileNames[static_cast<std::size_t>(index)], name);
  }
}

const char* vtkGeometricTextureTrainer::GetReferenceFileName(int index) const
{
  return index >= 0 && index < this->GetNumberOfReferenceFileNames()
    ? this->ReferenceFileNames[static_cast<std::size_t>(index)].c_str()
    : nullptr;
}

void vtkGeometricTextureTrainer::SetNumberOfIterationsOfLevels(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->IterationsOfLevels.size() != wanted)
  {
    this->IterationsOfLevels.resize(wanted, this->IterationsPerLevel);
    this->Modified();
  }
}

void vtkGeometricTextureTrainer::SetIterationsOfLevel(int index, int iterations)
{
  if (index < 0 || index >= this->GetNumberOfIterationsOfLevels())
  {
    return;
  }
  int& found = this->IterationsOfLevels[static_cast<std::size_t>(index)];
  const int wanted = std::clamp(iterations, 1, 100000000);
  if (found != wanted)
  {
    found = wanted;
    this->Modified();
  }
}

int vtkGeometricTextureTrainer::GetIterationsOfLevel(int index) const
{
  return index >= 0 && index < this->GetNumberOfIterationsOfLevels()
    ? this->IterationsOfLevels[static_cast<std::size_t>(index)]
    : 0;
}

int vtkGeometricTextureTrainer::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in their place
  if (port == 0)
  {
    info->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
    return surfsynth::AcceptSurfaces(info);
  }
  return surfsynth::AcceptSurface(info);
}

void vtkGeometricTextureTrainer::Train(vtkInformationVector** inputVector, Run& run)
{
  Internals(this).Train(inputVector, run);
}

void vtkGeometricTextureTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "TextureName: " << this->TextureName << "\n";
  os << indent << "ReferenceFileNames:";
  for (const std::string& name : this->ReferenceFileNames)
  {
    os << " " << name;
  }
  os << "\n";
  os << indent << "Objective: " << this->Objective << "\n";
  os << indent << "FlowSteps: " << this->FlowSteps << "\n";
  os << indent << "BaseNoiseAmplitude: " << this->BaseNoiseAmplitude << "\n";
  os << indent << "NumberOfBaseSamples: " << this->NumberOfBaseSamples << "\n";
  os << indent << "NumberOfProjections: " << this->NumberOfProjections << "\n";
  os << indent << "IterationsPerLevel: " << this->IterationsPerLevel << "\n";
  os << indent << "IterationsOfLevels:";
  for (const int iterations : this->IterationsOfLevels)
  {
    os << " " << iterations;
  }
  os << "\n";
  os << indent << "DiscriminatorSteps: " << this->DiscriminatorSteps << "\n";
  os << indent << "GeneratorSteps: " << this->GeneratorSteps << "\n";
  os << indent << "LearningRateInterval: " << this->LearningRateInterval << "\n";
  os << indent << "LearningRateFactor: " << this->LearningRateFactor << "\n";
  os << indent << "PenaltyWeight: " << this->PenaltyWeight << "\n";
  os << indent << "PenaltyInterval: " << this->PenaltyInterval << "\n";
  os << indent << "ReconstructionWeight: " << this->ReconstructionWeight << "\n";
  os << indent << "Layers: " << this->Layers << "\n";
  os << indent << "StartChannels: " << this->StartChannels << "\n";
  os << indent << "MinimumChannels: " << this->MinimumChannels << "\n";
  os << indent << "MaximumChannels: " << this->MaximumChannels << "\n";
  os << indent << "NoiseAmplitude: " << this->NoiseAmplitude << "\n";
}
