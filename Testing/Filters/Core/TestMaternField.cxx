// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/LaplaceEigenpairs.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

using namespace surfsynth;

namespace
{

constexpr double Pi = 3.14159265358979323846;
const double NaN = std::numeric_limits<double>::quiet_NaN();
const double Infinity = std::numeric_limits<double>::infinity();

const std::vector<NoiseModel> AllModels = { NoiseModel::Matern, NoiseModel::PerVertex, NoiseModel::White,
  NoiseModel::Unscreened, NoiseModel::Spectral };

MaternFieldOptions ByRange(double range, double deviation = 1.0)
{
  MaternFieldOptions options;
  options.CorrelationRange = range;
  options.StandardDeviation = deviation;
  return options;
}

MaternFieldOptions ByScreening(double tau, NoiseModel model = NoiseModel::Matern)
{
  MaternFieldOptions options;
  options.Model = model;
  options.Mode = ScaleMode::Screening;
  options.Screening = tau;
  options.NumberOfEigenpairs = 20;
  return options;
}

MaternFieldOptions ByNormalizedScreening(double c)
{
  MaternFieldOptions options;
  options.Mode = ScaleMode::NormalizedScreening;
  options.NormalizedScreening = c;
  return options;
}

SampleRequest Request(std::uint64_t seed, std::uint32_t samples = 1, std::uint32_t components = 1)
{
  SampleRequest request;
  request.Seed = seed;
  request.NumberOfSamples = samples;
  request.NumberOfComponents = components;
  return request;
}

/// All samples of @p request side by side.
std::vector<Eigen::MatrixXd> Draw(const MaternField& field, const SampleRequest& request)
{
  std::vector<Eigen::MatrixXd> samples;
  field.Sample(
    request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) { samples.emplace_back(values); });
  return samples;
}

bool SameBits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() &&
    std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

/// N(0, 1) numbers of the first sample and component.
Eigen::VectorXd Normals(Eigen::Index count, std::uint64_t seed)
{
  Eigen::VectorXd normals(count);
  for (Eigen::Index v = 0; v < count; ++v)
  {
    NormalKey key;
    key.Seed = seed;
    normals[v] = Normal(key, v);
  }
  return normals;
}

void ExpectClose(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected, double tolerance)
{
  ASSERT_EQ(actual.rows(), expected.rows());
  ASSERT_EQ(actual.cols(), expected.cols());
  EXPECT_LE((actual - expected).norm(), tolerance * expected.norm());
}

/// Mean over surface and samples of f^2: the variance of a field of mean zero.
double PooledVariance(const MaternField& field, const SampleRequest& request, const Eigen::VectorXd& weights)
{
  double sum = 0.0;
  field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) {
    sum += weights.dot(values.col(0).cwiseAbs2());
  });
  return sum / (weights.sum() * request.NumberOfSamples);
}

/// Covariance on the unit sphere at angle theta of the unscaled field, summed over the exact spectrum
/// (1 / 4 pi) sum (2 l + 1) P_l(cos theta) / (l (l + 1) + tau)^2.
double SphereCovariance(double tau, double theta)
{
  const double x = std::cos(theta);
  double sum = 0.0;
  double before = 0.0;
  double legendre = 1.0;
  for (int l = 0; l < 20000; ++l)
  {
    const double denominator = l * (l + 1.0) + tau;
    sum += (2.0 * l + 1.0) * legendre / (denominator * denominator);
    const double next = ((2.0 * l + 1.0) * x * legendre - l * before) / (l + 1.0);
    before = legendre;
    legendre = next;
  }
  return sum / (4.0 * Pi);
}

/// Correlation between points of a sphere around the origin at a geodesic distance within 2 per cent of @p distance.
double CorrelationAtDistance(const MaternField& field, const SampleRequest& request, double radius, double distance)
{
  const PointMatrix directions = field.Mesh().Points.rowwise().normalized();
  std::vector<std::pair<Index, Index>> pairs;
  const double largest = std::cos(0.98 * distance / radius);
  const double smallest = std::cos(1.02 * distance / radius);
  for (Index i = 0; i < directions.rows(); i += std::max<Index>(1, static_cast<Index>(directions.rows()) / 150))
  {
    const Eigen::VectorXd cosines = directions * directions.row(i).transpose();
    for (Index j = 0; j < directions.rows(); ++j)
    {
      if (cosines[j] > smallest && cosines[j] < largest)
      {
        pairs.emplace_back(i, j);
      }
    }
  }
  EXPECT_GT(pairs.size(), 500U);
  double product = 0.0;
  double squares = 0.0;
  field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) {
    for (const auto& [i, j] : pairs)
    {
      product += values(i, 0) * values(j, 0);
      squares += 0.5 * (values(i, 0) * values(i, 0) + values(j, 0) * values(j, 0));
    }
  });
  return product / squares;
}

} // namespace

