// SPDX-License-Identifier: BSD-3-Clause
// Matérn fields of operator powers between the integers, and the rational approximation behind them.
#include "DenseFields.h"
#include "ExampleMeshes.h"
#include "SampleBits.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternField.h"
#include "Core/Noise/RationalPower.h"
#include "Core/Operators/SurfaceOperators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

using namespace surfsynth;
using surfsynth::test::Covariance;
using surfsynth::test::ExpectClose;

namespace
{
constexpr double Tau = 12.0;
constexpr double OfDeviation = 1.01e-4; // the tolerance of the standard deviation at every eigenvalue

MaternFieldOptions ByScreening(double power, double tau = Tau)
{
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  options.Screening = tau;
  options.OperatorPower = power;
  return options;
}

/// M^-1/2 (M^-1/2 A M^-1/2)^-power M^-1/2 by dense eigenvalues.
Eigen::MatrixXd DensePower(const TriangleMesh& mesh, double power)
{
  const Eigen::VectorXd root = LumpedMass(mesh).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd matrix = root.asDiagonal() * Eigen::MatrixXd(CotangentStiffness(mesh)) * root.asDiagonal();
  matrix.diagonal().array() += Tau;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  const Eigen::MatrixXd vectors = root.asDiagonal() * solver.eigenvectors();
  return vectors * solver.eigenvalues().array().pow(-power).matrix().asDiagonal() * vectors.transpose();
}

/// Options that vary a field in each of the ways there are.
std::vector<MaternFieldOptions> Variations(const TriangleMesh& mesh)
{
  std::vector<MaternFieldOptions> variations(5, ByScreening(2.0));
  variations[0].Boundary = BoundaryCondition::Dirichlet;
  variations[1].Boundary = BoundaryCondition::Robin;
  variations[2].Arrays.RangeFactors = 1.0 + 0.5 * (3.0 * mesh.Points.col(0).array()).sin();
  variations[3].Arrays.Directions = PointMatrix::Ones(mesh.NumberOfPoints(), 3);
  variations[4].Arrays.Barrier.assign(static_cast<std::size_t>(mesh.NumberOfTriangles()), false);
  for (std::size_t f = 0; f < 20; ++f)
  {
    variations[4].Arrays.Barrier[f] = true;
  }
  return variations;
}

class FractionalField : public testing::TestWithParam<double>
{};

INSTANTIATE_TEST_SUITE_P(Powers, FractionalField, testing::Values(1.5, 2.5, 3.5),
  [](const auto& info) { return std::to_string(static_cast<int>(10.0 * info.param)); });
} // namespace

TEST(RationalPower, HasPositiveTermsAndALevelErrorOnTheInterval)
{
  for (const double power : { 0.001, 0.25, 0.5, 0.75, 0.999 })
  {
    for (const double ratio : { 30.0, 3e4, 1e8 })
    {
      const RationalPower r = ApproximateInversePower(power, 2.0, 2.0 * ratio, 5);
      int extrema = 1;
      double largest = 0.0;
      double last = 0.0;
      for (double t = 0.0; t <= 1.0; t += 1e-4)
      {
        const double x = 2.0 * std::pow(ratio, 0.5 - 0.5 * std::cos(M_PI * t));
        const double error = std::pow(x, power) * r(x) - 1.0;
        largest = std::max(largest, std::abs(error));
        extrema += last * error < 0.0 ? 1 : 0;
        last = error;
      }
      EXPECT_NEAR(largest, r.RelativeError, 0.01 * r.RelativeError) << power << " " << ratio;
      EXPECT_EQ(extrema, 11) << power << " " << ratio; // the error of the best approximation has 2 K + 1 extrema
      for (int k = 0; k < 5; ++k)
      {
        EXPECT_GT(r.Weights[static_cast<std::size_t>(k)], 0.0);
        EXPECT_GT(r.Shifts[static_cast<std::size_t>(k)], 0.0);
      }
    }
  }
}

