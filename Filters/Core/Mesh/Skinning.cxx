// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/Skinning.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/SharedProgress.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
using Quaternion = Eigen::Quaterniond;

/// Points that are moved in one task.
constexpr std::int64_t PointsOfTask = 1024;

Quaternion ToQuaternion(const Eigen::Vector4d& v) { return { v[0], v[1], v[2], v[3] }; }

Eigen::Vector4d ToVector(const Quaternion& q) { return { q.w(), q.x(), q.y(), q.z() }; }

/// The unit quaternion of one of any finite length but 0, whose square may be too large or too small for a number.
Quaternion ToUnitQuaternion(const Eigen::Vector4d& v) { return ToQuaternion(v / v.cwiseAbs().maxCoeff()).normalized(); }

void RequireSkeleton(const Skeleton& skeleton, const SkeletonPose& pose)
{
  const Eigen::Index bones = skeleton.Heads.rows();
  const auto require = [](bool condition, const std::string& found, const char* expected) {
    if (!condition)
    {
      throw InvalidInput("ComputeBoneMotions: " + found + "; expected " + expected + ".");
    }
  };
  require(static_cast<Eigen::Index>(skeleton.Parents.size()) == bones,
    std::to_string(skeleton.Parents.size()) + " parents of " + std::to_string(bones) + " bones", "one for each");
  require(pose.Rotations.rows() == bones,
    std::to_string(pose.Rotations.rows()) + " rotations of " + std::to_string(bones) + " bones", "one for each");
  require(pose.Translations.rows() == 0 || pose.Translations.rows() == bones,
    std::to_string(pose.Translations.rows()) + " translations of " + std::to_string(bones) + " bones",
    "one for each, or none");
  for (Eigen::Index b = 0; b < bones; ++b)
  {
    const std::string of = " of bone " + std::to_string(b);
    const bool isMoved = pose.Translations.rows() > 0;
    require(skeleton.Heads.row(b).allFinite(), "the head" + of + " is not finite", "finite numbers");
    require(
      !isMoved || pose.Translations.row(b).allFinite(), "the translation" + of + " is not finite", "finite numbers");
    require(pose.Rotations.row(b).allFinite() && !pose.Rotations.row(b).isZero(0.0),
      "the rotation" + of + " is not finite or 0", "a quaternion of any length but 0");
    const Index parent = skeleton.Parents[b];
    require(parent >= -1 && parent < bones, "the parent" + of + " is " + std::to_string(parent),
      "the number of another bone, or -1 for none");
    // A chain of parents that is longer than the number of bones goes round in a loop.
    Eigen::Index length = 0;
    for (Index next = parent; next >= 0 && next < bones && length <= bones; next = skeleton.Parents[next])
    {
      ++length;
    }
    require(length <= bones, "the parents" + of + " form a loop", "a tree of bones");
  }
}

/// Kinds of bad weights, each counted.
struct BadWeights
{
  const char* Found;
  const char* Expected;
  std::int64_t Count = 0;
  Eigen::Index First = 0;

  void Add(Eigen::Index point)
  {
    this->First = this->Count == 0 ? point : this->First;
    ++this->Count;
  }
};

void RequireWeights(const PointMatrix& points, const SkinWeights& weights, std::size_t bones)
{
  if (weights.Values.rows() != points.rows() || weights.Bones.rows() != points.rows() ||
    weights.Values.cols() != weights.Bones.cols() || weights.Values.cols() < 1)
  {
    throw InvalidInput("SkinPoints: weights [" + std::to_string(weights.Values.rows()) + ", " +
      std::to_string(weights.Values.cols()) + "] and bones [" + std::to_string(weights.Bones.rows()) + ", " +
      std::to_string(weights.Bones.cols()) + "] of " + std::to_string(points.rows()) +
      " points; expected a row of both for each point, of equal length.");
  }
  BadWeights kinds[] = { { "a weight that is not finite", "finite numbers" },
    { "a negative weight", "numbers of at least 0" }, { "an unknown bone", "numbers of bones from 0" },
    { "weights whose sum is not 1", "a sum within 0.01 of 1" } };
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    const auto row = weights.Values.row(v);
    if (!row.allFinite())
    {
      kinds[0].Add(v);
      continue;
    }
    bool isKnown = true;
    for (Eigen::Index k = 0; k < row.size(); ++k)
    {
      const Index bone = weights.Bones(v, k);
      isKnown = isKnown && (row[k] == 0.0 || (bone >= 0 && static_cast<std::size_t>(bone) < bones));
    }
    if (row.minCoeff() < 0.0)
    {
      kinds[1].Add(v);
    }
    else if (!isKnown)
    {
      kinds[2].Add(v);
    }
    else if (std::abs(row.sum() - 1.0) > SkinWeightTolerance)
    {
      kinds[3].Add(v);
    }
  }
  for (const BadWeights& kind : kinds)
  {
    if (kind.Count > 0)
    {
      throw InvalidInput("SkinPoints: " + std::to_string(kind.Count) + " point(s) with " + kind.Found +
        ", the first of them point " + std::to_string(kind.First) + "; expected " + kind.Expected + " (of " +
        std::to_string(bones) + " bones).");
    }
  }
}

/// A motion as a unit dual quaternion: real and dual part, w, x, y, z.
struct DualQuaternion
{
  Eigen::Vector4d Real = Eigen::Vector4d::Zero();
  Eigen::Vector4d Dual = Eigen::Vector4d::Zero();
};

