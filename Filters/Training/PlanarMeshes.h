// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random planar meshes for the training of field latents. Private to the module.
#pragma once

#include "Core/Common/Progress.h"
#include "IO/Datasets/TextureDataset.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Makes triangulations of the unit square as [Mitchel2024], section 9.1: farthest-point samples of eight times as many
/// uniform points, triangulated by Delaunay (vtkDelaunay2D). Triangles at the border whose height is below 1e-3 of their
/// longest side are left out. A pure function of the arguments, but for @p progress. O(count points^2), parallel.
/// @param count number of meshes, at least 1
/// @param points number of points of each mesh, at least 16
/// @param seed of all points: mesh k is the same for every count
/// @throws Cancelled
std::vector<PlanarMesh> MakePlanarMeshes(
  std::int64_t count, std::int64_t points, std::uint64_t seed, const Progress& progress = {});

} // namespace surfsynth