TEST(RationalPower, ErrorsFallAsTheTableOfTheDocumentationSays)
{
  // The bound 4 sin(pi s) exp(-2 pi^2 K / log(16 ratio)), 1.2 times it at most, and the tolerance with the fewest terms.
  std::cout << "power ratio terms: relative error of the standard deviation\n";
  for (const double power : { 0.25, 0.75 })
  {
    for (const double ratio : { 300.0, 3e4, 3e6 })
    {
      for (int terms = 2; terms <= 10; terms += 2)
      {
        const double error = ApproximateInversePower(power, 1.0, ratio, terms).RelativeError;
        std::cout << power << " " << ratio << " " << terms << ": " << error << "\n";
        const double bound = 4.0 * std::sin(M_PI * power) *
          std::exp(-2.0 * M_PI * M_PI * terms / std::log(16.0 * ratio));
        EXPECT_LT(error, 1.2 * bound);
      }
      const RationalPower fewest = ApproximateInversePowerTo(1e-4, power, 1.0, ratio);
      EXPECT_LE(fewest.RelativeError, 1e-4);
      EXPECT_GT(ApproximateInversePower(power, 1.0, ratio, fewest.NumberOfTerms() - 1).RelativeError, 1e-4);
    }
  }
}

TEST(RationalPower, RefusesWhatIsOutOfRange)
{
  EXPECT_THROW(ApproximateInversePower(0.0, 1.0, 2.0, 3), InvalidInput);
  EXPECT_THROW(ApproximateInversePower(1.0, 1.0, 2.0, 3), InvalidInput);
  EXPECT_THROW(ApproximateInversePower(0.5, 0.0, 2.0, 3), InvalidInput);
  EXPECT_THROW(ApproximateInversePower(0.5, 2.0, 2.0, 3), InvalidInput);
  EXPECT_THROW(ApproximateInversePower(0.5, 1.0, 2.0, 33), InvalidInput);
  EXPECT_THROW(ApproximateInversePowerTo(0.0, 0.5, 1.0, 2.0), InvalidInput);
}

TEST_P(FractionalField, HasTheCovarianceOfTheDensePowerOfTheOperator)
{
  const TriangleMesh mesh = test::PlanePatch(11, 8, 1.5, 1.0, 0.2);
  const MaternField field(mesh, ByScreening(GetParam()));
  const Eigen::MatrixXd covariance = Covariance(field);
  ExpectClose(covariance, DensePower(mesh, GetParam()), 2.0 * OfDeviation);
  ExpectClose(field.MarginalVariances(), covariance.diagonal(), 1e-9);
  EXPECT_EQ(field.Smoothness(), GetParam() - 1.0);
}

TEST_P(FractionalField, SphericalHarmonicsHaveTheVarianceOfTheExactLaw)
{
  // Zonal harmonics P_l(z) of the unit sphere have the eigenvalue l (l + 1): their standard deviation within 1 %.
  const TriangleMesh mesh = test::Icosphere(5);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const MaternField field(mesh, ByScreening(GetParam()));
  for (const unsigned degree : { 0U, 1U, 2U, 4U, 8U })
  {
    Eigen::VectorXd harmonic(mesh.NumberOfPoints());
    for (Eigen::Index v = 0; v < harmonic.size(); ++v)
    {
      harmonic[v] = std::legendre(degree, mesh.Points(v, 2));
    }
    const Eigen::VectorXd weighted = mass.asDiagonal() * harmonic;
    const double variance = weighted.dot(field.SolvePrecision(weighted).col(0)) / weighted.dot(harmonic);
    const double exact = std::pow(degree * (degree + 1.0) + Tau, -GetParam());
    EXPECT_NEAR(std::sqrt(variance / exact), 1.0, 0.01) << degree;
    RecordProperty("ratio_" + std::to_string(degree), std::to_string(std::sqrt(variance / exact)));
  }
}

