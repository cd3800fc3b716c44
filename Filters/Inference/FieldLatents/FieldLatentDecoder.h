// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Decoder of field latents [Mitchel2024]: tangent vectors at vertices to colors of texels. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/FieldLatentModel.h"

#include <memory>

namespace surfsynth
{

/// Points of triangles whose colors are asked for, Q in all. Neighbors in memory should be neighbors on the surface: what
/// belongs to a vertex is computed once for each tile of some hundred texels.
struct FieldLatentTexels
{
  TriangleMatrix Corners; ///< [Q, 3], vertices of the triangle
  /// [Q, 6], log_p(q) / r_p for each corner p in turn, in its frame; see FieldLatentRings::Logarithms. Not read with
  /// barycentric coordinates, and may then be empty.
  FieldLatentMatrix Logarithms;
  FieldLatentMatrix Barycentric; ///< [Q, 3], barycentric coordinates: weights of the corners, with a sum of 1
};

/// Evaluator of the decoder, without LibTorch, on tiles of texels that stay in cache: memory beside input and output
/// grows neither with the vertices nor with the texels. Results have the same bits for every number of threads, and do
/// not depend on the frames (to rounding errors).
///
/// The neural field (equation 18) sees real and imaginary parts of log_p(q) / r_p conj(z) (equation 5) and of the upper
/// triangle of z z^*; hidden layers with SiLU, then a linear one. Predictions of the three corners are blended by the
/// barycentric coordinates. The share of the outer products in the first layer is computed once for each vertex of a
/// tile; so is that of equation 5, which is linear in the logarithm.
class FieldLatentDecoder
{
public:
  /// Prepares the weights; @p model is not needed afterwards.
  /// @throws InvalidInput as CheckModel().
  explicit FieldLatentDecoder(const FieldLatentModel& model);
  ~FieldLatentDecoder();
  FieldLatentDecoder(FieldLatentDecoder&&) noexcept;
  FieldLatentDecoder& operator=(FieldLatentDecoder&&) noexcept;

  /// Architecture of the model.
  const FieldLatentOptions& Options() const;

  /// Decodes all texels.
  /// @param latents [V, 2 d], real and imaginary part of each tangent vector in turn: FieldLatentCodes::Mean, or a sample
  /// @return [Q, 3] RGB, from -1 (0) to 1 (255); not clamped.
  /// @throws InvalidInput when sizes do not fit, a vertex does not exist, or an input or a result is not finite;
  /// Cancelled.
  FieldLatentMatrix Decode(
    const FieldLatentMatrix& latents, const FieldLatentTexels& texels, const Progress& progress = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
