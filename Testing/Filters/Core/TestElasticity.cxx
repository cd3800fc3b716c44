// SPDX-License-Identifier: BSD-3-Clause
//
// Elastic bodies: derivatives, mechanics in closed form, and what rest states promise.
#include "ExampleVolumes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/NodeMatrix.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

using namespace surfsynth;
using surfsynth::test::BoxOfTetrahedra;

namespace
{
using Map = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// The unit cube of so many cells, whose points are mapped.
TetrahedralMesh Mapped(int nx, int ny, int nz, const Map& map)
{
  TetrahedralMesh mesh = BoxOfTetrahedra({ nx, ny, nz });
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    mesh.Points.row(v) = map(mesh.Points.row(v).transpose()).transpose();
  }
  return mesh;
}

/// A plank that is no cuboid, of @p cells cells across.
TetrahedralMesh Wedge(int cells)
{
  return Mapped(2 * cells, cells, cells, [](const Eigen::Vector3d& x) {
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

/// A quasi-static equilibrium without floor under loads.
ElasticEquilibrium Loaded(const ElasticBody& body, ElasticSurroundings surroundings)
{
  surroundings.HasFloor = false;
  surroundings.HasSelfContact = false;
  surroundings.Gravity = 0.0;
  MotionOptions options;
  options.MaximumTime = 0.0;
  options.Imbalance = 1e-5;
  ElasticMotion motion(body, surroundings, options);
  return motion.Settle(body.Mesh().Points, PointMatrix::Zero(body.Mesh().NumberOfPoints(), 3));
}

/// Deflection of the end of a cantilever over that of beam theory with shear, with @p cells across its height.
double BendingRatio(int cells)
{
  constexpr double Length = 1.0;
  constexpr double Height = 0.1;
  constexpr double Force = 0.05;
  const ElasticMaterial material{ 1e6, 0.0, 1000.0 };
  const ElasticBody body(BoxOfTetrahedra({ 5 * cells, 2, cells }, { Length, Height, Height }), material);
  const PointMatrix& points = body.Mesh().Points;
  ElasticSurroundings surroundings;
  surroundings.Loads = PointMatrix::Zero(points.rows(), 3);
  surroundings.IsFixed.assign(static_cast<std::size_t>(points.rows()), false);
  const auto edge = [](double x) { return x < 1e-9 || x > Height - 1e-9 ? 0.5 : 1.0; };
  double deflection = 0.0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    surroundings.IsFixed[static_cast<std::size_t>(v)] = points(v, 0) == 0.0;
    if (points(v, 0) > Length - 1e-9)
    {
      surroundings.Loads(v, 2) = -Force * edge(points(v, 1)) * edge(points(v, 2)) / (2 * cells);
    }
  }
  const PointMatrix bent = Loaded(body, surroundings).Points;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
  {
    deflection += surroundings.Loads(v, 2) / -Force * (points(v, 2) - bent(v, 2));
  }
  const double inertia = std::pow(Height, 4) / 12.0;
  const double shear = 5.0 / 6.0 * Height * Height * material.YoungsModulus / 2.0;
  const double theory = Force * std::pow(Length, 3) / (3.0 * material.YoungsModulus * inertia) + Force * Length / shear;
  return deflection / theory;
}

/// A ball of radius 1 on z = 0, of @p cells cells across, whose points crowd around its lowest one: the conformal map of
/// the ball to itself by inversion, scaling and inversion.
TetrahedralMesh Ball(int cells, double crowding)
{
  const Eigen::Vector3d north(0.0, 0.0, 1.0);
  const Eigen::Vector3d south(0.0, 0.0, -1.0);
  const auto invert = [north](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(north + 4.0 * (p - north) / (p - north).squaredNorm());
  };
  return Mapped(cells, cells, cells, [=](const Eigen::Vector3d& x) {
    Eigen::Vector3d p = 2.0 * x - Eigen::Vector3d::Ones();
    const double largest = p.cwiseAbs().maxCoeff();
    p *= largest > 0.0 ? largest / p.norm() : 1.0;
    if ((p - north).norm() > 1e-9)
    {
      p = invert(south + crowding * (invert(p) - south));
    }
    return Eigen::Vector3d(p - south);
  });
}

/// Indentation of a ball that lies on the floor under its weight over that of Hertz.
double IndentationRatio(int cells)
{
  constexpr double Indentation = 0.01;
  const ElasticMaterial material{ 1e6, 0.0, 1000.0 };
  const ElasticBody body(Ball(cells, 0.15), material);
  const PointMatrix& points = body.Mesh().Points;
  ElasticSurroundings surroundings;
  surroundings.ContactDistance = 5e-3 * Indentation;
  surroundings.HasSelfContact = false;
  surroundings.Friction = 0.0;
  const double force = 4.0 / 3.0 * material.YoungsModulus * std::pow(Indentation, 1.5);
  surroundings.Gravity = force / body.Masses().sum();
  MotionOptions options;
  options.MaximumTime = 0.0;
  options.Imbalance = 1e-3;
  PointMatrix start = points;
  start.col(2).array() += surroundings.ContactDistance * std::sqrt(12.0);
  ElasticMotion motion(body, surroundings, options);
  const PointMatrix rest = motion.Settle(start, PointMatrix::Zero(points.rows(), 3)).Points;
  const double sunk = body.Masses().dot(points.col(2) - rest.col(2)) / body.Masses().sum();
  return (sunk + rest.col(2).minCoeff()) / Indentation;
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

TEST(Elasticity, RotationsCostNothing)
{
  const ElasticBody body(Wedge(2), {});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const PointMatrix turned = body.Mesh().Points * turn.transpose();
  EXPECT_NEAR(body.Energy(turned), 0.0, 1e-10);
  EXPECT_LT(GradientOf(body, turned).norm(), 1e-9);
}

TEST(Elasticity, CantileverBendsAsBeamTheorySays)
{
  const double coarse = BendingRatio(8);
  const double fine = BendingRatio(14);
  EXPECT_NEAR(fine, 1.0, 0.05) << "14 tetrahedra across";
  EXPECT_LT(coarse, fine) << "linear tetrahedra are too stiff";
}

TEST(Elasticity, BallIsIndentedAsHertzSays)
{
  const double coarse = IndentationRatio(8);
  const double fine = IndentationRatio(12);
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
    EXPECT_GT(state.Points.col(2).minCoeff(), 0.0);
    EXPECT_LT(state.Points.col(2).minCoeff(), 2e-3 * size) << "it lies on the floor";
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