TEST(FractionalFieldLimit, NextToAnIntegerIsTheExactFieldWithEveryVariation)
{
  const TriangleMesh mesh = test::PlanePatch(11, 8, 1.5, 1.0, 0.2);
  for (MaternFieldOptions options : Variations(mesh))
  {
    for (const double power : { 2.0, 3.0 })
    {
      options.OperatorPower = power;
      const MaternField exact(mesh, options);
      for (const double step : { -1e-6, 1e-6 })
      {
        options.OperatorPower = power + step;
        const MaternField field(mesh, options);
        ExpectClose(Covariance(field), Covariance(exact), 2.0 * OfDeviation);
        if (power == 2.0) // the same white noise
        {
          ExpectClose(field.Sample(), exact.Sample(), 10.0 * OfDeviation);
        }
      }
    }
  }
}

TEST_P(FractionalField, CorrectedDeviationIsExactOnAnOpenThinTube)
{
  MaternFieldOptions options;
  options.CorrelationRange = 0.6;
  options.OperatorPower = GetParam();
  options.StandardDeviation = 2.5;
  options.VarianceCorrection = true;
  const MaternField field(test::OpenCylinder(12, 60, 0.15, 2.0), options);
  const Eigen::VectorXd deviations = Covariance(field).diagonal().cwiseSqrt();
  EXPECT_NEAR(deviations.minCoeff(), 2.5, 1e-8);
  EXPECT_NEAR(deviations.maxCoeff(), 2.5, 1e-8);
  // The sum of squares of 2,000 samples: bounds as in TestMaternAlgebra.cxx.
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(deviations.size());
  SampleRequest request;
  request.NumberOfSamples = 2000;
  field.Sample(request,
    [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& z) { squares += z.col(0).cwiseAbs2() / 2000.0; });
  EXPECT_LE(std::sqrt(squares.maxCoeff()), 1.085 * 2.5);
  EXPECT_GE(std::sqrt(squares.minCoeff()), 0.915 * 2.5);
  EXPECT_NEAR(std::sqrt(squares.mean()), 2.5, 0.02 * 2.5);
}

TEST_P(FractionalField, MeanAndDeviationGivenObservationsAreThoseOfDenseKriging)
{
  const TriangleMesh mesh = test::PlanePatch(11, 8, 1.5, 1.0, 0.2);
  const MaternField field(mesh, ByScreening(GetParam()));
  SparseRowMatrix matrix(12, mesh.NumberOfPoints()); // every seventh vertex, and the middle of an edge
  for (Index k = 0; k < 12; ++k)
  {
    matrix.insert(k, 7 * k) = k < 11 ? 1.0 : 0.5;
  }
  matrix.insert(11, 78) = 0.5;
  Eigen::VectorXd deviations = Eigen::VectorXd::Zero(12);
  deviations.tail(6).setConstant(0.01);
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(12, -0.2, 0.3);
  const FieldConditioning conditioning(
    [&field](const auto& x) { return field.SolvePrecision(x); }, matrix, deviations, std::uint64_t(1) << 30);
  const auto expectKriging = [&](const Eigen::MatrixXd& covariance, double tolerance) {
    const Eigen::MatrixXd cross = covariance * matrix.transpose();
    const Eigen::MatrixXd system = matrix * cross + Eigen::MatrixXd(deviations.cwiseAbs2().asDiagonal());
    const Eigen::MatrixXd gain = system.ldlt().solve(cross.transpose()).transpose();
    ExpectClose(conditioning.Mean(values), gain * values, tolerance);
    const Eigen::VectorXd variance = covariance.diagonal() - gain.cwiseProduct(cross).rowwise().sum();
    EXPECT_LE((conditioning.Variance(field.MarginalVariances()) - variance).cwiseAbs().maxCoeff(),
      tolerance * covariance.diagonal().maxCoeff());
  };
  expectKriging(Covariance(field), 1e-8);
  expectKriging(DensePower(mesh, GetParam()), 10.0 * OfDeviation); // the approximation of the power in it
}

TEST_P(FractionalField, HasTheDeviationAskedForOnSpheresOfEveryRange)
{
  // Mean over the surface; edges are at most an eighth of the range, as in TestMaternAlgebra.cxx.
  const TriangleMesh mesh = test::Icosphere(4);
  for (const double range : { 0.6, 1.0, 4.0, 30.0 })
  {
    MaternFieldOptions options;
    options.CorrelationRange = range;
    options.OperatorPower = GetParam();
    const double deviation = std::sqrt(MaternField(mesh, options).MarginalVariances().mean());
    EXPECT_NEAR(deviation, 1.0, 0.05) << range;
    RecordProperty("range_" + std::to_string(range), std::to_string(deviation));
  }
}

