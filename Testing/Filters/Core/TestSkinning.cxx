// SPDX-License-Identifier: BSD-3-Clause
// Skinning of points: rigid motions, bends and twists with results in closed form, and bad input.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/Skinning.h"

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::AllOf;
using testing::HasSubstr;

namespace
{
constexpr double Pi = 3.14159265358979323846;
const SkinningMethod Methods[] = { SkinningMethod::LinearBlend, SkinningMethod::DualQuaternion };

/// Two bones along the x axis: the second begins at x = 1 and hangs on the first.
Skeleton Arm()
{
  Skeleton skeleton;
  skeleton.Heads.resize(2, 3);
  skeleton.Heads << 0, 0, 0, 1, 0, 0;
  skeleton.Parents = { -1, 0 };
  return skeleton;
}

SkeletonPose AtRest(int bones = 2)
{
  SkeletonPose pose;
  pose.Rotations.setZero(bones, 4);
  pose.Rotations.col(0).setOnes();
  return pose;
}

Eigen::RowVector4d Turn(double angle, const Eigen::Vector3d& axis)
{
  const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis.normalized()));
  return { q.w(), q.x(), q.y(), q.z() };
}

SkeletonPose Bent(double angle, const Eigen::Vector3d& axis)
{
  SkeletonPose pose = AtRest();
  pose.Rotations.row(1) = Turn(angle, axis);
  return pose;
}

/// Weights of the second bone, the rest of the first.
SkinWeights WeightsOf(const std::vector<double>& second)
{
  SkinWeights weights;
  weights.Bones.resize(static_cast<Eigen::Index>(second.size()), 2);
  weights.Values.resize(static_cast<Eigen::Index>(second.size()), 2);
  for (std::size_t v = 0; v < second.size(); ++v)
  {
    weights.Bones.row(static_cast<Eigen::Index>(v)) << 0, 1;
    weights.Values.row(static_cast<Eigen::Index>(v)) << 1.0 - second[v], second[v];
  }
  return weights;
}

/// A ring of radius 1/4 around the second joint, with both bones at half of the weight.
PointMatrix Ring(int points = 16)
{
  PointMatrix ring(points, 3);
  for (int k = 0; k < points; ++k)
  {
    ring.row(k) << 1.0, 0.25 * std::cos(2.0 * Pi * k / points), 0.25 * std::sin(2.0 * Pi * k / points);
  }
  return ring;
}
} // namespace

