// SPDX-License-Identifier: BSD-3-Clause
// Matérn fields whose range, direction and barriers vary from place to place. Correlations are those that
// MaternField::SolvePrecision() computes, free of sampling error.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

using namespace surfsynth;

namespace
{

const double NaN = std::numeric_limits<double>::quiet_NaN();

MaternFieldOptions ByRange(double range, int power = 2)
{
  MaternFieldOptions options;
  options.CorrelationRange = range;
  options.OperatorPower = power;
  return options;
}

/// Correlations of all vertices with vertex @p v.
Eigen::VectorXd CorrelationsWith(const MaternField& field, Index v)
{
  const Eigen::VectorXd covariance = field.SolvePrecision(Eigen::VectorXd::Unit(field.Mesh().NumberOfPoints(), v));
  return covariance.cwiseQuotient((field.MarginalVariances() * covariance[v]).cwiseSqrt());
}

/// Index of vertex (column, row) of a square PlanePatch with @p cells cells on a side.
Index Vertex(int cells, int column, int row) { return row * (cells + 1) + column; }

/// First distance, in steps of (columns, rows) from the centre of the patch, at which the correlation falls to @p level.
double DistanceOf(
  const Eigen::VectorXd& correlations, const TriangleMesh& mesh, int cells, int columns, int rows, double level)
{
  const int centre = cells / 2;
  const auto at = [&](int k) { return Vertex(cells, centre + k * columns, centre + k * rows); };
  int k = 1;
  while (correlations[at(k)] > level)
  {
    ++k;
  }
  const double before = correlations[at(k - 1)];
  const double fraction = (before - level) / (before - correlations[at(k)]);
  const double step = (mesh.Points.row(at(1)) - mesh.Points.row(at(0))).norm();
  return (k - 1 + fraction) * step;
}

PointMatrix Everywhere(const TriangleMesh& mesh, const Eigen::RowVector3d& direction)
{
  return direction.replicate(mesh.Points.rows(), 1);
}

std::string ErrorOf(const TriangleMesh& mesh, const MaternFieldOptions& options)
{
  try
  {
    MaternField(mesh, options);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "none";
}

class AnisotropyAlong : public testing::TestWithParam<int>
{};

} // namespace

TEST(Operators, DiffusionWithTheUnitTensorIsTheCotangentStiffness)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  const MeshTopology topology(mesh);
  FaceTensors unit(mesh.Triangles.rows(), 3);
  unit.rowwise() = Eigen::RowVector3d(1.0, 0.0, 1.0);
  const Eigen::MatrixXd expected = CotangentStiffness(mesh, topology);
  const Eigen::MatrixXd actual = DiffusionStiffness(mesh, topology, unit);
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
  // So it is for the ratio 1 and for directions that are orthogonal to the surface or 0.
  const FaceTensors one = DirectionTensors(mesh, Everywhere(mesh, { 1.0, 2.0, 3.0 }), 1.0);
  EXPECT_LE((one - unit).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((DirectionTensors(mesh, Everywhere(mesh, { 0.0, 0.0, 0.0 }), 5.0) - unit).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Operators, DiffusionOfLinearFunctionsHasTheEnergyOfTheTensor)
{
  // Energy of u on the unit square with direction d: ratio (d . grad u)^2 + 1 / ratio (the rest)^2; sign and length of d
  // do not matter.
  const TriangleMesh mesh = test::PlanePatch(9, 7, 1.0, 1.0, 0.2);
  const MeshTopology topology(mesh);
  const double angle = 0.4;
  const Eigen::RowVector3d along(std::cos(angle), std::sin(angle), 0.0);
  const Eigen::RowVector3d across(-std::sin(angle), std::cos(angle), 0.0);
  PointMatrix directions = Everywhere(mesh, along);
  for (Eigen::Index v = 0; v < directions.rows(); v += 2)
  {
    directions.row(v) *= -3.0;
  }
  const FaceTensors tensors = DirectionTensors(mesh, directions, 6.0);
  const Eigen::MatrixXd stiffness = DiffusionStiffness(mesh, topology, tensors);
  const Eigen::VectorXd u = mesh.Points * along.transpose();
  const Eigen::VectorXd w = mesh.Points * across.transpose();
  EXPECT_NEAR(u.dot(stiffness * u), 6.0, 1e-11);
  EXPECT_NEAR(w.dot(stiffness * w), 1.0 / 6.0, 1e-11);
  EXPECT_NEAR(u.dot(stiffness * w), 0.0, 1e-11);
  for (Eigen::Index f = 0; f < tensors.rows(); ++f)
  {
    EXPECT_NEAR(tensors(f, 0) * tensors(f, 2) - tensors(f, 1) * tensors(f, 1), 1.0, 1e-12);
  }
}

TEST_P(AnisotropyAlong, CorrelationLengthsDifferByTheRatioAlongAndAcross)
{
  // Distances at which the correlation is 0.14 and 0.5, along the direction and across, on a plane: their ratio within
  // 3 %, and their geometric mean that of the isotropic field within 3 %. 120 cells, 9 edges in the shorter range.
  constexpr int Cells = 120;
  const TriangleMesh mesh = test::PlanePatch(Cells, Cells, 2.0, 2.0, 0.0);
  const int turned = GetParam();
  MaternFieldOptions options = ByRange(0.3);
  const Index centre = Vertex(Cells, Cells / 2, Cells / 2);
  const Eigen::VectorXd isotropic = CorrelationsWith(MaternField(mesh, options), centre);
  options.Arrays.Directions = Everywhere(
    mesh, turned ? Eigen::RowVector3d(1.0, 1.0, 0.0) : Eigen::RowVector3d(0, 1, 0));
  options.AnisotropyRatio = 4.0;
  const MaternField field(mesh, options);
  const Eigen::VectorXd correlations = CorrelationsWith(field, centre);
  for (const double level : { 0.5, 0.14 })
  {
    const double along = DistanceOf(correlations, mesh, Cells, turned, 1, level);
    const double across = DistanceOf(correlations, mesh, Cells, 1, -turned, level);
    EXPECT_NEAR(along / across, 4.0, 0.12) << "level " << level;
    const double mean = DistanceOf(isotropic, mesh, Cells, 1, 0, level);
    EXPECT_NEAR(std::sqrt(along * across) / mean, 1.0, 0.03) << "level " << level;
  }
  EXPECT_NEAR(std::sqrt(field.MarginalVariances()[centre]), 1.0, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Directions, AnisotropyAlong, testing::Values(0, 1),
  [](const auto& info) { return std::string(info.param ? "Diagonal" : "Axis"); });

TEST(MaternField, AnisotropyFollowsTheSurface)
{
  // A tube stretched around its axis: the correlation at a quarter of the circumference is larger than that at the same
  // distance along the axis; and the other way round.
  constexpr int Segments = 48;
  const TriangleMesh mesh = test::OpenCylinder(Segments, 100, 1.0, 12.0);
  PointMatrix around(mesh.Points.rows(), 3);
  for (Eigen::Index v = 0; v < around.rows(); ++v)
  {
    around.row(v) << -mesh.Points(v, 1), mesh.Points(v, 0), 0.0;
  }
  MaternFieldOptions options = ByRange(1.5);
  options.Arrays.Directions = around;
  const auto correlationsOf = [&](double ratio) {
    options.AnisotropyRatio = ratio;
    Index middle = 0;
    (mesh.Points.rowwise() - Eigen::RowVector3d(1.0, 0.0, mesh.Points.col(2).mean()))
      .rowwise()
      .norm()
      .minCoeff(&middle);
    const Eigen::VectorXd correlations = CorrelationsWith(MaternField(mesh, options), middle);
    const Eigen::RowVector3d place = mesh.Points.row(middle);
    Index side = 0;
    Index above = 0;
    (mesh.Points.rowwise() - Eigen::RowVector3d(0.0, 1.0, place[2])).rowwise().norm().minCoeff(&side);
    (mesh.Points.rowwise() - Eigen::RowVector3d(1.0, 0.0, place[2] + 0.5 * M_PI)).rowwise().norm().minCoeff(&above);
    return Eigen::Vector2d(correlations[side], correlations[above]);
  };
  const Eigen::Vector2d stretchedAround = correlationsOf(3.0);
  const Eigen::Vector2d stretchedAlong = correlationsOf(1.0 / 3.0);
  EXPECT_GT(stretchedAround[0], 5.0 * stretchedAround[1]);
  EXPECT_GT(stretchedAlong[1], 5.0 * stretchedAlong[0]);
}

TEST(MaternField, AConstantRangeFactorIsALongerRange)
{
  const TriangleMesh mesh = test::PlanePatch(15, 12, 1.5, 1.0, 0.2);
  for (const int power : { 2, 3, 4 })
  {
    MaternFieldOptions options = ByRange(0.2, power);
    options.Arrays.RangeFactors = Eigen::VectorXd::Constant(mesh.Points.rows(), 2.0);
    const Eigen::VectorXd actual = MaternField(mesh, options).MarginalVariances();
    const Eigen::VectorXd expected = MaternField(mesh, ByRange(0.4, power)).MarginalVariances();
    EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.maxCoeff()) << "alpha " << power;
  }
}

TEST(MaternField, ARangeFactorScalesTheRangeAndKeepsTheDeviation)
{
  // Factors from 1 at the south pole to 2 at the north pole. Edges are a ninth of the smallest range.
  const TriangleMesh mesh = test::Icosphere(5);
  MaternFieldOptions options = ByRange(0.35);
  options.Arrays.RangeFactors = (1.5 + 0.5 * mesh.Points.col(2).array()).matrix();
  const MaternField field(mesh, options);
  const Eigen::VectorXd deviations = field.MarginalVariances().cwiseSqrt();
  EXPECT_GE(deviations.minCoeff(), 0.93);
  EXPECT_LE(deviations.maxCoeff(), 1.07);
  for (const double pole : { -1.0, 1.0 })
  {
    Index v = 0;
    (pole * mesh.Points.col(2)).maxCoeff(&v);
    const double range = pole > 0.0 ? 0.7 : 0.35;
    const Eigen::VectorXd correlations = CorrelationsWith(field, v);
    double sum = 0.0;
    int count = 0;
    for (Index other = 0; other < mesh.NumberOfPoints(); ++other)
    {
      const double angle = std::acos(std::clamp(mesh.Points.row(v).dot(mesh.Points.row(other)), -1.0, 1.0));
      if (std::abs(angle - range) < 0.05 * range)
      {
        sum += correlations[other];
        ++count;
      }
    }
    ASSERT_GT(count, 20);
    EXPECT_NEAR(sum / count, 0.14, 0.03) << "pole " << pole;
  }
  options.VarianceCorrection = true;
  const Eigen::VectorXd corrected = MaternField(mesh, options).MarginalVariances().cwiseSqrt();
  EXPECT_LE((corrected.array() - 1.0).abs().maxCoeff(), 1e-8);
}

TEST(MaternField, BarriersCutTheCorrelationAndLeaveTheRest)
{
  // A wall of cells in the middle of a patch: without a gap, both sides are fields of their own; with a gap, the
  // correlation goes around.
  constexpr int Cells = 40;
  const TriangleMesh mesh = test::PlanePatch(Cells, Cells, 2.0, 2.0, 0.0);
  const Index left = Vertex(Cells, 18, 20);
  const Index right = Vertex(Cells, 22, 20);
  MaternFieldOptions options = ByRange(0.8);
  const double before = CorrelationsWith(MaternField(mesh, options), left)[right];
  const auto withWall = [&](double gap) {
    options.Arrays.Barrier.clear();
    for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
    {
      const Eigen::RowVector3d centre = (mesh.Points.row(mesh.Triangles(f, 0)) + mesh.Points.row(mesh.Triangles(f, 1)) +
                                          mesh.Points.row(mesh.Triangles(f, 2))) /
        3.0;
      options.Arrays.Barrier.push_back(std::abs(centre[0] - 1.0) < 0.1 && centre[1] >= gap);
    }
    return MaternField(mesh, options);
  };
  const MaternField cut = withWall(0.0);
  const Eigen::VectorXd covariance = cut.SolvePrecision(Eigen::VectorXd::Unit(mesh.NumberOfPoints(), left));
  const Eigen::MatrixXd sample = cut.Sample();
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_EQ(covariance[v] != 0.0, mesh.Points(v, 0) < 0.92) << v;
    EXPECT_EQ(sample(v, 0) == 0.0, std::abs(mesh.Points(v, 0) - 1.0) < 0.08) << v;
  }
  const MaternField open = withWall(0.4);
  const double around = open.SolvePrecision(Eigen::VectorXd::Unit(mesh.NumberOfPoints(), left))(right, 0);
  EXPECT_GT(before, 0.6);
  EXPECT_LT(around, 0.1);
  EXPECT_GT(around, 0.0);
  options.VarianceCorrection = true;
  const Eigen::VectorXd corrected = withWall(0.4).MarginalVariances();
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_NEAR(corrected[v], sample(v, 0) == 0.0 && mesh.Points(v, 1) > 0.42 ? 0.0 : 1.0, 1e-9) << v;
  }
}

