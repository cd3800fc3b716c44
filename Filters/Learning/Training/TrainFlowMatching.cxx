// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <filesystem>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
void Save(const FlowMatchingTrainer& trainer, const TrainingFiles& files)
{
  if (!files.Checkpoint.empty())
  {
    trainer.SaveCheckpoint(files.Checkpoint);
  }
  if (!files.Model.empty())
  {
    WriteFlowMatchingModel(files.Model, trainer.Model());
  }
  if (!files.LossTable.empty())
  {
    WriteLossTable(files.LossTable, trainer.History());
  }
}
}

FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  if (files.CheckpointInterval < 1)
  {
    throw InvalidInput("TrainFlowMatching: the checkpoint interval is " + std::to_string(files.CheckpointInterval) +
      "; expected at least 1.");
  }
  FlowMatchingTrainer trainer(std::move(dataset), options, SubProgress(progress, 0.0, 0.02));
  if (files.Resume && !files.Checkpoint.empty() && std::filesystem::exists(files.Checkpoint))
  {
    trainer.LoadCheckpoint(files.Checkpoint);
  }
  const Progress iterations = SubProgress(progress, 0.02, 1.0);
  while (trainer.Iteration() < options.Iterations)
  {
    const TrainingStep step = trainer.Step();
    const bool goOn = (!observe || observe(step)) &&
      (!iterations || iterations(static_cast<double>(step.Iteration) / static_cast<double>(options.Iterations)));
    const bool last = step.Iteration == options.Iterations;
    if (!goOn || last || step.Iteration % files.CheckpointInterval == 0)
    {
      Save(trainer, files);
    }
    if (!goOn && !last)
    {
      throw Cancelled("TrainFlowMatching: stopped after iteration " + std::to_string(step.Iteration) + ".");
    }
  }
  return trainer;
}

} // namespace surfsynth
