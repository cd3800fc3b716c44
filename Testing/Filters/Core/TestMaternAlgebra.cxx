// SPDX-License-Identifier: BSD-3-Clause
// Covariance, precision and boundary of Matérn fields against dense algebra of the same operators.
#include "DenseFields.h"
#include "ExampleMeshes.h"
#include "SampleBits.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/CholeskySolver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace surfsynth;
using surfsynth::test::Covariance;
using surfsynth::test::DenseCovariance;
using surfsynth::test::ExpectClose;

namespace
{

const double NaN = std::numeric_limits<double>::quiet_NaN();

MaternFieldOptions ByScreening(double tau, int power)
{
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  options.Screening = tau;
  options.OperatorPower = power;
  return options;
}

MaternFieldOptions ByRange(double range, int power = 2)
{
  MaternFieldOptions options;
  options.CorrelationRange = range;
  options.OperatorPower = power;
  return options;
}

Eigen::MatrixXd DenseOperator(const TriangleMesh& mesh, double tau)
{
  Eigen::MatrixXd a = CotangentStiffness(mesh);
  a.diagonal() += tau * LumpedMass(mesh);
  return a;
}

/// Open, curved and thin: a cylinder of radius 0.15 and length 2, both ends open.
TriangleMesh Tube() { return test::OpenCylinder(12, 60, 0.15, 2.0); }

std::vector<bool> BoundaryOf(const TriangleMesh& mesh)
{
  const MeshTopology topology(mesh);
  const Eigen::VectorXd mass = BoundaryMass(mesh, topology);
  std::vector<bool> boundary;
  for (const double length : mass)
  {
    boundary.push_back(length > 0.0);
  }
  return boundary;
}

class FieldOfPower : public testing::TestWithParam<int>
{};

INSTANTIATE_TEST_SUITE_P(
  Powers, FieldOfPower, testing::Values(1, 2, 3, 4), [](const auto& info) { return std::to_string(info.param); });

class InverseOnMesh : public testing::TestWithParam<std::string>
{};

INSTANTIATE_TEST_SUITE_P(
  Suite, InverseOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

TEST_P(InverseOnMesh, DiagonalsAreThoseOfSolvesForUnitVectorsTo1em9)
{
  const TriangleMesh& mesh = test::FromSuite(GetParam()).Mesh;
  const Eigen::VectorXd mass = LumpedMass(mesh);
  SparseMatrix matrix = CotangentStiffness(mesh);
  for (Index v = 0; v < mass.size(); ++v)
  {
    matrix.coeffRef(v, v) += mass[v] > 0.0 ? 30.0 / mass.sum() * mass[v] : 1.0;
  }
  const CholeskySolver solver(matrix);
  const Eigen::MatrixXd diagonals = solver.InverseDiagonals(mass, 4);
  const Index step = std::max<Index>(1, mesh.NumberOfPoints() / 60);
  for (Index v = 0; v < mesh.NumberOfPoints(); v += step)
  {
    Eigen::VectorXd column = Eigen::VectorXd::Unit(mass.size(), v);
    for (int power = 1; power <= 4; ++power)
    {
      column = solver.Solve(column);
      EXPECT_NEAR(diagonals(v, power - 1), column[v], 1e-9 * std::abs(column[v])) << "vertex " << v;
      column.array() *= mass.array();
    }
  }
}

TEST(CholeskySolver, LogDeterminantIsThatOfTheDenseMatrix)
{
  const TriangleMesh mesh = test::Icosphere(3);
  const Eigen::MatrixXd dense = DenseOperator(mesh, 7.0);
  const double expected = 2.0 * Eigen::MatrixXd(dense.llt().matrixL()).diagonal().array().log().sum();
  EXPECT_NEAR(CholeskySolver(dense.sparseView()).LogDeterminant(), expected, 1e-10 * std::abs(expected));
}

TEST(CholeskySolver, TransposedSolvesHaveTheInverseAsTheirGram)
{
  // Columns of L^-T P for unit vectors: their products with themselves sum to A^-1.
  const Eigen::MatrixXd dense = DenseOperator(test::Icosphere(2), 7.0);
  const CholeskySolver solver(dense.sparseView());
  const Eigen::Index size = solver.Size();
  const Eigen::Index padded = (size + 7) / 8 * 8;
  RowMatrix columns = RowMatrix::Identity(size, padded);
  solver.SolveTransposedOrderedInPlace(columns);
  Eigen::MatrixXd inverse(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
  {
    for (Eigen::Index j = 0; j < size; ++j)
    {
      inverse(solver.Order()[i], solver.Order()[j]) = columns.row(i).dot(columns.row(j));
    }
  }
  ExpectClose(inverse, dense.inverse(), 1e-11);
}

TEST(CholeskySolver, InverseDiagonalsRejectWhatIsOutOfRangeAndStopOnRequest)
{
  const TriangleMesh mesh = test::Icosphere(3);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const CholeskySolver solver(DenseOperator(mesh, 7.0).sparseView());
  EXPECT_THROW(solver.InverseDiagonals(mass.head(3), 2), InvalidInput);
  EXPECT_THROW(solver.InverseDiagonals(-mass, 2), InvalidInput);
  EXPECT_THROW(solver.InverseDiagonals(NaN * mass, 2), InvalidInput);
  EXPECT_THROW(solver.InverseDiagonals(mass, 0), InvalidInput);
  double last = 0.0;
  EXPECT_THROW(solver.InverseDiagonals(mass, 2,
                 [&](double fraction) {
                   EXPECT_GE(fraction, last);
                   last = fraction;
                   return fraction < 0.5;
                 }),
    Cancelled);
}

TEST_P(FieldOfPower, CovarianceAndPrecisionAreThoseOfDenseAlgebraTo1em9)
{
  const int power = GetParam();
  const TriangleMesh mesh = test::PlanePatch(11, 8, 1.5, 1.0, 0.2);
  const MaternField field(mesh, ByScreening(12.0, power));
  const Eigen::MatrixXd expected = DenseCovariance(DenseOperator(mesh, 12.0), LumpedMass(mesh), power);
  ExpectClose(Covariance(field), expected, 1e-9);
  ExpectClose(field.ApplyPrecision(expected), Eigen::MatrixXd::Identity(mesh.Points.rows(), mesh.Points.rows()), 1e-7);
  ExpectClose(field.MarginalVariances(), expected.diagonal(), 1e-9);
  const double determinant = -2.0 * Eigen::MatrixXd(expected.llt().matrixL()).diagonal().array().log().sum();
  EXPECT_NEAR(field.LogDeterminantOfPrecision(), determinant, 1e-8 * std::abs(determinant));
  EXPECT_EQ(field.Smoothness(), power - 1.0);
}

TEST_P(FieldOfPower, SamplesHaveTheCovarianceThatIsComputed)
{
  // z^T Q z of one sample is chi-square with V degrees of freedom; the mean over 400 samples within 4 deviations.
  const TriangleMesh mesh = test::Icosphere(3);
  const MaternField field(mesh, ByScreening(10.0, GetParam()));
  SampleRequest request;
  request.NumberOfSamples = 400;
  double sum = 0.0;
  field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& z) {
    sum += (z.transpose() * field.ApplyPrecision(z))(0, 0);
  });
  const double freedom = 400.0 * static_cast<double>(mesh.NumberOfPoints());
  EXPECT_NEAR(sum / freedom, 1.0, 4.0 * std::sqrt(2.0 / freedom));
}

TEST_P(FieldOfPower, CorrectedDeviationIsExactOnAnOpenThinTube)
{
  // Without the correction the deviation of this tube, narrower than the range, is far from the one asked for.
  MaternFieldOptions options = GetParam() == 1 ? ByScreening(50.0, 1) : ByRange(0.6, GetParam());
  options.StandardDeviation = 2.5;
  const TriangleMesh mesh = Tube();
  if (GetParam() > 1)
  {
    const Eigen::VectorXd before = MaternField(mesh, options).MarginalVariances().cwiseSqrt();
    EXPECT_GT(before.maxCoeff(), 1.3 * 2.5);
  }
  options.VarianceCorrection = true;
  const MaternField field(mesh, options);
  const Eigen::VectorXd deviations = Covariance(field).diagonal().cwiseSqrt();
  EXPECT_NEAR(deviations.minCoeff(), 2.5, 1e-8);
  EXPECT_NEAR(deviations.maxCoeff(), 2.5, 1e-8);
}

TEST_P(FieldOfPower, CorrectedSamplesHaveTheDeviationAtEveryPoint)
{
  // 2,000 samples: the sum of squares at a point is chi-square with 2,000 degrees; the bound is its quantile of
  // probability 1e-4 over all points (Bonferroni), z = 5.2, the deviation within 8.5 %. The mean over all points, whose
  // correlation leaves at least 20 independent places, within 4 deviations: 2 %.
  MaternFieldOptions options = GetParam() == 1 ? ByScreening(50.0, 1) : ByRange(0.3, GetParam());
  options.VarianceCorrection = true;
  const TriangleMesh mesh = Tube();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
  SampleRequest request;
  request.NumberOfSamples = 2000;
  MaternField(mesh, options).Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& z) {
    squares += z.col(0).cwiseAbs2();
  });
  squares /= 2000.0;
  EXPECT_LE(std::sqrt(squares.maxCoeff()), 1.085);
  EXPECT_GE(std::sqrt(squares.minCoeff()), 0.915);
  EXPECT_NEAR(std::sqrt(squares.mean()), 1.0, 0.02);
}

