// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tetrahedra that fill a closed surface. Private to the module.
#pragma once

#include "MeshProcessing/Tetrahedra/TetGenClient.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

struct TetrahedralizeOptions
{
  bool PreserveSurface = true;        ///< no new points on the surface
  bool InnerSurfacesAreHoles = false; ///< what every second of nested surfaces encloses stays empty; else all is filled
  double QualityRatio = 2.0;          ///< largest ratio of circumradius to shortest edge; 0 for none, else at least 1
  double MinimumDihedralAngle = 0.0;  ///< degrees
  double MaximumVolume = 0.0;         ///< cubic world units, 0 for none
  double Seconds = 0.0;               ///< time limit of each run of TetGen, 0 for none
  std::int64_t MemoryLimit = 0;       ///< bytes, 0 for none
};

struct TetrahedralMesh
{
  PointMatrix Points;           ///< [P, 3]: the points of the surface, unchanged and in their order, then new ones
  TetrahedronMatrix Tetrahedra; ///< [T, 4], all of volume above zero as VTK_TETRA
  std::vector<Index> Regions;   ///< [T], the patch of the surface (see FindPatches()) that encloses the tetrahedron
  TriangleMatrix Faces;         ///< the surface in the mesh: its triangles, or parts of them
  std::vector<Index> Triangles; ///< [faces], of the surface
  std::vector<Index> Patches;   ///< [triangles of the surface], the patch that each belongs to
};

/// @param surface passes the gate, is closed, and has no unused points
/// @param cellOfTriangle turns triangle ids into the caller's cell ids in messages; empty when they are the same
/// @throws InvalidInput, SolverFailure, Cancelled
TetrahedralMesh Tetrahedralize(const TriangleMesh& surface, const TetrahedralizeOptions& options,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle, const Progress& progress);

} // namespace surfsynth
