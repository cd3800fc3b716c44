// SPDX-License-Identifier: BSD-3-Clause
//
// Elastic bodies: derivatives, mechanics in closed form, and what rest states promise.
#include "ElasticMechanics.h"
#include "ExampleVolumes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/NodeMatrix.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

using namespace surfsynth;
using surfsynth::test::BendingRatio;
using surfsynth::test::BoxOfTetrahedra;
using surfsynth::test::IndentationRatio;
using surfsynth::test::MappedBox;

namespace
{
/// A plank that is no cuboid, of @p cells cells across.
TetrahedralMesh Wedge(int cells)
{
  return MappedBox({ 2 * cells, cells, cells }, [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(0.5 * x[0], 0.25 * x[1] * (1.0 - 0.4 * x[0]), 0.2 * x[2] * (1.0 - 0.3 * x[1]));
  });
}

PointMatrix Wavy(const PointMatrix& points, double amplitude)
{
  PointMatrix moved = points;
  for (Eigen::Index k = 0; k < moved.size(); ++k)
  {
    moved.data()[k] += amplitude * std::sin(3.7 * static_cast<double>(k));
  }
  return moved;
}

PointMatrix GradientOf(const ElasticBody& body, const PointMatrix& points)
{
  PointMatrix gradient = PointMatrix::Zero(points.rows(), 3);
  body.AddGradient(points, gradient);
  return gradient;
}

/// Number of points that lie inside a tetrahedron they are no corner of.
int PointsInside(const TetrahedralMesh& mesh, const PointMatrix& points)
{
  int count = 0;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    Eigen::Matrix4d corners = Eigen::Matrix4d::Ones();
    for (int k = 0; k < 4; ++k)
    {
      corners.col(k).head<3>() = points.row(mesh.Tetrahedra(t, k)).transpose();
    }
    const Eigen::Matrix4d toWeights = corners.inverse();
    for (Index v = 0; v < points.rows(); ++v)
    {
      const bool isCorner = (mesh.Tetrahedra.row(t).array() == v).any();
      const Eigen::Vector4d place(points(v, 0), points(v, 1), points(v, 2), 1.0);
      count += !isCorner && (toWeights * place).minCoeff() > 1e-9 ? 1 : 0;
    }
  }
  return count;
}

DropOptions QuickDrop()
{
  DropOptions options;
  options.Motion.TimeStep = 0.05;
  return options;
}
} // namespace

TEST(Elasticity, GradientIsTheDerivativeOfTheEnergy)
{
  const ElasticBody body(BoxOfTetrahedra({ 3, 2, 2 }, { 0.3, 0.2, 0.2 }), {});
  const PointMatrix points = Wavy(body.Mesh().Points, 0.01);
  const PointMatrix direction = Wavy(PointMatrix::Zero(points.rows(), 3), 1.0);
  constexpr double Step = 1e-6;
  const double difference = (body.Energy(points + Step * direction) - body.Energy(points - Step * direction)) /
    (2.0 * Step);
  const double slope = GradientOf(body, points).cwiseProduct(direction).sum();
  EXPECT_NEAR(difference, slope, 1e-7 * std::abs(slope));
}

TEST(Elasticity, StiffnessIsTheDerivativeOfTheGradientWhereItIsPositive)
{
  const ElasticBody body(BoxOfTetrahedra({ 3, 2, 2 }, { 0.3, 0.2, 0.2 }), {});
  // Stretched everywhere, so that no eigenvalue is negative.
  const PointMatrix points = Wavy(1.01 * body.Mesh().Points, 1e-5);
  const PointMatrix direction = Wavy(PointMatrix::Zero(points.rows(), 3), 1.0);
  constexpr double Step = 1e-6;
  const PointMatrix difference = (GradientOf(body, points + Step * direction) -
                                   GradientOf(body, points - Step * direction)) /
    (2.0 * Step);
  NodeMatrix stiffness(body.Mesh(), {});
  body.AddStiffness(points, stiffness);
  const Eigen::VectorXd product = stiffness.Matrix() *
    Eigen::Map<const Eigen::VectorXd>(direction.data(), direction.size());
  const Eigen::Map<const Eigen::VectorXd> expected(difference.data(), difference.size());
  EXPECT_LT((product - expected).norm(), 1e-6 * expected.norm());
}

TEST(Elasticity, SmallStretchFollowsHooke)
{
  const ElasticMaterial material{ 1e4, 0.3, 1000.0 };
  const NeoHookean density(material);
  constexpr double Strain = 1e-5;
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
  EXPECT_NEAR(density.Energy(gradient), 0.0, 1e-9);
  EXPECT_LT(density.Stress(gradient).norm(), 1e-9);
  gradient(0, 0) += Strain;
  gradient(1, 1) -= material.PoissonsRatio * Strain;
  gradient(2, 2) -= material.PoissonsRatio * Strain;
  const Eigen::Matrix3d stress = density.Stress(gradient);
  EXPECT_NEAR(stress(0, 0), material.YoungsModulus * Strain, 1e-4 * material.YoungsModulus * Strain);
  EXPECT_NEAR(stress(1, 1), 0.0, 1e-4 * material.YoungsModulus * Strain);
  gradient = Eigen::Matrix3d::Identity();
  gradient(0, 1) = Strain;
  const double shear = material.YoungsModulus / (2.0 * (1.0 + material.PoissonsRatio)) * Strain;
  EXPECT_NEAR(density.Stress(gradient)(1, 0), shear, 1e-4 * shear);
}