// --- The five models, by their definitions ----------------------------------------------------------------------

class MaternFieldOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const TriangleMesh& Mesh = test::FromSuite(GetParam()).Mesh;
  const Eigen::VectorXd Mass = LumpedMass(Mesh);
  const Eigen::MatrixXd Stiffness = Eigen::MatrixXd(CotangentStiffness(Mesh));
  const double Tau = 50.0 / Mass.sum();

  /// (L + tau M)^-1 sqrt(M) n on the dense matrices.
  Eigen::VectorXd Algorithm1(double tau, std::uint64_t seed) const
  {
    Eigen::VectorXd diagonal = tau * this->Mass;
    diagonal = (this->Mass.array() > 0.0).select(diagonal, 1.0);
    const Eigen::MatrixXd matrix = this->Stiffness + Eigen::MatrixXd(diagonal.asDiagonal());
    return matrix.llt().solve(this->Mass.cwiseSqrt().cwiseProduct(Normals(this->Mass.size(), seed)));
  }
};

INSTANTIATE_TEST_SUITE_P(
  Suite, MaternFieldOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

TEST_P(MaternFieldOnMesh, ScreeningModeIsAlgorithm1)
{
  const MaternField field(this->Mesh, ByScreening(this->Tau));
  ExpectClose(field.Sample(Request(7)), this->Algorithm1(this->Tau, 7), 1e-10);
  EXPECT_EQ(field.EffectiveScreening(), this->Tau);
  EXPECT_NEAR(field.EffectiveCorrelationRange(), std::sqrt(8.0 / this->Tau), 1e-14 * std::sqrt(8.0 / this->Tau));
  EXPECT_LE(field.RelativeResidual(), 1e-10);
}

TEST_P(MaternFieldOnMesh, NormalizedScreeningModeIsAlgorithm2)
{
  const double gamma = LaplaceBeltramiNorm(CotangentStiffness(this->Mesh), this->Mass);
  const double c = 0.003;
  const MaternField field(this->Mesh, ByNormalizedScreening(c));
  ExpectClose(field.Sample(Request(8)), std::sqrt(gamma) * this->Algorithm1(c * gamma, 8), 1e-10);
  EXPECT_DOUBLE_EQ(field.Gamma(), gamma);
  EXPECT_NEAR(field.EffectiveScreening(), c * gamma, 1e-14 * c * gamma);
}

TEST_P(MaternFieldOnMesh, RangeModeIsAlgorithm1ScaledOnEachComponent)
{
  const MeshTopology topology(this->Mesh);
  const MeshComponents components = ComputeComponents(topology, this->Mass);
  const double range = 0.3 * std::sqrt(this->Mass.sum());
  const double tau = 8.0 / (range * range);
  Eigen::VectorXd expected = this->Algorithm1(tau, 9);
  for (Index v = 0; v < expected.size(); ++v)
  {
    const Index c = components.OfVertex[static_cast<std::size_t>(v)];
    if (c >= 0)
    {
      const auto at = static_cast<std::size_t>(c);
      expected[v] *= 2.5 /
        std::sqrt(
          MarginalVariance(tau, components.Area[at], components.EulerCharacteristic[at], components.Closed[at]));
    }
  }
  const MaternField field(this->Mesh, ByRange(range, 2.5));
  ExpectClose(field.Sample(Request(9)), expected, 1e-10);
  EXPECT_NEAR(field.EffectiveCorrelationRange(), range, 1e-14 * range);
}

TEST_P(MaternFieldOnMesh, PerVertexIsIndependentNumbers)
{
  MaternFieldOptions options;
  options.Model = NoiseModel::PerVertex;
  options.StandardDeviation = 3.0;
  const MaternField field(this->Mesh, options);
  const Eigen::VectorXd expected =
    (this->Mass.array() > 0.0).select(3.0 * Normals(this->Mass.size(), 10), Eigen::VectorXd::Zero(this->Mass.size()));
  ExpectClose(field.Sample(Request(10)), expected, 1e-15);
  EXPECT_EQ(field.EffectiveScreening(), 0.0);
  EXPECT_EQ(field.EffectiveCorrelationRange(), 0.0);
  EXPECT_EQ(field.Gamma(), 0.0);
  EXPECT_EQ(field.RelativeResidual(), 0.0);
}

TEST_P(MaternFieldOnMesh, WhiteIsNormalsOverRootMass)
{
  MaternFieldOptions options;
  options.Model = NoiseModel::White;
  Eigen::VectorXd expected = Normals(this->Mass.size(), 11);
  for (Index v = 0; v < expected.size(); ++v)
  {
    expected[v] = this->Mass[v] > 0.0 ? expected[v] / std::sqrt(this->Mass[v]) : 0.0;
  }
  ExpectClose(MaternField(this->Mesh, options).Sample(Request(11)), expected, 1e-14);
}

TEST_P(MaternFieldOnMesh, UnscreenedSolvesThePoissonEquationOrthogonallyToConstants)
{
  MaternFieldOptions options;
  options.Model = NoiseModel::Unscreened;
  const MaternField field(this->Mesh, options);
  const Eigen::VectorXd values = field.Sample(Request(12));
  // The right-hand side without its mean on each component, M (1^T b) / area.
  Eigen::VectorXd side = this->Mass.cwiseSqrt().cwiseProduct(Normals(this->Mass.size(), 12));
  const MeshTopology topology(this->Mesh);
  const MeshComponents components = ComputeComponents(topology, this->Mass);
  for (Index c = 0; c < components.Count; ++c)
  {
    Eigen::VectorXd inside = Eigen::VectorXd::Zero(side.size());
    for (Index v = 0; v < side.size(); ++v)
    {
      inside[v] = components.OfVertex[static_cast<std::size_t>(v)] == c ? 1.0 : 0.0;
    }
    const Eigen::VectorXd mass = inside.cwiseProduct(this->Mass);
    side -= mass * (inside.dot(side) / mass.sum());
    EXPECT_LE(
      std::abs(mass.dot(values)), 1e-12 * mass.cwiseSqrt().norm() * mass.cwiseSqrt().cwiseProduct(values).norm())
      << "component " << c << " is orthogonal to constants";
  }
  // L is badly conditioned where the mesh lies far from the origin: its entries are only good to 1e-11.
  EXPECT_LE((this->Stiffness * values - side).norm(), 1e-10 * side.norm());
  EXPECT_LE(field.RelativeResidual(), 1e-10);
  EXPECT_EQ(field.EffectiveScreening(), 0.0);
}

TEST_P(MaternFieldOnMesh, SpectralIsASumOverTheLowestEigenpairs)
{
  const auto used = static_cast<Index>((this->Mass.array() > 0.0).count());
  MaternFieldOptions options = ByScreening(this->Tau, NoiseModel::Spectral);
  options.NumberOfEigenpairs = std::min<Index>(12, used - 1);
  const Eigenpairs pairs = LowestLaplaceEigenpairs(
    CotangentStiffness(this->Mesh), this->Mass, options.NumberOfEigenpairs);
  const Eigen::VectorXd weights =
    Normals(options.NumberOfEigenpairs, 13).cwiseQuotient((pairs.Values.array() + this->Tau).matrix());
  const MaternField field(this->Mesh, options);
  ExpectClose(field.Sample(Request(13)), pairs.Vectors * weights, 1e-9);
  EXPECT_EQ(field.EffectiveScreening(), this->Tau);
}

TEST_P(MaternFieldOnMesh, DefaultsGiveFiniteSamplesWithSmallResiduals)
{
  for (const NoiseModel model : AllModels)
  {
    MaternFieldOptions options;
    options.Model = model;
    options.NumberOfEigenpairs = 2;
    const MaternField field(this->Mesh, options);
    const Eigen::MatrixXd values = field.Sample(Request(1, 1, 3));
    ASSERT_EQ(values.rows(), this->Mesh.NumberOfPoints());
    ASSERT_EQ(values.cols(), 3);
    EXPECT_TRUE(values.allFinite());
    EXPECT_GT(values.norm(), 0.0);
    EXPECT_LE(field.RelativeResidual(), 1e-10);
    for (Index v = 0; v < values.rows(); ++v)
    {
      if (this->Mass[v] == 0.0)
      {
        EXPECT_EQ(values.row(v).cwiseAbs().maxCoeff(), 0.0) << "unused vertex " << v;
      }
    }
  }
}

TEST(MaternField, DefaultRangeIsAFifthOfTheLongestSide)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::PlanePatch(30, 20, 3.0, 2.0));
  const MaternField field(mesh, {});
  EXPECT_NEAR(field.EffectiveCorrelationRange(), 0.6, 1e-14);
  EXPECT_NEAR(field.LongestEdge(), std::sqrt(0.02), 1e-14);
  EXPECT_EQ(field.Mesh().Points, mesh.Points);
  EXPECT_EQ(field.Mesh().Triangles, mesh.Triangles);
}