TEST_P(FieldOfPower, ASampleHasTheSameBitsAloneInABatchAndForEveryNumberOfThreads)
{
  MaternFieldOptions options = ByScreening(10.0, GetParam());
  options.VarianceCorrection = true;
  test::ExpectSameBitsAloneAndInABatch(test::Icosphere(4), options, 3);
}

TEST(MaternField, PowerOneHasNoRangeAndPowersEndAtFour)
{
  const TriangleMesh mesh = test::Icosphere(2);
  EXPECT_THROW(MaternField(mesh, ByRange(0.5, 1)), InvalidInput);
  EXPECT_THROW(MaternField(mesh, ByScreening(1.0, 0)), InvalidInput);
  EXPECT_THROW(MaternField(mesh, ByScreening(1.0, 5)), InvalidInput);
  try
  {
    MaternField(mesh, ByRange(0.5, 1));
  }
  catch (const InvalidInput& error)
  {
    EXPECT_NE(std::string(error.what()).find("no finite variance"), std::string::npos) << error.what();
  }
}

TEST(MaternField, EachPowerHasTheDeviationAskedForOnSpheresOfEveryRange)
{
  // Mean over the surface, within 5 % as MarginalVariance() promises. Edges are at most an eighth of the range, as in
  // TestMaternField.cxx.
  const TriangleMesh mesh = test::Icosphere(4);
  for (const int power : { 2, 3, 4 })
  {
    for (const double range : { 0.6, 1.0, 2.0, 4.0, 30.0 })
    {
      const MaternField field(mesh, ByRange(range, power));
      EXPECT_NEAR(std::sqrt(field.MarginalVariances().mean()), 1.0, 0.05) << "alpha " << power << ", range " << range;
    }
  }
}