DualQuaternion ToDualQuaternion(const RigidMotion& motion)
{
  const Quaternion translation(0.0, motion.Translation[0], motion.Translation[1], motion.Translation[2]);
  return { motion.Rotation, 0.5 * ToVector(translation * ToQuaternion(motion.Rotation)) };
}

Eigen::Vector3d Moved(const DualQuaternion& motion, const Eigen::Vector3d& point)
{
  const double length = motion.Real.norm();
  const Quaternion rotation = ToQuaternion(motion.Real / length);
  const Quaternion translation = ToQuaternion(motion.Dual / length) * rotation.conjugate();
  return rotation * point + 2.0 * translation.vec();
}

/// The largest weight of a row, whose bone decides on the signs of the quaternions.
Index LargestBone(const SkinWeights& weights, Eigen::Index v)
{
  Eigen::Index largest = 0;
  weights.Values.row(v).maxCoeff(&largest);
  return weights.Bones(v, largest);
}

Eigen::Vector3d BlendLinearly(const SkinWeights& weights, const std::vector<Eigen::Matrix3d>& rotations,
  const std::vector<RigidMotion>& motions, Eigen::Index v, const Eigen::Vector3d& point)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < weights.Values.cols(); ++k)
  {
    const double weight = weights.Values(v, k);
    if (weight > 0.0)
    {
      const Index b = weights.Bones(v, k);
      sum += weight * (rotations[b] * point + motions[b].Translation);
    }
  }
  return sum / weights.Values.row(v).sum();
}

Eigen::Vector3d BlendDualQuaternions(
  const SkinWeights& weights, const std::vector<DualQuaternion>& motions, Eigen::Index v, const Eigen::Vector3d& point)
{
  const Eigen::Vector4d& pivot = motions[LargestBone(weights, v)].Real;
  DualQuaternion sum;
  for (Eigen::Index k = 0; k < weights.Values.cols(); ++k)
  {
    const double weight = weights.Values(v, k);
    if (weight > 0.0)
    {
      const DualQuaternion& motion = motions[weights.Bones(v, k)];
      const double signedWeight = motion.Real.dot(pivot) < 0.0 ? -weight : weight; // q and -q are one rotation
      sum.Real += signedWeight * motion.Real;
      sum.Dual += signedWeight * motion.Dual;
    }
  }
  return Moved(sum, point);
}
} // namespace

std::vector<RigidMotion> ComputeBoneMotions(const Skeleton& skeleton, const SkeletonPose& pose)
{
  RequireSkeleton(skeleton, pose);
  std::vector<RigidMotion> motions(skeleton.Parents.size());
  std::vector<bool> isDone(skeleton.Parents.size(), false);
  std::vector<Index> chain;
  for (std::size_t b = 0; b < motions.size(); ++b)
  {
    chain.clear();
    for (auto next = static_cast<Index>(b); next >= 0 && !isDone[next]; next = skeleton.Parents[next])
    {
      chain.push_back(next);
    }
    for (auto bone = chain.rbegin(); bone != chain.rend(); ++bone)
    {
      const Index parent = skeleton.Parents[*bone];
      const RigidMotion above = parent >= 0 ? motions[parent] : RigidMotion();
      const Quaternion turn = ToQuaternion(above.Rotation);
      const Eigen::Vector3d head = skeleton.Heads.row(*bone).transpose();
      Eigen::Vector3d moved = turn * head + above.Translation;
      if (pose.Translations.rows() > 0)
      {
        moved += turn * pose.Translations.row(*bone).transpose();
      }
      const Quaternion rotation = (turn * ToUnitQuaternion(pose.Rotations.row(*bone).transpose())).normalized();
      motions[*bone] = { ToVector(rotation), moved - rotation * head };
      isDone[*bone] = true;
    }
  }
  return motions;
}

PointMatrix SkinPoints(const PointMatrix& points, const SkinWeights& weights, const std::vector<RigidMotion>& motions,
  SkinningMethod method, const Progress& progress)
{
  RequireWeights(points, weights, motions.size());
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<DualQuaternion> dualQuaternions;
  for (const RigidMotion& motion : motions)
  {
    rotations.push_back(ToQuaternion(motion.Rotation).toRotationMatrix());
    dualQuaternions.push_back(ToDualQuaternion(motion));
  }
  PointMatrix moved(points.rows(), 3);
  const auto move = [&](std::int64_t v) {
    const Eigen::Vector3d point = points.row(v).transpose();
    moved.row(v) = (method == SkinningMethod::LinearBlend ? BlendLinearly(weights, rotations, motions, v, point)
                                                          : BlendDualQuaternions(weights, dualQuaternions, v, point))
                     .transpose();
  };
  SharedProgress shared(progress, points.rows());
  const auto moveSome = [&](std::int64_t task) {
    const std::int64_t begin = task * PointsOfTask;
    const std::int64_t end = std::min<std::int64_t>(begin + PointsOfTask, points.rows());
    for (std::int64_t v = begin; v < end; ++v)
    {
      move(v);
    }
    shared.Advance(end - begin);
  };
  const std::int64_t tasks = (points.rows() + PointsOfTask - 1) / PointsOfTask;
  ParallelTasks(tasks, moveSome, [&shared] { shared.Advance(0); });
  Report(progress, 1.0);
  return moved;
}

} // namespace surfsynth
