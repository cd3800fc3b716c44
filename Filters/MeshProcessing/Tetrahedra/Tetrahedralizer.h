// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tetrahedral meshing of a closed surface by TetGen [Si2015]. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Tetrahedra/TetGenClient.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace surfsynth
{

/// Options of Tetrahedralize().
struct TetrahedralizeOptions
{
  bool PreserveSurface = true;        ///< no new points on the surface
  bool InnerSurfacesAreHoles = false; ///< the region inside every second of nested surfaces stays empty
  double QualityRatio = 2.0;          ///< largest ratio of circumradius to shortest edge; 0 for none, else at least 1
  double MinimumDihedralAngle = 0.0;  ///< degrees, 0 for none
  double MaximumVolume = 0.0;         ///< cubic world units, 0 for none
  double TargetEdgeLength = 0.0;      ///< as MaximumVolume, by the edges of the regular tetrahedron; 0 for none
  double MaximumNumberOfTetrahedra = 1e7; ///< more expected ones, by a bound of the volume, are an error before work
  double Seconds = 0.0;                   ///< time limit of each run of TetGen, 0 for none
  std::int64_t MemoryLimit = 0;           ///< bytes, 0 for none
};

/// Result of Tetrahedralize().
struct FilledSurface
{
  PointMatrix Points;           ///< [P, 3]: the points of the surface, unchanged and in their order, then new ones
  TetrahedronMatrix Tetrahedra; ///< [T, 4], all of volume above zero as VTK_TETRA
  std::vector<Index> Regions;   ///< [T], the patch of the surface (see FindPatches()) that encloses the tetrahedron
  TriangleMatrix Faces;         ///< the surface in the mesh: its triangles, or parts of them
  std::vector<Index> Triangles; ///< [faces], triangle of the surface that each face is a part of
  std::vector<Index> Patches;   ///< [triangles of the surface], patch of each triangle
};

/// Fills a closed surface with tetrahedra.
/// @param surface passes CheckMesh(), is closed, and has no unused points
/// @param cellOfTriangle turns triangle ids into the caller's cell ids in messages; empty when they are the same
/// @throws InvalidInput, SolverFailure, Cancelled
FilledSurface Tetrahedralize(const TriangleMesh& surface, const TetrahedralizeOptions& options,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle, const Progress& progress);

} // namespace surfsynth