// --- Scaling ----------------------------------------------------------------------------------------------------

TEST(MaternField, Algorithm2IsInvariantUnderScaling)
{
  for (const TriangleMesh& mesh : { test::BumpySurface(4), test::IrregularSphere(3), test::OpenCylinder(40, 20) })
  {
    const Eigen::MatrixXd reference = MaternField(mesh, ByNormalizedScreening(1e-3)).Sample(Request(3, 1, 2));
    for (const double scale : { 0.1, 2.0, 1e-5, 1e5 })
    {
      const MaternField field(test::Scaled(mesh, scale), ByNormalizedScreening(1e-3));
      ExpectClose(field.Sample(Request(3, 1, 2)), reference, 1e-9);
    }
  }
}

TEST(MaternField, FixedScreeningIsNotInvariantUnderScaling)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const Eigen::MatrixXd reference = MaternField(mesh, ByScreening(100.0)).Sample(Request(3));
  const Eigen::MatrixXd scaled = MaternField(test::Scaled(mesh, 2.0), ByScreening(100.0)).Sample(Request(3));
  EXPECT_GT((scaled - reference).norm(), 0.1 * reference.norm());
}

TEST(MaternField, RangeModeFollowsTheMeshUnderScaling)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const Eigen::MatrixXd reference = MaternField(mesh, ByRange(0.5)).Sample(Request(3));
  const Eigen::MatrixXd byDefault = MaternField(mesh, {}).Sample(Request(3));
  for (const double scale : { 0.1, 2.0, 1e-5, 1e5 })
  {
    ExpectClose(MaternField(test::Scaled(mesh, scale), ByRange(0.5 * scale)).Sample(Request(3)), reference, 1e-9);
    ExpectClose(MaternField(test::Scaled(mesh, scale), {}).Sample(Request(3)), byDefault, 1e-9);
  }
}

