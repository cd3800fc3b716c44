// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tangent vectors at vertices as complex numbers: (a, b) in the frame of a vertex, a X + b Y, is a + i b [Knoppel2013].
#pragma once

#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Returns the tangent parts of vectors at the vertices as complex numbers; the parts along the normals are left out.
/// @param vectors [V, 3]
/// @return [V] complex, in the units of @p vectors.
/// @throws InvalidInput when the numbers of rows differ.
Eigen::VectorXcd ToTangent(const VertexFrames& frames, const Eigen::Ref<const PointMatrix>& vectors);

/// Returns tangent vectors as vectors in space.
/// @param tangents [V] complex
/// @return [V, 3], in the units of @p tangents.
/// @throws InvalidInput when the numbers of rows differ.
PointMatrix FromTangent(const VertexFrames& frames, const Eigen::Ref<const Eigen::VectorXcd>& tangents);

/// Returns the frames turned counter-clockwise about their normals. A tangent vector z becomes exp(-i angle) z.
/// @param angles [V], radians
/// @throws InvalidInput when the numbers of rows differ.
VertexFrames TurnedFrames(const VertexFrames& frames, const Eigen::Ref<const Eigen::VectorXd>& angles);

} // namespace surfsynth
