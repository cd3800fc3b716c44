// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Muon for networks of tangent vectors, whose matrices are complex. Private to the training.
#pragma once

#include "Learning/Training/Muon.h"

#include <torch/torch.h>

#include <string>
#include <vector>

namespace surfsynth
{

/// Muon for complex matrices A + i B that are parameters [2, rows, ...] with A and B in turn: it moves the real matrices
///   (A -B; B A),
/// which act on real and imaginary parts. Orthogonalized they are of this form again, so that a turn of frames commutes with
/// the step. Dimensions after the rows count as columns.
class ComplexMuon
{
public:
  /// True for the parameters that are moved: complex matrices with at least 16 rows and columns.
  static bool Moves(const torch::Tensor& parameter);

  /// @param parameters those of a network; the others are left alone. Their gradients must exist and stay the same tensors.
  explicit ComplexMuon(const std::vector<torch::Tensor>& parameters);

  /// Takes the gradients of the matrices away from them, which hold 0 then: an optimizer of all parameters leaves them as
  /// they are.
  void TakeGradients();
  /// One step along the gradients that were taken.
  void Step(double learningRate);

  /// The running mean of the gradients of a parameter that is moved, in its shape.
  torch::Tensor MomentumOf(const torch::Tensor& parameter);
  /// Sets it, as when a checkpoint is restored.
  void SetMomentum(const torch::Tensor& parameter, const torch::Tensor& momentum);

private:
  torch::Tensor& RealMomentumOf(const torch::Tensor& parameter);

  std::vector<torch::Tensor> Parameters;
  std::vector<torch::Tensor> Matrices; ///< real ones
  Muon Real;
};

} // namespace surfsynth
