// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/FloorContact.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
/// Part of its height that a node keeps in one move.
constexpr double KeptHeight = 0.1;
} // namespace

FloorContact::FloorContact(const Barrier& barrier, Eigen::VectorXd areas, double friction, double slip)
  : Floor(barrier)
  , Areas(std::move(areas))
  , Friction(friction)
  , Slip(slip)
  , Grip(Eigen::VectorXd::Zero(this->Areas.size()))
{}

void FloorContact::Begin(const PointMatrix& points, double step)
{
  this->Previous = points;
  this->SlipDistance = this->Slip * step;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    this->Grip[v] = this->Areas[v] > 0.0 ? this->Friction * this->Areas[v] * this->Floor.Pressure(points(v, 2)) : 0.0;
  }
}

double FloorContact::Energy(const PointMatrix& points) const
{
  double energy = 0.0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    energy += this->Areas[v] > 0.0 ? this->Areas[v] * this->Floor.Energy(points(v, 2)) : 0.0;
  }
  return energy;
}

double FloorContact::FrictionEnergy(const PointMatrix& points) const
{
  const double e = this->SlipDistance;
  double energy = 0.0;
  for (Index v = 0; v < points.rows(); ++v)
  {
    if (this->Grip[v] > 0.0)
    {
      const double y = this->Slide(points, v).norm();
      energy += this->Grip[v] * (y >= e ? y : y * y * (1.0 - y / (3.0 * e)) / e + e / 3.0);
    }
  }
  return energy;
}

void FloorContact::AddGradient(const PointMatrix& points, PointMatrix& gradient) const
{
  const double e = this->SlipDistance;
  for (Index v = 0; v < points.rows(); ++v)
  {
    if (this->Areas[v] > 0.0)
    {
      gradient(v, 2) -= this->Areas[v] * this->Floor.Pressure(points(v, 2));
    }
    if (this->Grip[v] > 0.0)
    {
      const Eigen::Vector2d slide = this->Slide(points, v);
      const double y = slide.norm();
      gradient.row(v).head<2>() += this->Grip[v] * (y >= e ? 1.0 / y : (2.0 - y / e) / e) * slide.transpose();
    }
  }
}

void FloorContact::AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const
{
  const double e = this->SlipDistance;
  for (Index v = 0; v < points.rows(); ++v)
  {
    Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
    if (this->Areas[v] > 0.0)
    {
      block(2, 2) = this->Areas[v] * this->Floor.Curvature(points(v, 2));
    }
    if (this->Grip[v] > 0.0)
    {
      const Eigen::Vector2d slide = this->Slide(points, v);
      const double y = slide.norm();
      const double across = y >= e ? 1.0 / y : (2.0 - y / e) / e;
      const double along = y >= e ? 0.0 : 2.0 * (1.0 - y / e) / e;
      const Eigen::Vector2d direction = y > 0.0 ? Eigen::Vector2d(slide / y) : Eigen::Vector2d::UnitX();
      block.topLeftCorner<2, 2>() = this->Grip[v] *
        (across * Eigen::Matrix2d::Identity() + (along - across) * direction * direction.transpose());
    }
    if (block(0, 0) != 0.0 || block(1, 1) != 0.0 || block(2, 2) != 0.0)
    {
      stiffness.Add(v, v, block);
    }
  }
}

double FloorContact::LargestStep(const PointMatrix& points, const PointMatrix& move) const
{
  double part = 1.0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    if (this->Areas[v] > 0.0 && move(v, 2) < 0.0)
    {
      part = std::min(part, (1.0 - KeptHeight) * points(v, 2) / -move(v, 2));
    }
  }
  return part;
}

} // namespace surfsynth