TEST(MaternField, IsLinearInTheStandardDeviation)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const Eigen::MatrixXd one = MaternField(mesh, ByRange(0.5)).Sample(Request(3));
  ExpectClose(MaternField(mesh, ByRange(0.5, 7.0)).Sample(Request(3)), 7.0 * one, 1e-14);
  EXPECT_EQ(MaternField(mesh, ByRange(0.5, 0.0)).Sample(Request(3)).cwiseAbs().maxCoeff(), 0.0);
}

// --- Range mode on closed spheres -------------------------------------------------------------------------------

namespace
{
struct SphereCase
{
  const char* Name;
  int Level;
  double Radius;
  double Range;
  std::uint32_t Samples; ///< enough that three standard errors of the pooled variance are below 3 per cent
};
void PrintTo(const SphereCase& sphere, std::ostream* os) { *os << sphere.Name; }

class MaternOnSphere : public testing::TestWithParam<SphereCase>
{};

// A sample holds about area / range^2 independent numbers, one at large ranges. Edges are at most an eighth of the
// range: linear elements with lumped mass raise the variance by about 2.7 (edge / range)^2.
INSTANTIATE_TEST_SUITE_P(Ranges, MaternOnSphere,
  testing::Values(SphereCase{ "SmallRange", 6, 1.0, 0.2, 200 }, SphereCase{ "ThirdOfRadius", 6, 1.0, 0.3, 200 },
    SphereCase{ "LargeSphere", 5, 50.0, 25.0, 600 }, SphereCase{ "RangeIsRadius", 4, 1.0, 1.0, 3000 },
    SphereCase{ "RangeIsDiameter", 3, 1.0, 2.0, 10000 }, SphereCase{ "RangeIsCircumference", 3, 1.0, 6.28, 20000 },
    SphereCase{ "RangeBeyondTheSphere", 2, 1.0, 30.0, 20000 }),
  [](const auto& info) { return info.param.Name; });
} // namespace

TEST_P(MaternOnSphere, VarianceIsTheOneAskedForWithin5PerCent)
{
  const SphereCase& sphere = GetParam();
  const TriangleMesh mesh = test::Icosphere(sphere.Level, sphere.Radius);
  const MaternField field(mesh, ByRange(sphere.Range, 3.0));
  EXPECT_NEAR(PooledVariance(field, Request(17, sphere.Samples), LumpedMass(mesh)), 9.0, 0.05 * 9.0);
}

TEST_P(MaternOnSphere, CorrelationIsThatOfTheExactSpectrum)
{
  // 0.03 covers sampling, elements and the width of the distance bins.
  const SphereCase& sphere = GetParam();
  const double angle = std::min(sphere.Range / sphere.Radius, 2.0);
  const double tau = 8.0 * sphere.Radius * sphere.Radius / (sphere.Range * sphere.Range);
  const MaternField field(test::Icosphere(sphere.Level, sphere.Radius), ByRange(sphere.Range));
  const double correlation = CorrelationAtDistance(
    field, Request(18, std::min(sphere.Samples, 3000U)), sphere.Radius, angle * sphere.Radius);
  EXPECT_NEAR(correlation, SphereCovariance(tau, angle) / SphereCovariance(tau, 0.0), 0.03);
}

TEST(MaternField, CorrelationAtTheRangeIs014OnIrregularSpheres)
{
  const TriangleMesh mesh = test::IrregularSphere(5);
  for (const double range : { 0.25, 0.4 })
  {
    const MaternField field(mesh, ByRange(range));
    EXPECT_NEAR(CorrelationAtDistance(field, Request(19, 300), 1.0, range), 0.14, 0.03) << range;
    EXPECT_NEAR(PooledVariance(field, Request(20, 300), LumpedMass(mesh)), 1.0, 0.05) << range;
  }
}