TEST(MaternField, AConstantRangeFactorIsAnotherRangeAtTheBoundaryToo)
{
  const TriangleMesh mesh = test::PlanePatch(20, 20, 2.0, 2.0, 0.1);
  for (const BoundaryCondition boundary : { BoundaryCondition::Neumann, BoundaryCondition::Robin })
  {
    MaternFieldOptions options = ByRange(0.8);
    options.Boundary = boundary;
    options.VarianceCorrection = true;
    const MaternField direct(mesh, options);
    options.CorrelationRange = 1.6;
    options.Arrays.RangeFactors = Eigen::VectorXd::Constant(mesh.NumberOfPoints(), 0.5);
    const MaternField scaled(mesh, options);
    EXPECT_LE((direct.Sample() - scaled.Sample()).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NEAR(direct.LongestEdgeOverRange(), scaled.LongestEdgeOverRange(), 1e-12);
    EXPECT_NEAR(direct.LongestEdgeOverRange(), direct.LongestEdge() / 0.8, 1e-12);
  }
}

TEST(MaternField, LongestEdgeIsMeasuredInTheRangeOfItsDirection)
{
  // Right triangles with sides of 0.1 along x and 0.05 along y, and diagonals.
  const TriangleMesh mesh = test::PlanePatch(20, 20, 2.0, 1.0, 0.0);
  MaternFieldOptions options = ByRange(1.0);
  options.AnisotropyRatio = 4.0;
  options.Arrays.Directions = Everywhere(mesh, { 1.0, 0.0, 0.0 }); // ranges of 2 along x and 0.5 along y
  EXPECT_NEAR(MaternField(mesh, options).LongestEdgeOverRange(), std::hypot(0.05, 0.1), 1e-12);
  options.Arrays.Directions = Everywhere(mesh, { 0.0, 3.0, 0.0 }); // 0.5 along x and 2 along y
  EXPECT_NEAR(MaternField(mesh, options).LongestEdgeOverRange(), std::hypot(0.2, 0.025), 1e-12);
}

TEST(MaternField, VariancesForWhichThereIsNoRoomAreAnError)
{
  const TriangleMesh mesh = test::Icosphere(5);
  MaternFieldOptions options = ByRange(0.5);
  options.FactorMemoryLimit = std::uint64_t(12) << 20; // the factor takes less, the factors of its inverse more
  const MaternField field(mesh, options);
  ASSERT_STREQ(field.SolverName(), "Cholesky");
  std::string text = "none";
  try
  {
    field.MarginalVariances();
  }
  catch (const InvalidInput& error)
  {
    text = error.what();
  }
  EXPECT_NE(text.find("expected at most 12 MiB"), std::string::npos) << text;
}

TEST(MaternField, RejectsMalformedArrays)
{
  const TriangleMesh mesh = test::Icosphere(2);
  const Eigen::Index points = mesh.Points.rows();
  MaternFieldOptions options = ByRange(1.0);
  options.Arrays.RangeFactors = Eigen::VectorXd::Ones(points - 1);
  EXPECT_NE(ErrorOf(mesh, options).find("161 range factors; expected 162"), std::string::npos)
    << ErrorOf(mesh, options);
  for (const double bad : { 0.0, -1.0, NaN })
  {
    options.Arrays.RangeFactors = Eigen::VectorXd::Ones(points);
    options.Arrays.RangeFactors[7] = bad;
    EXPECT_NE(ErrorOf(mesh, options).find("range factor of point 7"), std::string::npos) << ErrorOf(mesh, options);
  }
  options.Arrays = {};
  options.Arrays.Directions = Everywhere(mesh, { 1.0, 0.0, NaN });
  EXPECT_NE(ErrorOf(mesh, options).find("direction of point 0"), std::string::npos) << ErrorOf(mesh, options);
  options.Arrays.Directions = Everywhere(mesh, { 1.0, 0.0, 0.0 });
  for (const double bad : { 0.0, -2.0, NaN })
  {
    options.AnisotropyRatio = bad;
    EXPECT_NE(ErrorOf(mesh, options).find("anisotropy ratio"), std::string::npos) << ErrorOf(mesh, options);
  }
  options.Arrays = {};
  options.Arrays.BoundaryMask.assign(3, true);
  EXPECT_NE(ErrorOf(mesh, options).find("boundary mask"), std::string::npos) << ErrorOf(mesh, options);
  options.Arrays = {};
  options.Arrays.Barrier.assign(3, true);
  EXPECT_NE(ErrorOf(mesh, options).find("expected 320"), std::string::npos) << ErrorOf(mesh, options);
  options.Arrays = {};
  options.Boundary = BoundaryCondition::Robin;
  options.RobinCoefficient = -1.0;
  EXPECT_NE(ErrorOf(mesh, options).find("Robin"), std::string::npos) << ErrorOf(mesh, options);
}

TEST(MaternField, OfBarriersAloneOrOfPinnedPointsAloneIsZero)
{
  const TriangleMesh mesh = test::Icosphere(2);
  MaternFieldOptions options = ByRange(1.0);
  options.VarianceCorrection = true;
  options.Arrays.Barrier.assign(static_cast<std::size_t>(mesh.NumberOfTriangles()), true);
  EXPECT_EQ(MaternField(mesh, options).Sample().cwiseAbs().maxCoeff(), 0.0);
  options.Arrays.Barrier.clear();
  options.Boundary = BoundaryCondition::Dirichlet;
  options.Arrays.BoundaryMask.assign(static_cast<std::size_t>(mesh.NumberOfPoints()), true);
  EXPECT_EQ(MaternField(mesh, options).Sample().cwiseAbs().maxCoeff(), 0.0);
}
