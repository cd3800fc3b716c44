// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFieldLatentTrainer.h"

#include "ModelTrainerRun.h"
#include "PlanarMeshes.h"
#include "Reporting.h"
#include "TrainingImages.h"

#include "Core/Common/Errors.h"
#include "IO/Datasets/TextureDataset.h"
#include "Learning/Training/FieldLatentTrainer.h"

#include <vtkDataObject.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

using surfsynth::FieldLatentOptions;
using surfsynth::FieldLatentTrainingOptions;
using surfsynth::TextureDataset;

vtkStandardNewMacro(vtkFieldLatentTrainer);

namespace
{
/// Part of the progress that the planar meshes take.
constexpr double AfterMeshes = 0.02;
/// Default of LearningRate, which is larger than that of the other trainings.
constexpr double DefaultAutoencoderRate = 1e-3;
} // namespace

/// Dataset and recipe of one update.
class vtkFieldLatentTrainer::Internals
{
public:
  explicit Internals(vtkFieldLatentTrainer* self)
    : Self(self)
  {}

  void Train(vtkInformationVector** inputVector, Run& run) const
  {
    const surfsynth::TrainingFiles files = run.Files();
    const FieldLatentTrainingOptions options = this->Options(run);
    CheckOptions(options);
    const auto data = std::make_shared<TextureDataset>(this->Dataset(inputVector, run.GetProgress()));
    if (data->Images.empty())
    {
      return;
    }
    run.Train([data, files, options](surfsynth::TrainingWatch& watch) {
      const surfsynth::TrainingClock clock(options.Iterations);
      watch.Finish(surfsynth::TrainFieldLatents(std::move(*data), options, files, watch.ShowProgress(clock),
        surfsynth::SubProgress(watch.GetProgress(), AfterMeshes, 1.0)));
    });
  }

private:
  /// Without images when the input is empty.
  TextureDataset Dataset(vtkInformationVector** inputVector, const surfsynth::Progress& progress) const
  {
    const std::string file = this->Self->GetDatasetFileName();
    if (!file.empty())
    {
      return surfsynth::ReadTextureDataset(file);
    }
    vtkDataObject* images = vtkDataObject::GetData(inputVector[0]);
    if (!images)
    {
      throw surfsynth::InvalidInput("There is no image on port 0; one or several, or a DatasetFileName, are needed.");
    }
    surfsynth::TrainingImages read = surfsynth::ReadTrainingImages(images);
    for (const std::string& remark : read.Remarks)
    {
      surfsynth::ReportWarning(this->Self, "", remark);
    }
    TextureDataset dataset;
    dataset.Images = std::move(read.Images);
    if (!dataset.Images.empty())
    {
      dataset.Meshes = surfsynth::MakePlanarMeshes(this->Self->NumberOfMeshes, this->Self->MeshPoints,
        static_cast<std::uint64_t>(this->Self->GetSeed()), surfsynth::SubProgress(progress, 0.0, AfterMeshes));
    }
    return dataset;
  }

  FieldLatentTrainingOptions Options(const Run& run) const
  {
    const vtkFieldLatentTrainer& self = *this->Self;
    FieldLatentTrainingOptions options;
    run.SetSharedOptions(options);
    options.Network = this->Network();
    options.Iterations = self.Iterations;
    options.BatchSize = self.BatchSize;
    options.FinalLearningRate = self.FinalLearningRate;
    options.DivergenceWeight = self.DivergenceWeight;
    options.MinimumTexels = self.MinimumTexels;
    options.MaximumTexels = self.MaximumTexels;
    options.TargetPower = self.TargetPower;
    options.ColorAugmentation = self.ColorAugmentation;
    options.GradientClip = self.GradientClip;
    return options;
  }

  /// Sizes of the preset where a property is 0.
  FieldLatentOptions Network() const
  {
    const vtkFieldLatentTrainer& self = *this->Self;
    FieldLatentOptions network = self.Sizes == PAPER ? FieldLatentOptions::Paper() : FieldLatentOptions::Small();
    const std::pair<int, std::int64_t*> sizes[] = { { self.LatentDimension, &network.LatentDimension },
      { self.Channels, &network.Channels }, { self.EncoderLayers, &network.EncoderLayers },
      { self.Heads, &network.Heads }, { self.SamplesPerRing, &network.SamplesPerRing },
      { self.DecoderLayers, &network.DecoderLayers }, { self.DecoderWidth, &network.DecoderWidth } };
    for (const auto& [given, size] : sizes)
    {
      *size = given > 0 ? given : *size;
    }
    network.Coordinates = self.Coordinates == BARYCENTRIC ? surfsynth::FieldLatentCoordinates::Barycentric
                                                          : surfsynth::FieldLatentCoordinates::Logarithmic;
    return network;
  }

  vtkFieldLatentTrainer* Self;
};

vtkFieldLatentTrainer::vtkFieldLatentTrainer()
{
  this->SetNumberOfInputPorts(1);
  this->SetLearningRate(DefaultAutoencoderRate);
}

vtkFieldLatentTrainer::~vtkFieldLatentTrainer() = default;

int vtkFieldLatentTrainer::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // there may be a dataset file in its place
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

void vtkFieldLatentTrainer::Train(vtkInformationVector** inputVector, Run& run)
{
  Internals(this).Train(inputVector, run);
}

void vtkFieldLatentTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfMeshes: " << this->NumberOfMeshes << "\n";
  os << indent << "MeshPoints: " << this->MeshPoints << "\n";
  os << indent << "Sizes: " << this->Sizes << "\n";
  os << indent << "LatentDimension: " << this->LatentDimension << "\n";
  os << indent << "Channels: " << this->Channels << "\n";
  os << indent << "EncoderLayers: " << this->EncoderLayers << "\n";
  os << indent << "Heads: " << this->Heads << "\n";
  os << indent << "SamplesPerRing: " << this->SamplesPerRing << "\n";
  os << indent << "DecoderLayers: " << this->DecoderLayers << "\n";
  os << indent << "DecoderWidth: " << this->DecoderWidth << "\n";
  os << indent << "Coordinates: " << this->Coordinates << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "BatchSize: " << this->BatchSize << "\n";
  os << indent << "FinalLearningRate: " << this->FinalLearningRate << "\n";
  os << indent << "DivergenceWeight: " << this->DivergenceWeight << "\n";
  os << indent << "MinimumTexels: " << this->MinimumTexels << "\n";
  os << indent << "MaximumTexels: " << this->MaximumTexels << "\n";
  os << indent << "TargetPower: " << this->TargetPower << "\n";
  os << indent << "ColorAugmentation: " << this->ColorAugmentation << "\n";
  os << indent << "GradientClip: " << this->GradientClip << "\n";
}
