// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/FlowMatchingTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <cmath>

namespace surfsynth
{

namespace
{
void Require(bool fine, const char* option, double found, const char* expected)
{
  if (!fine)
  {
    throw InvalidInput(
      std::string("TrainingOptions: ") + option + " is " + FormatNumber(found) + "; expected " + expected + ".");
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

void CheckOptions(const TrainingOptions& options)
{
  RequireCount("Iterations", options.Iterations, 100000000, "1 to 1e8");
  Require(std::isfinite(options.LearningRate) && options.LearningRate > 0.0, "LearningRate", options.LearningRate,
    "a finite number above 0");
  Require(options.LearningRateFactor > 0.0 && options.LearningRateFactor <= 1.0, "LearningRateFactor",
    options.LearningRateFactor, "a number in (0, 1]");
  RequireWeight("GradientClip", options.GradientClip);
  Require(options.WeightAveraging >= 0.0 && options.WeightAveraging < 1.0, "WeightAveraging", options.WeightAveraging,
    "a number in [0, 1)");
  for (const std::int64_t milestone : options.Milestones)
  {
    Require(milestone >= 0, "a milestone", static_cast<double>(milestone), "a number of iterations");
  }
}

void CheckNetworkSize(std::int64_t width, std::int64_t blocks, std::int64_t layers)
{
  RequireCount("Width", width, 100000, "1 to 100000");
  RequireCount("Blocks", blocks, 1000, "1 to 1000");
  RequireCount("ComplexLayers", layers, 100, "1 to 100");
}

void CheckOptions(const FlowMatchingTrainingOptions& options)
{
  CheckOptions(static_cast<const TrainingOptions&>(options));
  CheckNetworkSize(options.Width, options.Blocks, options.ComplexLayers);
  RequireCount("BatchSize", options.BatchSize, 100000, "1 to 100000");
  Require(options.SourcesPerBatch >= 1 && options.BatchSize % options.SourcesPerBatch == 0, "SourcesPerBatch",
    static_cast<double>(options.SourcesPerBatch), "a number that divides BatchSize");
  Require(options.Iterations * options.BatchSize < (std::int64_t(1) << 32), "Iterations * BatchSize",
    static_cast<double>(options.Iterations) * static_cast<double>(options.BatchSize), "below 2^32");
  RequireWeight("VertexWeight", options.VertexWeight);
  RequireWeight("JacobianWeight", options.JacobianWeight);
  Require(options.VertexWeight + options.JacobianWeight > 0.0, "VertexWeight + JacobianWeight", 0.0,
    "a number above 0: else nothing is learnt");
  Require(std::isfinite(options.Noise.Screening) && options.Noise.Screening > 0.0, "Noise.Screening",
    options.Noise.Screening, "a finite number above 0");
  RequireWeight("Noise.Scale", options.Noise.Scale);
  RequireWeight("Noise.Smoothing", options.Noise.Smoothing);
  RequireCount("Noise.Eigenpairs", options.Noise.Eigenpairs, 1000000, "1 to 1000000");
}

} // namespace surfsynth
