// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Skinning: motion of the points of a body with the bones of a skeleton.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Bones of a body at rest.
struct Skeleton
{
  PointMatrix Heads;          ///< [B, 3], joint at which each bone turns, world units
  std::vector<Index> Parents; ///< [B], bone that carries each one; -1 for none
};

/// Pose of a skeleton. Axes are those of the body at rest, so that no bone has a frame of its own.
struct SkeletonPose
{
  /// [B, 4], quaternion w, x, y, z of any length but 0: rotation of each bone about its head, on top of its parent's.
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> Rotations;
  PointMatrix
    Translations; ///< [B, 3], displacement of each head from where its parent carries it, world units; or empty
};

/// Bones that move each point, and their weights.
struct SkinWeights
{
  Eigen::Matrix<Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
    Bones; ///< [V, K]; ignored where the weight is 0
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Values; ///< [V, K], >= 0, with the sum 1
};

/// Blending of the motions of bones.
enum class SkinningMethod
{
  LinearBlend,   ///< weighted mean of the moved points [Lewis2000]: shrinks where bones turn far against each other
  DualQuaternion ///< rigid motion of the weighted mean of unit dual quaternions [Kavan2008]
};

/// Rigid motion p -> R p + t, as a quaternion w, x, y, z of length 1 and a translation.
struct RigidMotion
{
  Eigen::Vector4d Rotation{ 1.0, 0.0, 0.0, 0.0 };        ///< w, x, y, z
  Eigen::Vector3d Translation = Eigen::Vector3d::Zero(); ///< world units
};

/// Largest distance of the sum of the weights of a point from 1: files round them. They are divided by their sum.
constexpr double SkinWeightTolerance = 1e-2;

/// Computes the motion of each bone, [B], from rest to pose: with q the rotation of a bone, R = R_parent q, and its head
/// goes to where its parent carries it, plus its translation.
/// @throws InvalidInput for heads or rotations that are not finite, rotations of length 0, arrays that do not fit, and
/// parents that do not exist or form a loop; the text names the first bone.
std::vector<RigidMotion> ComputeBoneMotions(const Skeleton& skeleton, const SkeletonPose& pose);

/// Moves @p points, [V, 3].
/// @throws InvalidInput for weights that are negative, not finite or do not sum up to 1, bones that do not exist, and
/// arrays that do not fit; the text says how many points and names the first. Cancelled.
PointMatrix SkinPoints(const PointMatrix& points, const SkinWeights& weights, const std::vector<RigidMotion>& motions,
  SkinningMethod method, const Progress& progress = {});

} // namespace surfsynth
