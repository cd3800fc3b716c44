// SPDX-License-Identifier: BSD-3-Clause
// The statistics of the spectral coefficients f^T M phi_i over 2,000 samples on three triangulations of one surface.
//
// With expected standard deviation s_i, x = f^T M phi_i / s_i is N(0, 1), independent over i and samples:
//  - the sum of x^2 over n samples is chi-square with n degrees of freedom, for each i. Bound: the two-sided quantile
//    of probability 1e-4 / 100 (Bonferroni over 100 coefficients), z = 4.89: +- 15.5 % at n = 2,000;
//  - so is the sum over all coefficients, with 100 n degrees. Bound: z = 4, +- 1.3 %;
//  - sqrt(n) times the correlation of two coefficients is about N(0, 1). Bound: 1e-4 / 4,950 pairs, z = 5.61;
//  - n times the sum of the squared correlations is about chi-square with 4,950 degrees. Bound: z = 4;
//  - sqrt(n) times the mean of x is N(0, 1). Bound: z = 4.89.
#include "ExampleMeshes.h"
#include "SpectralSamples.h"

#include "Core/Noise/MaternField.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

using namespace surfsynth;

namespace
{

constexpr Index Coefficients = 100;
constexpr std::uint32_t Samples = 2000;
constexpr double Tau = 100.0; // as in the paper, on a surface of longest side 1

MaternFieldOptions Options(NoiseModel model, double tau = Tau)
{
  MaternFieldOptions options;
  options.Model = model;
  options.Mode = ScaleMode::Screening;
  options.Screening = tau;
  options.NumberOfEigenpairs = Coefficients;
  return options;
}

/// A triangulation with its eigenpairs, which are computed once.
const test::SpectralSurface& SurfaceOf(int triangulation)
{
  static std::map<int, test::SpectralSurface> surfaces;
  const auto found = surfaces.find(triangulation);
  return found != surfaces.end()
    ? found->second
    : surfaces.emplace(triangulation, test::WithEigenpairs("", test::Triangulation(triangulation), Coefficients))
        .first->second;
}

class SpectrumOf : public testing::TestWithParam<int>
{
protected:
  const test::SpectralSurface& Surface = SurfaceOf(GetParam());

  Eigen::MatrixXd Draw(const MaternFieldOptions& options) const
  {
    SampleRequest request;
    request.Seed = 2025U + static_cast<unsigned>(GetParam());
    request.NumberOfSamples = Samples;
    return test::SpectralCoefficients(MaternField(this->Surface.Mesh, options), this->Surface, request);
  }
};

/// The bounds at the head of this file; @p deviations are the expected standard deviations of the rows.
void ExpectIndependentNormals(const Eigen::MatrixXd& coefficients, const Eigen::VectorXd& deviations)
{
  const Eigen::MatrixXd x = deviations.cwiseInverse().asDiagonal() * coefficients;
  const auto count = static_cast<double>(x.rows());
  const auto n = static_cast<double>(x.cols());
  const Eigen::VectorXd squares = x.rowwise().squaredNorm();
  for (Eigen::Index i = 0; i < x.rows(); ++i)
  {
    EXPECT_GT(squares[i], test::ChiSquareQuantile(n, -4.89)) << "variance of coefficient " << i;
    EXPECT_LT(squares[i], test::ChiSquareQuantile(n, 4.89)) << "variance of coefficient " << i;
    EXPECT_LT(std::abs(x.row(i).mean()) * std::sqrt(n), 4.89) << "mean of coefficient " << i;
  }
  EXPECT_GT(squares.sum(), test::ChiSquareQuantile(count * n, -4.0)) << "all variances are too small";
  EXPECT_LT(squares.sum(), test::ChiSquareQuantile(count * n, 4.0)) << "all variances are too large";
  const Eigen::MatrixXd gram = x * x.transpose();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
  {
    for (Eigen::Index j = 0; j < i; ++j)
    {
      const double correlation = gram(i, j) / std::sqrt(gram(i, i) * gram(j, j));
      EXPECT_LT(std::abs(correlation) * std::sqrt(n), 5.61) << "coefficients " << i << " and " << j;
      sum += n * correlation * correlation;
    }
  }
  const double pairs = count * (count - 1.0) / 2.0;
  EXPECT_GT(sum, test::ChiSquareQuantile(pairs, -4.0)) << "correlations";
  EXPECT_LT(sum, test::ChiSquareQuantile(pairs, 4.0)) << "correlations";
}

INSTANTIATE_TEST_SUITE_P(Triangulations, SpectrumOf, testing::Values(0, 1, 2), [](const auto& info) {
  return std::string(info.param == 0 ? "Coarse" : info.param == 1 ? "Medium" : "Fine");
});

} // namespace

TEST_P(SpectrumOf, MaternHasVarianceOneOverLambdaPlusTauSquared)
{
  ExpectIndependentNormals(
    this->Draw(Options(NoiseModel::Matern)), (this->Surface.Pairs.Values.array() + Tau).inverse().matrix());
}

TEST_P(SpectrumOf, MaternWithSmallScreeningHasTheSameLaw)
{
  ExpectIndependentNormals(
    this->Draw(Options(NoiseModel::Matern, 0.5)), (this->Surface.Pairs.Values.array() + 0.5).inverse().matrix());
}

