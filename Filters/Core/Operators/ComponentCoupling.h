// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Coupling of the connected components of a mesh, for equations that would leave each component on its own.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

namespace surfsynth
{

/// Options of a coupling.
struct ComponentCoupling
{
  bool IsOn = false; ///< false: components are not coupled
  /// w > 0, no unit: weight of the squared differences of the pairs against the Dirichlet energy. Larger is stiffer.
  double Weight = 1e6;
  /// Largest distance of the two ends of a pair, world units, >= 0; 0 for 0.03 sqrt(A), A the area of the mesh.
  double Distance = 0.0;

  /// True when both couple alike.
  bool operator==(const ComponentCoupling& other) const
  {
    return this->IsOn == other.IsOn &&
      (!this->IsOn || (this->Weight == other.Weight && this->Distance == other.Distance));
  }
};

/// Largest distance of the two ends of a pair of a mesh of this area: Distance, or what 0 stands for.
double LargestDistance(const ComponentCoupling& coupling, double area);

/// A pair of close places of two components.
struct CoupledPair
{
  Index Vertex;            ///< one end, a vertex
  Index Corners[3];        ///< vertices of the triangle of another component in which the other end lies
  Eigen::Vector3d Weights; ///< its barycentric coordinates
};

/// Finds the pairs that couple the components of @p mesh: each vertex and the nearest place of all other components,
/// where their distance is at most ComponentCoupling::Distance, and at most twice the distance of that place from the
/// component of the vertex, so that only parts that face each other are coupled. The nearest of several places of equal
/// distance is the first by coordinates, so that the pairs do not depend on the order of the components. The time hardly
/// depends on the number of components.
/// @return pairs in ascending order of Vertex; none for one component
/// @throws InvalidInput for options out of range, and where pairs do not join all components to one. Cancelled.
std::vector<CoupledPair> FindCoupledPairs(const TriangleMesh& mesh, const MeshComponents& components,
  const ComponentCoupling& coupling, const Progress& progress = {});

/// Returns w B'B, [V, V]: u' (w B'B) u is w / A times the sum over the pairs of m_v (u_v - u_q)^2, with m_v the lumped
/// mass of the vertex, u_q the value at the other end and A the sum of all m_v. It has no unit, as the stiffness L, and
/// depends on the triangulation only as L does. A matrix without rows when the coupling is off or there is one component.
/// Same errors as FindCoupledPairs().
SparseMatrix CouplingMatrix(const TriangleMesh& mesh, const MeshTopology& topology, const ComponentCoupling& coupling,
  const Progress& progress = {});

/// Returns the components as the single one that a coupling makes of them: the sum of their areas, closed when all are,
/// with the Euler characteristic of the largest.
MeshComponents CoupledAsOne(const MeshComponents& components);

} // namespace surfsynth