TEST(MaternField, CorrelationAtTheRangeIs014OnRegularSpheres)
{
  const TriangleMesh mesh = test::Icosphere(5);
  for (const double range : { 0.2, 0.3, 0.4 })
  {
    const MaternField field(mesh, ByRange(range));
    EXPECT_NEAR(CorrelationAtDistance(field, Request(21, 200), 1.0, range), 0.14, 0.03) << range;
  }
}

TEST(MaternField, EveryComponentHasTheDeviationAskedFor)
{
  // Range 0.5 is small on the first sphere, of the size of the second, and beyond the third.
  const std::vector<TriangleMesh> parts = { test::Icosphere(5), test::Translated(test::Icosphere(3, 0.4), { 4, 0, 0 }),
    test::Translated(test::Icosphere(2, 0.05), { 8, 0, 0 }) };
  const TriangleMesh mesh = test::Join(test::Join(parts[0], parts[1]), parts[2]);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const MaternField field(mesh, ByRange(0.5, 2.0));
  Eigen::Index begin = 0;
  for (const TriangleMesh& part : parts)
  {
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(mass.size());
    weights.segment(begin, part.Points.rows()) = mass.segment(begin, part.Points.rows());
    begin += part.Points.rows();
    EXPECT_NEAR(PooledVariance(field, Request(22, 8000), weights), 4.0, 0.05 * 4.0) << "component at " << begin;
  }
}

TEST(MaternField, OpenSurfacesHaveTheDeviationInsideAndMoreAtTheBoundary)
{
  const TriangleMesh mesh = test::PlanePatch(60, 60, 6.0, 6.0, 0.1);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  Eigen::VectorXd inside = mass;
  Eigen::VectorXd edge = mass;
  for (Index v = 0; v < mass.size(); ++v)
  {
    const double x = mesh.Points(v, 0);
    const double y = mesh.Points(v, 1);
    const double distance = std::min({ x, y, 6.0 - x, 6.0 - y });
    inside[v] *= distance > 1.5 ? 1.0 : 0.0;
    edge[v] *= (x == 0.0 || x == 6.0) && y > 1.5 && y < 4.5 ? 1.0 : 0.0;
  }
  const MaternField field(mesh, ByRange(1.0));
  EXPECT_NEAR(PooledVariance(field, Request(23, 800), inside), 1.0, 0.05);
  EXPECT_NEAR(PooledVariance(field, Request(23, 800), edge), 2.0, 0.15) << "Neumann: a factor sqrt(2) on the deviation";
}

// --- MarginalVariance -------------------------------------------------------------------------------------------

TEST(MarginalVariance, IsWithin5PerCentOfTheExactSumOnTheSphere)
{
  double worst = 0.0;
  for (double exponent = -4.0; exponent <= 5.0; exponent += 0.1)
  {
    const double tau = std::pow(10.0, exponent);
    worst = std::max(worst, std::abs(MarginalVariance(tau, 4.0 * Pi, 2, true) / SphereCovariance(tau, 0.0) - 1.0));
  }
  EXPECT_LT(worst, 0.05);
}

TEST(MarginalVariance, IsExactInBothLimitsOnTheSphere)
{
  for (const double tau : { 1e-4, 1e3, 1e4 })
  {
    EXPECT_NEAR(MarginalVariance(tau, 4.0 * Pi, 2, true) / SphereCovariance(tau, 0.0), 1.0, 1e-3) << tau;
  }
}

TEST(MarginalVariance, ScalesWithTheSquareOfLength)
{
  // tau scales with length^-2 and the area with length^2.
  for (const bool closed : { true, false })
  {
    const double reference = MarginalVariance(3.0, 5.0, 0, closed);
    EXPECT_NEAR(MarginalVariance(3.0 / 49.0, 5.0 * 49.0, 0, closed), 49.0 * reference, 1e-12 * 49.0 * reference);
  }
}

TEST(MarginalVariance, OfHighGenusIsPositiveAndAtMostThatOfThePlanePlusTheConstant)
{
  for (const std::int64_t euler : { 2, 0, -2, -40, -1000 })
  {
    for (const double tau : { 1e-3, 1.0, 1e3 })
    {
      const double variance = MarginalVariance(tau, 1.0, euler, true);
      EXPECT_GT(variance, 0.0);
      EXPECT_LE(variance, 1.0 / (tau * tau) + 1.0 / (4.0 * Pi * tau));
    }
  }
}

TEST(MarginalVariance, OfOpenSurfacesIsThatOfThePlaneOrOfTheConstant)
{
  EXPECT_DOUBLE_EQ(MarginalVariance(100.0, 5.0, 1, false), 1.0 / (400.0 * Pi));
  EXPECT_DOUBLE_EQ(MarginalVariance(1e-3, 5.0, 1, false), 1.0 / (5.0 * 1e-6));
}

// --- Streams and bits -------------------------------------------------------------------------------------------

