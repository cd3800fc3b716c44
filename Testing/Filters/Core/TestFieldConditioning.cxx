// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Dense>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

using namespace surfsynth;
using surfsynthtest::TextOf;
using testing::HasSubstr;

namespace
{
constexpr double Range = 0.8;
constexpr double Deviation = 1.7;
constexpr std::uint64_t Unlimited = std::uint64_t(1) << 40;

/// A field on a small surface, with its covariance as a dense matrix from the operators.
class FieldConditioningOnSurface : public testing::Test
{
protected:
  const TriangleMesh Mesh = test::BumpySurface(3);
  const MaternField Field = MakeField(this->Mesh);
  const Eigen::MatrixXd Dense = this->DenseCovariance();

  static MaternField MakeField(const TriangleMesh& mesh)
  {
    MaternFieldOptions options;
    options.CorrelationRange = Range;
    options.StandardDeviation = Deviation;
    return MaternField(mesh, options);
  }

  /// sigma^2 / v A^-1 M A^-1 with A = L + tau M and v = MarginalVariance().
  Eigen::MatrixXd DenseCovariance() const
  {
    const double tau = 8.0 / (Range * Range);
    const Eigen::VectorXd mass = LumpedMass(this->Mesh);
    const Eigen::MatrixXd matrix = Eigen::MatrixXd(CotangentStiffness(this->Mesh)) +
      Eigen::MatrixXd((tau * mass).asDiagonal());
    const Eigen::MatrixXd inverse = matrix.inverse();
    const double variance = MarginalVariance(tau, mass.sum(), 2, true);
    return Deviation * Deviation / variance * inverse * mass.asDiagonal() * inverse;
  }

  /// @p count places all over the surface.
  std::vector<SurfacePlace> Places(Index count) const
  {
    std::vector<SurfacePlace> places;
    for (Index k = 0; k < count; ++k)
    {
      SurfacePlace place{ static_cast<Index>(k * std::int64_t(this->Mesh.NumberOfTriangles()) / count) };
      place.Weights = Eigen::Vector3d(1.5 + test::Uniform(1, static_cast<std::uint64_t>(k)),
        1.5 + test::Uniform(2, static_cast<std::uint64_t>(k)), 1.5 + test::Uniform(3, static_cast<std::uint64_t>(k)));
      place.Weights /= place.Weights.sum();
      places.push_back(place);
    }
    return places;
  }

  FieldConditioning Conditioning(
    const SparseRowMatrix& matrix, const Eigen::VectorXd& deviations, std::uint64_t limit = Unlimited) const
  {
    const auto covariance = [this](
                              const Eigen::Ref<const Eigen::MatrixXd>& x) { return this->Field.SolvePrecision(x); };
    return FieldConditioning(covariance, matrix, deviations, limit);
  }

  static Eigen::MatrixXd Values(Eigen::Index count, Eigen::Index columns = 1)
  {
    Eigen::MatrixXd values(count, columns);
    for (Eigen::Index k = 0; k < values.size(); ++k)
    {
      values.data()[k] = 2.0 * test::Uniform(4, static_cast<std::uint64_t>(k));
    }
    return values;
  }

  /// Zero for each third observation, else up to 0.4.
  static Eigen::VectorXd Deviations(Eigen::Index count)
  {
    Eigen::VectorXd deviations(count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
      deviations[k] = 0.2 * static_cast<double>(k % 3);
    }
    return deviations;
  }
};

double MaximumNorm(const Eigen::MatrixXd& matrix) { return matrix.cwiseAbs().maxCoeff(); }

std::vector<NormalKey> Keys(std::uint32_t count)
{
  std::vector<NormalKey> keys(count);
  for (std::uint32_t k = 0; k < count; ++k)
  {
    keys[k].Seed = 3;
    keys[k].Sample = k;
  }
  return keys;
}
} // namespace

TEST_F(FieldConditioningOnSurface, MeanAndDeviationAreThoseOfDenseKriging)
{
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, this->Places(30));
  const Eigen::VectorXd deviations = Deviations(30);
  const Eigen::MatrixXd values = Values(30, 2);
  const FieldConditioning conditioning = this->Conditioning(matrix, deviations);
  const Eigen::MatrixXd cross = this->Dense * matrix.transpose();
  const Eigen::MatrixXd system = matrix * cross + Eigen::MatrixXd(deviations.cwiseAbs2().asDiagonal());
  const Eigen::MatrixXd gain = system.ldlt().solve(cross.transpose()).transpose();
  const Eigen::MatrixXd mean = gain * values;
  EXPECT_LE(MaximumNorm(conditioning.Mean(values) - mean), 1e-8 * MaximumNorm(mean));
  const Eigen::VectorXd variance = this->Dense.diagonal() - gain.cwiseProduct(cross).rowwise().sum();
  const Eigen::VectorXd prior = this->Field.MarginalVariances();
  EXPECT_LE(MaximumNorm(conditioning.Variance(prior) - variance), 1e-8 * MaximumNorm(prior));
  EXPECT_LE(MaximumNorm(conditioning.Variance(prior).cwiseSqrt() - variance.cwiseMax(0.0).cwiseSqrt()),
    1e-8 * MaximumNorm(prior));
}

