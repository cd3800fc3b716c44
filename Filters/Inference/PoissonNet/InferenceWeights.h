// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Weights of a PoissonNet in the form of the inference. Private to the inference.
///
/// Matrices are transposed, [inputs, outputs] row-major, so that rows of features are multiplied from the left. Linear
/// maps that follow each other without a non-linearity are multiplied out, in double.
#pragma once

#include "Inference/PoissonNet/PoissonNetModel.h"

#include <optional>
#include <vector>

namespace surfsynth
{

/// An affine map.
struct AffineWeights
{
  std::vector<float> Matrix; ///< [inputs, outputs]
  std::vector<float> Bias;   ///< [outputs]
};

/// A complex-linear map in three real products (Gauss): with t = (re + im) A, u = re B, v = im C the product is
/// (t - v) + i (t + u), where A = Wr^T, B = (Wi - Wr)^T, C = (Wr + Wi)^T.
struct ComplexWeights
{
  std::vector<float> A; ///< [inputs, outputs]
  std::vector<float> B; ///< [inputs, outputs]
  std::vector<float> C; ///< [inputs, outputs]
};

/// A complex-linear map and the bias of the non-linearity of the modulus behind it.
struct ComplexLayerWeights
{
  ComplexWeights Product;           ///< the map
  std::vector<float> MagnitudeBias; ///< [outputs]
};

/// A complex MLP.
struct ComplexMlpWeights
{
  bool Modulated = false;                  ///< true with a modulator
  AffineWeights ModulatorIn;               ///< an affine map commutes with the mean of corners: applied to vertices
  AffineWeights ModulatorOut;              ///< [W, 2 W]
  std::vector<ComplexLayerWeights> Layers; ///< the layers with a non-linearity
  std::vector<float> LastReal;             ///< [W, out], the last layer: it is linear and commutes with the divergence
  std::vector<float> LastImaginary;        ///< [W, out], its imaginary part
};

/// A per-channel norm.
struct NormWeights
{
  std::vector<float> Weight; ///< [W]
  std::vector<float> Bias;   ///< [W]
};

/// One block. The first affine map of the vertex MLP is split into the parts for its inputs, [W, W] each.
struct BlockWeights
{
  ComplexMlpWeights GradientMlp;           ///< complex MLP of the faces
  std::optional<ComplexWeights> Products;  ///< the last layer and the map of the inner products in one
  std::vector<float> ProductScale;         ///< [W], scale of the inner products
  std::vector<float> FromFeatures;         ///< part of the first map for the features x
  std::vector<float> FromSolution;         ///< part for the Poisson solution u
  std::vector<float> FromExtra;            ///< part for the condition, or empty
  std::vector<float> FromProducts;         ///< part for the inner products, or empty
  std::vector<float> Bias1;                ///< [W], bias of the first map
  AffineWeights Out1;                      ///< second map of the first half, with the layer scale
  AffineWeights In2;                       ///< first map of the second half
  AffineWeights Out2;                      ///< second map of the second half, with the layer scale
  std::optional<NormWeights> SolutionNorm; ///< norm of u
  std::optional<NormWeights> ProductNorm;  ///< norm of the inner products
};

/// A whole network.
struct InferenceWeights
{
  /// Converts the weights of @p model.
  /// @throws InvalidInput as CheckModel().
  explicit InferenceWeights(const PoissonNetModel& model);

  AffineWeights ProjectIn;                       ///< map of the input signal to the features
  std::optional<AffineWeights> ExtraIn;          ///< first map of the condition
  std::optional<AffineWeights> ExtraOut;         ///< second map of the condition
  std::vector<BlockWeights> Blocks;              ///< the blocks, first to last
  AffineWeights LinearHead;                      ///< a linear head; empty for a gradient-domain head
  std::optional<ComplexMlpWeights> GradientHead; ///< a gradient-domain head
};

} // namespace surfsynth
