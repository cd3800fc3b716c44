// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/FieldDomain.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/MaternFieldInternals.h"
#include "Core/Operators/VolumeOperators.h"

namespace surfsynth
{

namespace
{
bool IsAnisotropic(const MaternFieldOptions& options)
{
  return options.Model == NoiseModel::Matern && options.Arrays.Directions.rows() > 0 && options.AnisotropyRatio != 1.0;
}
} // namespace

Eigen::VectorXd SurfaceDomain::Mass() const { return LumpedMass(this->Mesh, this->Topology); }

MeshComponents SurfaceDomain::Components(const Eigen::VectorXd& mass) const
{
  return ComputeComponents(this->Topology, mass);
}

SparseMatrix SurfaceDomain::Stiffness() const { return FieldStiffness(this->Mesh, this->Topology, this->Options); }

std::vector<bool> SurfaceDomain::Pinned() const { return PinnedVertices(this->Topology, this->Options); }

Eigen::VectorXd SurfaceDomain::RobinMass() const
{
  return surfsynth::RobinMass(this->Mesh, this->Topology, this->Options);
}

LatticeNoise SurfaceDomain::Lattice(double side) const { return { this->Mesh, this->Topology, side }; }

double SurfaceDomain::Variance(double tau, const MeshComponents& components, Index component) const
{
  return MarginalVariance(tau, components.Area[component], components.EulerCharacteristic[component],
    components.Closed[component], this->Options.OperatorPower);
}

VolumeDomain::VolumeDomain(const TetrahedralMesh& mesh, const MaternFieldOptions& options)
  : Mesh(mesh)
  , Options(options)
{
  const bool isDirichlet = options.Boundary == BoundaryCondition::Dirichlet && options.Arrays.BoundaryMask.empty();
  if (options.Model == NoiseModel::Matern && (isDirichlet || options.Boundary == BoundaryCondition::Robin))
  {
    this->Boundary = FindFaces(mesh).Boundary;
  }
}

Eigen::VectorXd VolumeDomain::Mass() const { return LumpedMass(this->Mesh); }

MeshComponents VolumeDomain::Components(const Eigen::VectorXd& mass) const
{
  return ComputeComponents(this->Mesh, mass);
}

SparseMatrix VolumeDomain::Stiffness() const
{
  return IsAnisotropic(this->Options)
    ? VolumeStiffness(
        this->Mesh, DirectionTensors(this->Mesh, this->Options.Arrays.Directions, this->Options.AnisotropyRatio))
    : VolumeStiffness(this->Mesh);
}

std::vector<bool> VolumeDomain::Pinned() const
{
  if (this->Options.Boundary != BoundaryCondition::Dirichlet)
  {
    return {};
  }
  if (!this->Options.Arrays.BoundaryMask.empty())
  {
    return this->Options.Arrays.BoundaryMask;
  }
  std::vector<bool> pinned(static_cast<std::size_t>(this->Mesh.NumberOfPoints()), false);
  for (const FaceVertices& face : this->Boundary)
  {
    for (const Index v : face)
    {
      pinned[v] = true;
    }
  }
  return pinned;
}

Eigen::VectorXd VolumeDomain::RobinMass() const
{
  if (this->Options.Boundary != BoundaryCondition::Robin)
  {
    return {};
  }
  const std::vector<bool>& mask = this->Options.Arrays.BoundaryMask;
  std::function<bool(const FaceVertices&)> isMasked;
  if (!mask.empty())
  {
    isMasked = [&mask](const FaceVertices& face) { return mask[face[0]] && mask[face[1]] && mask[face[2]]; };
  }
  return this->Options.RobinCoefficient * BoundaryMass(this->Mesh, this->Boundary, isMasked);
}

LatticeNoise VolumeDomain::Lattice(double) const
{
  throw InvalidInput(
    "MaternField: coherent noise in a volume asked for; expected a surface, whose parts the lattice is "
    "shared among by area, or noise without CoherentNoise.");
}

double VolumeDomain::Variance(double tau, const MeshComponents& components, Index component) const
{
  return MarginalVarianceInVolume(tau, components.Area[component], this->Options.OperatorPower);
}

} // namespace surfsynth
