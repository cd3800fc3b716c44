// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Encoder of field latents [Mitchel2024]: colors around vertices to tangent vectors at them. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/FieldLatents/FieldLatentModel.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Rows of numbers, float32.
using FieldLatentMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Samples of a texture in the one-rings of V vertices, S in all.
struct FieldLatentRings
{
  /// [V + 1], first sample of each vertex, from 0 to S, never decreasing. Rings may have different numbers of samples.
  std::vector<std::int64_t> Offsets = { 0 };
  /// [S, 2], log_p(q) / r_p in the frame of p, with r_p = sqrt(area of the one-ring / pi). The paper names no unit; this
  /// one makes codes independent of the scale of the surface.
  FieldLatentMatrix Logarithms;
  FieldLatentMatrix Colors; ///< [S, 3], RGB from -1 (0) to 1 (255)

  /// Number of vertices, V.
  std::int64_t NumberOfVertices() const { return static_cast<std::int64_t>(this->Offsets.size()) - 1; }
};

/// Gaussians in the tangent spaces of V vertices, d in each.
struct FieldLatentCodes
{
  FieldLatentMatrix Mean;         ///< [V, 2 d], real and imaginary part of each tangent vector in turn
  FieldLatentMatrix LogDeviation; ///< [V, d], natural logarithm of the deviation of each component
};

/// Evaluator of the encoder, without LibTorch, on tiles of rings that stay in cache: memory beside input and output
/// does not grow with the number of vertices. Results have the same bits for every number of threads. They turn with
/// the frames and do not depend on the order of the samples (to rounding errors).
///
/// Each ring passes through the network by itself: its samples are lifted (equation 21) and gathered into a token
/// (equation 22); VN-transformer layers follow, and the token gives mean (equation 24) and deviation (equation 25).
/// Choices that the paper leaves open, and misprints:
///
/// - Equation 22 is divided by the number of samples, so that codes do not depend on it.
/// - The mean of equation 20 runs over the tokens of one ring, samples and token, because the encoder works at each
///   vertex by itself. Its delta is exp(log_delta), so that it stays positive.
/// - The delta of equation 19 is 1e-3: with smaller ones rounding errors of small keys grow to those of results.
/// - The softmax takes the real part of <query, key> over sqrt(2 C / heads), the number of real components (section 9.1
///   has "keys and values").
/// - The invariant feature of equation 25 is conj(L3 x) x: the product without the conjugate is not invariant.
///
/// A vertex without samples has a mean of 0.
class FieldLatentEncoder
{
public:
  /// Prepares the weights; @p model is not needed afterwards.
  /// @throws InvalidInput as CheckModel().
  explicit FieldLatentEncoder(const FieldLatentModel& model);
  ~FieldLatentEncoder();
  FieldLatentEncoder(FieldLatentEncoder&&) noexcept;
  FieldLatentEncoder& operator=(FieldLatentEncoder&&) noexcept;

  /// Architecture of the model.
  const FieldLatentOptions& Options() const;

  /// Encodes all rings.
  /// @throws InvalidInput when sizes or offsets do not fit, or an input or a result is not finite; Cancelled.
  FieldLatentCodes Encode(const FieldLatentRings& rings, const Progress& progress = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
