// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticDrops.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/SharedProgress.h"
#include "Core/Random/CounterUniforms.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Parts of a drop in which its progress is counted.
constexpr std::int64_t WorkOfDrop = 1000;

/// Numbers of the random numbers of a drop.
enum DropComponent : std::uint32_t
{
  ORIENTATION, ///< four normal numbers, a quaternion
  AXIS,        ///< three normal numbers
  SPEED        ///< a uniform number
};

Eigen::Vector4d Normals(NormalKey key, DropComponent component)
{
  key.Component = component;
  Eigen::Vector4d numbers;
  FillNormals(key, 0, 4, numbers.data());
  return numbers;
}

Eigen::Matrix3d RandomRotation(const NormalKey& key)
{
  const Eigen::Vector4d q = Normals(key, ORIENTATION).normalized();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Eigen::RowVector3d CenterOf(const ElasticBody& body, const PointMatrix& points)
{
  return body.Masses().transpose() * points / body.Masses().sum();
}

/// Largest principal axis of the horizontal coordinates about the origin, weighted by masses.
Eigen::Vector2d LongAxis(const ElasticBody& body, const PointMatrix& centered)
{
  const auto plan = centered.leftCols<2>();
  const Eigen::Matrix2d covariance = plan.transpose() * body.Masses().asDiagonal() * plan;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvectors().col(1);
}

void RequireAtLeast(double value, double least, const char* name)
{
  if (!(value >= least) || !std::isfinite(value))
  {
    throw InvalidInput(std::string("ElasticDrops: ") + name + " is " + FormatNumber(value) +
      "; expected a finite number of at least " + FormatNumber(least) + ".");
  }
}

const DropOptions& Checked(const DropOptions& options)
{
  RequireAtLeast(options.DropHeight, 0.0, "the drop height");
  RequireAtLeast(options.MinimumSpin, 0.0, "the least spin");
  RequireAtLeast(options.MaximumSpin, options.MinimumSpin, "the largest spin");
  RequireAtLeast(options.Surroundings.Friction, 0.0, "the friction");
  RequireAtLeast(options.Surroundings.Damping, 0.0, "the damping");
  RequireAtLeast(options.Surroundings.Gravity, 1e-6, "the gravity");
  RequireAtLeast(options.Motion.TimeStep, 1e-4, "the time step");
  return options;
}
} // namespace

ElasticDrops::ElasticDrops(TetrahedralMesh mesh, const DropOptions& options)
  : Options(Checked(options))
  , Elastic(std::move(mesh), options.Material)
{}

ElasticEquilibrium ElasticDrops::Drop(const NormalKey& key, const Progress& progress) const
{
  PointMatrix points = this->Elastic.Mesh().Points;
  const Eigen::RowVector3d center = CenterOf(this->Elastic, points);
  points.rowwise() -= center;
  if (this->Options.RandomOrientation)
  {
    points = (points * RandomRotation(key).transpose()).eval();
  }
  const Eigen::Vector3d axis = Normals(key, AXIS).head<3>().normalized();
  NormalKey speedKey = key;
  speedKey.Component = SPEED;
  const double spread = this->Options.MaximumSpin - this->Options.MinimumSpin;
  const Eigen::Vector3d spin = (this->Options.MinimumSpin + spread * Uniform(speedKey, 0)) * axis;
  PointMatrix velocities(points.rows(), 3);
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    velocities.row(v) = spin.cross(Eigen::Vector3d(points.row(v).transpose())).transpose();
  }
  // Contact begins at its distance: there a body that is laid down feels nothing yet.
  const BoundingBox box = ComputeBoundingBox(this->Elastic.Mesh());
  const double contact = this->Options.Surroundings.ContactDistance * (box.Upper - box.Lower).norm();
  points.col(2).array() += this->Options.DropHeight + contact - points.col(2).minCoeff();
  ElasticMotion motion(this->Elastic, this->Options.Surroundings, this->Options.Motion);
  ElasticEquilibrium rest = motion.Settle(std::move(points), std::move(velocities), progress);
  if (this->Options.Align)
  {
    this->AlignPlan(rest.Points);
  }
  else
  {
    rest.Points.leftCols<2>().rowwise() += center.head<2>();
  }
  return rest;
}

void ElasticDrops::AlignPlan(PointMatrix& points) const
{
  PointMatrix source = this->Elastic.Mesh().Points;
  const Eigen::RowVector3d center = CenterOf(this->Elastic, source);
  source.rowwise() -= center;
  Eigen::RowVector3d shift = CenterOf(this->Elastic, points);
  shift[2] = 0.0;
  points.rowwise() -= shift;
  const Eigen::Vector2d to = LongAxis(this->Elastic, source);
  const Eigen::Vector2d from = LongAxis(this->Elastic, points);
  Eigen::Matrix2d turn;
  turn << from.dot(to), from[1] * to[0] - from[0] * to[1], from[0] * to[1] - from[1] * to[0], from.dot(to);
  points.leftCols<2>() = (points.leftCols<2>() * turn.transpose()).eval();
  // Of the two rotations that bring the axes together the one that moves the body less.
  const double agreement =
    (this->Elastic.Masses().asDiagonal() * points.leftCols<2>().cwiseProduct(source.leftCols<2>())).sum();
  if (agreement < 0.0)
  {
    points.leftCols<2>() *= -1.0;
  }
  points.leftCols<2>().rowwise() += center.head<2>();
}

std::vector<ElasticEquilibrium> ElasticDrops::Sample(const NormalKey& key, int count, const Progress& progress) const
{
  std::vector<ElasticEquilibrium> states(static_cast<std::size_t>(count));
  const SingleThreadedBlas oneThread;
  SharedProgress shared(progress, WorkOfDrop * count);
  const auto drop = [&](std::int64_t k) {
    NormalKey sample = key;
    sample.Sample = key.Sample + static_cast<std::uint32_t>(k);
    std::int64_t done = 0;
    const auto advance = [&shared, &done](double fraction) {
      const auto now = static_cast<std::int64_t>(fraction * WorkOfDrop);
      shared.Advance(now - done);
      done = now;
      return true;
    };
    try
    {
      states[static_cast<std::size_t>(k)] = this->Drop(sample, advance);
    }
    catch (const SolverFailure& error)
    {
      throw SolverFailure("Sample " + std::to_string(sample.Sample) + ": " + error.what());
    }
  };
  ParallelTasks(count, drop, [&shared] { shared.Advance(0); });
  Report(progress, 1.0);
  return states;
}

} // namespace surfsynth