TEST(Elasticity, EnergiesOfStiffBodiesAreNotThoseOfRounding)
{
  // Strains of a stiff body under its weight: their energy is far below the rounding of the modulus.
  const ElasticMaterial material{ 1e12, 0.3, 1000.0 };
  const NeoHookean density(material);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(density.Energy(turn), 0.0, 1e-15);
  for (const double strain : { 0x1p-30, -0x1p-30, 0x1p-16, 0x1p-8 })
  {
    // Volume and shape change: lambda and mu of Hooke's law; the next term is of the order of the strain.
    Eigen::Matrix3d gradient = (1.0 + strain) * Eigen::Matrix3d::Identity();
    const double bulk = material.YoungsModulus / (3.0 * (1.0 - 2.0 * material.PoissonsRatio));
    const double expected = 4.5 * bulk * strain * strain;
    EXPECT_NEAR(density.Energy(gradient), expected, (1e-5 + 10.0 * std::abs(strain)) * expected) << strain;
    gradient = Eigen::Matrix3d::Identity();
    gradient(0, 1) = strain;
    const double shear = 0.25 * material.YoungsModulus / (1.0 + material.PoissonsRatio) * strain * strain;
    EXPECT_NEAR(density.Energy(gradient), shear, (1e-5 + 10.0 * std::abs(strain)) * shear) << strain;
  }
}

TEST(Elasticity, RotationsCostNothing)
{
  const ElasticBody body(Wedge(2), {});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const PointMatrix turned = body.Mesh().Points * turn.transpose();
  EXPECT_NEAR(body.Energy(turned), 0.0, 1e-20);
  EXPECT_LT(GradientOf(body, turned).norm(), 1e-9);
}

TEST(Elasticity, CantileverBendsAsBeamTheorySays)
{
  const double coarse = BendingRatio(8, 0.0);
  const double fine = BendingRatio(14, 0.0);
  EXPECT_NEAR(fine, 1.0, 0.05) << "14 tetrahedra across";
  EXPECT_LT(coarse, fine) << "linear tetrahedra are too stiff";
}

TEST(Elasticity, BallIsIndentedAsHertzSays)
{
  const double coarse = IndentationRatio(8, 0.0);
  const double fine = IndentationRatio(12, 0.0);
  // Errors of the meshes fall with the length of their edges.
  EXPECT_LT(std::abs(fine - 1.0), std::abs(coarse - 1.0));
  EXPECT_NEAR(fine + (fine - coarse) * 8.0 / (12.0 - 8.0), 1.0, 0.05);
}

TEST(Elasticity, RestStatesKeepWhatIsPromised)
{
  const ElasticDrops drops(Wedge(3), QuickDrop());
  const BoundingBox box = ComputeBoundingBox(drops.Body().Mesh());
  const double size = (box.Upper - box.Lower).norm();
  for (const ElasticEquilibrium& state : drops.Sample({ 5, 0, 0, 0 }, 2))
  {
    EXPECT_LT(state.Imbalance, 1e-3);
    EXPECT_GT(state.SmallestVolumeRatio, 0.0);
    EXPECT_LE(state.LargestEnergyRise, 1e-12);
    EXPECT_TRUE(state.HasSettled);
    EXPECT_GE(state.Time, 0.2) << "it was at rest for so long";
    EXPECT_LT(state.Time, 10.0);
    EXPECT_GT(state.Points.col(2).minCoeff(), 0.0);
    EXPECT_LT(state.Points.col(2).minCoeff(), 2e-3 * size) << "it lies on the floor";
  }
}

TEST(Elasticity, StiffBodiesSettleWithoutARiseOfTheEnergy)
{
  for (const double modulus : { 1e11, 1e12 })
  {
    DropOptions options;
    options.Material.YoungsModulus = modulus;
    options.DropHeight = 0.02;
    options.Motion.MaximumTime = 30.0;
    const ElasticEquilibrium state = ElasticDrops(Wedge(1), options).Drop({ 5, 1, 0, 0 });
    EXPECT_TRUE(state.HasSettled) << modulus;
    EXPECT_LT(state.Imbalance, 1e-3) << modulus;
    EXPECT_NEAR(state.SmallestVolumeRatio, 1.0, 1e-6) << modulus;
    EXPECT_LE(state.LargestEnergyRise, 1e-9) << modulus;
    EXPECT_GT(state.Points.col(2).minCoeff(), 0.0) << modulus;
  }
}

