// SPDX-License-Identifier: BSD-3-Clause
//
// Rest states next to given shapes of an elastic body.
#include "ExampleVolumes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/ElasticSettling.h"
#include "Core/Elasticity/ElasticTethers.h"
#include "Core/Elasticity/NodeMatrix.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynth;
using surfsynth::test::BoxOfTetrahedra;

namespace
{
TetrahedralMesh Plank() { return BoxOfTetrahedra({ 5, 3, 2 }, { 0.4, 0.2, 0.08 }); }

/// A place in the middle of each tetrahedron of a mesh.
std::vector<VolumePlace> Middles(const TetrahedralMesh& mesh)
{
  std::vector<VolumePlace> places;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    places.push_back({ t, Eigen::Vector4d::Constant(0.25) });
  }
  return places;
}

/// Positions of places in the mesh with these nodes.
PointMatrix PositionsOf(const std::vector<VolumePlace>& places, const TetrahedralMesh& mesh, const PointMatrix& nodes)
{
  PointMatrix positions(static_cast<Eigen::Index>(places.size()), 3);
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    positions.row(static_cast<Eigen::Index>(k)) = PositionOf({ nodes, mesh.Tetrahedra }, places[k]).transpose();
  }
  return positions;
}

/// Settling of the plank by the middles of its tetrahedra.
ElasticSettling Settling(const SettlingOptions& options = {})
{
  const TetrahedralMesh mesh = Plank();
  const auto count = mesh.NumberOfTetrahedra();
  return { mesh, Middles(mesh), PointMatrix::Zero(count, 3), Eigen::VectorXd::Ones(count), options };
}

void ExpectRestState(const ElasticEquilibrium& state)
{
  EXPECT_LE(state.Imbalance, 5e-4);
  EXPECT_GT(state.SmallestVolumeRatio, 0.0);
  EXPECT_LE(state.LargestEnergyRise, 1e-12);
  EXPECT_GT(state.Points.col(2).minCoeff(), 0.0);
  EXPECT_LT(state.Points.col(2).minCoeff(), 1e-3) << "it lies on the floor";
}

/// Root mean square of the distances of two sets of points.
double Distance(const PointMatrix& a, const PointMatrix& b)
{
  return std::sqrt((a - b).rowwise().squaredNorm().mean());
}
} // namespace

TEST(ElasticSettling, TethersAreSprings)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 2, 1, 1 }, { 0.2, 0.1, 0.1 });
  std::vector<VolumePlace> places{ { 0, { 0.1, 0.2, 0.3, 0.4 } }, {}, { 3, { 0.7, 0.1, 0.1, 0.1 } } };
  PointMatrix ends(3, 3);
  ends << 0.3, 0.1, -0.2, 1e300, 0.0, 0.0, 0.0, 0.4, 0.1;
  const Eigen::Vector3d strength(20.0, 30.0, 50.0);
  const ElasticTethers tethers(mesh, places, ends, strength);
  PointMatrix points = mesh.Points;
  double expected = 0.0;
  for (const int k : { 0, 2 })
  {
    expected += 0.5 * strength[k] * (PositionOf(mesh, places[k]).transpose() - ends.row(k)).squaredNorm();
  }
  EXPECT_NEAR(tethers.Energy(points), expected, 1e-12 * expected);
  PointMatrix gradient = PointMatrix::Zero(points.rows(), 3);
  tethers.AddGradient(points, gradient);
  NodeMatrix stiffness(mesh, {});
  tethers.AddStiffness(stiffness);
  constexpr double Step = 1e-3; // of a quadratic function: differences are exact
  for (const Index v : { mesh.Tetrahedra(0, 0), mesh.Tetrahedra(0, 2), mesh.Tetrahedra(3, 1) })
  {
    PointMatrix ahead = points;
    PointMatrix back = points;
    ahead(v, 1) += Step;
    back(v, 1) -= Step;
    EXPECT_NEAR((tethers.Energy(ahead) - tethers.Energy(back)) / (2.0 * Step), gradient(v, 1), 1e-9) << v;
    PointMatrix turned = PointMatrix::Zero(points.rows(), 3);
    tethers.AddGradient(ahead, turned);
    EXPECT_NE(gradient(v, 1), 0.0) << v;
    for (const Index w : { v, mesh.Tetrahedra(0, 1), mesh.Tetrahedra(3, 0) })
    {
      EXPECT_NEAR((turned(w, 1) - gradient(w, 1)) / Step, stiffness.Matrix().coeff(3 * w + 1, 3 * v + 1), 1e-9) << w;
      EXPECT_EQ(stiffness.Matrix().coeff(3 * w, 3 * v + 1), 0.0) << w;
    }
  }
  EXPECT_EQ(ElasticTethers().Energy(points), 0.0);
}

