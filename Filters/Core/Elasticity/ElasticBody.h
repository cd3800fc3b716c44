// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Elastic body of linear tetrahedra.
#pragma once

#include "Core/Elasticity/NeoHookean.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

class NodeMatrix;

/// A stable neo-Hookean body [Smith2018] of linear tetrahedra, whose deformation gradient is constant in each; masses are
/// lumped at the nodes. Positions are in meters.
class ElasticBody
{
public:
  /// @param mesh the body at rest, meters; passes RequireValidVolume(), and every point is a corner of a tetrahedron.
  /// Tetrahedra of negative volume are turned round.
  /// @throws InvalidInput when a point is used by no tetrahedron, or a constant is out of its range.
  ElasticBody(TetrahedralMesh mesh, const ElasticMaterial& material);

  /// The body at rest, with positive volumes.
  const TetrahedralMesh& Mesh() const { return this->Rest; }
  /// Constants of the material.
  const ElasticMaterial& Material() const { return this->Constants; }
  /// Mass of each node, [V], kilograms.
  const Eigen::VectorXd& Masses() const { return this->NodeMasses; }
  /// Area of the boundary at each node, [V], square meters; 0 inside.
  const Eigen::VectorXd& BoundaryAreas() const { return this->Areas; }
  /// Triangles of the boundary, with normals outwards.
  const TriangleMatrix& Boundary() const { return this->Faces; }

  /// Elastic energy, joules.
  double Energy(const PointMatrix& points) const;
  /// Adds the derivative of the energy by the positions, newtons, to @p gradient [V, 3].
  void AddGradient(const PointMatrix& points, PointMatrix& gradient) const;
  /// Adds its second derivative, projected to positive semi-definite tetrahedron by tetrahedron, newtons per meter.
  void AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const;
  /// Smallest volume of a tetrahedron over its volume at rest.
  double SmallestVolumeRatio(const PointMatrix& points) const;

private:
  Eigen::Matrix3d DeformationGradient(const PointMatrix& points, Index t) const;
  void FindBoundary();

  TetrahedralMesh Rest;
  ElasticMaterial Constants;
  NeoHookean Density;
  std::vector<double> Volumes;                             ///< [T], at rest
  std::vector<Eigen::Matrix<double, 4, 3>> ShapeGradients; ///< [T], of the four barycentric coordinates, per meter
  Eigen::VectorXd NodeMasses;
  Eigen::VectorXd Areas;
  TriangleMatrix Faces;
};

} // namespace surfsynth
