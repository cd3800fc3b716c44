// SPDX-License-Identifier: BSD-3-Clause
#include "vtkModelTrainer.h"

#include "FilterSupport.h"
#include "JointProcessing.h"
#include "ModelTrainerRun.h"
#include "TableColumns.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformationVector.h>
#include <vtkTable.h>

#include <string>
#include <vector>

namespace
{
/// Whole numbers as vtkIdType, all others as float64.
void AddLosses(vtkTable* table, const surfsynth::LossHistory& history)
{
  for (std::size_t column = 0; column < history.Columns().size(); ++column)
  {
    const std::string& name = history.Columns()[column];
    const std::vector<double> values = history.Column(name);
    if (column < history.NumberOfCounts())
    {
      surfsynth::AddColumn<vtkIdTypeArray>(table, name.c_str(), std::vector<vtkIdType>(values.begin(), values.end()));
    }
    else
    {
      surfsynth::AddColumn<vtkDoubleArray>(table, name.c_str(), values);
    }
  }
}
} // namespace

vtkModelTrainer::Run::Run(vtkModelTrainer* self, vtkTable* table, const surfsynth::Progress& progress)
  : Self(self)
  , Table(table)
  , Progress(progress)
{}

surfsynth::TrainingFiles vtkModelTrainer::Run::Files() const
{
  const vtkModelTrainer& self = *this->Self;
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
  files.Inputs = { self.DatasetFileName };
  return files;
}

void vtkModelTrainer::Run::SetSharedOptions(surfsynth::ModelTrainingOptions& options) const
{
  options.LearningRate = this->Self->LearningRate;
  options.Seed = static_cast<std::uint64_t>(this->Self->Seed);
  options.Device = static_cast<surfsynth::TrainingDevice>(this->Self->Device);
}

surfsynth::TrainingObserver vtkModelTrainer::Run::ShowProgress(std::int64_t iterations, const std::string& stage) const
{
  return [self = this->Self, clock = surfsynth::TrainingClock(iterations), stage](
           const surfsynth::LossHistory& history) mutable {
    clock.Add(history);
    self->SetProgressText((stage + clock.Describe()).c_str());
    return true;
  };
}

void vtkModelTrainer::Run::Finish(const surfsynth::ModelTrainer& trainer)
{
  this->Self->NumberOfIterationsDone = trainer.Iteration();
  this->Self->DeviceInUse = trainer.DeviceName();
  AddLosses(this->Table, trainer.History());
}

vtkModelTrainer::vtkModelTrainer() = default;

vtkModelTrainer::~vtkModelTrainer() = default;

void vtkModelTrainer::SetText(std::string& property, const char* text) { surfsynth::SetString(this, property, text); }

void vtkModelTrainer::SetModelFileName(const char* name) { this->SetText(this->ModelFileName, name); }

void vtkModelTrainer::SetCheckpointFileName(const char* name) { this->SetText(this->CheckpointFileName, name); }

void vtkModelTrainer::SetLossTableFileName(const char* name) { this->SetText(this->LossTableFileName, name); }

void vtkModelTrainer::SetDatasetFileName(const char* name) { this->SetText(this->DatasetFileName, name); }

vtkTypeInt64 vtkModelTrainer::GetNumberOfIterationsDone() const { return this->NumberOfIterationsDone; }

const char* vtkModelTrainer::GetDeviceInUse() const { return this->DeviceInUse.c_str(); }

void vtkModelTrainer::ReadInputs(vtkInformationVector**) {}

int vtkModelTrainer::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->NumberOfIterationsDone = 0;
  this->DeviceInUse.clear();
  this->ReadInputs(inputVector);
  const auto train = [&](const surfsynth::Progress& progress) {
    Run run(this, vtkTable::GetData(outputVector), progress);
    this->Train(inputVector, run);
  };
  const int success = surfsynth::ProcessJointly(this, inputVector, outputVector, train);
  this->SetProgressText(nullptr);
  return success;
}

void vtkModelTrainer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ModelFileName: " << this->ModelFileName << "\n";
  os << indent << "CheckpointFileName: " << this->CheckpointFileName << "\n";
  os << indent << "LossTableFileName: " << this->LossTableFileName << "\n";
  os << indent << "CheckpointInterval: " << this->CheckpointInterval << "\n";
  os << indent << "Resume: " << this->Resume << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "NumberOfIterationsDone: " << this->NumberOfIterationsDone << "\n";
  os << indent << "DeviceInUse: " << this->DeviceInUse << "\n";
}
