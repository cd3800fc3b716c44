// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/SurfaceDisplacement.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/FieldConditioning.h"

#include <Eigen/Geometry>

#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Normal that is interpolated at a place.
Eigen::RowVector3d NormalAt(const TriangleMesh& mesh, const PointMatrix& normals, const SurfacePlace& place)
{
  Eigen::RowVector3d normal = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k)
  {
    normal += place.Weights[k] * normals.row(mesh.Triangles(place.Triangle, k));
  }
  return normal.normalized();
}

/// Two unit vectors across a unit vector.
Eigen::Matrix<double, 2, 3> Across(const Eigen::RowVector3d& normal)
{
  Eigen::Matrix<double, 2, 3> axes;
  axes.row(0) = normal.unitOrthogonal();
  axes.row(1) = normal.cross(axes.row(0));
  return axes;
}

/// Normal of triangle @p f whose corners are moved, not of unit length.
Eigen::RowVector3d AreaVectorOf(const TriangleMesh& mesh, Index f, const Eigen::Map<const Rows>& moves, double scale)
{
  const auto t = mesh.Triangles.row(f);
  const auto corner = [&](int k) -> Eigen::RowVector3d { return mesh.Points.row(t(k)) + scale * moves.row(t(k)); };
  const Eigen::RowVector3d origin = corner(0);
  return (corner(1) - origin).cross(corner(2) - origin);
}
} // namespace

SurfaceDisplacement::SurfaceDisplacement(DisplacementDirections directions, Index numberOfPoints, PointMatrix normals)
  : Kind(directions)
  , Points(numberOfPoints)
  , Normals(std::move(normals))
{
  if (directions != DisplacementDirections::Free && this->Normals.rows() != numberOfPoints)
  {
    throw InvalidInput("SurfaceDisplacement: " + std::to_string(this->Normals.rows()) + " normals; expected " +
      std::to_string(numberOfPoints) + ".");
  }
}

void SurfaceDisplacement::ToDisplacements(double* values) const
{
  Eigen::Map<Rows> rows(values, this->Points, 3);
  switch (this->Kind)
  {
    case DisplacementDirections::Free:
      break;
    case DisplacementDirections::Normal:
      for (Index v = this->Points - 1; v >= 0; --v) // from the end: the fields lie in front
      {
        const double amplitude = values[v];
        rows.row(v) = amplitude * this->Normals.row(v);
      }
      break;
    case DisplacementDirections::Tangential:
      for (Index v = 0; v < this->Points; ++v)
      {
        const Eigen::RowVector3d normal = this->Normals.row(v);
        const double along = normal.dot(rows.row(v));
        rows.row(v) -= along * normal;
      }
      break;
  }
}

SurfaceDisplacement::Product SurfaceDisplacement::Covariance(Product covariance) const
{
  if (this->Kind != DisplacementDirections::Tangential)
  {
    return covariance;
  }
  return [this, covariance = std::move(covariance)](const Eigen::Ref<const Eigen::MatrixXd>& values) {
    const Eigen::Index columns = values.cols();
    Eigen::MatrixXd result = values;
    Eigen::MatrixXd fields(this->Points, 3 * columns);
    for (Eigen::Index k = 0; k < columns; ++k)
    {
      this->ToDisplacements(result.col(k).data());
      fields.middleCols(3 * k, 3) = Eigen::Map<const Rows>(result.col(k).data(), this->Points, 3);
    }
    fields = covariance(fields);
    for (Eigen::Index k = 0; k < columns; ++k)
    {
      Eigen::Map<Rows>(result.col(k).data(), this->Points, 3) = fields.middleCols(3 * k, 3);
      this->ToDisplacements(result.col(k).data());
    }
    return result;
  };
}

DisplacementObservations SurfaceDisplacement::Observe(const TriangleMesh& mesh, const std::vector<SurfacePlace>& places,
  const Eigen::MatrixXd& displacements, const Eigen::VectorXd& deviations) const
{
  const auto count = static_cast<Index>(places.size());
  if (displacements.rows() != count || displacements.cols() != 3 || deviations.size() != count ||
    mesh.NumberOfPoints() != this->Points)
  {
    throw InvalidInput("SurfaceDisplacement: " + std::to_string(displacements.rows()) + " displacements of " +
      std::to_string(displacements.cols()) + " components and " + std::to_string(deviations.size()) +
      " deviations on " + std::to_string(mesh.NumberOfPoints()) + " points; expected " + std::to_string(count) +
      " of 3 components on " + std::to_string(this->Points) + ".");
  }
  DisplacementObservations made{ ObservationMatrix(mesh, places), displacements, deviations,
    Eigen::VectorXd::Zero(count) };
  if (this->Kind == DisplacementDirections::Free)
  {
    return made;
  }
  const bool isNormal = this->Kind == DisplacementDirections::Normal;
  const Index parts = isNormal ? 1 : 2;
  std::vector<Eigen::Triplet<double, Index>> entries;
  Eigen::VectorXd values(parts * count);
  for (Index i = 0; i < count; ++i)
  {
    const SurfacePlace& place = places[static_cast<std::size_t>(i)];
    const Eigen::RowVector3d normal = NormalAt(mesh, this->Normals, place);
    const Eigen::RowVector3d observed = displacements.row(i);
    const double along = normal.dot(observed);
    const Eigen::Matrix<double, 2, 3> axes = Across(normal);
    made.Excluded[i] = isNormal ? (observed - along * normal).norm() : std::abs(along);
    for (Index part = 0; part < parts; ++part)
    {
      const Index row = parts * i + part;
      values[row] = isNormal ? along : axes.row(part).dot(observed);
      for (int k = 0; k < 3; ++k)
      {
        const Index v = mesh.Triangles(place.Triangle, k);
        const double weight = place.Weights[k];
        if (isNormal)
        {
          entries.emplace_back(row, v, weight * normal.dot(this->Normals.row(v)));
        }
        for (Index c = 0; c < 3 && !isNormal; ++c)
        {
          entries.emplace_back(row, 3 * v + c, weight * axes(part, c));
        }
      }
    }
  }
  made.Matrix = SparseRowMatrix(parts * count, (isNormal ? 1 : 3) * this->Points);
  made.Matrix.setFromTriplets(entries.begin(), entries.end());
  made.Values = values;
  made.Deviations = deviations.transpose().replicate(parts, 1).reshaped();
  return made;
}

Eigen::VectorXd SurfaceDisplacement::UnknownVariances(const Eigen::VectorXd& variances) const
{
  if (this->Kind != DisplacementDirections::Tangential)
  {
    return variances;
  }
  Rows parts = 1.0 - this->Normals.array().square();
  parts.array().colwise() *= variances.array();
  return Eigen::Map<const Eigen::VectorXd>(parts.data(), parts.size());
}

Eigen::VectorXd SurfaceDisplacement::DeviationAlong(const Eigen::VectorXd& variances) const
{
  if (this->Kind != DisplacementDirections::Tangential)
  {
    return variances.cwiseSqrt();
  }
  return (0.5 * variances.reshaped(3, this->Points).colwise().sum().transpose()).cwiseSqrt();
}

InvertedTriangles FindInvertedTriangles(const TriangleMesh& mesh, const double* displacements)
{
  const Eigen::Map<const Rows> moves(displacements, mesh.NumberOfPoints(), 3);
  InvertedTriangles found;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (!(AreaVectorOf(mesh, f, moves, 0.0).dot(AreaVectorOf(mesh, f, moves, 1.0)) > 0.0))
    {
      found.First = found.Count == 0 ? f : found.First;
      ++found.Count;
    }
  }
  return found;
}

} // namespace surfsynth
