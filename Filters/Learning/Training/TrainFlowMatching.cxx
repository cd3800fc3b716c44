// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FlowMatchingTrainer.h"

#include <utility>

namespace surfsynth
{

FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  FlowMatchingTrainer trainer(std::move(dataset), options, SubProgress(progress, 0.0, 0.02));
  if (HasCheckpoint(files))
  {
    trainer.LoadCheckpoint(files.Checkpoint);
  }
  const auto save = [&] {
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
  };
  const auto step = [&] {
    const TrainingStep done = trainer.Step();
    return AfterIteration{ !observe || observe(done) };
  };
  RunTraining(trainer.Iteration(), options.Iterations, files, step, save, SubProgress(progress, 0.02, 1.0));
  return trainer;
}

} // namespace surfsynth
