// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The state of a training in a file. Private to the training; no torch.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"
#include "Learning/Training/LossHistory.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <string>

namespace surfsynth
{

/// The empty losses of a PoissonNet under training: iteration, loss (the weighted sum of the two that follow, monitored),
/// vertex_loss, jacobian_loss, gradient_norm and learning_rate. Checkpoints of all trainings hold a table of these columns;
/// losses by time are a tensor beside it.
LossHistory NetworkLossHistory();

/// The state of a training after some iterations.
struct TrainingCheckpoint
{
  std::map<std::string, ModelTensor> Tensors; ///< by "<what>.<parameter>"
  LossHistory History = NetworkLossHistory(); ///< of all iterations done
  std::map<std::string, std::string> Recipe;  ///< values that must be the same when the training goes on
};

/// The shared options that decide the weights after a number of iterations: neither Iterations, Milestones nor Device.
/// @param training its name.
std::map<std::string, std::string> RecipeOf(const TrainingOptions& options, const std::string& training);

/// All digits of a number, so that equal texts mean equal numbers, in every locale.
std::string FormatExact(double number);

/// Compares two recipes. @throws ModelMismatch naming the first entry in which a checkpoint differs.
void RequireSameRecipe(const std::string& file, const std::map<std::string, std::string>& expected,
  const std::map<std::string, std::string>& found);

/// Writes a checkpoint. @throws InvalidInput when the file cannot be written; it is replaced only when all is written.
void WriteCheckpoint(const std::string& path, const TrainingCheckpoint& checkpoint);

/// Shape of a checkpoint: read without its numbers.
struct CheckpointHeader
{
  std::map<std::string, std::string> Recipe; ///< as TrainingCheckpoint::Recipe
  std::int64_t Iterations = 0;               ///< number of iterations done
  std::int64_t Numbers = 0;                  ///< elements of all tensors beside the history
};

/// Reads the header of a checkpoint. @throws as ReadCheckpoint().
CheckpointHeader ReadCheckpointHeader(const std::string& path);

/// Reads a checkpoint. @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch when it is no checkpoint.
TrainingCheckpoint ReadCheckpoint(const std::string& path);

} // namespace surfsynth
