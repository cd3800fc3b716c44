// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// One run of TetGen [Si2015] in a process of its own. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Tetrahedra/TetGenProtocol.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Point ids of tetrahedra, [T, 4].
using TetrahedronMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 4, Eigen::RowMajor>;

/// Options of a run.
struct TetGenCall
{
  bool PreserveSurface = true;       ///< no new points on the surface
  double QualityRatio = 2.0;         ///< largest ratio of circumradius to shortest edge; 0 for none
  double MinimumDihedralAngle = 0.0; ///< degrees, 0 for none
  double MaximumVolume = 0.0;        ///< in the cubic units of the points; 0 for none
  std::vector<tetgen::Seed> Seeds;   ///< a place in each region; none: one region, everything enclosed
  bool WantNeighbors = false;        ///< fill TetGenMesh::Neighbors

  double Seconds = 0.0;         ///< time limit, 0 for none
  std::int64_t MemoryLimit = 0; ///< bytes, 0 for none
  /// Turns triangle ids into the caller's cell ids in messages; empty when they are the same.
  std::function<std::int64_t(std::int64_t)> CellOfTriangle;
};

/// Tetrahedra of TetGen. All ids have been checked.
struct TetGenMesh
{
  PointMatrix NewPoints;        ///< new points; their ids follow those of the surface's points
  TetrahedronMatrix Tetrahedra; ///< [T, 4], wound as VTK_TETRA
  std::vector<Index> Regions;   ///< [T], region of the seed; 0 without seeds
  TetrahedronMatrix Neighbors;  ///< [T, 4], across the face opposite to each corner, -1 outside; empty unless asked for
  TriangleMatrix Faces;         ///< the surface in the mesh
  std::vector<Index> Triangles; ///< [faces], the triangle of the surface that a face is a part of
};

/// Finds the program that links TetGen: the value of the environment variable SURFACE_SYNTHESIS_TETGEN, else a file
/// beside the library of this function.
/// @return path
/// @throws InvalidInput when there is none
std::string FindTetGenProgram();

/// Runs TetGen on a surface.
/// @param surface closed, every point used, coordinates of about unit size
/// @throws SolverFailure with the cause inside TetGen and a remedy; Cancelled
TetGenMesh RunTetGen(const TriangleMesh& surface, const TetGenCall& call, const Progress& progress);

} // namespace surfsynth
