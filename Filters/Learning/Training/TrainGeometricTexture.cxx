// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Learning/Training/GeometricTextureTrainer.h"

#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
void Require(bool fine, const char* option, double found, const char* expected)
{
  if (!fine)
  {
    throw InvalidInput(std::string("GeometricTextureTrainingOptions: ") + option + " is " + FormatNumber(found) +
      "; expected " + expected + ".");
  }
}

void RequireCount(const char* option, std::int64_t found, std::int64_t most, const char* expected)
{
  Require(found >= 1 && found <= most, option, static_cast<double>(found), expected);
}

void RequireWeight(const char* option, double found)
{
  Require(std::isfinite(found) && found >= 0.0, option, found, "a finite number of at least 0");
}
} // namespace

void CheckOptions(const GeometricTextureTrainingOptions& options)
{
  CheckOptions(options.Network);
  if (options.Name.empty())
  {
    throw InvalidInput("GeometricTextureTrainingOptions: Name is empty; expected a name.");
  }
  RequireCount("IterationsPerLevel", options.IterationsPerLevel, 100000000, "1 to 1e8");
  RequireCount("DiscriminatorSteps", options.DiscriminatorSteps, 1000, "1 to 1000");
  RequireCount("GeneratorSteps", options.GeneratorSteps, 1000, "1 to 1000");
  Require(std::isfinite(options.LearningRate) && options.LearningRate > 0.0, "LearningRate", options.LearningRate,
    "a finite number above 0");
  RequireCount("LearningRateInterval", options.LearningRateInterval, 100000000, "1 to 1e8");
  Require(options.LearningRateFactor > 0.0 && options.LearningRateFactor <= 1.0, "LearningRateFactor",
    options.LearningRateFactor, "a number in (0, 1]");
  RequireWeight("PenaltyWeight", options.PenaltyWeight);
  RequireWeight("ReconstructionWeight", options.ReconstructionWeight);
}

GeometricTextureTrainer TrainGeometricTexture(MultiscaleDataset dataset, const GeometricTextureTrainingOptions& options,
  const TrainingFiles& files, const GeometricTextureTrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  GeometricTextureTrainer trainer(std::move(dataset), options);
  if (HasCheckpoint(files))
  {
    trainer.LoadCheckpoint(files.Checkpoint);
  }
  const auto step = [&] {
    const GeometricTextureTrainingStep done = trainer.Step();
    const bool levelEnds = done.Iteration % options.IterationsPerLevel == 0;
    return AfterIteration{ !observe || observe(done), levelEnds };
  };
  const auto save = [&] {
    if (!files.Checkpoint.empty())
    {
      trainer.SaveCheckpoint(files.Checkpoint);
    }
    if (!files.Model.empty())
    {
      WriteGeometricTexture(files.Model, trainer.Model());
    }
    if (!files.LossTable.empty())
    {
      WriteLossTable(files.LossTable, trainer.History());
    }
  };
  RunTraining(trainer.Iteration(), trainer.Iterations(), files, step, save, progress);
  return trainer;
}

void WriteLossTable(const std::string& path, const std::vector<GeometricTextureTrainingStep>& history)
{
  std::vector<std::vector<double>> rows;
  rows.reserve(history.size());
  for (const GeometricTextureTrainingStep& step : history)
  {
    rows.push_back({ static_cast<double>(step.Iteration), static_cast<double>(step.Level), step.CriticLoss,
      step.GradientPenalty, step.AdversarialLoss, step.ReconstructionLoss, step.LearningRate });
  }
  WriteTable(path,
    { "iteration", "level", "critic_loss", "gradient_penalty", "adversarial_loss", "reconstruction_loss",
      "learning_rate" },
    rows);
}

} // namespace surfsynth
