// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingOptions.h"

#include "Learning/Training/OptionChecks.h"

namespace surfsynth
{

void CheckOptions(const TrainingOptions& options)
{
  const OptionChecks check("TrainingOptions");
  check.Iterations("Iterations", options.Iterations);
  check.LearningRate("LearningRate", options.LearningRate);
  check.Factor("LearningRateFactor", options.LearningRateFactor);
  check.Weight("GradientClip", options.GradientClip);
  check.Require(options.WeightAveraging >= 0.0 && options.WeightAveraging < 1.0, "WeightAveraging",
    options.WeightAveraging, "a number in [0, 1)");
  for (const std::int64_t milestone : options.Milestones)
  {
    check.Require(milestone >= 0, "a milestone", std::to_string(milestone), "a number of iterations");
  }
  check.Count("Width", options.Width, 1, 100000);
  check.Count("Blocks", options.Blocks, 1, 1000);
  check.Count("ComplexLayers", options.ComplexLayers, 1, 100);
}

PoissonNetOptions NetworkOfSize(const TrainingOptions& options)
{
  PoissonNetOptions network;
  network.Width = options.Width;
  network.Blocks = options.Blocks;
  network.ComplexLayers = options.ComplexLayers;
  network.InnerProducts = options.InnerProducts;
  network.Shift = ShiftOfTrainings;
  return network;
}

} // namespace surfsynth