TEST_F(FieldConditioningOnSurface, SamplesFollowMatheronsRule)
{
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, this->Places(20));
  const Eigen::VectorXd deviations = Deviations(20);
  const Eigen::MatrixXd values = Values(20).replicate(1, 2);
  Eigen::MatrixXd prior(this->Mesh.NumberOfPoints(), 2);
  SampleRequest request;
  request.Seed = 3;
  request.NumberOfSamples = 2;
  this->Field.Sample(
    request, [&](std::uint32_t k, const Eigen::Ref<const Eigen::MatrixXd>& sample) { prior.col(k) = sample.col(0); });
  const Eigen::MatrixXd samples = this->Conditioning(matrix, deviations).Sample(prior, values, Keys(2));
  const Eigen::MatrixXd cross = this->Dense * matrix.transpose();
  const Eigen::MatrixXd system = matrix * cross + Eigen::MatrixXd(deviations.cwiseAbs2().asDiagonal());
  for (Index k = 0; k < 2; ++k)
  {
    // The rest is C H^T times weights, which give back errors of the observations: those of the exact ones are 0.
    const Eigen::VectorXd weights =
      (cross.transpose() * cross).ldlt().solve(cross.transpose() * (samples.col(k) - prior.col(k)));
    const Eigen::VectorXd errors = values.col(k) - matrix * prior.col(k) - system * weights;
    for (Eigen::Index i = 0; i < 20; ++i)
    {
      EXPECT_LT(std::abs(errors[i]), deviations[i] > 0.0 ? 4.0 * deviations[i] : 1e-6) << i;
      EXPECT_TRUE(deviations[i] == 0.0 || std::abs(errors[i]) > 1e-4) << i;
    }
  }
}

TEST_F(FieldConditioningOnSurface, ExactObservationsAreHonored)
{
  // At many places, and at all vertices of a third of the surface, which make an ill-conditioned system.
  std::vector<SurfacePlace> places = this->Places(60);
  for (const bool dense : { false, true })
  {
    SparseRowMatrix matrix = ObservationMatrix(this->Mesh, places);
    if (dense)
    {
      matrix.resize(200, this->Mesh.NumberOfPoints());
      matrix.setZero();
      for (Index i = 0; i < 200; ++i)
      {
        matrix.insert(i, 3 * i) = 1.0;
      }
    }
    const Eigen::MatrixXd values = Values(matrix.rows(), 3);
    const FieldConditioning conditioning = this->Conditioning(matrix, Eigen::VectorXd::Zero(matrix.rows()));
    EXPECT_EQ(conditioning.NumberOfDependent(), 0);
    EXPECT_LE(MaximumNorm(matrix * conditioning.Mean(values) - values), 1e-8 * MaximumNorm(values));
    SampleRequest request;
    request.NumberOfComponents = 3;
    const Eigen::MatrixXd samples = conditioning.Sample(this->Field.Sample(request), values, Keys(3));
    EXPECT_LE(MaximumNorm(matrix * samples - values), 1e-8 * MaximumNorm(samples));
    const Eigen::VectorXd variance = matrix * conditioning.Variance(this->Field.MarginalVariances());
    EXPECT_TRUE(!dense || MaximumNorm(variance) < 1e-9 * Deviation * Deviation);
  }
}

TEST_F(FieldConditioningOnSurface, SamplesHaveThePosteriorMeanAndVariance)
{
  // 2,000 samples at 642 vertices: z = 4.5 for means, 4.7 for variances, each of probability below 1e-5 per vertex.
  constexpr std::uint32_t Samples = 2000;
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, this->Places(15));
  const Eigen::MatrixXd values = Values(15);
  const FieldConditioning conditioning = this->Conditioning(matrix, Deviations(15));
  Eigen::MatrixXd prior(this->Mesh.NumberOfPoints(), Samples);
  SampleRequest request;
  request.Seed = 3;
  request.NumberOfSamples = Samples;
  this->Field.Sample(
    request, [&](std::uint32_t k, const Eigen::Ref<const Eigen::MatrixXd>& sample) { prior.col(k) = sample.col(0); });
  const Eigen::MatrixXd samples = conditioning.Sample(prior, values.replicate(1, Samples), Keys(Samples));
  const Eigen::VectorXd mean = conditioning.Mean(values);
  const Eigen::VectorXd variance = conditioning.Variance(this->Field.MarginalVariances());
  for (Eigen::Index v = 0; v < mean.size(); ++v)
  {
    EXPECT_NEAR(samples.row(v).mean(), mean[v], 4.5 * std::sqrt(variance[v] / Samples)) << v;
    const double sampled = (samples.row(v).array() - mean[v]).square().mean();
    EXPECT_NEAR(sampled, variance[v], 4.7 * std::sqrt(2.0 / Samples) * variance[v]) << v;
  }
}

