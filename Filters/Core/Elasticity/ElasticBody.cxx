// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticBody.h"

#include "Core/Common/Errors.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Operators/VolumeOperators.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Corners of the face opposite to each corner, with the normal outwards.
constexpr int FaceCorners[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };

TetrahedralMesh WithPositiveVolumes(TetrahedralMesh mesh)
{
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    if (EdgesFromFirstCorner(mesh.Points, mesh.Tetrahedra, t).determinant() < 0.0)
    {
      std::swap(mesh.Tetrahedra(t, 2), mesh.Tetrahedra(t, 3));
    }
  }
  return mesh;
}

/// Block of nodes with shape gradients @p a and @p b, in the axes V of the stiffness: see NeoHookeanStiffness.
Eigen::Matrix3d BlockInAxes(const NeoHookeanStiffness& stiffness, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  Eigen::Matrix3d block = (stiffness.Stretch.array() * (a * b.transpose()).array()).matrix();
  for (int k = 0; k < 3; ++k)
  {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    const double sum = 0.5 * (stiffness.Symmetric[k] + stiffness.Rotation[k]);
    const double difference = 0.5 * (stiffness.Symmetric[k] - stiffness.Rotation[k]);
    block(i, i) += sum * a[j] * b[j];
    block(j, j) += sum * a[i] * b[i];
    block(i, j) += difference * a[j] * b[i];
    block(j, i) += difference * a[i] * b[j];
  }
  return block;
}
} // namespace

ElasticBody::ElasticBody(TetrahedralMesh mesh, const ElasticMaterial& material)
  : Rest(WithPositiveVolumes(std::move(mesh)))
  , Constants(material)
  , Density(material)
{
  this->NodeMasses = material.Density * LumpedMass(this->Rest);
  Eigen::Index unused = 0;
  if (this->NodeMasses.size() > 0 && this->NodeMasses.minCoeff(&unused) <= 0.0)
  {
    throw InvalidInput("ElasticBody: no tetrahedron uses point " + std::to_string(unused) +
      "; expected a corner of a tetrahedron at every point.");
  }
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    const Eigen::Matrix3d edges = EdgesFromFirstCorner(this->Rest.Points, this->Rest.Tetrahedra, t);
    this->Volumes.push_back(edges.determinant() / 6.0);
    Eigen::Matrix<double, 4, 3> gradients;
    gradients.bottomRows<3>() = edges.inverse();
    gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
    this->ShapeGradients.push_back(gradients);
  }
  this->FindBoundary();
}

void ElasticBody::FindBoundary()
{
  const std::vector<FaceVertices> boundary = FindFaces(this->Rest).Boundary;
  this->Areas = BoundaryMass(this->Rest, boundary);
  std::vector<std::array<Index, 3>> faces;
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    for (const auto& corners : FaceCorners)
    {
      const std::array<Index, 3> face{ this->Rest.Tetrahedra(t, corners[0]), this->Rest.Tetrahedra(t, corners[1]),
        this->Rest.Tetrahedra(t, corners[2]) };
      FaceVertices sorted = face;
      std::sort(sorted.begin(), sorted.end());
      if (std::binary_search(boundary.begin(), boundary.end(), sorted))
      {
        faces.push_back(face);
      }
    }
  }
  this->Faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    std::copy(faces[f].begin(), faces[f].end(), this->Faces.row(static_cast<Eigen::Index>(f)).data());
  }
}

Eigen::Matrix3d ElasticBody::DeformationGradient(const PointMatrix& points, Index t) const
{
  return EdgesFromFirstCorner(points, this->Rest.Tetrahedra, t) * this->ShapeGradients[t].bottomRows<3>();
}

double ElasticBody::Energy(const PointMatrix& points) const
{
  double energy = 0.0;
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    energy += this->Volumes[t] * this->Density.Energy(this->DeformationGradient(points, t));
  }
  return energy;
}

void ElasticBody::AddGradient(const PointMatrix& points, PointMatrix& gradient) const
{
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    const Eigen::Matrix3d stress = this->Volumes[t] * this->Density.Stress(this->DeformationGradient(points, t));
    const Eigen::Matrix<double, 4, 3> forces = this->ShapeGradients[t] * stress.transpose();
    for (int corner = 0; corner < 4; ++corner)
    {
      gradient.row(this->Rest.Tetrahedra(t, corner)) += forces.row(corner);
    }
  }
}

void ElasticBody::AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const
{
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    const NeoHookeanStiffness local = this->Density.Stiffness(this->DeformationGradient(points, t));
    const Eigen::Matrix<double, 4, 3> gradients = this->ShapeGradients[t] * local.V;
    for (int a = 0; a < 4; ++a)
    {
      for (int b = 0; b <= a; ++b)
      {
        const Eigen::Matrix3d inAxes = BlockInAxes(local, gradients.row(a).transpose(), gradients.row(b).transpose());
        const Eigen::Matrix3d block = this->Volumes[t] * (local.U * inAxes * local.U.transpose());
        stiffness.AddCorners(t, a, b, block);
        if (a != b)
        {
          stiffness.AddCorners(t, b, a, block.transpose());
        }
      }
    }
  }
}

double ElasticBody::SmallestVolumeRatio(const PointMatrix& points) const
{
  double smallest = std::numeric_limits<double>::infinity();
  for (Index t = 0; t < this->Rest.NumberOfTetrahedra(); ++t)
  {
    const double volume = EdgesFromFirstCorner(points, this->Rest.Tetrahedra, t).determinant() / 6.0;
    smallest = std::min(smallest, volume / this->Volumes[t]);
  }
  return smallest;
}

} // namespace surfsynth
