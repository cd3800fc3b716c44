// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Statistics/EnsembleMetrics.h"
#include "Core/Statistics/PairKernels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <thread>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
using Sample = std::vector<double>;
using Samples = std::vector<Sample>;

const double NaN = std::numeric_limits<double>::quiet_NaN();
const double Infinity = std::numeric_limits<double>::infinity();

std::vector<SampleValues> ViewsOf(const Samples& samples)
{
  std::vector<SampleValues> views;
  for (const Sample& sample : samples)
  {
    views.emplace_back(sample.data());
  }
  return views;
}

EnsembleMetrics Compare(const Samples& generated, const Samples& reference, int components, const Eigen::VectorXd& mass,
  const EnsembleMetricsOptions& options = {}, const Progress& progress = {})
{
  return ComputeEnsembleMetrics({ ViewsOf(generated), ViewsOf(reference), components }, mass, options, progress);
}

Eigen::VectorXd Masses(std::initializer_list<double> values)
{
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

EnsembleMetricsOptions Options(SampleDistance distance, bool removeCentroid = false)
{
  EnsembleMetricsOptions options;
  options.Distance = distance;
  options.RemoveCentroid = removeCentroid;
  return options;
}

/// @p count samples of @p size numbers, uniform in [-1, 1).
Samples RandomSamples(int count, std::size_t size, std::uint64_t seed)
{
  Samples samples(static_cast<std::size_t>(count), Sample(size));
  for (std::size_t k = 0; k < samples.size(); ++k)
  {
    for (std::size_t i = 0; i < size; ++i)
    {
      samples[k][i] = Uniform(1000 * seed + k, i);
    }
  }
  return samples;
}

Eigen::VectorXd RandomMass(Eigen::Index points)
{
  Eigen::VectorXd mass(points);
  for (Eigen::Index p = 0; p < points; ++p)
  {
    mass[p] = 1.5 + Uniform(77, static_cast<std::uint64_t>(p));
  }
  return mass;
}

/// The definition of the distance, term by term.
double PlainDistance(
  Sample a, Sample b, std::size_t components, const Eigen::VectorXd& mass, const EnsembleMetricsOptions& options)
{
  const auto points = static_cast<std::size_t>(mass.size());
  const double total = mass.sum();
  for (std::size_t c = 0; options.RemoveCentroid && c < components; ++c)
  {
    for (Sample* sample : { &a, &b })
    {
      double mean = 0.0;
      for (std::size_t p = 0; p < points; ++p)
      {
        mean += mass[static_cast<Eigen::Index>(p)] * (*sample)[p * components + c] / total;
      }
      for (std::size_t p = 0; p < points; ++p)
      {
        (*sample)[p * components + c] -= mean;
      }
    }
  }
  double sum = 0.0;
  for (std::size_t p = 0; p < points; ++p)
  {
    double squares = 0.0;
    for (std::size_t c = 0; c < components; ++c)
    {
      squares += std::pow(a[p * components + c] - b[p * components + c], 2);
    }
    sum += mass[static_cast<Eigen::Index>(p)] *
      (options.Distance == SampleDistance::RMS ? squares : std::sqrt(squares));
  }
  sum /= total;
  return options.Distance == SampleDistance::RMS ? std::sqrt(sum) : sum;
}

Sample MeanOf(const Samples& samples)
{
  Sample mean(samples[0].size());
  for (const Sample& sample : samples)
  {
    std::transform(sample.begin(), sample.end(), mean.begin(), mean.begin(),
      [&](double value, double sum) { return sum + value / static_cast<double>(samples.size()); });
  }
  return mean;
}

/// The definitions of the metrics, term by term, with every distance computed on its own.
EnsembleMetrics PlainMetrics(const Samples& generated, const Samples& reference, std::size_t components,
  const Eigen::VectorXd& mass, const EnsembleMetricsOptions& options)
{
  Samples all = generated;
  all.insert(all.end(), reference.begin(), reference.end());
  const std::size_t count = generated.size();
  EnsembleMetrics metrics;
  std::vector<bool> covered(reference.size());
  double recognized = 0.0;
  for (std::size_t a = 0; a < all.size(); ++a)
  {
    double own = Infinity, other = Infinity;
    std::size_t nearest = 0;
    for (std::size_t b = 0; b < all.size(); ++b)
    {
      const double distance = a == b ? Infinity : PlainDistance(all[a], all[b], components, mass, options);
      double& least = (a < count) == (b < count) ? own : other;
      nearest = &least == &other && distance < other ? b : nearest;
      least = std::min(least, distance);
    }
    recognized += own < other ? 1.0 : 0.0;
    (a < count ? metrics.MMD : metrics.ReverseMMD) += other;
    (a < count ? metrics.GeneratedSpacing : metrics.ReferenceSpacing) += own;
    if (a < count)
    {
      covered[nearest - count] = true;
      metrics.NearestReference.push_back(static_cast<std::int64_t>(nearest - count));
      metrics.DistanceToReference.push_back(other);
    }
  }
  metrics.MMD /= static_cast<double>(count);
  metrics.GeneratedSpacing /= static_cast<double>(count);
  metrics.ReverseMMD /= static_cast<double>(reference.size());
  metrics.ReferenceSpacing /= static_cast<double>(reference.size());
  metrics.COV = static_cast<double>(std::count(covered.begin(), covered.end(), true)) /
    static_cast<double>(reference.size());
  metrics.OneNearestNeighborAccuracy = recognized / static_cast<double>(all.size());
  metrics.MeanError = PlainDistance(MeanOf(generated), MeanOf(reference), components, mass, options);
  return metrics;
}

void ExpectNear(const EnsembleMetrics& found, const EnsembleMetrics& expected, double tolerance)
{
  EXPECT_NEAR(found.MMD, expected.MMD, tolerance);
  EXPECT_NEAR(found.ReverseMMD, expected.ReverseMMD, tolerance);
  EXPECT_NEAR(found.MeanError, expected.MeanError, tolerance);
  EXPECT_NEAR(found.GeneratedSpacing, expected.GeneratedSpacing, tolerance);
  EXPECT_NEAR(found.ReferenceSpacing, expected.ReferenceSpacing, tolerance);
  EXPECT_DOUBLE_EQ(found.COV, expected.COV);
  EXPECT_DOUBLE_EQ(found.OneNearestNeighborAccuracy, expected.OneNearestNeighborAccuracy);
  EXPECT_EQ(found.NearestReference, expected.NearestReference);
  ASSERT_EQ(found.DistanceToReference.size(), expected.DistanceToReference.size());
  for (std::size_t k = 0; k < found.DistanceToReference.size(); ++k)
  {
    EXPECT_NEAR(found.DistanceToReference[k], expected.DistanceToReference[k], tolerance);
  }
}

void ExpectSameBits(const EnsembleMetrics& a, const EnsembleMetrics& b)
{
  EXPECT_EQ(a.MMD, b.MMD);
  EXPECT_EQ(a.ReverseMMD, b.ReverseMMD);
  EXPECT_EQ(a.COV, b.COV);
  EXPECT_EQ(a.OneNearestNeighborAccuracy, b.OneNearestNeighborAccuracy);
  EXPECT_EQ(a.MeanError, b.MeanError);
  EXPECT_EQ(a.GeneratedSpacing, b.GeneratedSpacing);
  EXPECT_EQ(a.ReferenceSpacing, b.ReferenceSpacing);
  EXPECT_EQ(a.NearestReference, b.NearestReference);
  EXPECT_EQ(a.DistanceToReference, b.DistanceToReference);
}

/// The text of the error that a comparison must end with.
std::string ErrorOf(const Samples& generated, const Samples& reference, const Eigen::VectorXd& mass, int components = 1)
{
  try
  {
    Compare(generated, reference, components, mass);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}
} // namespace

TEST(EnsembleMetrics, TwoGeneratedAndThreeReferencesByHand)
{
  // Weights 1/4 and 3/4. Distances: g0 to r 0.25, 1, 10; g1 to r 3.75, 3, 6; g0 g1 4; r0 r1 0.75, r0 r2 9.75, r1 r2 9.
  const auto metrics = Compare({ { 0, 0 }, { 4, 4 } }, { { 1, 0 }, { 1, 1 }, { 10, 10 } }, 1, Masses({ 2.0, 6.0 }));
  EXPECT_DOUBLE_EQ(metrics.MMD, (0.25 + 3.0) / 2.0);
  EXPECT_DOUBLE_EQ(metrics.ReverseMMD, (0.25 + 1.0 + 6.0) / 3.0);
  EXPECT_DOUBLE_EQ(metrics.COV, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(metrics.OneNearestNeighborAccuracy, 0.2) << "only r1 has a nearest neighbour of its own kind";
  EXPECT_DOUBLE_EQ(metrics.MeanError, 0.25 * (4.0 - 2.0) + 0.75 * (11.0 / 3.0 - 2.0));
  EXPECT_DOUBLE_EQ(metrics.GeneratedSpacing, 4.0);
  EXPECT_DOUBLE_EQ(metrics.ReferenceSpacing, (0.75 + 0.75 + 9.0) / 3.0);
  EXPECT_EQ(metrics.NearestReference, (std::vector<std::int64_t>{ 0, 1 }));
  EXPECT_EQ(metrics.DistanceToReference, (std::vector<double>{ 0.25, 3.0 }));
}

TEST(EnsembleMetrics, DistancesByHand)
{
  const Eigen::VectorXd mass = Masses({ 1.0, 3.0 });
  const Samples origin = { { 0, 0, 0, 0, 0, 0 } };
  const Samples other = { { 3, 4, 0, 0, 0, 1 } }; // 5 and 1 away
  EXPECT_DOUBLE_EQ(Compare(origin, other, 3, mass).MMD, (5.0 + 3.0 * 1.0) / 4.0);
  EXPECT_DOUBLE_EQ(Compare(origin, other, 3, mass, Options(SampleDistance::RMS)).MMD, std::sqrt((25.0 + 3.0) / 4.0));
  EXPECT_DOUBLE_EQ(Compare({ { 0, 0 } }, { { 3, -1 } }, 1, mass, Options(SampleDistance::RMS)).MMD, std::sqrt(3.0));
}

TEST(EnsembleMetrics, SingleSamplesHaveNoNeighborOfTheirOwn)
{
  const auto metrics = Compare({ { 1 } }, { { 3 } }, 1, Masses({ 1.0 }));
  EXPECT_EQ(metrics.MMD, 2.0);
  EXPECT_EQ(metrics.COV, 1.0);
  EXPECT_EQ(metrics.GeneratedSpacing, 0.0);
  EXPECT_EQ(metrics.ReferenceSpacing, 0.0);
  EXPECT_EQ(metrics.OneNearestNeighborAccuracy, 0.0);
}

TEST(EnsembleMetrics, AgreesWithTheDefinitionsForEveryNumberOfComponents)
{
  for (const int components : { 1, 2, 3, 5, 60 })
  {
    const Eigen::Index points = components == 60 ? 100 : 1111; // more than one block, the last one partly filled
    const auto size = static_cast<std::size_t>(points * components);
    const Samples generated = RandomSamples(19, size, 1);
    const Samples reference = RandomSamples(23, size, 2);
    const Eigen::VectorXd mass = RandomMass(points);
    for (const SampleDistance distance : { SampleDistance::MeanL2, SampleDistance::RMS })
    {
      for (const bool removeCentroid : { false, true })
      {
        SCOPED_TRACE(std::to_string(components) + (removeCentroid ? " less centroid" : ""));
        const auto options = Options(distance, removeCentroid);
        ExpectNear(Compare(generated, reference, components, mass, options),
          PlainMetrics(generated, reference, static_cast<std::size_t>(components), mass, options), 1e-12);
      }
    }
  }
}

TEST(EnsembleMetrics, SinglePrecisionIsReadInPlaceAndWidened)
{
  const Samples generated = RandomSamples(5, 3 * 400, 3);
  const Samples reference = RandomSamples(6, 3 * 400, 4);
  std::vector<std::vector<float>> single;
  Samples widened;
  for (const Sample& sample : generated)
  {
    single.emplace_back(sample.begin(), sample.end());
    widened.emplace_back(single.back().begin(), single.back().end());
  }
  EnsemblePair mixed{ {}, ViewsOf(reference), 3 };
  for (const auto& sample : single)
  {
    mixed.Generated.emplace_back(sample.data());
  }
  const Eigen::VectorXd mass = RandomMass(400);
  ExpectSameBits(ComputeEnsembleMetrics(mixed, mass), Compare(widened, reference, 3, mass));
}

TEST(EnsembleMetrics, IdenticalEnsembles)
{
  const Samples samples = RandomSamples(20, 3 * 300, 5);
  for (const bool removeCentroid : { false, true })
  {
    const auto metrics = Compare(samples, samples, 3, RandomMass(300), Options(SampleDistance::MeanL2, removeCentroid));
    EXPECT_EQ(metrics.MMD, 0.0);
    EXPECT_EQ(metrics.ReverseMMD, 0.0);
    EXPECT_EQ(metrics.COV, 1.0);
    EXPECT_EQ(metrics.MeanError, 0.0);
    EXPECT_EQ(metrics.OneNearestNeighborAccuracy, 0.0) << "copies are nearer than anything else";
    std::vector<std::int64_t> order(samples.size());
    std::iota(order.begin(), order.end(), 0);
    EXPECT_EQ(metrics.NearestReference, order);
  }
}

TEST(EnsembleMetrics, SeparateClustersAreToldApart)
{
  const Samples near = RandomSamples(30, 200, 6);
  Samples far = RandomSamples(20, 200, 7);
  for (Sample& sample : far)
  {
    std::transform(sample.begin(), sample.end(), sample.begin(), [](double value) { return value + 100.0; });
  }
  const auto metrics = Compare(near, far, 1, RandomMass(200));
  EXPECT_EQ(metrics.OneNearestNeighborAccuracy, 1.0);
  EXPECT_NEAR(metrics.MMD, 100.0, 1.0);
  EXPECT_LT(metrics.GeneratedSpacing, 2.0);
}

TEST(EnsembleMetrics, SameDistributionIsGuessedHalfOfTheTime)
{
  // Fields of three random coefficients: dense enough that neighbours are real ones.
  const auto fields = [](std::uint64_t seed) {
    Samples samples = RandomSamples(400, 50, seed);
    for (Sample& sample : samples)
    {
      const double a = sample[0], b = sample[1], c = sample[2];
      for (std::size_t p = 0; p < sample.size(); ++p)
      {
        const double x = static_cast<double>(p) / 50.0;
        sample[p] = a + b * std::cos(3.0 * x) + c * std::sin(5.0 * x);
      }
    }
    return samples;
  };
  const auto metrics = Compare(fields(8), fields(9), 1, RandomMass(50));
  EXPECT_NEAR(metrics.OneNearestNeighborAccuracy, 0.5, 0.06) << "three standard deviations of about 0.02";
  EXPECT_NEAR(metrics.COV, 0.6, 0.1);
  EXPECT_NEAR(metrics.MMD / metrics.ReferenceSpacing, 1.0, 0.1);
}

TEST(EnsembleMetrics, ACollapsedGeneratorHasFidelityButNoCoverage)
{
  const Samples reference = RandomSamples(20, 100, 10);
  const Samples collapsed(20, reference[7]);
  const auto metrics = Compare(collapsed, reference, 1, RandomMass(100));
  EXPECT_EQ(metrics.MMD, 0.0);
  EXPECT_EQ(metrics.COV, 1.0 / 20.0);
  EXPECT_GT(metrics.ReverseMMD, 0.5);
  EXPECT_EQ(metrics.GeneratedSpacing, 0.0);
}

TEST(EnsembleMetrics, TiesGoToTheLowestIndexGeneratedBeforeReference)
{
  const Eigen::VectorXd mass = Masses({ 1.0 });
  const auto twins = Compare({ { 0 } }, { { 1 }, { -1 }, { 1 } }, 1, mass);
  EXPECT_EQ(twins.NearestReference, (std::vector<std::int64_t>{ 0 }));
  // 0 and 2 generated, 1 and 3 references: 1 and 2 have a neighbour of each kind at distance 1.
  const auto comb = Compare({ { 0 }, { 2 } }, { { 1 }, { 3 } }, 1, mass);
  EXPECT_EQ(comb.OneNearestNeighborAccuracy, 0.0);
  const auto pairs = Compare({ { 0 }, { 0 } }, { { 0 }, { 0 } }, 1, mass);
  EXPECT_EQ(pairs.OneNearestNeighborAccuracy, 0.5) << "generated ones are right, references are not";
}

TEST(EnsembleMetrics, TranslationCountsForNothingLessTheCentroid)
{
  const Samples generated = RandomSamples(6, 3 * 200, 11);
  Samples moved = generated;
  for (std::size_t k = 0; k < moved.size(); ++k)
  {
    for (std::size_t i = 0; i < moved[k].size(); ++i)
    {
      moved[k][i] += static_cast<double>(k + 1) * static_cast<double>(i % 3 + 1);
    }
  }
  const Eigen::VectorXd mass = RandomMass(200);
  EXPECT_GT(Compare(generated, moved, 3, mass).MMD, 1.0);
  const auto metrics = Compare(generated, moved, 3, mass, Options(SampleDistance::MeanL2, true));
  EXPECT_LT(metrics.MMD, 1e-13);
  EXPECT_LT(metrics.MeanError, 1e-13);
  EXPECT_EQ(metrics.COV, 1.0);
}

TEST(EnsembleMetrics, ScaleWithTheValuesAndNotWithTheMass)
{
  const Samples generated = RandomSamples(7, 90, 12);
  const Samples reference = RandomSamples(8, 90, 13);
  const Eigen::VectorXd mass = RandomMass(90);
  const auto metrics = Compare(generated, reference, 1, mass);
  for (const double scale : { 1e-12, 1e12 })
  {
    Samples scaledGenerated = generated, scaledReference = reference;
    for (Samples* samples : { &scaledGenerated, &scaledReference })
    {
      for (Sample& sample : *samples)
      {
        std::transform(sample.begin(), sample.end(), sample.begin(), [&](double value) { return scale * value; });
      }
    }
    const auto scaled = Compare(scaledGenerated, scaledReference, 1, scale * scale * mass);
    EXPECT_NEAR(scaled.MMD / scale, metrics.MMD, 1e-13);
    EXPECT_NEAR(scaled.MeanError / scale, metrics.MeanError, 1e-13);
    EXPECT_EQ(scaled.OneNearestNeighborAccuracy, metrics.OneNearestNeighborAccuracy);
    EXPECT_EQ(scaled.NearestReference, metrics.NearestReference);
  }
  const auto heavy = Compare(generated, reference, 1, mass * (1e308 / mass.maxCoeff()));
  EXPECT_NEAR(heavy.MMD, metrics.MMD, 1e-13) << "a sum of masses beyond the largest number";
}

TEST(EnsembleMetrics, ARefinedMeshWithTheSameFunctionsHasTheSameMetrics)
{
  // Differences are multiples of x + 2 in one direction: their norm is linear, and the lumped mass integrates it
  // exactly.
  const auto fieldsOn = [](const TriangleMesh& mesh, int count, std::uint64_t seed) {
    Samples samples(static_cast<std::size_t>(count), Sample(static_cast<std::size_t>(3 * mesh.NumberOfPoints())));
    for (std::size_t k = 0; k < samples.size(); ++k)
    {
      for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
      {
        const double value = Uniform(seed, k) * (mesh.Points(v, 0) + 2.0);
        const auto first = static_cast<std::size_t>(3 * v);
        samples[k][first] = 2.0 * value;
        samples[k][first + 1] = -value;
        samples[k][first + 2] = 0.5 * value;
      }
    }
    return samples;
  };
  const TriangleMesh coarse = IrregularSphere(2);
  const TriangleMesh uneven = RefineWhere(coarse, [](Index triangle) { return triangle % 3 == 0; });
  const auto metricsOn = [&](const TriangleMesh& mesh, SampleDistance distance) {
    return Compare(fieldsOn(mesh, 12, 14), fieldsOn(mesh, 15, 15), 3, LumpedMass(mesh), Options(distance));
  };
  ASSERT_GT(uneven.NumberOfPoints(), coarse.NumberOfPoints());
  const auto expected = metricsOn(coarse, SampleDistance::MeanL2);
  ExpectNear(metricsOn(uneven, SampleDistance::MeanL2), expected, 1e-12);
  ExpectNear(metricsOn(Subdivide(uneven), SampleDistance::MeanL2), expected, 1e-12);
}

TEST(EnsembleMetrics, PointsWithoutMassCountForNothing)
{
  const auto metrics = Compare({ { 0, NaN, 1 }, { 5, 0, 5 } }, { { 1, Infinity, 2 } }, 1, Masses({ 1.0, 0.0, 1.0 }));
  EXPECT_EQ(metrics.MMD, (1.0 + 3.5) / 2.0);
  EXPECT_EQ(metrics.MeanError, 0.5 * (1.5 + 1.0));
}

TEST(EnsembleMetrics, TheSameBitsForEveryNumberOfThreads)
{
  const Samples generated = RandomSamples(37, 3 * 700, 16);
  const Samples reference = RandomSamples(41, 3 * 700, 17);
  const Eigen::VectorXd mass = RandomMass(700);
  const auto withThreads = [&](int threads) {
    const ThreadScope scope(threads);
    return Compare(generated, reference, 3, mass, Options(SampleDistance::RMS, true));
  };
  const auto expected = withThreads(1);
  for (const int threads : { 2, 3, 8, 64 })
  {
    ExpectSameBits(withThreads(threads), expected);
  }
}

TEST(EnsembleMetrics, TheSameBitsWithEveryInstructionSet)
{
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2"))
  {
    GTEST_SKIP() << "this processor has one variant only";
  }
  const bool hasAvx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
    __builtin_cpu_supports("avx512vl");
  const Samples planes = RandomSamples(3, 5 * 100, 21);
  for (const int components : { 1, 2, 3, 5 })
  {
    for (const int count : { 1, 7, 8, 9, 100 })
    {
      for (const bool squared : { false, true })
      {
        const PairOfPlanes pair{ planes[0].data(), planes[1].data(), planes[2].data(), components, count, squared };
        EXPECT_EQ(AddUpPairAvx2(pair), AddUpPairGeneric(pair));
        EXPECT_EQ(hasAvx512 ? AddUpPairAvx512(pair) : AddUpPairGeneric(pair), AddUpPairGeneric(pair));
      }
    }
  }
#else
  GTEST_SKIP() << "this processor has one variant only";
#endif
}

TEST(EnsembleMetrics, RefusesWhatHasNoMeaning)
{
  const Samples two = { { 1, 2 }, { 3, 4 } };
  const Eigen::VectorXd mass = Masses({ 1.0, 2.0 });
  EXPECT_THAT(ErrorOf({}, two, mass), HasSubstr("the generated ensemble has no sample"));
  EXPECT_THAT(ErrorOf(two, {}, mass), HasSubstr("the reference ensemble has no sample"));
  EXPECT_THAT(ErrorOf(two, two, mass, 0), HasSubstr("0 components"));
  EXPECT_THAT(ErrorOf(two, two, Masses({ 0.0, 0.0 })), HasSubstr("no point has mass"));
  EXPECT_THAT(ErrorOf(two, two, Eigen::VectorXd()), HasSubstr("no point has mass"));
  EXPECT_THAT(ErrorOf(two, two, Masses({ 1.0, -1.0 })), HasSubstr("the mass of point 1 is -1"));
  EXPECT_THAT(ErrorOf(two, two, Masses({ NaN, 1.0 })), HasSubstr("the mass of point 0 is nan"));
}

TEST(EnsembleMetrics, RefusesValuesThatAreNotFinite)
{
  const Samples sound = { { 1, 2 }, { 3, 4 } };
  const Eigen::VectorXd mass = Masses({ 1.0, 2.0 });
  EXPECT_THAT(ErrorOf({ { 1, 2 }, { 0, NaN } }, sound, mass),
    HasSubstr("generated sample 1 has 1 point(s) with a value that is not finite, first point 1"));
  EXPECT_THAT(ErrorOf(sound, { { Infinity, NaN }, { 0, NaN } }, mass),
    HasSubstr("reference sample 0 has 2 point(s) with a value that is not finite, first point 0"));
  EXPECT_THAT(ErrorOf(sound, { { 1e308, 0 }, { -1e308, 0 } }, mass), HasSubstr("not finite"));
  EXPECT_THAT(ErrorOf({ { 1e200, 0, 0 } }, { { 0, 0, 0 } }, Masses({ 1.0 }), 3),
    HasSubstr("distance of generated sample 0 and reference sample 0 is not finite"));
}

TEST(EnsembleMetrics, ProgressIsMonotoneEndsAtOneAndStaysOnTheThread)
{
  const Samples generated = RandomSamples(60, 3 * 1000, 18);
  const Samples reference = RandomSamples(60, 3 * 1000, 19);
  for (const int threads : { 1, 3 })
  {
    std::vector<double> reports;
    bool foreign = false;
    const auto thread = std::this_thread::get_id();
    const auto record = [&](double fraction) {
      foreign = foreign || std::this_thread::get_id() != thread;
      reports.push_back(fraction);
      return true;
    };
    const ThreadScope scope(threads);
    Compare(generated, reference, 3, RandomMass(1000), {}, record);
    EXPECT_GT(reports.size(), threads == 1 ? 50u : 2u);
    EXPECT_LT(reports.size(), 200u) << "about a hundred, and twenty a second";
    EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
    EXPECT_EQ(reports.front(), 0.0);
    EXPECT_EQ(reports.back(), 1.0);
    EXPECT_FALSE(foreign);
  }
}

TEST(EnsembleMetrics, StopsWithinASecondWhereverItIs)
{
  const Samples samples = RandomSamples(40, 3 * 20000, 20);
  const Eigen::VectorXd mass = RandomMass(20000);
  for (const int threads : { 1, 3 })
  {
    const ThreadScope scope(threads);
    for (const double stopAt : { 0.0, 0.03, 0.08, 0.5 })
    {
      auto asked = std::chrono::steady_clock::time_point();
      const auto stop = [&](double fraction) {
        asked = fraction >= stopAt ? std::chrono::steady_clock::now() : asked;
        return fraction < stopAt;
      };
      EXPECT_THROW(Compare(samples, samples, 3, mass, {}, stop), Cancelled);
      EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(1));
    }
  }
}