TEST(Skinning, LeavesABodyAtRest)
{
  const TriangleMesh mesh = test::Icosphere(2);
  const auto motions = ComputeBoneMotions(Arm(), AtRest());
  const SkinWeights weights = WeightsOf(std::vector<double>(static_cast<std::size_t>(mesh.NumberOfPoints()), 0.3));
  for (const SkinningMethod method : Methods)
  {
    EXPECT_LT((SkinPoints(mesh.Points, weights, motions, method) - mesh.Points).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(Skinning, ReproducesARigidMotionForAllWeights)
{
  const TriangleMesh mesh = test::Icosphere(2);
  SkeletonPose pose = AtRest();
  pose.Rotations.row(0) = -3.0 * Turn(2.1, { 1.0, -2.0, 0.5 }); // any length and sign
  pose.Translations.resize(2, 3);
  pose.Translations << 0.3, -0.2, 0.7, 0, 0, 0;
  const Eigen::Matrix3d rotation =
    Eigen::AngleAxisd(2.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const auto motions = ComputeBoneMotions(Arm(), pose);
  std::vector<double> second;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    second.push_back(static_cast<double>(v % 11) / 10.0);
  }
  const PointMatrix expected = (mesh.Points * rotation.transpose()).rowwise() + Eigen::RowVector3d(0.3, -0.2, 0.7);
  for (const SkinningMethod method : Methods)
  {
    EXPECT_LT((SkinPoints(mesh.Points, WeightsOf(second), motions, method) - expected).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Skinning, TakesQuaternionsOfAnyLength)
{
  const SkeletonPose unit = Bent(1.0, { 1.0, 2.0, -0.5 });
  const auto expected = ComputeBoneMotions(Arm(), unit);
  for (const double length : { 1e200, -1e300, 1e-200, 1e-300 })
  {
    SkeletonPose pose = unit;
    pose.Rotations *= length;
    const auto motions = ComputeBoneMotions(Arm(), pose);
    for (std::size_t b = 0; b < motions.size(); ++b)
    {
      const double sign = motions[b].Rotation.dot(expected[b].Rotation) < 0.0 ? -1.0 : 1.0; // both are one rotation
      EXPECT_LT((motions[b].Rotation - sign * expected[b].Rotation).norm(), 1e-15) << length;
      EXPECT_LT((motions[b].Translation - expected[b].Translation).norm(), 1e-15) << length;
    }
  }
}

TEST(Skinning, TurnsTheForearmAboutTheElbow)
{
  PointMatrix points(3, 3);
  points << 0.5, 0.1, 0.0, 2.0, 0.0, 0.0, 1.5, 0.2, 0.1;
  const auto motions = ComputeBoneMotions(Arm(), Bent(0.5 * Pi, Eigen::Vector3d::UnitZ()));
  PointMatrix expected(3, 3);
  expected << 0.5, 0.1, 0.0, 1.0, 1.0, 0.0, 0.8, 0.5, 0.1;
  for (const SkinningMethod method : Methods)
  {
    EXPECT_LT(
      (SkinPoints(points, WeightsOf({ 0.0, 1.0, 1.0 }), motions, method) - expected).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(Skinning, CarriesChildrenWhateverTheOrderOfBones)
{
  // The same arm with the forearm before the upper arm.
  Skeleton skeleton;
  skeleton.Heads.resize(2, 3);
  skeleton.Heads << 1, 0, 0, 0, 0, 0;
  skeleton.Parents = { 1, -1 };
  SkeletonPose pose = AtRest();
  pose.Rotations.row(0) = Turn(0.5 * Pi, Eigen::Vector3d::UnitZ());
  pose.Rotations.row(1) = Turn(0.5 * Pi, Eigen::Vector3d::UnitZ());
  PointMatrix hand(1, 3);
  hand << 2, 0, 0;
  SkinWeights weights = WeightsOf({ 0.0 });
  const PointMatrix moved = SkinPoints(
    hand, weights, ComputeBoneMotions(skeleton, pose), SkinningMethod::DualQuaternion);
  EXPECT_LT((moved.row(0) - Eigen::RowVector3d(-1, 1, 0)).norm(), 1e-15); // elbow at (0, 1), turned by 180 degrees
}

TEST(Skinning, DualQuaternionsBlendHalfOfATurn)
{
  const double angle = 1.2;
  const auto motions = ComputeBoneMotions(Arm(), Bent(angle, Eigen::Vector3d::UnitX()));
  const Eigen::Matrix3d half = Eigen::AngleAxisd(0.5 * angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PointMatrix moved = SkinPoints(
    Ring(), WeightsOf(std::vector<double>(16, 0.5)), motions, SkinningMethod::DualQuaternion);
  EXPECT_LT((moved - Ring() * half.transpose()).cwiseAbs().maxCoeff(), 1e-15);
}

// The candy wrapper: a ring between bones that are twisted by the angle a against each other shrinks by cos(a / 2).
TEST(Skinning, LinearBlendsCollapseWhereDualQuaternionsKeepTheRadius)
{
  for (const double angle : { 0.5, 1.5, 2.5, 3.1, -3.1 })
  {
    const auto motions = ComputeBoneMotions(Arm(), Bent(angle, Eigen::Vector3d::UnitX()));
    const SkinWeights weights = WeightsOf(std::vector<double>(16, 0.5));
    const PointMatrix linear = SkinPoints(Ring(), weights, motions, SkinningMethod::LinearBlend);
    const PointMatrix dual = SkinPoints(Ring(), weights, motions, SkinningMethod::DualQuaternion);
    for (Eigen::Index v = 0; v < 16; ++v)
    {
      EXPECT_NEAR(linear.row(v).tail(2).norm(), 0.25 * std::cos(0.5 * angle), 1e-14);
      EXPECT_NEAR(dual.row(v).tail(2).norm(), 0.25, 1e-14);
      EXPECT_NEAR(dual(v, 0), 1.0, 1e-14);
    }
  }
}

TEST(Skinning, DividesRoundedWeightsByTheirSum)
{
  SkinWeights weights = WeightsOf(std::vector<double>(16, 0.5));
  const auto motions = ComputeBoneMotions(Arm(), Bent(1.0, Eigen::Vector3d::UnitY()));
  for (const SkinningMethod method : Methods)
  {
    const PointMatrix exact = SkinPoints(Ring(), weights, motions, method);
    SkinWeights rounded = weights;
    rounded.Values *= 1.005;
    EXPECT_LT((SkinPoints(Ring(), rounded, motions, method) - exact).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(Skinning, ReportsProgressAndCanBeCancelled)
{
  const TriangleMesh mesh = test::Icosphere(5); // 10,242 points
  const SkinWeights weights = WeightsOf(std::vector<double>(static_cast<std::size_t>(mesh.NumberOfPoints()), 0.3));
  const auto motions = ComputeBoneMotions(Arm(), Bent(1.0, Eigen::Vector3d::UnitY()));
  std::vector<double> reports;
  const auto record = [&reports](double fraction) {
    reports.push_back(fraction);
    return true;
  };
  const ThreadScope oneThread(1); // on several, the others may leave nothing for the thread that reports
  SkinPoints(mesh.Points, weights, motions, SkinningMethod::DualQuaternion, record);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_GT(reports.size(), 4u);
  EXPECT_EQ(reports.back(), 1.0);
  const auto stop = [](double fraction) { return fraction < 0.5; };
  EXPECT_THROW(SkinPoints(mesh.Points, weights, motions, SkinningMethod::DualQuaternion, stop), Cancelled);
}

TEST(Skinning, RefusesBadWeights)
{
  const auto motions = ComputeBoneMotions(Arm(), AtRest());
  const auto message = [&](const std::function<void(SkinWeights&)>& change) {
    SkinWeights weights = WeightsOf(std::vector<double>(16, 0.5));
    change(weights);
    return MessageOf([&] { SkinPoints(Ring(), weights, motions, SkinningMethod::LinearBlend); });
  };
  EXPECT_EQ(message([](SkinWeights&) {}), "accepted");
  EXPECT_THAT(message([](SkinWeights& w) { w.Values(5, 0) = std::numeric_limits<double>::quiet_NaN(); }),
    AllOf(HasSubstr("not finite"), HasSubstr("point 5")));
  EXPECT_THAT(message([](SkinWeights& w) { w.Values.row(6) << -0.5, 1.5; }),
    AllOf(HasSubstr("1 point(s) with a negative weight"), HasSubstr("point 6")));
  EXPECT_THAT(
    message([](SkinWeights& w) { w.Bones(7, 1) = 2; }), AllOf(HasSubstr("unknown bone"), HasSubstr("point 7")));
  EXPECT_THAT(message([](SkinWeights& w) { w.Bones(7, 1) = -1; }), HasSubstr("unknown bone"));
  EXPECT_THAT(message([](SkinWeights& w) { w.Values.middleRows(3, 2) *= 0.5; }),
    AllOf(HasSubstr("2 point(s) with weights whose sum is not 1"), HasSubstr("point 3")));
  EXPECT_THAT(message([](SkinWeights& w) { w.Values.conservativeResize(15, 2); }), HasSubstr("[15, 2]"));
  // A bone without weight need not exist.
  EXPECT_EQ(message([](SkinWeights& w) {
    w.Bones(0, 1) = -1;
    w.Values.row(0) << 1.0, 0.0;
  }),
    "accepted");
}

TEST(Skinning, RefusesBadSkeletonsAndPoses)
{
  const auto message = [](const std::function<void(Skeleton&, SkeletonPose&)>& change) {
    Skeleton skeleton = Arm();
    SkeletonPose pose = AtRest();
    change(skeleton, pose);
    return MessageOf([&] { ComputeBoneMotions(skeleton, pose); });
  };
  EXPECT_EQ(message([](Skeleton&, SkeletonPose&) {}), "accepted");
  EXPECT_THAT(message([](Skeleton& s, SkeletonPose&) { s.Parents[1] = 2; }), HasSubstr("parent of bone 1 is 2"));
  EXPECT_THAT(message([](Skeleton& s, SkeletonPose&) { s.Parents[0] = -2; }), HasSubstr("parent of bone 0 is -2"));
  EXPECT_THAT(message([](Skeleton& s, SkeletonPose&) { s.Parents[0] = 1; }), HasSubstr("form a loop"));
  EXPECT_THAT(message([](Skeleton& s, SkeletonPose&) { s.Parents[1] = 1; }), HasSubstr("form a loop"));
  EXPECT_THAT(message([](Skeleton& s, SkeletonPose&) { s.Heads(1, 2) = INFINITY; }), HasSubstr("head of bone 1"));
  EXPECT_THAT(
    message([](Skeleton&, SkeletonPose& p) { p.Rotations.row(1).setZero(); }), HasSubstr("rotation of bone 1"));
  EXPECT_THAT(message([](Skeleton&, SkeletonPose& p) { p.Rotations(0, 0) = NAN; }), HasSubstr("rotation of bone 0"));
  EXPECT_THAT(
    message([](Skeleton&, SkeletonPose& p) { p.Rotations(1, 2) = INFINITY; }), HasSubstr("rotation of bone 1"));
  EXPECT_THAT(message([](Skeleton&, SkeletonPose& p) { p.Translations.setConstant(2, 3, NAN); }),
    HasSubstr("translation of bone 0"));
  EXPECT_THAT(
    message([](Skeleton&, SkeletonPose& p) { p.Rotations.conservativeResize(1, 4); }), HasSubstr("1 rotations"));
}
