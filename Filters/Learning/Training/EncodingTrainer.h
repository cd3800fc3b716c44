// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Training of the positional encoding that serves many surfaces. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/SignalDataset.h"
#include "Inference/PoissonNet/PoissonNetModel.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace surfsynth
{

/// The recipe. Defaults are the paper's but for the network's size, the batch and the iterations.
struct EncodingTrainingOptions : TrainingOptions
{
  std::int64_t Eigenfunctions = 64; ///< channels of the encoding, >= 1; the paper's 64
  std::int64_t BatchSize = 4;       ///< surfaces in an iteration, >= 1
  /// Largest part of the edges of a surface that are split at random, in [0, 1]; each surface of an iteration draws its
  /// own, up to this. Above 0 the encoder learns no triangulation by heart.
  double EdgeSplits = 0.0;
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const EncodingTrainingOptions& options);

/// Trains a PoissonNet that predicts, from the positions of a surface, the lowest eigenfunctions of the Laplacian of one
/// reference surface at the same places (section 5.1.2 and appendix B.1 of "Matérn Noise for Triangulation-Agnostic Flow
/// Matching on Meshes"): coordinates that mean the same on all surfaces of a kind, in any pose.
///
/// The surfaces must correspond: all sources have the triangles of the first, which is the reference. Each source is a
/// surface of the training, and where the dataset holds positions so is each of its samples. The eigenfunctions
/// (without the constant) are scaled to mean square 1; the loss is the mean squared error over the surface, 1 for a
/// prediction of nothing. With EdgeSplits each surface gets another triangulation in each iteration, with the
/// eigenfunctions interpolated linearly at the new vertices. Surfaces are moved to their centroid and scaled to area 1,
/// which stands for the paper's random scales and shifts.
class EncodingTrainer : public ModelTrainer
{
public:
  /// @throws InvalidInput when an option is out of range, triangles or numbers of vertices differ, a source does not meet
  /// FlowMatchingSampler::Requirements(), or the reference has too few vertices; SolverFailure; Cancelled.
  EncodingTrainer(SignalDataset dataset, const EncodingTrainingOptions& options, const Progress& progress = {});
  ~EncodingTrainer() override;
  EncodingTrainer(EncodingTrainer&&) noexcept;
  EncodingTrainer& operator=(EncodingTrainer&&) noexcept;

  /// @throws SolverFailure when the loss is not finite; InvalidInput naming a sample that is degenerate.
  void Step() override;
  std::int64_t Iterations() const override;
  /// Columns as the first six of FlowMatchingTrainer; jacobian_loss is 0.
  const LossHistory& History() const override;
  std::string DeviceName() const override;
  void SaveModel(const std::string& path) const override;

  /// The encoder, to be given to a FlowMatchingTrainer or written with WritePoissonNet().
  PoissonNetModel Model() const;

private:
  /// All but Iterations, Milestones and Device.
  std::map<std::string, std::string> Recipe() const override;
  TrainingCheckpoint Checkpoint() const override;
  void Restore(const std::string& file, const TrainingCheckpoint& checkpoint) override;

  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Trains to the last iteration as TrainAndSave(); the files are checked before the trainer is made.
EncodingTrainer TrainEncoding(SignalDataset dataset, const EncodingTrainingOptions& options, const TrainingFiles& files,
  const TrainingObserver& observe = {}, const Progress& progress = {});

} // namespace surfsynth
