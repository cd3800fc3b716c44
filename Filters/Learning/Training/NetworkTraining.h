// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A PoissonNet under training: network, optimizer, averages of weights, losses, and checkpoints of them. Private to the
/// training.
#pragma once

#include "Inference/PoissonNet/PoissonNetEvaluator.h"
#include "Learning/Networks/PoissonNet.h"
#include "Learning/Training/AdamMoments.h"
#include "Learning/Training/Muon.h"
#include "Learning/Training/TimeLosses.h"
#include "Learning/Training/TrainingCheckpoint.h"
#include "Learning/Training/TrainingOptions.h"

#include <torch/torch.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// The device to train on. @throws InvalidInput when CUDA is asked for and LibTorch finds none.
torch::Device ChooseDevice(TrainingDevice wanted);

/// "CPU" or "CUDA".
std::string NameOf(const torch::Device& device);

/// The numbers of a matrix as a float32 tensor on @p device.
torch::Tensor ToTensor(const FeatureMatrix& matrix, const torch::Device& device);

/// The numbers of a tensor in the form of files, rounded to float32.
ModelTensor ToModelTensor(const torch::Tensor& tensor);

/// The tensor of that name in a checkpoint, on the device of @p like.
/// @throws ModelMismatch when it is missing or has another shape than @p like.
torch::Tensor ReadTensor(
  const std::string& file, const TrainingCheckpoint& checkpoint, const std::string& name, const torch::Tensor& like);

/// The moments of Adam for a parameter, of the tensors "adam_mean." and "adam_square." + @p name.
/// @throws ModelMismatch as ReadTensor(), and when a mean of squares is negative.
AdamMoments ReadMoments(
  const std::string& file, const TrainingCheckpoint& checkpoint, const std::string& name, const torch::Tensor& like);

/// Checks the weights after a step. @param iteration counted from 1, for the message
/// @throws SolverFailure when one is not finite.
void RequireFiniteWeights(const std::vector<torch::Tensor>& weights, std::int64_t iteration);

/// The losses of one iteration.
struct NetworkLosses
{
  double Total = 0.0;    ///< the weighted sum of those that follow
  double Vertex = 0.0;   ///< of values at vertices
  double Jacobian = 0.0; ///< of their gradients
  TimeLosses ByTime;     ///< weighted sums of the samples, in trainings with columns of losses by time
};

/// A PoissonNet under training.
class NetworkTraining
{
public:
  /// @param initial the weights to begin with; they go to the device that @p options choose.
  /// @param timePrefix prefix of the columns of losses by time; empty for a history without
  NetworkTraining(const PoissonNetModel& initial, const TrainingOptions& options, const std::string& timePrefix = "");

  const torch::Device& Device() const { return this->Where; }
  PoissonNetImpl& Network() { return *this->Net; }
  /// Number of iterations done.
  std::int64_t Iteration() const { return static_cast<std::int64_t>(this->Losses.Size()); }
  const LossHistory& History() const { return this->Losses; }

  /// Adds the gradients of an iteration's losses to those of the parameters, and fills in the losses.
  using Objective = std::function<void(NetworkLosses& losses)>;

  /// One iteration: gradients, which are clipped, a step of the optimizer, averages.
  /// @throws SolverFailure when the loss, its gradient or a weight is not finite.
  void Step(const Objective& accumulate);

  /// The averaged weights. Fields other than Options and Tensors are left empty.
  PoissonNetModel Model();

  /// The state; its recipe is left empty.
  TrainingCheckpoint Checkpoint();
  /// Takes the state of a checkpoint. @param file for messages. @throws ModelMismatch when tensors are missing or of another shape; nothing has changed
  /// then.
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint);

private:
  double LearningRate() const;
  void UpdateAverages();
  bool HasTimeLosses() const;
  /// The momentum of a parameter of Muon; nothing for one of Adam.
  torch::Tensor* MomentumOf(const torch::Tensor& parameter);
  LossHistory RestoredLosses(const std::string& file, const TrainingCheckpoint& checkpoint) const;

  TrainingOptions Options;
  torch::Device Where;
  PoissonNet Net;
  std::unique_ptr<torch::optim::Adam> Adam; ///< of the parameters that Matrices does not move
  std::unique_ptr<Muon> Matrices;
  std::vector<torch::Tensor> Averages; ///< of the parameters, in their order
  LossHistory Losses;
};

} // namespace surfsynth
