// SPDX-License-Identifier: BSD-3-Clause
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Statistics/EnsembleStatistics.h"
#include "Core/Statistics/ShapeModel.h"

#include <Eigen/SVD>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace surfsynth;
using surfsynthtest::TextOf;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int Components = 3;

/// Correlated samples [N, 3 V] about values of the size of @p offset.
Samples MakeSamples(int samples, int points, double offset = 10.0)
{
  Samples values(samples, points * Components);
  for (int k = 0; k < samples; ++k)
  {
    NormalKey key;
    key.Sample = static_cast<std::uint32_t>(k);
    Eigen::VectorXd row(values.cols());
    FillNormals(key, 0, row.size(), row.data());
    Eigen::Vector4d common;
    key.Component = 1;
    FillNormals(key, 0, 4, common.data());
    for (Eigen::Index c = 0; c < row.size(); ++c)
    {
      const double place = static_cast<double>(c) / static_cast<double>(row.size());
      row[c] = offset + 0.1 * row[c] + 3.0 * common[0] * std::sin(7.0 * place) + common[1] * std::cos(4.0 * place);
    }
    values.row(k) = row;
  }
  return values;
}

std::vector<SampleValues> Rows(const Samples& samples)
{
  std::vector<SampleValues> rows;
  for (Eigen::Index k = 0; k < samples.rows(); ++k)
  {
    rows.emplace_back(static_cast<const double*>(&samples(k, 0)));
  }
  return rows;
}

EnsembleStatistics Compute(const Samples& samples, const EnsembleStatisticsOptions& options = {})
{
  return ComputeEnsembleStatistics(Rows(samples), samples.cols() / Components, Components, options);
}

/// Quantile by the definition of NumPy's default, "linear".
double Quantile(Eigen::VectorXd values, double probability)
{
  std::sort(values.begin(), values.end());
  const double place = probability * static_cast<double>(values.size() - 1);
  const auto below = static_cast<Eigen::Index>(std::floor(place));
  const double above = values[std::min(below + 1, values.size() - 1)];
  return values[below] + (above - values[below]) * (place - std::floor(place));
}

EnsembleStatisticsOptions Everything()
{
  EnsembleStatisticsOptions options;
  options.Quantiles = { 0.0, 0.05, 0.5, 0.9, 1.0 };
  options.NumberOfModes = -1;
  return options;
}
} // namespace

TEST(EnsembleStatistics, AgreesWithDenseMoments)
{
  const Samples samples = MakeSamples(23, 3001); // several tiles, the last one not full
  const EnsembleStatistics found = Compute(samples, Everything());
  for (Eigen::Index c = 0; c < samples.cols(); c += 7)
  {
    const Eigen::VectorXd values = samples.col(c);
    const double mean = values.mean();
    const double deviation = std::sqrt((values.array() - mean).square().sum() / 22.0);
    EXPECT_NEAR(found.Mean[c], mean, 1e-12);
    EXPECT_NEAR(found.StandardDeviation[c], deviation, 1e-12);
    for (int q = 0; q < 5; ++q)
    {
      EXPECT_NEAR(found.Quantiles(c, q), Quantile(values, Everything().Quantiles[static_cast<std::size_t>(q)]), 1e-12);
    }
  }
}

TEST(EnsembleStatistics, ModesAreTheSingularVectorsOfTheDeviations)
{
  const Samples samples = MakeSamples(17, 701);
  const EnsembleStatistics found = Compute(samples, Everything());
  const Eigen::MatrixXd deviations = samples.rowwise() - samples.colwise().mean();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(deviations, Eigen::ComputeThinU | Eigen::ComputeThinV);
  ASSERT_EQ(found.Variances.size(), 16) << "N - 1 modes";
  for (Eigen::Index k = 0; k < 16; ++k)
  {
    const double sigma = svd.singularValues()[k];
    EXPECT_NEAR(found.Variances[k], sigma * sigma / 16.0, 1e-10 * found.Variances[0]);
    const Eigen::VectorXd mode = svd.matrixV().col(k) * sigma / 4.0;
    const double sign = mode.dot(found.Modes.col(k)) > 0.0 ? 1.0 : -1.0;
    EXPECT_LT((mode * sign - found.Modes.col(k)).norm(), 1e-9 * found.Modes.col(0).norm()) << k;
  }
  EXPECT_NEAR(found.TotalVariance, deviations.squaredNorm() / 16.0, 1e-10 * found.TotalVariance);
  EXPECT_NEAR(found.Variances.sum(), found.TotalVariance, 1e-10 * found.TotalVariance);
}

