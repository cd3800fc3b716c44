// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/ModelTrainer.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"
#include "Learning/Training/TimeLimit.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <vector>

#ifdef __GLIBC__ // known from the headers before
#include <malloc.h>
#endif

namespace surfsynth
{

namespace
{
/// @param goesOn whether the training does.
void SaveFiles(const ModelTrainer& trainer, const TrainingFiles& files, bool goesOn)
{
  if (!files.Checkpoint.empty())
  {
    trainer.SaveCheckpoint(files.Checkpoint);
  }
  if (!files.Model.empty())
  {
    goesOn ? trainer.SaveUnfinishedModel(files.Model) : trainer.SaveModel(files.Model);
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
  for (const std::string* path : { &files.Model, &files.Checkpoint, &files.LossTable, &files.Sample })
  {
    if (!path->empty())
    {
      locks.emplace_back(*path, "TrainingFiles");
      RemoveUnfinishedOutput(*path);
    }
  }
  return locks;
}

/// Bound of the numbers that a checkpoint holds for each iteration.
constexpr std::int64_t LossesOfIteration = 8;

/// Compares the header of a checkpoint with the training that is to go on from it: a wrong or damaged one is refused
/// before its numbers are read.
/// @param state of the training now.
void RequireFits(
  const std::string& path, const CheckpointHeader& header, const TrainingCheckpoint& state, std::int64_t iterations)
{
  RequireSameRecipe(path, state.Recipe, header.Recipe);
  if (header.Iterations > iterations)
  {
    throw ModelMismatch(path + ": the checkpoint is of iteration " + std::to_string(header.Iterations) +
      "; expected at most the " + std::to_string(iterations) +
      " iterations of this training. Ask for more, or begin anew with another checkpoint file.");
  }
  std::size_t numbers = 0;
  for (const auto& entry : state.Tensors)
  {
    numbers += entry.second.Values.size();
  }
  // Beside each weight there are two moments of Adam, which a training has after its first iteration.
  const std::int64_t most = 3 * static_cast<std::int64_t>(numbers) + LossesOfIteration * iterations;
  if (header.Numbers > most)
  {
    throw ModelMismatch(path + ": the checkpoint has " + std::to_string(header.Numbers) +
      " numbers; expected at most " + std::to_string(most) +
      " for this network: it is the checkpoint of another one, or damaged.");
  }
}

/// Iterations after which ReleaseFreedMemory() is called.
constexpr std::int64_t ReleaseInterval = 200;

/// Returns freed memory to the system. The aligned blocks of tensors leave holes in the heap of glibc, which grew by half
/// a megabyte in each iteration of a small network: by gigabytes in an hour.
void ReleaseFreedMemory()
{
#ifdef __GLIBC__
  malloc_trim(0);
#endif
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
  TrainingCheckpoint state = this->Checkpoint();
  state.Recipe = this->Recipe();
  RequireFits(path, ReadCheckpointHeader(path), state, this->Iterations());
  this->Restore(path, ReadCheckpoint(path));
}

void TrainAndSave(
  ModelTrainer& trainer, const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  const std::vector<OutputLock> locks = LockFiles(files);
  if (HasCheckpoint(files))
  {
    trainer.LoadCheckpoint(files.Checkpoint);
  }
  const std::int64_t iterations = trainer.Iterations();
  const TimeLimit limit(files.TimeBudget);
  bool saved = false;
  bool inTime = true;
  while (inTime && trainer.Iteration() < iterations)
  {
    trainer.Step();
    const std::int64_t done = trainer.Iteration();
    if (done % ReleaseInterval == 0)
    {
      ReleaseFreedMemory();
    }
    const bool goOn = (!observe || observe(trainer.History())) &&
      (!progress || progress(static_cast<double>(done) / static_cast<double>(iterations)));
    inTime = !limit.IsReached();
    const bool goesOn = goOn && inTime && done < iterations;
    saved = !goesOn || trainer.IsAtEndOfStage() || done % files.CheckpointInterval == 0;
    if (saved)
    {
      SaveFiles(trainer, files, goesOn);
    }
    if (!goOn && done < iterations)
    {
      throw Cancelled("The training was stopped after iteration " + std::to_string(done) + ".");
    }
    if (saved && files.AfterWriting)
    {
      files.AfterWriting(
        [&] { return !progress || progress(static_cast<double>(done) / static_cast<double>(iterations)); });
    }
  }
  if (!saved) // the checkpoint is of the last iteration: the files may have gone, or have other names
  {
    SaveFiles(trainer, files, false);
  }
}

} // namespace surfsynth
