// SPDX-License-Identifier: BSD-3-Clause
#include "vtkModelTrainer.h"

#include "Announcement.h"
#include "FilterSupport.h"
#include "JointProcessing.h"
#include "ModelTrainerRun.h"
#include "Reporting.h"
#include "TableColumns.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIndent.h>
#include <vtkInformationVector.h>
#include <vtkTable.h>

#include <sstream>
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
  files.TimeBudget = self.Background ? 0.0 : self.TimeBudget;
  files.Inputs = { self.DatasetFileName };
  return files;
}

void vtkModelTrainer::Run::Train(const surfsynth::TrainingJob& job)
{
  if (!this->Self->Background)
  {
    this->Self->Task->Stop(); // goes on from its checkpoint
    job(*this);
    return;
  }
  this->Self->Task->Start(job);
  this->ShowBackground();
}

void vtkModelTrainer::Run::ShowBackground()
{
  const surfsynth::BackgroundReport report = this->Self->Task->Look();
  this->Self->NumberOfIterationsDone = static_cast<vtkTypeInt64>(report.History.Size());
  this->Self->DeviceInUse = report.Device;
  this->Self->RemainingTime = report.SecondsLeft / 60.0;
  AddLosses(this->Table, report.History);
}

void vtkModelTrainer::Run::SetSharedOptions(surfsynth::ModelTrainingOptions& options) const
{
  options.LearningRate = this->Self->LearningRate;
  options.Seed = static_cast<std::uint64_t>(this->Self->Seed);
  options.Device = static_cast<surfsynth::TrainingDevice>(this->Self->Device);
}

surfsynth::TrainingObserver vtkModelTrainer::Run::ShowProgress(
  const surfsynth::TrainingClock& clock, const std::string& stage)
{
  this->Clock = clock;
  return [this, stage](const surfsynth::LossHistory& history) {
    this->Clock.Add(history);
    this->Self->SetProgressText((stage + this->Clock.Describe()).c_str());
    surfsynth::AnnounceTime(this->Self, stage, this->Clock, this->Self->TimeBudget);
    return true;
  };
}

bool vtkModelTrainer::Run::EndsEarly(const surfsynth::ModelTrainer& trainer, const std::string& what)
{
  if (trainer.Iteration() >= trainer.Iterations())
  {
    return false;
  }
  const double seconds = this->Clock.SecondsLeft();
  this->Self->RemainingTime = seconds / 60.0;
  const std::string expected = seconds > 0.0
    ? " The other iterations take about " + surfsynth::FormatDuration(seconds) + "."
    : "";
  std::ostringstream text;
  text << "The TimeBudget of " << surfsynth::FormatNumber(this->Self->TimeBudget)
       << " minutes ended the training of the " << what << " after iteration " << trainer.Iteration() << " of "
       << trainer.Iterations() << "." << expected << " The file of the " << what
       << " holds it as it is now. The next run goes on from the checkpoint; a larger TimeBudget, or "
          "0 for no limit, trains longer.";
  surfsynth::ReportWarning(this->Self, "", text.str());
  return true;
}

void vtkModelTrainer::Run::Finish(const surfsynth::ModelTrainer& trainer)
{
  this->Self->NumberOfIterationsDone = trainer.Iteration();
  this->Self->DeviceInUse = trainer.DeviceName();
  AddLosses(this->Table, trainer.History());
  this->EndsEarly(trainer, "model");
}

vtkModelTrainer::vtkModelTrainer()
  : Task(std::make_unique<surfsynth::BackgroundTraining>())
{}

vtkModelTrainer::~vtkModelTrainer() = default;

void vtkModelTrainer::SetText(std::string& property, const char* text) { surfsynth::SetString(this, property, text); }

void vtkModelTrainer::SetModelFileName(const char* name) { this->SetText(this->ModelFileName, name); }

void vtkModelTrainer::SetCheckpointFileName(const char* name) { this->SetText(this->CheckpointFileName, name); }

void vtkModelTrainer::SetLossTableFileName(const char* name) { this->SetText(this->LossTableFileName, name); }

void vtkModelTrainer::SetDatasetFileName(const char* name) { this->SetText(this->DatasetFileName, name); }

vtkTypeInt64 vtkModelTrainer::GetNumberOfIterationsDone() const { return this->NumberOfIterationsDone; }

double vtkModelTrainer::GetRemainingTime() const { return this->RemainingTime; }

const char* vtkModelTrainer::GetBackgroundState() const
{
  this->BackgroundState = this->Task->State();
  return this->BackgroundState.c_str();
}

void vtkModelTrainer::StopBackground()
{
  this->Task->Stop();
  this->Modified();
}

const char* vtkModelTrainer::GetDeviceInUse() const { return this->DeviceInUse.c_str(); }

void vtkModelTrainer::ReadInputs(vtkInformationVector**) {}

int vtkModelTrainer::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->NumberOfIterationsDone = 0;
  this->RemainingTime = 0.0;
  this->DeviceInUse.clear();
  this->ReadInputs(inputVector);
  const auto train = [&](const surfsynth::Progress& progress) {
    Run run(this, vtkTable::GetData(outputVector), progress);
    if (this->Background && this->Task->IsPending())
    {
      run.ShowBackground();
    }
    else
    {
      this->Train(inputVector, run);
    }
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
  os << indent << "TimeBudget: " << this->TimeBudget << "\n";
  os << indent << "Background: " << this->Background << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "NumberOfIterationsDone: " << this->NumberOfIterationsDone << "\n";
  os << indent << "RemainingTime: " << this->RemainingTime << "\n";
  os << indent << "BackgroundState: " << this->GetBackgroundState() << "\n";
  os << indent << "DeviceInUse: " << this->DeviceInUse << "\n";
}
