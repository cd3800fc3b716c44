// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Meshes that a fit begins with. Private to the training; no torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>

namespace surfsynth
{

/// The icosahedron on the unit sphere, each triangle split into four @p level times; wound outwards.
TriangleMesh MakeIcosphere(std::int64_t level);

/// The torus around the z axis with radii 1 and 0.4: @p segments pairs of triangles around the axis, a third as many, but at
/// least 3, around the tube; wound outwards.
TriangleMesh MakeTorus(std::int64_t segments);

} // namespace surfsynth
