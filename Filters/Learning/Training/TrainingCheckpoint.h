// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a training needs to go on. Private to the training; no torch.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"
#include "Learning/Training/TrainingOptions.h"

#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

struct TrainingCheckpoint
{
  std::map<std::string, ModelTensor> Tensors; ///< by "<what>.<parameter>"
  std::vector<TrainingStep> History;          ///< of all iterations done
  std::map<std::string, std::string> Recipe;  ///< what must be the same when the training goes on
};

/// What decides the weights after a number of iterations, of what all trainings share: neither Iterations, Milestones nor
/// Device. @param training its name.
std::map<std::string, std::string> RecipeOf(const TrainingOptions& options, const std::string& training);

/// All digits of a number, so that equal texts mean equal numbers, in every locale.
std::string FormatExact(double number);

/// @throws ModelMismatch naming the first entry in which a checkpoint differs.
void RequireSameRecipe(const std::string& file, const std::map<std::string, std::string>& expected,
  const std::map<std::string, std::string>& found);

/// @throws InvalidInput when the file cannot be written; it is replaced only when all is written.
void WriteCheckpoint(const std::string& path, const TrainingCheckpoint& checkpoint);

/// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch when it is no checkpoint.
TrainingCheckpoint ReadCheckpoint(const std::string& path);

} // namespace surfsynth
