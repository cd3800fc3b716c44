// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/PlanAlignment.h"

#include <Eigen/Eigenvalues>

namespace surfsynth
{

namespace
{
/// Largest principal axis of the horizontal coordinates about the origin, weighted by masses.
Eigen::Vector2d LongAxis(const ElasticBody& body, const PointMatrix& centered)
{
  const auto plan = centered.leftCols<2>();
  const Eigen::Matrix2d covariance = plan.transpose() * body.Masses().asDiagonal() * plan;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvectors().col(1);
}
} // namespace

Eigen::RowVector3d CenterOfMass(const ElasticBody& body, const PointMatrix& points)
{
  return body.Masses().transpose() * points / body.Masses().sum();
}

void AlignPlan(const ElasticBody& body, PointMatrix& points, const PointMatrix& towards)
{
  PointMatrix source = body.Mesh().Points;
  const Eigen::RowVector3d center = CenterOfMass(body, source);
  source.rowwise() -= center;
  Eigen::RowVector3d shift = CenterOfMass(body, points);
  shift[2] = 0.0;
  points.rowwise() -= shift;
  const Eigen::Vector2d to = LongAxis(body, source);
  const Eigen::Vector2d from = LongAxis(body, points);
  Eigen::Matrix2d turn;
  turn << from.dot(to), from[1] * to[0] - from[0] * to[1], from[0] * to[1] - from[1] * to[0], from.dot(to);
  points.leftCols<2>() = (points.leftCols<2>() * turn.transpose()).eval();
  const PointMatrix place = towards.rowwise() - CenterOfMass(body, towards);
  const double agreement = (body.Masses().asDiagonal() * points.leftCols<2>().cwiseProduct(place.leftCols<2>())).sum();
  if (agreement < 0.0)
  {
    points.leftCols<2>() *= -1.0;
  }
  points.leftCols<2>().rowwise() += center.head<2>();
}

} // namespace surfsynth
