// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The options that trainings share. No torch.
#pragma once

#include "Inference/PoissonNet/PoissonNetOptions.h"

#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// Shift of the Poisson equation in networks that are trained: it acts alike on every triangulation. Models keep theirs.
constexpr PoissonShift ShiftOfTrainings = PoissonShift::Mass;

/// The device on which networks are trained.
enum class TrainingDevice
{
  Auto, ///< CUDA where LibTorch finds a device, else the processor
  CPU,
  CUDA
};

/// Course of the learning rate.
enum class LearningRateSchedule
{
  Milestones, ///< falls at each milestone, as published
  Cosine      ///< rises linearly over the first hundredth of all iterations, then falls to 0 along half a cosine
};

/// Optimizer of a PoissonNet.
enum class TrainingOptimizer
{
  Adam, ///< [Kingma2015], as published
  Muon ///< [Jordan2024] for the matrices inside the network, Adam for the rest; learning rates of 0.01 to 0.02 serve it
};

/// The options of every training.
struct ModelTrainingOptions
{
  double LearningRate = 5e-4; ///< of the optimizer, > 0
  std::uint64_t Seed = 0;     ///< of everything random
  TrainingDevice Device = TrainingDevice::Auto;
};

/// The recipe of a PoissonNet. Defaults learn in hours on a processor what those of appendix B.1 of "Matérn Noise for
/// Triangulation-Agnostic Flow Matching on Meshes" take a large GPU days for: these are given as the paper's.
struct TrainingOptions : ModelTrainingOptions
{
  TrainingOptions() { this->LearningRate = 0.02; }

  std::int64_t Width = 64;        ///< hidden channels; the paper's 128
  std::int64_t Blocks = 4;        ///< the paper's 5
  std::int64_t ComplexLayers = 3; ///< of the maps between gradients
  /// See PoissonNetOptions::InnerProducts. They grow with the gradients of the noise, and jump where the surface has creases,
  /// so that with them a model serves other triangulations less well.
  bool InnerProducts = false;
  std::int64_t Iterations = 3000;                               ///< >= 1; the paper's 160,000
  TrainingOptimizer Optimizer = TrainingOptimizer::Muon;        ///< of the weights; the paper's Adam, at a rate of 5e-4
  LearningRateSchedule Schedule = LearningRateSchedule::Cosine; ///< of the learning rate; the paper's Milestones
  /// Iterations after which the learning rate is multiplied by LearningRateFactor, with LearningRateSchedule::Milestones; empty:
  /// after a quarter of all.
  std::vector<std::int64_t> Milestones;
  double LearningRateFactor = 0.2; ///< in (0, 1]
  double GradientClip = 1.0;       ///< norm of all gradients together at most; 0: no limit
  /// The model holds an average of the weights of the last iterations: average = d average + (1 - d) weights, with
  /// d = min(WeightAveraging, (1 + n) / (10 + n)) in iteration n. In [0, 1); 0: the weights themselves, as in the paper.
  double WeightAveraging = 0.99;
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const TrainingOptions& options);

/// Returns options of a network of that size; the others are defaults.
PoissonNetOptions NetworkOfSize(const TrainingOptions& options);

} // namespace surfsynth