TEST(MaternField, ASampleHasTheSameBitsAloneAndInEveryBatch)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::BumpySurface(3));
  for (const NoiseModel model : AllModels)
  {
    const MaternField field(mesh, ByScreening(30.0, model));
    for (const std::uint32_t components : { 1U, 3U })
    {
      const std::vector<Eigen::MatrixXd> batch = Draw(field, Request(5, 77, components));
      ASSERT_EQ(batch.size(), 77U);
      for (const std::uint32_t k : { 0U, 1U, 31U, 32U, 33U, 63U, 64U, 76U })
      {
        SampleRequest alone = Request(5, 1, components);
        alone.FirstSample = k;
        EXPECT_TRUE(SameBits(field.Sample(alone), batch[k])) << "sample " << k << " of model " << int(model);
      }
      SampleRequest part = Request(5, 40, components);
      part.FirstSample = 20;
      const std::vector<Eigen::MatrixXd> later = Draw(field, part);
      for (std::size_t k = 0; k < 40; ++k)
      {
        EXPECT_TRUE(SameBits(later[k], batch[k + 20]));
      }
    }
  }
}

TEST(MaternField, ComponentsHaveTheSameBitsWhateverTheirNumber)
{
  const MaternField field(test::BumpySurface(3), ByRange(0.5));
  const Eigen::MatrixXd many = field.Sample(Request(5, 1, 50));
  for (const std::uint32_t components : { 1U, 2U, 9U, 33U })
  {
    EXPECT_TRUE(SameBits(field.Sample(Request(5, 1, components)), many.leftCols(components)));
  }
}

TEST(MaternField, HasTheSameBitsForEveryNumberOfThreadsTenTimes)
{
#ifdef __SANITIZE_THREAD__
  const int repeats = 4; // each number of threads once: a race is found the first time
  const TriangleMesh mesh = test::BumpySurface(4);
#else
  const int repeats = 10;
  const TriangleMesh mesh = test::BumpySurface(5);
#endif
  for (const NoiseModel model : AllModels)
  {
    std::vector<Eigen::MatrixXd> reference;
    {
      const ThreadScope one(1);
      reference = Draw(MaternField(mesh, ByScreening(30.0, model)), Request(6, 40, 2));
    }
    for (int repeat = 0; repeat < repeats; ++repeat)
    {
      const ThreadScope scope(1 + repeat % 4);
      const std::vector<Eigen::MatrixXd> samples = Draw(MaternField(mesh, ByScreening(30.0, model)), Request(6, 40, 2));
      ASSERT_EQ(samples.size(), reference.size());
      for (std::size_t k = 0; k < samples.size(); ++k)
      {
        ASSERT_TRUE(SameBits(samples[k], reference[k]))
          << "model " << int(model) << ", " << 1 + repeat % 4 << " threads";
      }
    }
  }
}

TEST(MaternField, SeedsSamplesComponentsAndStreamsAreIndependent)
{
  // Correlations of samples with about 400 independent numbers each.
  const TriangleMesh mesh = test::Icosphere(5);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const MaternField field(mesh, ByRange(0.2));
  const Eigen::VectorXd reference = field.Sample(Request(5));
  const auto correlation = [&](const Eigen::VectorXd& other) {
    const auto dot = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return a.cwiseProduct(mass).dot(b); };
    return dot(reference, other) / std::sqrt(dot(reference, reference) * dot(other, other));
  };
  SampleRequest stream = Request(5);
  stream.Stream = 1;
  SampleRequest sample = Request(5);
  sample.FirstSample = 1;
  EXPECT_LT(std::abs(correlation(field.Sample(Request(6)))), 0.25) << "seed";
  EXPECT_LT(std::abs(correlation(field.Sample(stream))), 0.25) << "stream";
  EXPECT_LT(std::abs(correlation(field.Sample(sample))), 0.25) << "sample";
  EXPECT_LT(std::abs(correlation(field.Sample(Request(5, 1, 2)).col(1))), 0.25) << "component";
  EXPECT_NEAR(correlation(field.Sample(Request(5))), 1.0, 1e-14) << "the same again";
}

TEST(MaternField, TheSeedFixesThePatternWhateverTheRange)
{
  // The numbers are keyed by vertex, not drawn in order: a slightly longer range gives nearly the same field.
  const TriangleMesh mesh = test::BumpySurface(4);
  const Eigen::VectorXd a = MaternField(mesh, ByRange(0.5)).Sample(Request(5));
  const Eigen::VectorXd b = MaternField(mesh, ByRange(0.55)).Sample(Request(5));
  EXPECT_GT(a.dot(b) / (a.norm() * b.norm()), 0.95);
}

