// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/FieldDomain.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/MaternFieldInternals.h"
#include "Core/Operators/VolumeOperators.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

Eigen::VectorXd SurfaceDomain::Mass() const { return LumpedMass(this->Mesh, this->Topology); }

MeshComponents SurfaceDomain::Components(const Eigen::VectorXd& mass) const
{
  const MeshComponents components = ComputeComponents(this->Topology, mass);
  return this->Options.Coupling.IsOn ? CoupledAsOne(components) : components;
}

SparseMatrix SurfaceDomain::Stiffness() const { return FieldStiffness(this->Mesh, this->Topology, this->Options); }

SparseMatrix SurfaceDomain::Coupling(const Progress& progress) const
{
  const SparseMatrix coupling = CouplingMatrix(this->Mesh, this->Topology, this->Options.Coupling, progress);
  if (coupling.rows() > 0 && this->Options.Model == NoiseModel::Matern && !this->Options.Arrays.Barrier.empty())
  {
    throw InvalidInput(
      "MaternField: coupled components and barriers asked for; expected one of them, because a coupling "
      "would join the parts that a barrier divides.");
  }
  return coupling;
}

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

SparseMatrix VolumeDomain::Coupling(const Progress&) const
{
  if (this->Options.Coupling.IsOn)
  {
    throw InvalidInput("MaternField: coupled components in a volume asked for; expected a surface, whose parts the "
                       "coupling joins across gaps.");
  }
  return {};
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

double LongestEdgeForRange(const TetrahedralMesh& mesh, const MaternFieldOptions& options)
{
  const MaternFieldArrays& arrays = options.Arrays;
  const bool isMatern = options.Model == NoiseModel::Matern;
  const VolumeTensors tensors = IsAnisotropic(options)
    ? DirectionTensors(mesh, arrays.Directions, options.AnisotropyRatio)
    : VolumeTensors(0, 6);
  double longest = 0.0;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    if (isMatern && !arrays.Barrier.empty() && arrays.Barrier[t])
    {
      continue;
    }
    Eigen::Matrix3d metric =
      Eigen::Matrix3d::Identity(); // H^-1, with which lengths are those of a field without directions
    if (tensors.rows() > 0)
    {
      const auto h = tensors.row(t);
      metric << h(0), h(1), h(2), h(1), h(3), h(4), h(2), h(4), h(5);
      metric = metric.inverse().eval();
    }
    for (int i = 0; i < 4; ++i)
    {
      for (int j = 0; j < i; ++j)
      {
        const Index a = mesh.Tetrahedra(t, i);
        const Index b = mesh.Tetrahedra(t, j);
        const Eigen::RowVector3d edge = mesh.Points.row(a) - mesh.Points.row(b);
        const double length = std::sqrt(std::max(edge.dot(edge * metric), 0.0));
        longest = std::max(longest, length / RangeFactorOfEdge(options, a, b));
      }
    }
  }
  return longest;
}

} // namespace surfsynth
