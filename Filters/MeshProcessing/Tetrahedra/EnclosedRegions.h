// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Regions that nested closed surfaces enclose, found in tetrahedra that fill them. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Tetrahedra/TetGenClient.h"

#include "Core/Mesh/TriangleAdjacency.h"

#include <vector>

namespace surfsynth
{

/// The space between a closed surface and those directly inside it.
struct EnclosedRegion
{
  int Depth = -1;                ///< number of surfaces around the enclosing one: 0 for an outermost one
  Index LargestTetrahedron = -1; ///< largest tetrahedron; its middle is a place inside the region
};

/// Finds the region that each patch of the surface encloses, in the order of the patches: a closed surface that is
/// connected by edges has one inner side. Uses ids only, so that nothing depends on rounding.
///
/// @param patches patches of the closed surface
/// @param mesh its tetrahedra, made without seeds, with neighbours
/// @param points points of the surface, followed by the new ones
/// @throws SolverFailure when tetrahedra and surface do not fit together
std::vector<EnclosedRegion> FindEnclosedRegions(
  const SurfacePatches& patches, const TetGenMesh& mesh, const PointMatrix& points);

/// Six times the volume of tetrahedron @p t, cubic units of @p points; positive when it is wound as VTK_TETRA.
double SixfoldVolume(const PointMatrix& points, const TetrahedronMatrix& tetrahedra, Index t);

} // namespace surfsynth
