// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticSettling.h"

#include "Core/Common/Errors.h"
#include "Core/Elasticity/ElasticSamples.h"
#include "Core/Elasticity/ElasticTethers.h"
#include "Core/Elasticity/PlanAlignment.h"

#include <Eigen/Dense>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Pressure of the springs, in multiples of Young's modulus, on a place that is a diagonal away from its end.
constexpr double SpringPressure = 50.0;
/// Forces that are left where the springs let go, as a fraction of the weight.
constexpr double HeldImbalance = 0.05;
/// Largest number of steps in which they hold it.
constexpr int HeldSteps = 10;
/// Part of the progress in which springs hold the body.
constexpr double HeldPart = 0.6;

/// The rotation and translation that bring points nearest to others.
struct RigidMotion
{
  Eigen::Matrix3d Rotation;
  Eigen::RowVector3d From;
  Eigen::RowVector3d To;

  PointMatrix operator()(const PointMatrix& points) const
  {
    return ((points.rowwise() - this->From) * this->Rotation.transpose()).rowwise() + this->To;
  }
};

/// @param weights [K] with a sum above 0
RigidMotion NearestMotion(const PointMatrix& from, const PointMatrix& to, const Eigen::VectorXd& weights)
{
  RigidMotion motion;
  motion.From = weights.transpose() * from / weights.sum();
  motion.To = weights.transpose() * to / weights.sum();
  const Eigen::Matrix3d covariance = (to.rowwise() - motion.To).transpose() * weights.asDiagonal() *
    (from.rowwise() - motion.From);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  motion.Rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return motion;
}

/// Moves @p points up or down until the lowest of those that count is at @p height.
void LayDown(PointMatrix& points, const Eigen::VectorXd& weights, double height)
{
  double lowest = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < points.rows(); ++k)
  {
    lowest = weights[k] > 0.0 ? std::min(lowest, points(k, 2)) : lowest;
  }
  points.col(2).array() += height - lowest;
}
} // namespace

ElasticSettling::ElasticSettling(TetrahedralMesh mesh, std::vector<VolumePlace> places, PointMatrix offsets,
  Eigen::VectorXd weights, const SettlingOptions& options)
  : Options(options)
  , Elastic(std::move(mesh), options.Material)
  , Places(std::move(places))
  , Rest(static_cast<Eigen::Index>(this->Places.size()), 3)
  , Offsets(std::move(offsets))
  , Weights(std::move(weights))
{
  this->Options.Surroundings.Damping = 0.0; // the body creeps: there is no momentum
  for (Eigen::Index k = 0; k < this->Rest.rows(); ++k)
  {
    const VolumePlace& place = this->Places[static_cast<std::size_t>(k)];
    const bool isBound = place.Tetrahedron >= 0;
    this->Weights[k] = isBound ? this->Weights[k] : 0.0;
    this->Rest.row(k) = isBound ? Eigen::RowVector3d(PositionOf(this->Elastic.Mesh(), place).transpose())
                                : Eigen::RowVector3d::Zero();
  }
  if (!(this->Weights.sum() > 0.0))
  {
    throw InvalidInput("ElasticSettling: no point of the shapes lies in a tetrahedron; expected points of the body.");
  }
}

ElasticEquilibrium ElasticSettling::Settle(const PointMatrix& shape, const Progress& progress) const
{
  const std::string cause =
    "There is no rest state next to this shape, which may be too far from all shapes of the body. ";
  try
  {
    PointMatrix bound = shape;
    for (Eigen::Index k = 0; k < bound.rows(); ++k)
    {
      bound.row(k) = this->Weights[k] > 0.0 ? Eigen::RowVector3d(shape.row(k)) : Eigen::RowVector3d::Zero();
    }
    return this->SettleBound(bound, progress);
  }
  catch (const InvalidInput& error)
  {
    throw SolverFailure(cause + error.what());
  }
  catch (const SolverFailure& error)
  {
    throw SolverFailure(cause + error.what());
  }
}

ElasticEquilibrium ElasticSettling::SettleBound(const PointMatrix& shape, const Progress& progress) const
{
  const TetrahedralMesh& mesh = this->Elastic.Mesh();
  const BoundingBox box = ComputeBoundingBox(mesh);
  const double diagonal = (box.Upper - box.Lower).norm();
  const double contact = this->Options.Surroundings.ContactDistance * diagonal; // feels nothing of the floor yet
  // Far from the origin coordinates would be too coarse for strains.
  Eigen::RowVector3d shift = this->Weights.transpose() * shape / this->Weights.sum();
  shift[2] = 0.0;
  PointMatrix ends = shape.rowwise() - shift;
  LayDown(ends, this->Weights, contact);
  const RigidMotion motion = NearestMotion(this->Rest, ends, this->Weights);
  ends -= this->Offsets * motion.Rotation.transpose();
  PointMatrix start = motion(mesh.Points);
  LayDown(start, this->Elastic.Masses(), std::max(contact, start.col(2).minCoeff()));

  ElasticSurroundings held = this->Options.Surroundings;
  const double pressure = SpringPressure * this->Options.Material.YoungsModulus / diagonal;
  const double area = this->Elastic.BoundaryAreas().sum();
  held.Tethers = ElasticTethers(mesh, this->Places, ends, pressure * area / this->Weights.sum() * this->Weights);
  MotionOptions creep = this->Options.Motion;
  creep.MaximumTime = 0.0;
  creep.Imbalance = HeldImbalance;
  creep.MaximumSteps = std::min(HeldSteps, this->Options.Motion.MaximumSteps);
  creep.MustBalance = false;
  const PointMatrix none = PointMatrix::Zero(start.rows(), 3);
  const ElasticEquilibrium drawn =
    ElasticMotion(this->Elastic, held, creep).Settle(std::move(start), none, SubProgress(progress, 0.0, HeldPart));
  creep = this->Options.Motion;
  creep.MaximumTime = 0.0;
  ElasticEquilibrium rest = ElasticMotion(this->Elastic, this->Options.Surroundings, creep)
                              .Settle(drawn.Points, none, SubProgress(progress, HeldPart, 1.0));
  if (this->Options.Align)
  {
    AlignPlan(this->Elastic, rest.Points, PointMatrix(rest.Points));
  }
  else
  {
    rest.Points.rowwise() += shift;
  }
  return rest;
}

std::vector<ElasticEquilibrium> ElasticSettling::Settle(
  const std::vector<PointMatrix>& shapes, int first, const Progress& progress) const
{
  const auto settle = [&](int k, const Progress& advance) {
    return this->Settle(shapes[static_cast<std::size_t>(k)], advance);
  };
  return SettleSamples(static_cast<int>(shapes.size()), first, settle, progress);
}

} // namespace surfsynth