TEST_P(FractionalField, VarianceOnTheSphereIsWithin6PerCentOfTheExactSum)
{
  const double power = GetParam();
  for (double exponent = -4.0; exponent <= 5.0; exponent += 0.25)
  {
    const double tau = std::pow(10.0, exponent);
    double sum = 0.0;
    double degree = 0.0;
    for (; degree < 20000.0; ++degree)
    {
      sum += (2.0 * degree + 1.0) / std::pow(degree * (degree + 1.0) + tau, power);
    }
    sum += std::pow(degree * degree + tau, 1.0 - power) / (power - 1.0); // the rest, as an integral
    EXPECT_NEAR(MarginalVariance(tau, 4.0 * M_PI, 2, true, power) / (sum / (4.0 * M_PI)), 1.0, 0.06) << tau;
  }
}

TEST_P(FractionalField, ASampleHasTheSameBitsAloneInABatchAndForEveryNumberOfThreads)
{
  test::ExpectSameBitsAloneAndInABatch(test::Icosphere(3), ByScreening(GetParam()), 2);
}

TEST_P(FractionalField, SamplesAreThoseOfTheFactorWithMultigrid)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  MaternFieldOptions options = ByScreening(GetParam());
  const Eigen::MatrixXd expected = MaternField(mesh, options).Sample();
  options.FactorMemoryLimit = 1;
  const MaternField field(mesh, options);
  EXPECT_STREQ(field.SolverName(), "Multigrid");
  EXPECT_LE((field.Sample() - expected).norm(), 1e-8 * expected.norm());
  EXPECT_GT(field.Iterations(), 2);
  EXPECT_LE(field.RelativeResidual(), 1.001e-10);
  EXPECT_THROW(field.MarginalVariances(), InvalidInput);
}

TEST_P(FractionalField, RefusesPrecisionAndDeterminants)
{
  const TriangleMesh mesh = test::Icosphere(2);
  const MaternField field(mesh, ByScreening(GetParam()));
  EXPECT_THROW(field.ApplyPrecision(Eigen::MatrixXd::Ones(mesh.NumberOfPoints(), 1)), InvalidInput);
  EXPECT_THROW(field.LogDeterminantOfPrecision(), InvalidInput);
}

TEST(FractionalFieldRange, PowersBetweenHalfTheDimensionAndFourHaveARange)
{
  const TriangleMesh mesh = test::Icosphere(2);
  MaternFieldOptions options;
  for (const double power : { 0.99, 1.0, 4.01, std::nan("") })
  {
    options.OperatorPower = power;
    EXPECT_THROW(MaternField(mesh, options), InvalidInput) << power;
  }
  options.OperatorPower = 1.25;
  EXPECT_TRUE(MaternField(mesh, options).Sample().allFinite());
}

TEST(FractionalFieldRange, CoherentNoiseTakesFractions)
{
  MaternFieldOptions options;
  options.CoherentNoise = true;
  options.OperatorPower = 2.0;
  const TriangleMesh mesh = test::Icosphere(3);
  const Eigen::MatrixXd expected = MaternField(mesh, options).Sample();
  options.OperatorPower = 2.000001;
  ExpectClose(MaternField(mesh, options).Sample(), expected, 10.0 * OfDeviation);
}

TEST(FractionalFieldRange, ARangeFarAboveTheMeshIsNamed)
{
  MaternFieldOptions options;
  options.OperatorPower = 2.5;
  options.Mode = ScaleMode::CorrelationRange;
  options.CorrelationRange = 1e30;
  std::string message;
  try
  {
    const MaternField field(test::Icosphere(2), options);
  }
  catch (const SolverFailure& error)
  {
    message = error.what();
  }
  EXPECT_NE(message.find("the operator power 2.5"), std::string::npos) << message;
  EXPECT_NE(message.find("smaller correlation range"), std::string::npos) << message;
}
