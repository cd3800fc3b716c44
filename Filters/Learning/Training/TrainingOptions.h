// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What all trainings share: recipe, progress and files. No torch.
#pragma once

#include "Core/Common/Progress.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Where networks are trained.
enum class TrainingDevice
{
  Auto, ///< CUDA where LibTorch finds a device, else the processor
  CPU,
  CUDA
};

/// The recipe of the optimiser: Adam with falling learning rate. Defaults are those of appendix B.1 of "Matérn Noise for
/// Triangulation-Agnostic Flow Matching on Meshes" but for the iterations, which take a large GPU days there.
struct TrainingOptions
{
  std::int64_t Iterations = 20000; ///< >= 1; the paper's 160,000
  double LearningRate = 5e-4;      ///< of Adam, > 0
  /// Iterations after which the learning rate is multiplied by LearningRateFactor; empty: after a quarter of all.
  std::vector<std::int64_t> Milestones;
  double LearningRateFactor = 0.2; ///< in (0, 1]
  double GradientClip = 1.0;       ///< norm of all gradients together at most; 0: no limit
  /// The model holds an average of the weights of the last iterations: average = d average + (1 - d) weights, with
  /// d = min(WeightAveraging, (1 + n) / (10 + n)) in iteration n. In [0, 1); 0: the weights themselves, as in the paper.
  double WeightAveraging = 0.0;
  std::uint64_t Seed = 0;
  TrainingDevice Device = TrainingDevice::Auto;
};

/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const TrainingOptions& options);

/// @throws InvalidInput when width, blocks or layers of a PoissonNet to be trained are out of range.
void CheckNetworkSize(std::int64_t width, std::int64_t blocks, std::int64_t layers);

/// What an iteration says of itself.
struct TrainingStep
{
  std::int64_t Iteration = 0; ///< 1 for the first
  double Loss = 0.0;          ///< the weighted sum of those that follow
  double VertexLoss = 0.0;    ///< of values at vertices
  double JacobianLoss = 0.0;  ///< of their gradients
  double GradientNorm = 0.0;  ///< before it was clipped
  double LearningRate = 0.0;
};

/// Where a training leaves its results; empty for nowhere.
struct TrainingFiles
{
  std::string Model;      ///< written at the end, and at each checkpoint
  std::string Checkpoint; ///< read at the start when it exists and Resume is set; written every CheckpointInterval
  std::string LossTable;  ///< a CSV file with a row for each iteration, written with each checkpoint
  std::int64_t CheckpointInterval = 500; ///< iterations, >= 1
  bool Resume = true;
  std::vector<std::string> Inputs; ///< what the training is made from, which it must not write over
};

/// Receives each iteration on the calling thread; false stops the training after it, as cancelling does.
using TrainingObserver = std::function<bool(const TrainingStep& step)>;

/// @throws InvalidInput when a file has no folder to lie in, is a folder, another one or one of the inputs, or
/// CheckpointInterval is below 1: what can be said before hours of training.
void CheckFiles(const TrainingFiles& files);

/// True when a training is to go on from a checkpoint, and there is one.
bool HasCheckpoint(const TrainingFiles& files);

/// The iterations of the checkpoint that a training is to go on from; 0 when there is none.
/// @throws InvalidInput when the file cannot be opened; FormatError; ModelMismatch when it is no checkpoint.
std::int64_t CheckpointIterations(const TrainingFiles& files);

/// What is to be done after an iteration.
struct AfterIteration
{
  bool GoOn = true;  ///< false stops the training
  bool Save = false; ///< writes the files even though CheckpointInterval does not ask for it
};

/// Takes the steps from @p iterationsDone to @p iterations, with checkpoints. @p step does one iteration, @p save writes the
/// files. On cancellation (by @p step or @p progress) the files are written first; after a checkpoint of the last iteration
/// they are written again, as they may have gone or have other names.
/// @throws ModelMismatch when more iterations are done than are asked for; Cancelled; what @p step and @p save throw.
void RunTraining(std::int64_t iterationsDone, std::int64_t iterations, const TrainingFiles& files,
  const std::function<AfterIteration()>& step, const std::function<void()>& save, const Progress& progress);

/// Writes the rows of @p history: iteration, loss, vertex_loss, jacobian_loss, gradient_norm, learning_rate.
/// @throws InvalidInput when the file cannot be written.
void WriteLossTable(const std::string& path, const std::vector<TrainingStep>& history);

/// Writes a CSV file: a line of the names of @p columns, then @p rows of as many numbers with nine digits. Replaces the file
/// only when all is written.
/// @throws InvalidInput when the file cannot be written.
void WriteTable(
  const std::string& path, const std::vector<std::string>& columns, const std::vector<std::vector<double>>& rows);

} // namespace surfsynth