TEST_P(SpectrumOf, MaternOfPowerAlphaHasVarianceOneOverLambdaPlusTauToThePowerAlpha)
{
  for (const double power : { 1.0, 1.5, 2.5, 3.0, 3.5, 4.0 })
  {
    SCOPED_TRACE("alpha " + std::to_string(power));
    MaternFieldOptions options = Options(NoiseModel::Matern);
    options.OperatorPower = power;
    ExpectIndependentNormals(
      this->Draw(options), (this->Surface.Pairs.Values.array() + Tau).pow(-0.5 * power).matrix());
  }
}

TEST(MaternSpectrum, SpectralOfPowerAlphaHasTheSameVariance)
{
  const test::SpectralSurface& surface = SurfaceOf(0);
  for (const double power : { 1.0, 2.5, 3.0, 4.0 })
  {
    SCOPED_TRACE("alpha " + std::to_string(power));
    MaternFieldOptions options = Options(NoiseModel::Spectral);
    options.OperatorPower = power;
    SampleRequest request;
    request.NumberOfSamples = Samples;
    const Eigen::MatrixXd coefficients = test::SpectralCoefficients(
      MaternField(surface.Mesh, options), surface, request);
    ExpectIndependentNormals(coefficients, (surface.Pairs.Values.array() + Tau).pow(-0.5 * power).matrix());
  }
}

TEST_P(SpectrumOf, CoherentMaternHasTheSameLaw)
{
  MaternFieldOptions options = Options(NoiseModel::Matern);
  options.CoherentNoise = true;
  ExpectIndependentNormals(this->Draw(options), (this->Surface.Pairs.Values.array() + Tau).inverse().matrix());
}

TEST_P(SpectrumOf, WhiteHasVarianceOne)
{
  ExpectIndependentNormals(this->Draw(Options(NoiseModel::White)), Eigen::VectorXd::Ones(Coefficients));
}

TEST_P(SpectrumOf, UnscreenedHasVarianceOneOverLambdaSquaredAndNoConstant)
{
  const Eigen::MatrixXd coefficients = this->Draw(Options(NoiseModel::Unscreened));
  const Eigen::Index rest = Coefficients - 1;
  ExpectIndependentNormals(coefficients.bottomRows(rest), this->Surface.Pairs.Values.tail(rest).cwiseInverse());
  EXPECT_LE(coefficients.row(0).cwiseAbs().maxCoeff(), 1e-10 * coefficients.row(1).cwiseAbs().maxCoeff());
}

TEST_P(SpectrumOf, SpectralHasTheSameVarianceAndNothingBeyondItsEigenpairs)
{
  MaternFieldOptions options = Options(NoiseModel::Spectral);
  options.NumberOfEigenpairs = 60;
  const Eigen::MatrixXd coefficients = this->Draw(options);
  ExpectIndependentNormals(
    coefficients.topRows(60), (this->Surface.Pairs.Values.head(60).array() + Tau).inverse().matrix());
  EXPECT_LE(coefficients.bottomRows(Coefficients - 60).cwiseAbs().maxCoeff(),
    1e-7 * coefficients.topRows(60).cwiseAbs().maxCoeff());
}

TEST_P(SpectrumOf, PerVertexHasTheVarianceOfItsTriangulation)
{
  // phi_i^T M^2 phi_i: proportional to the area of a vertex, so to one over the number of vertices. The coefficients
  // are correlated on uneven meshes, so only the variances are held against it.
  MaternFieldOptions options;
  options.Model = NoiseModel::PerVertex;
  const Eigen::MatrixXd coefficients = this->Draw(options);
  const Eigen::MatrixXd weighted = this->Surface.Mass.asDiagonal() * this->Surface.Pairs.Vectors;
  for (Index i = 0; i < Coefficients; ++i)
  {
    const double ratio = coefficients.row(i).squaredNorm() / weighted.col(i).squaredNorm();
    EXPECT_GT(ratio, test::ChiSquareQuantile(Samples, -4.89)) << i;
    EXPECT_LT(ratio, test::ChiSquareQuantile(Samples, 4.89)) << i;
  }
}

TEST(MaternSpectrum, AgreesBetweenTriangulationsWhereIidNoiseDoesNot)
{
  // Expected standard deviations, free of sampling error: 1 / (lambda + tau) differs by the discretisation of the
  // surface only, sqrt(phi^T M^2 phi) by the square root of the ratio of the numbers of vertices.
  const test::SpectralSurface& coarse = SurfaceOf(0);
  const test::SpectralSurface& fine = SurfaceOf(2);
  const double refinement = std::sqrt(
    static_cast<double>(fine.Mesh.NumberOfPoints()) / static_cast<double>(coarse.Mesh.NumberOfPoints()));
  ASSERT_GT(refinement, 3.0);
  for (Index i = 0; i < Coefficients; ++i)
  {
    const double ours = (fine.Pairs.Values[i] + Tau) / (coarse.Pairs.Values[i] + Tau);
    EXPECT_NEAR(ours, 1.0, 0.06) << i;
    const double iid = (coarse.Mass.asDiagonal() * coarse.Pairs.Vectors.col(i)).norm() /
      (fine.Mass.asDiagonal() * fine.Pairs.Vectors.col(i)).norm();
    EXPECT_GT(iid, 0.6 * refinement) << i;
  }
}
