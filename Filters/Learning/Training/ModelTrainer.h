// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Interface of all trainers, and the training from the first iteration to the files. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Learning/Training/LossHistory.h"
#include "Learning/Training/TrainingFiles.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace surfsynth
{

struct TrainingCheckpoint;

/// A model under training: iterations, losses, checkpoints and the model file. A new kind of training derives from this
/// and is run by TrainAndSave().
class ModelTrainer
{
public:
  virtual ~ModelTrainer() = default;

  /// Does one iteration and adds its row to History().
  /// @throws SolverFailure when a loss or its gradient is not finite: the learning rate is too high.
  virtual void Step() = 0;

  /// Number of iterations done, those before a checkpoint included.
  std::int64_t Iteration() const { return static_cast<std::int64_t>(this->History().Size()); }
  /// Number of all iterations to be done, those of a checkpoint included.
  virtual std::int64_t Iterations() const = 0;
  /// Losses of all iterations done, those before a checkpoint included. The first column is "iteration", from 1 on.
  virtual const LossHistory& History() const = 0;
  /// True after an iteration that ends a stage of the training, after which a checkpoint is always written.
  virtual bool IsAtEndOfStage() const { return false; }
  /// "CPU" or "CUDA".
  virtual std::string DeviceName() const = 0;

  /// Writes weights, moments of the optimizers and losses, as safetensors; replaces the file only when all is written.
  /// @throws InvalidInput when the file cannot be written; the earlier file is then still there.
  void SaveCheckpoint(const std::string& path) const;
  /// Goes on from a checkpoint of the same dataset and recipe.
  /// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch naming what differs, also when the
  /// checkpoint has more iterations than Iterations(). The trainer has not changed then.
  void LoadCheckpoint(const std::string& path);
  /// Writes the model file of the weights after the last iteration. @throws InvalidInput when it cannot be written.
  virtual void SaveModel(const std::string& path) const = 0;
  /// The same while the training goes on: without what takes long to measure and can be added to the file later.
  virtual void SaveUnfinishedModel(const std::string& path) const { this->SaveModel(path); }

protected:
  ModelTrainer() = default;
  ModelTrainer(ModelTrainer&&) noexcept = default;
  ModelTrainer& operator=(ModelTrainer&&) noexcept = default;

private:
  /// Values by name that must be the same when a training goes on.
  virtual std::map<std::string, std::string> Recipe() const = 0;
  /// State of the training; its recipe is left empty.
  virtual TrainingCheckpoint Checkpoint() const = 0;
  /// Takes the state of a checkpoint with the same recipe. @param file for messages.
  /// @throws ModelMismatch when a part is missing or of another shape; nothing has changed then.
  virtual void Restore(const std::string& file, const TrainingCheckpoint& checkpoint) = 0;
};

/// Receives the losses after each iteration on the calling thread; false stops the training, as cancelling does.
using TrainingObserver = std::function<bool(const LossHistory& history)>;

/// Trains to the last iteration and writes checkpoint, model and loss table: every files.CheckpointInterval iterations,
/// after each stage, at the end, and on cancellation (by @p observe or @p progress). Goes on from files.Checkpoint where
/// there is one and files.Resume is set; an interrupted training loses the iterations after its last checkpoint. A
/// checkpoint of the last iteration is enough to write the other files again. After files.TimeBudget minutes the training
/// writes its files and returns before its last iteration, after one iteration at least. While the training goes on,
/// the model is that of SaveUnfinishedModel().
/// @param progress called after each iteration with the part of all iterations that is done.
/// @throws the errors of the trainer; before the first iteration, InvalidInput as CheckFiles() and when another training
/// writes one of the files, and ModelMismatch when the checkpoint has more iterations than are asked for; Cancelled.
void TrainAndSave(ModelTrainer& trainer, const TrainingFiles& files, const TrainingObserver& observe = {},
  const Progress& progress = {});

} // namespace surfsynth