TEST(MarginalVariance, OfHigherPowersIsWithin6PerCentOfTheExactSumOnTheSphere)
{
  for (const int power : { 3, 4 })
  {
    double worst = 0.0;
    for (double exponent = -4.0; exponent <= 5.0; exponent += 0.1)
    {
      const double tau = std::pow(10.0, exponent);
      double sum = 0.0;
      for (double l = 0.0; l < 20000.0; ++l)
      {
        sum += (2.0 * l + 1.0) / std::pow(l * (l + 1.0) + tau, power);
      }
      const double exact = sum / (4.0 * M_PI);
      worst = std::max(worst, std::abs(MarginalVariance(tau, 4.0 * M_PI, 2, true, power) / exact - 1.0));
    }
    EXPECT_LT(worst, 0.06) << "alpha " << power;
  }
}

TEST(MaternField, DirichletIsTheFieldOfTheInnerVertices)
{
  const TriangleMesh mesh = test::PlanePatch(11, 8, 1.5, 1.0, 0.2);
  const std::vector<bool> boundary = BoundaryOf(mesh);
  std::vector<int> inner;
  for (std::size_t v = 0; v < boundary.size(); ++v)
  {
    if (!boundary[v])
    {
      inner.push_back(static_cast<int>(v));
    }
  }
  const Eigen::MatrixXd a = DenseOperator(mesh, 12.0);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  for (int power = 1; power <= 4; ++power)
  {
    MaternFieldOptions options = ByScreening(12.0, power);
    options.Boundary = BoundaryCondition::Dirichlet;
    const MaternField field(mesh, options);
    const Eigen::MatrixXd covariance = Covariance(field);
    ExpectClose(covariance(inner, inner), DenseCovariance(Eigen::MatrixXd(a(inner, inner)), mass(inner), power), 1e-9);
    const Eigen::MatrixXd sample = field.Sample();
    for (std::size_t v = 0; v < boundary.size(); ++v)
    {
      EXPECT_EQ(sample(static_cast<Eigen::Index>(v), 0) == 0.0, boundary[v]) << v;
    }
    // The same from a mask of the same vertices.
    options.Arrays.BoundaryMask = boundary;
    EXPECT_EQ((MaternField(mesh, options).Sample() - sample).cwiseAbs().maxCoeff(), 0.0);
    options.VarianceCorrection = true;
    const Eigen::VectorXd deviations = MaternField(mesh, options).MarginalVariances().cwiseSqrt();
    EXPECT_LE((deviations(inner).array() - 1.0).abs().maxCoeff(), 1e-9);
    EXPECT_EQ(deviations.minCoeff(), 0.0);
  }
}

