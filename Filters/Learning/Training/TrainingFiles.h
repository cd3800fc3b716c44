// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The files of a training. No torch.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Paths of the results of a training; empty for none.
struct TrainingFiles
{
  std::string Model;      ///< written at the end, and at each checkpoint
  std::string Checkpoint; ///< read at the start when it exists and Resume is set; written every CheckpointInterval
  std::string LossTable;  ///< a CSV file with a row for each iteration, written with each checkpoint
  std::int64_t CheckpointInterval = 500; ///< iterations, >= 1
  bool Resume = true;
  /// Minutes from the first iteration of a run to its end: the training then writes its files and stops; 0: no limit.
  double TimeBudget = 0.0;
  std::vector<std::string> Inputs; ///< paths that the training reads, which it must not write over
  /// Called after an iteration that wrote the files, unless the training is stopped: for samples along the way. May be empty.
  /// @param goOn false when the training is to stop, and so this call
  std::function<void(const std::function<bool()>& goOn)> AfterWriting;
  std::string Sample; ///< path that AfterWriting writes, "" for none
};

/// Checks the files before hours of training.
/// @throws InvalidInput when a file has no folder to lie in, is a folder, another one or one of the inputs, or
/// CheckpointInterval is below 1, or TimeBudget is negative or not finite.
void CheckFiles(const TrainingFiles& files);

/// True when a training is to go on from a checkpoint, and there is one.
bool HasCheckpoint(const TrainingFiles& files);

/// The iterations of the checkpoint that a training is to go on from; 0 when there is none.
/// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch when it is no checkpoint.
std::int64_t CheckpointIterations(const TrainingFiles& files);

} // namespace surfsynth
