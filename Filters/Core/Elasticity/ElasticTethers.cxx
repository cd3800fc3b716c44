// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticTethers.h"

#include "Core/Elasticity/NodeMatrix.h"

namespace surfsynth
{

ElasticTethers::ElasticTethers(const TetrahedralMesh& mesh, const std::vector<VolumePlace>& places,
  const PointMatrix& ends, const Eigen::VectorXd& stiffness)
  : Stiffness(mesh.NumberOfPoints(), mesh.NumberOfPoints())
  , Pull(PointMatrix::Zero(mesh.NumberOfPoints(), 3))
{
  double total = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    const auto row = static_cast<Eigen::Index>(k);
    const double share = places[k].Tetrahedron >= 0 ? stiffness[row] : 0.0;
    total += share;
    this->Origin += share > 0.0 ? Eigen::RowVector3d(share * ends.row(row)) : Eigen::RowVector3d::Zero();
  }
  this->Origin /= total > 0.0 ? total : 1.0;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    const auto row = static_cast<Eigen::Index>(k);
    if (places[k].Tetrahedron < 0 || stiffness[row] <= 0.0)
    {
      continue;
    }
    const auto nodes = mesh.Tetrahedra.row(places[k].Tetrahedron);
    const Eigen::RowVector3d end = ends.row(row) - this->Origin;
    this->Constant += 0.5 * stiffness[row] * end.squaredNorm();
    for (int a = 0; a < 4; ++a)
    {
      this->Pull.row(nodes[a]) += stiffness[row] * places[k].Weights[a] * end;
      for (int b = 0; b < 4; ++b)
      {
        entries.emplace_back(nodes[a], nodes[b], stiffness[row] * places[k].Weights[a] * places[k].Weights[b]);
      }
    }
  }
  this->Stiffness.setFromTriplets(entries.begin(), entries.end());
}

double ElasticTethers::Energy(const PointMatrix& points) const
{
  if (this->IsEmpty())
  {
    return 0.0;
  }
  const PointMatrix centered = points.rowwise() - this->Origin;
  const PointMatrix forces = 0.5 * (this->Stiffness * centered) - this->Pull;
  return centered.cwiseProduct(forces).sum() + this->Constant;
}

void ElasticTethers::AddGradient(const PointMatrix& points, PointMatrix& gradient) const
{
  if (!this->IsEmpty())
  {
    const PointMatrix centered = points.rowwise() - this->Origin;
    gradient += this->Stiffness * centered - this->Pull;
  }
}

void ElasticTethers::AddStiffness(NodeMatrix& stiffness) const
{
  for (Eigen::Index column = 0; column < this->Stiffness.outerSize(); ++column)
  {
    for (SparseMatrix::InnerIterator entry(this->Stiffness, column); entry; ++entry)
    {
      const auto row = static_cast<Index>(entry.row());
      stiffness.Add(row, static_cast<Index>(entry.col()), entry.value() * Eigen::Matrix3d::Identity());
    }
  }
}

} // namespace surfsynth
