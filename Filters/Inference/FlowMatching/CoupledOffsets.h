// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Offsets of coupled components that turn with the surface around them. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/ComponentCoupling.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Core>

#include <cstddef>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Offsets between the coupled components of a surface s. The coupling of a Poisson equation leads the differences at
/// its pairs to those of the source, B s, also where the surface f has turned: a tongue then leaves the mouth of a head
/// that nods. Here they become R B s, with R the rotation of the surface at the pairs.
///
/// Each pair has a place on the larger one of its components, and pairs whose places lie in a cube of the distance of
/// the coupling share R. It is that of the rigid motion that is nearest to f in squares over the vertices around: those
/// that are joined to the places by edges within twice that distance, and the first ones beyond. Weights are masses
/// times (1 - d^2 / r^2)^2, d their distances from the middle of the places and r twice that of the coupling, but at
/// least a hundredth of the mass. Results do not depend on the order of the components, up to rounding.
class CoupledOffsets
{
public:
  /// Finds the pairs and the vertices around them.
  /// @param mesh the source, in the units of @p coupling, with the bits of that of CouplingMatrix(): other pairs would
  /// pull where the equation is not stiff
  /// @param solver of L + w B'B and a shift, with w B'B as CouplingMatrix() has it
  /// @throws InvalidInput as FindCoupledPairs(); Cancelled.
  CoupledOffsets(const TriangleMesh& mesh, const MeshTopology& topology, const ComponentCoupling& coupling,
    std::shared_ptr<const CholeskySolver> solver, const Progress& progress = {});

  /// Moves @p positions f, [V, 3], by the solution d of (L + w B'B) d = w B'(R B s - B f), less its mean over the
  /// surface.
  void Restore(PointMatrix& positions) const;

private:
  /// Pairs that share a rotation, and the vertices that it is that of.
  struct Group
  {
    std::vector<std::size_t> Pairs;
    std::vector<Index> Vertices;
    Eigen::VectorXd Weights; ///< of the vertices
  };

  void MakeGroups(
    const MeshTopology& topology, const MeshComponents& components, double distance, const Progress& progress);
  /// Fills in the weights of the vertices of @p group, which are joined to it.
  void Weigh(Group& group, const Eigen::RowVector3d& center, double radius) const;
  Eigen::Matrix3d RotationOf(const Group& group, const PointMatrix& positions) const;

  PointMatrix Source;
  Eigen::VectorXd Mass;
  double Weight; ///< w over the area
  std::vector<CoupledPair> Pairs;
  std::vector<Group> Groups;
  std::shared_ptr<const CholeskySolver> Solver;
};

} // namespace surfsynth
