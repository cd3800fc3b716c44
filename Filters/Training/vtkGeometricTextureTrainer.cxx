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
    const surfsynth::TrainingFiles files = run.Files();
    if (this->Self->TextureName.empty())
    {
      throw InvalidInput("TextureName is empty; a name for the texture is needed.");
    }
    MultiscaleDataset dataset = this->Dataset(inputVector);
    if (dataset.Levels.empty())
    {
      return;
    }
    const auto iterations = static_cast<std::int64_t>(dataset.Levels.size()) * this->Self->IterationsPerLevel;
    const auto data = std::make_shared<MultiscaleDataset>(std::move(dataset));
    run.Train([data, iterations, files, options = this->Options(run)](surfsynth::TrainingWatch& watch) {
      const surfsynth::TrainingClock clock(iterations, surfsynth::CostsOfLevels(*data, options.Network));
      watch.Finish(surfsynth::TrainGeometricTexture(
        std::move(*data), options, files, watch.ShowProgress(clock), watch.GetProgress()));
    });
  }

private:
  /// Without levels when the input is empty.
  MultiscaleDataset Dataset(vtkInformationVector** inputVector) const
  {
    const std::string file = this->Self->GetDatasetFileName();
    if (!file.empty())
    {
      return surfsynth::ReadMultiscaleDataset(file);
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
    if (!dataset.Levels.empty() && !IsEmptyLevel(start))
    {
      dataset.Template = ReadLevelMesh(start, "The template");
    }
    return dataset;
  }

  GeometricTextureTrainingOptions Options(const Run& run) const
  {
    const vtkGeometricTextureTrainer& self = *this->Self;
    GeometricTextureTrainingOptions options;
    run.SetSharedOptions(options);
    options.Name = self.TextureName;
    options.IterationsPerLevel = self.IterationsPerLevel;
    options.DiscriminatorSteps = self.DiscriminatorSteps;
    options.GeneratorSteps = self.GeneratorSteps;
    options.LearningRateInterval = self.LearningRateInterval;
    options.LearningRateFactor = self.LearningRateFactor;
    options.PenaltyWeight = self.PenaltyWeight;
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

int vtkGeometricTextureTrainer::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in their place
  if (port == 0)
  {
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
  os << indent << "IterationsPerLevel: " << this->IterationsPerLevel << "\n";
  os << indent << "DiscriminatorSteps: " << this->DiscriminatorSteps << "\n";
  os << indent << "GeneratorSteps: " << this->GeneratorSteps << "\n";
  os << indent << "LearningRateInterval: " << this->LearningRateInterval << "\n";
  os << indent << "LearningRateFactor: " << this->LearningRateFactor << "\n";
  os << indent << "PenaltyWeight: " << this->PenaltyWeight << "\n";
  os << indent << "ReconstructionWeight: " << this->ReconstructionWeight << "\n";
  os << indent << "Layers: " << this->Layers << "\n";
  os << indent << "StartChannels: " << this->StartChannels << "\n";
  os << indent << "MinimumChannels: " << this->MinimumChannels << "\n";
  os << indent << "MaximumChannels: " << this->MaximumChannels << "\n";
  os << indent << "NoiseAmplitude: " << this->NoiseAmplitude << "\n";
}
