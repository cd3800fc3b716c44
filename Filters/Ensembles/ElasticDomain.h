// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tetrahedra that stand for a surface or a volume in a simulation. Private to the module.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <vector>

class vtkDataObject;
class vtkUnstructuredGrid;

namespace surfsynth
{

/// Tetrahedra without points that none of them uses, world units, and points that move with them.
struct ElasticDomain
{
  TetrahedralMesh Mesh;
  PointMatrix Points; ///< [V, 3], of the dataset
  std::vector<std::array<Index, 4>>
    Corners; ///< [V], nodes that each point moves with; -1 first where it is not finite and stays
  std::vector<Eigen::Vector4d> Weights; ///< [V], sum 1; below 0 outside the tetrahedra

  /// Points of the dataset for these nodes.
  PointMatrix Follow(const PointMatrix& nodes) const;
};

/// Converts the tetrahedra of @p grid and checks them.
/// @throws InvalidInput
TetrahedralMesh TetrahedraOf(vtkUnstructuredGrid* grid);

/// Makes the domain of a dataset: its own tetrahedra; or @p tetrahedra, where there are some; or tetrahedra that fill the
/// surface, remeshed to @p surfacePoints points, or as it is for 0.
/// @throws InvalidInput, SolverFailure, Cancelled
ElasticDomain MakeElasticDomain(
  vtkDataObject* input, const TetrahedralMesh* tetrahedra, int surfacePoints, const Progress& progress);

} // namespace surfsynth
