// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The weights of a PoissonNet as inference uses them. Private to the inference.
///
/// Matrices are transposed, [inputs, outputs] row-major, so that rows of features are multiplied from the left. What
/// follows each other without a non-linearity is multiplied out, in double.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"

#include <optional>
#include <vector>

namespace surfsynth
{

struct AffineWeights
{
  std::vector<float> Matrix;
  std::vector<float> Bias;
};

/// A complex-linear map in three real products (Gauss): with t = (re + im) A, u = re B, v = im C the product is
/// (t - v) + i (t + u), where A = Wr^T, B = (Wi - Wr)^T, C = (Wr + Wi)^T.
struct ComplexWeights
{
  std::vector<float> A;
  std::vector<float> B;
  std::vector<float> C;
};

struct ComplexLayerWeights
{
  ComplexWeights Product;
  std::vector<float> MagnitudeBias;
};

/// A complex MLP.
struct ComplexMlpWeights
{
  bool Modulated = false;
  AffineWeights ModulatorIn;               ///< an affine map commutes with the mean of corners: applied to vertices
  AffineWeights ModulatorOut;              ///< [W, 2 W]
  std::vector<ComplexLayerWeights> Layers; ///< those with a non-linearity
  /// The last layer, which is linear and commutes with the divergence: [W, out] each.
  std::vector<float> LastReal;
  std::vector<float> LastImaginary;
};

/// Per-channel norm: weight and bias.
struct NormWeights
{
  std::vector<float> Weight;
  std::vector<float> Bias;
};

struct BlockWeights
{
  ComplexMlpWeights GradientMlp;
  std::optional<ComplexWeights> Products; ///< the last layer and the map of the inner products in one
  std::vector<float> ProductScale;
  std::vector<float> FromFeatures; ///< the parts of the first affine map of the vertex MLP that meet x, u, extra and
  std::vector<float> FromSolution; ///< the inner products, [W, W] each, or empty
  std::vector<float> FromExtra;
  std::vector<float> FromProducts;
  std::vector<float> Bias1;
  AffineWeights Out1; ///< with the layer scale
  AffineWeights In2;
  AffineWeights Out2; ///< with the layer scale
  std::optional<NormWeights> SolutionNorm;
  std::optional<NormWeights> ProductNorm;
};

struct InferenceWeights
{
  /// @throws InvalidInput as CheckModel().
  explicit InferenceWeights(const PoissonNetModel& model);

  AffineWeights ProjectIn;
  std::optional<AffineWeights> ExtraIn;
  std::optional<AffineWeights> ExtraOut;
  std::vector<BlockWeights> Blocks;
  AffineWeights LinearHead;
  std::optional<ComplexMlpWeights> GradientHead;
};

} // namespace surfsynth