TEST(ElasticSettling, FindsTheRestStateThatAShapeComesFrom)
{
  DropOptions dropping;
  const ElasticDrops drops(Plank(), dropping);
  const ElasticSettling settling = Settling();
  const TetrahedralMesh mesh = Plank();
  for (const ElasticEquilibrium& dropped : drops.Sample({ 5, 0, 0, 0 }, 3))
  {
    const PointMatrix shape = PositionsOf(Middles(mesh), mesh, dropped.Points);
    PointMatrix rough = shape; // off the floor, and with noise of a hundredth of the size
    for (Eigen::Index k = 0; k < rough.size(); ++k)
    {
      rough.data()[k] += 0.3 + 0.005 * std::sin(3.7 * static_cast<double>(k));
    }
    const ElasticEquilibrium state = settling.Settle(rough);
    ExpectRestState(state);
    EXPECT_EQ(state.Time, 0.0);
    EXPECT_LT(Distance(PositionsOf(Middles(mesh), mesh, state.Points), shape), 2e-3);
  }
}

TEST(ElasticSettling, AnyShapeLeadsToARestState)
{
  const TetrahedralMesh mesh = Plank();
  const ElasticSettling settling = Settling();
  const PointMatrix middles = PositionsOf(Middles(mesh), mesh, mesh.Points);
  PointMatrix mirrored = middles;
  mirrored.col(0) *= -1.0;
  PointMatrix folded = middles; // one half lies in the other
  folded.col(0) = (folded.col(0).array() - 0.2).abs();
  PointMatrix scattered = middles;
  for (Eigen::Index k = 0; k < scattered.size(); ++k)
  {
    scattered.data()[k] = 0.3 * std::sin(91.7 * static_cast<double>(k * k));
  }
  const PointMatrix point = PointMatrix::Zero(middles.rows(), 3);
  const PointMatrix huge = 3.0 * middles;
  for (const PointMatrix& shape : { mirrored, folded, scattered, point, huge })
  {
    ExpectRestState(settling.Settle(shape));
  }
}

TEST(ElasticSettling, ShapesTurnWithTheirFrameAndAlignUndoesIt)
{
  const TetrahedralMesh mesh = Plank();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const PointMatrix shape = PositionsOf(Middles(mesh), mesh, mesh.Points);
  const PointMatrix turned = (shape * turn.transpose()).rowwise() + Eigen::RowVector3d(3.0, -2.0, 0.0);
  SettlingOptions options;
  options.Align = false;
  const ElasticSettling free = Settling(options);
  const PointMatrix straight = free.Settle(shape).Points;
  const PointMatrix expected = (straight * turn.transpose()).rowwise() + Eigen::RowVector3d(3.0, -2.0, 0.0);
  EXPECT_LT(Distance(free.Settle(turned).Points, expected), 1e-3);
  const ElasticSettling aligned = Settling();
  EXPECT_LT(Distance(aligned.Settle(turned).Points, aligned.Settle(shape).Points), 1e-3);
}

TEST(ElasticSettling, HasTheSameBitsForEveryNumberOfThreads)
{
  const TetrahedralMesh mesh = Plank();
  const ElasticSettling settling = Settling();
  const PointMatrix shape = PositionsOf(Middles(mesh), mesh, mesh.Points);
  const std::vector<PointMatrix> shapes{ shape, 1.1 * shape, 0.9 * shape };
  const ThreadScope oneThread(1);
  const auto alone = settling.Settle(shapes, 0);
  const ThreadScope threeThreads(3);
  const auto together = settling.Settle(shapes, 0);
  for (std::size_t k = 0; k < shapes.size(); ++k)
  {
    EXPECT_EQ(alone[k].Points, together[k].Points) << k;
  }
}

TEST(ElasticSettling, FailuresNameTheShapeAndCanBeCancelled)
{
  SettlingOptions options;
  options.Motion.MaximumSteps = 1;
  const TetrahedralMesh mesh = Plank();
  const PointMatrix shape = PositionsOf(Middles(mesh), mesh, mesh.Points);
  std::string text;
  try
  {
    Settling(options).Settle({ 2.0 * shape }, 7);
  }
  catch (const SolverFailure& error)
  {
    text = error.what();
  }
  EXPECT_EQ(text.rfind("Sample 7: ", 0), 0u) << text;
  EXPECT_THROW(Settling().Settle({ shape, shape }, 0, [](double) { return false; }), Cancelled);
  EXPECT_THROW(ElasticSettling(mesh, std::vector<VolumePlace>(3), PointMatrix::Zero(3, 3), Eigen::Vector3d::Ones(), {}),
    InvalidInput);
}
