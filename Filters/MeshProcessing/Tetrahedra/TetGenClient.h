// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// One run of TetGen in a process of its own. Private to the module.
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

/// What to ask of TetGen.
struct TetGenCall
{
  bool PreserveSurface = true;
  double QualityRatio = 2.0;         ///< 0 for none
  double MinimumDihedralAngle = 0.0; ///< degrees
  double MaximumVolume = 0.0;        ///< in the units of the points; 0 for none
  std::vector<tetgen::Seed> Seeds;   ///< none: one region, everything enclosed
  bool WantNeighbours = false;

  double Seconds = 0.0;         ///< time limit, 0 for none
  std::int64_t MemoryLimit = 0; ///< bytes, 0 for none
  /// Turns triangle ids into the caller's cell ids in messages; empty when they are the same.
  std::function<std::int64_t(std::int64_t)> CellOfTriangle;
};

/// What it has made. All ids have been checked.
struct TetGenMesh
{
  PointMatrix NewPoints;        ///< their ids follow those of the surface's points
  TetrahedronMatrix Tetrahedra; ///< wound as VTK_TETRA
  std::vector<Index> Regions;   ///< [T], of the seed; 0 without seeds
  TetrahedronMatrix Neighbours; ///< [T, 4], across the face opposite to each corner, -1 outside; empty unless asked for
  TriangleMatrix Faces;         ///< the surface in the mesh
  std::vector<Index> Triangles; ///< [faces], the triangle of the surface that a face is a part of
};

/// Where the program that links TetGen is: the value of the environment variable SURFACE_SYNTHESIS_TETGEN, else beside the
/// library that this function is in.
/// @throws InvalidInput when there is none
std::string FindTetGenProgram();

/// @param surface closed, every point used, coordinates of about unit size
/// @throws SolverFailure, saying what happened inside TetGen and what to try; Cancelled
TetGenMesh RunTetGen(const TriangleMesh& surface, const TetGenCall& call, const Progress& progress);

} // namespace surfsynth