TEST(EnsembleStatistics, CoefficientsGiveTheSamplesBack)
{
  const Samples samples = MakeSamples(9, 200);
  const EnsembleStatistics found = Compute(samples, Everything());
  const Eigen::MatrixXd rebuilt = (found.Coefficients * found.Modes.transpose()).rowwise() + found.Mean.transpose();
  EXPECT_LT((rebuilt - samples).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT(found.Coefficients.colwise().mean().cwiseAbs().maxCoeff(), 1e-10);
  const Eigen::MatrixXd covariance = found.Coefficients.transpose() * found.Coefficients / 8.0;
  EXPECT_LT((covariance - Eigen::MatrixXd::Identity(8, 8)).cwiseAbs().maxCoeff(), 1e-10);
  for (Eigen::Index k = 0; k < 8; ++k)
  {
    EXPECT_GT(found.Coefficients.col(k).maxCoeff(), -found.Coefficients.col(k).minCoeff() - 1e-12) << "sign of a mode";
  }
}

TEST(EnsembleStatistics, ValuesFarFromZeroKeepTheirDeviations)
{
  const Samples near = MakeSamples(12, 50, 0.0);
  const Samples far = near.array() + 1e6;
  const Eigen::VectorXd expected = Compute(near).StandardDeviation;
  EXPECT_LT((Compute(far).StandardDeviation - expected).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(EnsembleStatistics, SinglePrecisionIsWidened)
{
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> single = MakeSamples(6, 40).cast<float>();
  std::vector<SampleValues> rows;
  for (Eigen::Index k = 0; k < 6; ++k)
  {
    rows.emplace_back(static_cast<const float*>(&single(k, 0)));
  }
  const EnsembleStatistics found = ComputeEnsembleStatistics(rows, 40, Components, Everything());
  const EnsembleStatistics expected = Compute(single.cast<double>(), Everything());
  EXPECT_EQ(found.StandardDeviation, expected.StandardDeviation);
  EXPECT_EQ(found.Modes, expected.Modes);
}

TEST(EnsembleStatistics, SameBitsForAllNumbersOfThreads)
{
  const Samples samples = MakeSamples(40, 5000);
  EnsembleStatistics first;
  for (int threads = 1; threads <= 4; ++threads)
  {
    const ThreadScope scope(threads);
    const EnsembleStatistics found = Compute(samples, Everything());
    first = threads == 1 ? found : first;
    EXPECT_EQ(found.Mean, first.Mean);
    EXPECT_EQ(found.StandardDeviation, first.StandardDeviation);
    EXPECT_EQ(found.Quantiles, first.Quantiles);
    EXPECT_EQ(found.Modes, first.Modes);
    EXPECT_EQ(found.Coefficients, first.Coefficients);
  }
}

TEST(EnsembleStatistics, RunningMomentsAgree)
{
  const Samples samples = MakeSamples(31, 90, 1e3);
  RunningMoments running;
  for (const SampleValues& row : Rows(samples))
  {
    running.Add(row, samples.cols(), Components);
  }
  const EnsembleStatistics expected = Compute(samples);
  EXPECT_LT((running.Finish().Mean - expected.Mean).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((running.Finish().StandardDeviation - expected.StandardDeviation).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(EnsembleStatistics, EqualSamplesHaveNoModes)
{
  const Samples samples = MakeSamples(1, 20).replicate(5, 1);
  const EnsembleStatistics found = Compute(samples, Everything());
  EXPECT_EQ(found.Modes.cols(), 0);
  EXPECT_EQ(found.StandardDeviation.maxCoeff(), 0.0);
  EXPECT_EQ(found.Mean, samples.row(0).transpose());
}

TEST(EnsembleStatistics, RefusesWhatHasNoStatistics)
{
  EXPECT_THAT(TextOf<InvalidInput>([] { Compute(MakeSamples(1, 20)); }), HasSubstr("1 sample; expected at least 2"));
  Samples samples = MakeSamples(4, 20);
  samples(2, 3 * 7 + 1) = std::numeric_limits<double>::quiet_NaN();
  samples(3, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { Compute(samples); }), HasSubstr("sample 2 has a value that is not finite at point 7"));
  EnsembleStatisticsOptions options;
  options.Quantiles = { 1.5 };
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { Compute(MakeSamples(4, 20), options); }), HasSubstr("probability of a quantile is 1.5"));
  EXPECT_THAT(TextOf<InvalidInput>([&] { Compute(MakeSamples(4, 20) * 1e200); }), HasSubstr("not finite"));
  RunningMoments running;
  EXPECT_THAT(TextOf<InvalidInput>([&] { running.Finish(); }), HasSubstr("0 samples"));
  EXPECT_THROW(
    ComputeEnsembleStatistics(Rows(MakeSamples(3, 5000)), 5000, Components, {}, [](double) { return false; }),
    Cancelled);
}

TEST(ShapeModel, ProjectionOfAShapeOfTheModelIsItsCoefficients)
{
  const EnsembleStatistics found = Compute(MakeSamples(12, 300), Everything());
  const ShapeModel model(found.Mean, found.Modes.leftCols(5));
  const Eigen::VectorXd coefficients = model.RandomCoefficients(7, 3);
  EXPECT_LT((model.Project(model.Shape(coefficients)) - coefficients).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(model.Shape(Eigen::VectorXd()), found.Mean);
  EXPECT_LT((model.StandardDeviations() - found.Variances.head(5).cwiseSqrt()).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(ShapeModel, ProjectionIsTheNearestShape)
{
  const Samples samples = MakeSamples(12, 300);
  const EnsembleStatistics found = Compute(samples, Everything());
  const ShapeModel model(found.Mean, found.Modes.leftCols(3));
  const Eigen::VectorXd shape = samples.row(4);
  const Eigen::VectorXd difference = shape - model.Shape(model.Project(shape));
  EXPECT_LT((found.Modes.leftCols(3).transpose() * difference).cwiseAbs().maxCoeff(), 1e-8)
    << "orthogonal to the modes";
}

TEST(ShapeModel, RandomShapesHaveTheVarianceOfTheEnsemble)
{
  const EnsembleStatistics found = Compute(MakeSamples(30, 40), Everything());
  const ShapeModel model(found.Mean, found.Modes);
  const int count = 4000;
  Samples shapes(count, found.Mean.size());
  for (int k = 0; k < count; ++k)
  {
    shapes.row(k) = model.Shape(model.RandomCoefficients(1, static_cast<std::uint32_t>(k)));
  }
  const EnsembleStatistics made = Compute(shapes);
  const double tolerance = 5.0 / std::sqrt(2.0 * count); // of a standard deviation, 5 sigma
  EXPECT_LT(((made.StandardDeviation.array() / found.StandardDeviation.array()) - 1.0).abs().maxCoeff(), tolerance);
  EXPECT_EQ(model.RandomCoefficients(1, 2), model.RandomCoefficients(1, 2));
  EXPECT_NE(model.RandomCoefficients(1, 2), model.RandomCoefficients(2, 2));
  EXPECT_NE(model.RandomCoefficients(1, 2), model.RandomCoefficients(1, 3));
}

TEST(ShapeModel, RefusesWhatIsNoModel)
{
  const Eigen::VectorXd mean = Eigen::VectorXd::Zero(6);
  const Eigen::MatrixXd modes = Eigen::MatrixXd::Identity(6, 2);
  EXPECT_THAT(TextOf<InvalidInput>([&] { ShapeModel(mean, Eigen::MatrixXd::Ones(6, 2)); }), HasSubstr("orthogonal"));
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { ShapeModel(mean, Eigen::MatrixXd::Zero(6, 1)); }), HasSubstr("mode 0 is zero"));
  EXPECT_THAT(TextOf<InvalidInput>([&] { ShapeModel(mean.head(3), modes); }), HasSubstr("same number"));
  const ShapeModel model(mean, modes);
  EXPECT_THAT(TextOf<InvalidInput>([&] { model.Shape(Eigen::VectorXd::Ones(3)); }),
    AllOf(HasSubstr("3 coefficients"), HasSubstr("at most 2")));
  EXPECT_THAT(TextOf<InvalidInput>([&] { model.Project(Eigen::VectorXd::Ones(3)); }), HasSubstr("3 values"));
}