TEST(MaternField, HandsSamplesOverInOrderOnTheCallingThread)
{
  const ThreadScope scope(3);
  const MaternField field(test::BumpySurface(3), ByRange(0.5));
  SampleRequest request = Request(1, 150, 2);
  request.FirstSample = 1000;
  std::uint32_t next = 1000;
  const std::thread::id caller = std::this_thread::get_id();
  field.Sample(request, [&](std::uint32_t sample, const Eigen::Ref<const Eigen::MatrixXd>& values) {
    EXPECT_EQ(sample, next++);
    EXPECT_EQ(values.cols(), 2);
    EXPECT_EQ(std::this_thread::get_id(), caller);
  });
  EXPECT_EQ(next, 1150U);
}

TEST(MaternField, NoSamplesIsNoCall)
{
  const MaternField field(test::Icosphere(2), ByRange(0.5));
  field.Sample(Request(1, 0), [](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>&) { FAIL(); });
}

TEST(MaternField, ExceptionsOfTheConsumerPassThrough)
{
  const MaternField field(test::Icosphere(2), ByRange(0.5));
  const Eigen::MatrixXd before = field.Sample(Request(1));
  EXPECT_THROW(field.Sample(Request(1, 100),
                 [](std::uint32_t sample, const Eigen::Ref<const Eigen::MatrixXd>&) {
                   if (sample == 50)
                   {
                     throw FormatError("disk full");
                   }
                 }),
    FormatError);
  EXPECT_TRUE(SameBits(field.Sample(Request(1)), before));
}

