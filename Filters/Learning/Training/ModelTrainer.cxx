// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/ModelTrainer.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"
#include "Learning/Training/TimeLimit.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <vector>

namespace surfsynth
{

namespace
{
void SaveFiles(const ModelTrainer& trainer, const TrainingFiles& files)
{
  if (!files.Checkpoint.empty())
  {
    trainer.SaveCheckpoint(files.Checkpoint);
  }
  if (!files.Model.empty())
  {
    trainer.SaveModel(files.Model);
  }
  if (!files.LossTable.empty())
  {
    trainer.History().WriteCsv(files.LossTable);
  }
}

/// Locks the names of the files, and removes what killed trainings have left beside them.
/// @throws InvalidInput when another training writes one of them.
std::vector<OutputLock> LockFiles(const TrainingFiles& files)
{
  std::vector<OutputLock> locks;
  for (const std::string* path : { &files.Model, &files.Checkpoint, &files.LossTable })
  {
    if (!path->empty())
    {
      locks.emplace_back(*path, "TrainingFiles");
      RemoveUnfinishedOutput(*path);
    }
  }
  return locks;
}

/// @throws ModelMismatch when the checkpoint has more iterations than the training.
void Resume(ModelTrainer& trainer, const std::string& checkpoint)
{
  trainer.LoadCheckpoint(checkpoint);
  if (trainer.Iteration() > trainer.Iterations())
  {
    throw ModelMismatch(checkpoint + ": the checkpoint is of iteration " + std::to_string(trainer.Iteration()) +
      "; expected at most the " + std::to_string(trainer.Iterations()) +
      " iterations of this training. Ask for more, or begin anew with another checkpoint file.");
  }
}
} // namespace

void ModelTrainer::SaveCheckpoint(const std::string& path) const
{
  TrainingCheckpoint checkpoint = this->Checkpoint();
  checkpoint.Recipe = this->Recipe();
  WriteCheckpoint(path, checkpoint);
}

void ModelTrainer::LoadCheckpoint(const std::string& path)
{
  const TrainingCheckpoint checkpoint = ReadCheckpoint(path);
  RequireSameRecipe(path, this->Recipe(), checkpoint.Recipe);
  this->Restore(path, checkpoint);
}

void TrainAndSave(
  ModelTrainer& trainer, const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  const std::vector<OutputLock> locks = LockFiles(files);
  if (HasCheckpoint(files))
  {
    Resume(trainer, files.Checkpoint);
  }
  const std::int64_t iterations = trainer.Iterations();
  const TimeLimit limit(files.TimeBudget);
  bool saved = false;
  bool inTime = true;
  while (inTime && trainer.Iteration() < iterations)
  {
    trainer.Step();
    const std::int64_t done = trainer.Iteration();
    const bool goOn = (!observe || observe(trainer.History())) &&
      (!progress || progress(static_cast<double>(done) / static_cast<double>(iterations)));
    inTime = !limit.IsReached();
    saved = !goOn || !inTime || trainer.IsAtEndOfStage() || done == iterations || done % files.CheckpointInterval == 0;
    if (saved)
    {
      SaveFiles(trainer, files);
    }
    if (!goOn && done < iterations)
    {
      throw Cancelled("The training was stopped after iteration " + std::to_string(done) + ".");
    }
  }
  if (!saved) // the checkpoint is of the last iteration: the files may have gone, or have other names
  {
    SaveFiles(trainer, files);
  }
}

} // namespace surfsynth
