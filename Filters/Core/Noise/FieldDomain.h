// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Domain of a random field, as its assembly sees it: a surface or a volume. Private to the noise.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Noise/LatticeNoise.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"

#include <optional>
#include <vector>

namespace surfsynth
{

/// Operators of one mesh, each of which the assembly asks for once.
class FieldDomain
{
public:
  virtual ~FieldDomain() = default;

  /// Lumped mass, [V].
  virtual Eigen::VectorXd Mass() const = 0;
  /// Connected components, with the area or volume of each.
  virtual MeshComponents Components(const Eigen::VectorXd& mass) const = 0;
  /// Stiffness of the field's Laplacian: anisotropic where the options say so.
  virtual SparseMatrix Stiffness() const = 0;
  /// Coupling of the components to be added to the stiffness; without rows for none.
  virtual SparseMatrix Coupling(const Progress& progress) const = 0;
  /// Vertices at which the boundary condition sets the field to 0, [V]; empty for none.
  virtual std::vector<bool> Pinned() const = 0;
  /// Lumped mass of the boundary times the coefficient of the Robin condition, [V]; empty for other conditions.
  virtual Eigen::VectorXd RobinMass() const = 0;
  /// White noise on a lattice in space, for coherent noise.
  virtual LatticeNoise Lattice(double side) const = 0;
  /// Variance of the unscaled field on a component, from its area or volume.
  virtual double Variance(double tau, const MeshComponents& components, Index component) const = 0;
};

/// A surface.
class SurfaceDomain : public FieldDomain
{
public:
  /// Keeps references.
  SurfaceDomain(const TriangleMesh& mesh, const MeshTopology& topology, const MaternFieldOptions& options)
    : Mesh(mesh)
    , Topology(topology)
    , Options(options)
  {}

  Eigen::VectorXd Mass() const override;
  MeshComponents Components(const Eigen::VectorXd& mass) const override;
  SparseMatrix Stiffness() const override;
  SparseMatrix Coupling(const Progress& progress) const override;
  std::vector<bool> Pinned() const override;
  Eigen::VectorXd RobinMass() const override;
  LatticeNoise Lattice(double side) const override;
  double Variance(double tau, const MeshComponents& components, Index component) const override;

private:
  const TriangleMesh& Mesh;
  const MeshTopology& Topology;
  const MaternFieldOptions& Options;
};

/// A volume of tetrahedra.
class VolumeDomain : public FieldDomain
{
public:
  /// Keeps references, and finds the boundary where a boundary condition needs it.
  VolumeDomain(const TetrahedralMesh& mesh, const MaternFieldOptions& options);

  Eigen::VectorXd Mass() const override;
  MeshComponents Components(const Eigen::VectorXd& mass) const override;
  SparseMatrix Stiffness() const override;
  /// @throws InvalidInput for options that couple
  SparseMatrix Coupling(const Progress& progress) const override;
  std::vector<bool> Pinned() const override;
  Eigen::VectorXd RobinMass() const override;
  /// @throws InvalidInput
  LatticeNoise Lattice(double side) const override;
  double Variance(double tau, const MeshComponents& components, Index component) const override;

private:
  const TetrahedralMesh& Mesh;
  const MaternFieldOptions& Options;
  std::vector<FaceVertices> Boundary;
};

} // namespace surfsynth