TEST(Elasticity, StartsOfInfiniteEnergyAreRefused)
{
  const ElasticBody body(Wedge(1), { 1e4, 0.3, 1000.0 });
  const ElasticSurroundings surroundings;
  ElasticMotion motion(body, surroundings, {});
  const PointMatrix still = PointMatrix::Zero(body.Mesh().NumberOfPoints(), 3);
  PointMatrix below = body.Mesh().Points;
  below.col(2).array() -= 0.1;
  EXPECT_THROW(motion.Settle(below, still), InvalidInput);
  PointMatrix lost = body.Mesh().Points;
  lost.col(2).array() += 1.0;
  lost(0, 0) = std::nan("");
  EXPECT_THROW(motion.Settle(lost, still), InvalidInput);
}

TEST(Elasticity, FailuresNameWhatToChange)
{
  DropOptions options = QuickDrop();
  options.Motion.MaximumSteps = 3;
  std::string text;
  try
  {
    ElasticDrops(Wedge(1), options).Drop({});
  }
  catch (const SolverFailure& error)
  {
    text = error.what();
  }
  for (const char* name : { "YoungsModulus", "LengthUnit", "DropHeight" })
  {
    EXPECT_NE(text.find(name), std::string::npos) << text;
  }
}

TEST(Elasticity, DropsDependOnSeedAndSampleOnly)
{
  DropOptions options = QuickDrop();
  options.Motion.MaximumTime = 0.4;
  const ElasticDrops drops(Wedge(2), options);
  const ThreadScope oneThread(1);
  const auto alone = drops.Sample({ 5, 1, 0, 0 }, 1);
  const ThreadScope twoThreads(2);
  const auto together = drops.Sample({ 5, 0, 0, 0 }, 2);
  EXPECT_EQ(alone[0].Points, together[1].Points);
  EXPECT_GT((together[0].Points - together[1].Points).norm(), 1e-3);
  EXPECT_GT((drops.Drop({ 6, 1, 0, 0 }).Points - alone[0].Points).norm(), 1e-3);
}

TEST(Elasticity, BodyDoesNotPassThroughItself)
{
  // Jaws with a slot between them, of which the upper one sags onto the lower one.
  TetrahedralMesh mesh = BoxOfTetrahedra({ 8, 2, 5 }, { 0.2, 0.05, 0.1 });
  std::vector<Index> kept;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    const Index cell = t / 6;
    const bool isSlot = cell / 16 == 2 && cell % 8 > 0;
    if (!isSlot)
    {
      kept.push_back(t);
    }
  }
  mesh.Tetrahedra = TetrahedronMatrix(mesh.Tetrahedra(kept, Eigen::all));
  DropOptions options;
  options.Material.YoungsModulus = 4e3;
  options.DropHeight = 0.0;
  options.RandomOrientation = false;
  options.MinimumSpin = 0.0;
  options.MaximumSpin = 0.0;
  options.Motion.MaximumTime = 0.0;
  EXPECT_EQ(PointsInside(mesh, ElasticDrops(mesh, options).Drop({}).Points), 0);
  options.Surroundings.HasSelfContact = false;
  EXPECT_GT(PointsInside(mesh, ElasticDrops(mesh, options).Drop({}).Points), 0) << "they would meet";
}

TEST(Elasticity, CreepTakesNoTime)
{
  DropOptions options = QuickDrop();
  options.Motion.MaximumTime = 0.0;
  const ElasticEquilibrium laid = ElasticDrops(Wedge(1), options).Drop({});
  EXPECT_EQ(laid.Time, 0.0);
  EXPECT_GT(laid.NumberOfTimeSteps, 0);
  options.Motion.MaximumTime = 0.12;
  const double time = ElasticDrops(Wedge(1), options).Drop({}).Time;
  EXPECT_GE(time, 0.12);
  EXPECT_LE(time, 0.12 + options.Motion.TimeStep);
}

TEST(Elasticity, WrongConstantsAreErrors)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 1, 1, 1 }, { 1.0, 1.0, 1.0 });
  EXPECT_THROW(ElasticBody(mesh, { 0.0, 0.3, 1000.0 }), InvalidInput);
  EXPECT_THROW(ElasticBody(mesh, { 1e4, 0.5, 1000.0 }), InvalidInput);
  EXPECT_THROW(ElasticBody(mesh, { 1e4, 0.3, std::nan("") }), InvalidInput);
  TetrahedralMesh stray = mesh;
  stray.Points.conservativeResize(stray.Points.rows() + 1, 3);
  stray.Points.bottomRows(1).setZero();
  EXPECT_THROW(ElasticBody(stray, {}), InvalidInput);
  DropOptions options;
  options.MaximumSpin = 0.0;
  EXPECT_THROW(ElasticDrops(mesh, options), InvalidInput);
}

TEST(Elasticity, DropsCanBeCancelled)
{
  const ElasticDrops drops(Wedge(2), {});
  EXPECT_THROW(drops.Sample({}, 2, [](double) { return false; }), Cancelled);
}
