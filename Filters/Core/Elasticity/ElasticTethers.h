// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Springs between places of an elastic body and fixed ends.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/VolumePlace.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

class NodeMatrix;

/// Springs of rest length 0: energy sum_k s_k |P_k x - e_k|^2 / 2 of the nodes x, with the place P_k x of spring k, its
/// end e_k and its stiffness s_k; held as a quadratic form of the nodes, whatever the number of springs.
class ElasticTethers
{
public:
  /// No springs.
  ElasticTethers() = default;

  /// @param places [K] in @p mesh, of the body; those without a tetrahedron have no spring
  /// @param ends [K, 3], meters
  /// @param stiffness [K], newtons per meter, at least 0
  ElasticTethers(const TetrahedralMesh& mesh, const std::vector<VolumePlace>& places, const PointMatrix& ends,
    const Eigen::VectorXd& stiffness);

  /// Energy, joules.
  double Energy(const PointMatrix& points) const;
  /// Adds the derivative of the energy, newtons, to @p gradient.
  void AddGradient(const PointMatrix& points, PointMatrix& gradient) const;
  /// Adds the second derivative, newtons per meter; the pattern has the pairs of nodes of each tetrahedron.
  void AddStiffness(NodeMatrix& stiffness) const;

private:
  bool IsEmpty() const { return this->Pull.rows() == 0; }

  SparseMatrix Stiffness;                                 ///< [V, V] A: the derivative is A (x - origin) - pull
  PointMatrix Pull;                                       ///< [V, 3] newtons
  Eigen::RowVector3d Origin = Eigen::RowVector3d::Zero(); ///< center of the ends
  double Constant = 0.0;                                  ///< joules
};

} // namespace surfsynth