TEST(MaternField, RobinLiesBetweenNeumannAndDirichlet)
{
  const TriangleMesh mesh = test::PlanePatch(21, 16, 1.5, 1.0, 0.0);
  MaternFieldOptions options = ByRange(0.5);
  const Eigen::VectorXd neumann = MaternField(mesh, options).MarginalVariances();
  options.Boundary = BoundaryCondition::Dirichlet;
  const Eigen::VectorXd dirichlet = MaternField(mesh, options).MarginalVariances();
  options.Boundary = BoundaryCondition::Robin;
  options.RobinCoefficient = 0.0;
  ExpectClose(MaternField(mesh, options).MarginalVariances(), neumann, 1e-12);
  options.RobinCoefficient = 1e9;
  ExpectClose(MaternField(mesh, options).MarginalVariances(), dirichlet, 1e-6);
  options.RobinCoefficient = 1.0;
  const Eigen::VectorXd robin = MaternField(mesh, options).MarginalVariances();
  EXPECT_TRUE((robin.array() < neumann.array()).all());
  EXPECT_TRUE((robin.array() > dirichlet.array()).all());
  // The matrix by hand: sqrt(tau) times the boundary mass on the diagonal.
  Eigen::MatrixXd a = DenseOperator(mesh, 32.0);
  a.diagonal() += std::sqrt(32.0) * BoundaryMass(mesh, MeshTopology(mesh));
  const double amplitude = 1.0 / std::sqrt(MarginalVariance(32.0, 1.5, 1, false));
  ExpectClose(robin, amplitude * amplitude * DenseCovariance(a, LumpedMass(mesh), 2).diagonal(), 1e-9);
  // On a mask: the left side only.
  options.Arrays.BoundaryMask.assign(static_cast<std::size_t>(mesh.NumberOfPoints()), false);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    options.Arrays.BoundaryMask[v] = mesh.Points(v, 0) == 0.0;
  }
  const Eigen::VectorXd left = MaternField(mesh, options).MarginalVariances();
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (mesh.Points(v, 0) == 0.0)
    {
      EXPECT_LT(left[v], 0.8 * neumann[v]);
    }
    if (mesh.Points(v, 0) == 1.5)
    {
      EXPECT_NEAR(left[v], neumann[v], 0.02 * neumann[v]);
    }
  }
}

TEST(MaternField, TheRobinCoefficientSetsTheDeviationAtAStraightBoundary)
{
  // On a half-plane the variance at the boundary over that of the interior is half the integral of 1 / (cosh t + c)^2:
  // 2 for c = 0, 2 / 3 for c = 1, and 1 for c = 0.55.
  // Edges of a thirtieth of the range: lumped mass adds 6 % at the boundary for a fifteenth.
  const TriangleMesh mesh = test::PlanePatch(200, 100, 4.0, 2.0, 0.0);
  Index edge = 0;
  Index inside = 0;
  (mesh.Points.rowwise() - Eigen::RowVector3d(2.0, 0.0, 0.0)).rowwise().norm().minCoeff(&edge);
  (mesh.Points.rowwise() - Eigen::RowVector3d(2.0, 1.0, 0.0)).rowwise().norm().minCoeff(&inside);
  MaternFieldOptions options = ByRange(0.6);
  options.Boundary = BoundaryCondition::Robin;
  for (const auto& [coefficient, ratio] : { std::pair(0.0, 2.0), std::pair(0.55, 1.0), std::pair(1.0, 2.0 / 3.0) })
  {
    options.RobinCoefficient = coefficient;
    const Eigen::VectorXd variances = MaternField(mesh, options).MarginalVariances();
    EXPECT_NEAR(variances[edge] / variances[inside], ratio, 0.03 * ratio) << "c = " << coefficient;
  }
}

TEST(Operators, BoundaryMassSumsToTheLengthOfTheBoundary)
{
  const TriangleMesh patch = test::PlanePatch(7, 5, 1.5, 1.0);
  EXPECT_NEAR(BoundaryMass(patch, MeshTopology(patch)).sum(), 5.0, 1e-12);
  const TriangleMesh sphere = test::Icosphere(2);
  EXPECT_EQ(BoundaryMass(sphere, MeshTopology(sphere)).sum(), 0.0);
}
