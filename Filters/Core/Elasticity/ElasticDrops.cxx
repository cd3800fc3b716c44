// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticDrops.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Elasticity/ElasticSamples.h"
#include "Core/Elasticity/PlanAlignment.h"
#include "Core/Random/CounterUniforms.h"

#include <Eigen/Geometry>

#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
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
  const Eigen::RowVector3d center = CenterOfMass(this->Elastic, points);
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
    AlignPlan(this->Elastic, rest.Points, this->Elastic.Mesh().Points);
  }
  else
  {
    rest.Points.leftCols<2>().rowwise() += center.head<2>();
  }
  return rest;
}

std::vector<ElasticEquilibrium> ElasticDrops::Sample(const NormalKey& key, int count, const Progress& progress) const
{
  const auto drop = [&](int k, const Progress& advance) {
    NormalKey sample = key;
    sample.Sample = key.Sample + static_cast<std::uint32_t>(k);
    return this->Drop(sample, advance);
  };
  return SettleSamples(count, static_cast<int>(key.Sample), drop, progress);
}

} // namespace surfsynth