TEST(MaternField, SeveralThreadsMaySampleAtOnce)
{
  const MaternField field(test::BumpySurface(4), ByRange(0.5));
  std::vector<Eigen::MatrixXd> expected;
  for (std::uint64_t t = 0; t < 4; ++t)
  {
    expected.push_back(field.Sample(Request(t)));
  }
  std::vector<std::thread> threads;
  std::vector<int> equal(4, 0);
  for (std::size_t t = 0; t < 4; ++t)
  {
    threads.emplace_back([&, t] { equal[t] = SameBits(field.Sample(Request(t)), expected[t]) ? 1 : 0; });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(equal, std::vector<int>(4, 1));
}

TEST(MaternField, MovesWithItsFactor)
{
  MaternField first(test::Icosphere(2), ByRange(0.5));
  const Eigen::MatrixXd expected = first.Sample(Request(1));
  MaternField second(std::move(first));
  EXPECT_TRUE(SameBits(second.Sample(Request(1)), expected));
}

// --- Edge cases and refusals ------------------------------------------------------------------------------------

TEST(MaternField, OfAnEmptyMeshIsEmpty)
{
  for (const NoiseModel model : AllModels)
  {
    MaternFieldOptions options;
    options.Model = model;
    EXPECT_EQ(MaternField(TriangleMesh(), options).Sample(Request(1, 1, 2)).rows(), 0);
    TriangleMesh points;
    points.Points = PointMatrix::Random(7, 3);
    const Eigen::MatrixXd values = MaternField(points, options).Sample(Request(1, 1, 2));
    ASSERT_EQ(values.rows(), 7);
    ASSERT_EQ(values.cols(), 2);
    EXPECT_EQ(values.cwiseAbs().maxCoeff(), 0.0) << "no triangle uses a point";
  }
}

TEST(MaternField, RejectsOptionsOutOfRange)
{
  const TriangleMesh mesh = test::Icosphere(1);
  const auto refuse = [&](const MaternFieldOptions& options, const char* what) {
    EXPECT_THROW(MaternField(mesh, options), InvalidInput) << what;
  };
  for (const double bad : { -1.0, NaN, Infinity, -Infinity })
  {
    refuse(ByRange(bad), "range");
    refuse(ByRange(1.0, bad), "deviation");
    refuse(ByScreening(bad), "tau");
    refuse(ByScreening(bad, NoiseModel::Spectral), "tau of the spectral model");
    refuse(ByNormalizedScreening(bad), "c");
    MaternFieldOptions perVertex;
    perVertex.Model = NoiseModel::PerVertex;
    perVertex.StandardDeviation = bad;
    refuse(perVertex, "deviation per vertex");
  }
  refuse(ByScreening(0.0), "tau 0");
  refuse(ByNormalizedScreening(0.0), "c 0");
  for (const Index bad : { -1, 0, 42, 1000 }) // the mesh has 42 points
  {
    MaternFieldOptions options = ByScreening(1.0, NoiseModel::Spectral);
    options.NumberOfEigenpairs = bad;
    refuse(options, "eigenpairs");
  }
  MaternFieldOptions options = ByScreening(1.0, NoiseModel::Spectral);
  options.NumberOfEigenpairs = 41;
  EXPECT_NO_THROW(MaternField(mesh, options));
}

TEST(MaternField, RejectsRangesWhoseScreeningOverflows)
{
  const TriangleMesh mesh = test::Icosphere(1);
  EXPECT_THROW(MaternField(mesh, ByRange(1e-200)), InvalidInput);
  EXPECT_THROW(MaternField(mesh, ByRange(1e200)), InvalidInput);
}

TEST(MaternField, IgnoresOptionsThatTheModelDoesNotName)
{
  const TriangleMesh mesh = test::Icosphere(1);
  MaternFieldOptions range = ByRange(0.5);
  range.Screening = range.NormalizedScreening = NaN;
  range.NumberOfEigenpairs = -5;
  EXPECT_NO_THROW(MaternField(mesh, range));
  MaternFieldOptions screening = ByScreening(3.0);
  screening.CorrelationRange = screening.StandardDeviation = screening.NormalizedScreening = NaN;
  screening.NumberOfEigenpairs = -5;
  EXPECT_NO_THROW(MaternField(mesh, screening));
  for (const NoiseModel model : { NoiseModel::White, NoiseModel::Unscreened })
  {
    MaternFieldOptions options;
    options.Model = model;
    options.CorrelationRange = options.StandardDeviation = options.Screening = options.NormalizedScreening = NaN;
    EXPECT_NO_THROW(MaternField(mesh, options));
  }
}

TEST(MaternField, RejectsRequestsWithoutComponents)
{
  EXPECT_THROW(MaternField(test::Icosphere(1), ByRange(0.5)).Sample(Request(1, 1, 0)), InvalidInput);
}

TEST(MaternField, RejectsInvalidMeshes)
{
  for (const NoiseModel model : AllModels)
  {
    MaternFieldOptions options;
    options.Model = model;
    options.NumberOfEigenpairs = 5;
    TriangleMesh outOfRange = test::Icosphere(1);
    outOfRange.Triangles(3, 1) = 99999;
    EXPECT_THROW(MaternField(outOfRange, options), InvalidInput);
    TriangleMesh notFinite = test::Icosphere(1);
    notFinite.Points(3, 1) = NaN;
    EXPECT_THROW(MaternField(notFinite, options), InvalidInput);
    TriangleMesh degenerate = test::Icosphere(1);
    degenerate.Points.row(degenerate.Triangles(0, 0)) = degenerate.Points.row(degenerate.Triangles(0, 1)).eval();
    EXPECT_THROW(MaternField(degenerate, options), InvalidInput);
    TriangleMesh nonManifold = test::Icosphere(1);
    nonManifold.Triangles.conservativeResize(81, 3);
    nonManifold.Triangles.row(80) = nonManifold.Triangles.row(0);
    EXPECT_THROW(MaternField(nonManifold, options), InvalidInput);
  }
}

TEST(MaternField, WorksAtExtremeScalesAndFarFromTheOrigin)
{
  for (const double scale : { 1e-12, 1e12 })
  {
    const MaternField field(test::Scaled(test::BumpySurface(4), scale), {});
    EXPECT_TRUE(field.Sample(Request(1)).allFinite());
    EXPECT_LE(field.RelativeResidual(), 1e-10);
  }
  const MaternField far(test::Translated(test::Icosphere(3), { 1e9, -1e9, 1e9 }), {});
  EXPECT_TRUE(far.Sample(Request(1)).allFinite());
  EXPECT_LE(far.RelativeResidual(), 1e-10);
}

// --- Progress ---------------------------------------------------------------------------------------------------

TEST(MaternField, ProgressNeverFallsAndStaysOnTheCallingThread)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  for (const NoiseModel model : AllModels)
  {
    for (const int threads : { 1, 3 })
    {
      const ThreadScope scope(threads);
      double last = 0.0;
      int reports = 0;
      const std::thread::id caller = std::this_thread::get_id();
      const Progress progress = [&](double fraction) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        EXPECT_GE(fraction, last);
        EXPECT_LE(fraction, 1.0 + 1e-12);
        last = fraction;
        ++reports;
        return true;
      };
      const MaternField field(mesh, ByScreening(30.0, model), progress);
      EXPECT_GT(reports, 0);
      last = 0.0;
      reports = 0;
      field.Sample(
        Request(1, 150), [](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>&) {}, progress);
      EXPECT_NEAR(last, 1.0, 1e-12);
      EXPECT_GE(reports, 2);
    }
  }
}

TEST(MaternField, StopsOnRequestAtEveryReportAndCanGoOnAfterwards)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const MaternField field(mesh, ByScreening(30.0));
  const Eigen::MatrixXd expected = field.Sample(Request(1));
  for (const int allowed : { 0, 1, 2, 3, 5 })
  {
    int left = allowed;
    const Progress impatient = [&](double) { return left-- > 0; };
    EXPECT_THROW(field.Sample(
                   Request(1, 500), [](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>&) {}, impatient),
      Cancelled)
      << allowed;
    EXPECT_EQ(left, -1) << "nothing is reported after the request";
    EXPECT_TRUE(SameBits(field.Sample(Request(1)), expected));
    left = std::min(allowed, 1);
    EXPECT_THROW(MaternField(mesh, ByScreening(30.0), impatient), Cancelled) << allowed;
  }
}
