// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pooling between the levels of a surface, for denoising networks of field latents [Mitchel2024], section 9.2. Vectors are
/// carried by parallel transport, so that results turn with the frames, keep under bending and do not depend on numbers of
/// vertices (to rounding errors). Rows of C complex channels are [real parts, imaginary parts], 2 C numbers.
#pragma once

#include "Core/Tangent/TangentHierarchy.h"

#include <cstdint>

namespace surfsynth
{

/// Computes the means over the members of the coarse vertices [first, first + rows), each in the frame of the center.
/// @param fine features of the surface, [V, 2 C] @param out [rows, 2 C]
void PoolFieldRows(const TangentHierarchy& surface, const float* fine, std::int64_t channels, std::int64_t first,
  std::int64_t rows, float* out);

/// Computes the features of the centers of the vertices [first, first + rows) in the frames of the vertices.
/// @param coarse features of the coarse level, [W, 2 C] @param out [rows, 2 C]
void UnpoolFieldRows(const TangentHierarchy& surface, const float* coarse, std::int64_t channels, std::int64_t first,
  std::int64_t rows, float* out);

} // namespace surfsynth
