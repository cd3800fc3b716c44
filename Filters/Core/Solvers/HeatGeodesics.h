// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Distances along a surface by the heat method [Crane2013].
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Geodesic distances by the heat method [Crane2013]: with u the heat of a source after a short time t,
/// (M + t L) u = delta, the unit vectors X = -grad u / |grad u| point away from the source, and the distance d is the
/// function whose gradient fits them best, L d = G^T A X.
///
/// Both matrices are factored once; distances from many sources cost two solves with many right-hand sides. The error
/// is of the order of the edge length. At a boundary heat flows along it (Neumann conditions).
///
/// t is the square of the mean edge length h, or of diagonal / 200 where that is larger, so that the heat is still a
/// number far from the source.
class HeatGeodesics
{
public:
  /// Factors both matrices.
  /// @param mesh passes CheckMesh() with manifold edges; any number of components, open or closed.
  /// @param topology the tables of @p mesh
  /// @throws SolverFailure when a matrix cannot be factored; Cancelled
  HeatGeodesics(const TriangleMesh& mesh, const MeshTopology& topology, const Progress& progress = {});

  /// Computes the distances from K source vertices, [V, K] float64, one column each; world units, at least 0, 0 at the
  /// source; infinity at vertices of other components and at unused vertices. A column has the same bits alone or with
  /// others, and for every number of threads.
  /// @throws InvalidInput when a source is out of range or used by no triangle.
  /// @throws SolverFailure when a distance is not finite.
  RowMatrix Distances(const std::vector<Index>& sources) const;

  /// The connected components of the mesh.
  const MeshComponents& Components() const { return this->Parts; }
  /// Lumped mass, [V], square world units.
  const Eigen::VectorXd& Mass() const { return this->VertexMass; }

private:
  void RequireSources(const std::vector<Index>& sources) const;
  void AccumulateDivergence(
    const Eigen::Ref<const RowMatrix>& heat, Eigen::Ref<RowMatrix> divergence, Index firstColumn, Index columns) const;
  void ShiftToSource(const std::vector<Index>& sources, RowMatrix& distances) const;

  TriangleMatrix Triangles;
  /// [F, 6]: for each corner of a triangle, its area times the basis gradient of the corner, in a frame of the
  /// triangle: x0 y0 x1 y1 x2 y2.
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> WeightedGradients;
  Eigen::VectorXd VertexMass;
  MeshComponents Parts;
  std::vector<CholeskySolver> Solvers; ///< of the heat, then of the distance
};

} // namespace surfsynth
