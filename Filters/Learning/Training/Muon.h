// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Muon, an optimizer for the matrices inside a network [Jordan2024]. Private to the training.
#pragma once

#include <torch/torch.h>

#include <vector>

namespace surfsynth
{

/// Matrix with the singular vectors of @p matrix and singular values near 1: five steps of a Newton-Schulz iteration, which
/// leave them in [0.7, 1.2]. Near 0 for a matrix with a norm far below 1e-12.
torch::Tensor Orthogonalized(const torch::Tensor& matrix);

/// Moves matrices along the orthogonalized momentum of their gradients: with momentum 0.95 in Nesterov's form, and a step of
///   0.2 sqrt(max(rows, columns)) learning rate,
/// whose elements are as large as those of a step of Adam [Liu2025]; so one learning rate serves both.
class Muon
{
public:
  /// True for the parameters that Muon moves: matrices with at least 16 rows and columns. Adam takes biases, factors, and the
  /// first and last maps.
  static bool Moves(const torch::Tensor& parameter);

  /// @param matrices parameters for which Moves() is true
  explicit Muon(std::vector<torch::Tensor> matrices);

  /// One step along the gradients of the matrices. Those without a gradient stay.
  void Step(double learningRate);

  /// The running mean of the gradients of one of the matrices.
  torch::Tensor& MomentumOf(const torch::Tensor& matrix);

private:
  std::vector<torch::Tensor> Matrices;
  std::vector<torch::Tensor> Means;
};

} // namespace surfsynth