TEST_F(FieldConditioningOnSurface, ExactObservationsThatFollowFromOthersAreMergedOrContradict)
{
  std::vector<SurfacePlace> places = this->Places(6);
  places.push_back(places[2]); // the same place
  for (int k = 0; k < 4; ++k)  // three of four in a triangle give the fourth
  {
    SurfacePlace place = places[4];
    place.Weights = Eigen::Vector3d(0.2 + 0.1 * k, 0.1 + 0.05 * k * k, 0.0);
    place.Weights[2] = 1.0 - place.Weights.sum();
    places.push_back(place);
  }
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, places);
  const FieldConditioning conditioning = this->Conditioning(matrix, Eigen::VectorXd::Zero(matrix.rows()));
  EXPECT_EQ(conditioning.NumberOfDependent(), 3) << "one duplicate and two of the five in the triangle";
  const Eigen::MatrixXd field = this->Field.Sample();
  const Eigen::MatrixXd values = matrix * field;
  const Eigen::MatrixXd mean = conditioning.Mean(values);
  EXPECT_LE(MaximumNorm(matrix * mean - values), 1e-8 * MaximumNorm(values));
  Eigen::MatrixXd contradiction = values;
  contradiction(6, 0) += 0.01;
  EXPECT_THAT(TextOf<InvalidInput>([&] { conditioning.Mean(contradiction); }),
    HasSubstr("the exact observation 6 contradicts observation 2"));
  // A duplicate with a deviation is none.
  Eigen::VectorXd deviations = Eigen::VectorXd::Zero(7);
  deviations[6] = 0.1;
  places.resize(7);
  const FieldConditioning noisy = this->Conditioning(ObservationMatrix(this->Mesh, places), deviations);
  EXPECT_EQ(noisy.NumberOfDependent(), 0);
  EXPECT_NO_THROW(noisy.Mean(contradiction.topRows(7)));
}

TEST_F(FieldConditioningOnSurface, LittleMemoryTakesFewerColumnsAtATimeForTheSameResult)
{
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, this->Places(30));
  const Eigen::MatrixXd values = Values(30);
  const FieldConditioning wide = this->Conditioning(matrix, Deviations(30));
  EXPECT_EQ(wide.ColumnsTogether(), 64);
  const FieldConditioning narrow = this->Conditioning(matrix, Deviations(30), 3 * 32 * 642 + 32 * 900);
  EXPECT_EQ(narrow.ColumnsTogether(), 3);
  EXPECT_LE(MaximumNorm(narrow.Mean(values) - wide.Mean(values)), 1e-10 * MaximumNorm(values));
  const Eigen::VectorXd prior = this->Field.MarginalVariances();
  EXPECT_LE(MaximumNorm(narrow.Variance(prior) - wide.Variance(prior)), 1e-10 * MaximumNorm(prior));
}

TEST_F(FieldConditioningOnSurface, NoObservationsLeaveThePrior)
{
  const FieldConditioning conditioning = this->Conditioning(
    SparseRowMatrix(0, this->Mesh.NumberOfPoints()), Eigen::VectorXd());
  const Eigen::MatrixXd field = this->Field.Sample();
  EXPECT_EQ(conditioning.Sample(field, Eigen::MatrixXd(0, 1), Keys(1)), field);
  EXPECT_EQ(MaximumNorm(conditioning.Mean(Eigen::MatrixXd(0, 1))), 0.0);
  EXPECT_EQ(conditioning.Variance(this->Field.MarginalVariances()), this->Field.MarginalVariances());
}

TEST_F(FieldConditioningOnSurface, WrongInputIsNamed)
{
  const SparseRowMatrix matrix = ObservationMatrix(this->Mesh, this->Places(5));
  const auto text = [&](const Eigen::VectorXd& deviations, std::uint64_t limit = Unlimited) {
    return TextOf<InvalidInput>([&] { this->Conditioning(matrix, deviations, limit); });
  };
  EXPECT_THAT(text(Eigen::VectorXd::Zero(4)), HasSubstr("4 deviations; expected 5"));
  EXPECT_THAT(text(Eigen::VectorXd::Constant(5, -1.0)), HasSubstr("negative or not finite"));
  EXPECT_THAT(text(Eigen::VectorXd::Constant(5, std::nan(""))), HasSubstr("negative or not finite"));
  EXPECT_THAT(text(Eigen::VectorXd::Zero(5), 32 * 642 + 32 * 16), HasSubstr("expected at most 4, which fit into"));
  const FieldConditioning conditioning = this->Conditioning(matrix, Eigen::VectorXd::Zero(5));
  EXPECT_THAT(TextOf<InvalidInput>([&] { conditioning.Mean(Values(4)); }), HasSubstr("4 values; expected 5"));
  EXPECT_THAT(TextOf<InvalidInput>([&] { conditioning.Mean(Values(5) * std::nan("")); }), HasSubstr("not finite"));
  EXPECT_THAT(TextOf<InvalidInput>([&] { ObservationMatrix(this->Mesh, { SurfacePlace() }); }),
    HasSubstr("place 0 is in triangle -1"));
}
