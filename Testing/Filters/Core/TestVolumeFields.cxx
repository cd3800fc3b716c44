// SPDX-License-Identifier: BSD-3-Clause
// Operators of tetrahedral meshes, and Matérn fields in volumes against closed forms and dense algebra.
#include "DenseFields.h"
#include "ExampleVolumes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/VolumePlace.h"
#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternField.h"
#include "Core/Operators/VolumeOperators.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

using namespace surfsynth;
using surfsynth::test::BoxOfTetrahedra;
using surfsynth::test::BoxVertex;
using surfsynth::test::Covariance;
using surfsynth::test::DenseCovariance;
using surfsynth::test::ExpectClose;
using surfsynthtest::TextOf;
using testing::HasSubstr;

namespace
{
using Cells = std::array<Index, 3>;

MaternFieldOptions ByRange(double range, int power = 2)
{
  MaternFieldOptions options;
  options.CorrelationRange = range;
  options.OperatorPower = power;
  return options;
}

MaternFieldOptions ByScreening(double tau, int power)
{
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  options.Screening = tau;
  options.OperatorPower = power;
  return options;
}

/// Small, irregular and thin.
TetrahedralMesh ThinBox() { return BoxOfTetrahedra({ 9, 6, 3 }, { 1.0, 0.6, 0.12 }, 0.12); }

/// Correlation of the Matérn family at the distance @p d for nu = power - 3/2.
double MaternCorrelation(double d, double range, int power)
{
  const double x = d * std::sqrt(8.0 * (power - 1.5)) / range;
  const double factor = power == 2 ? 1.0 : power == 3 ? 1.0 + x : 1.0 + x + x * x / 3.0;
  return factor * std::exp(-x);
}

Eigen::MatrixXd DenseOperator(const TetrahedralMesh& mesh, double tau)
{
  Eigen::MatrixXd matrix = VolumeStiffness(mesh);
  matrix.diagonal() += tau * LumpedMass(mesh);
  return matrix;
}

/// Covariances of the field with that at a vertex.
Eigen::VectorXd CovariancesWith(const MaternField& field, Index vertex)
{
  return field.SolvePrecision(Eigen::VectorXd::Unit(field.Mesh().Points.rows(), vertex));
}

class VolumeFieldOfPower : public testing::TestWithParam<int>
{};

INSTANTIATE_TEST_SUITE_P(
  Powers, VolumeFieldOfPower, testing::Values(1, 2, 3, 4), [](const auto& info) { return std::to_string(info.param); });
} // namespace

TEST(VolumeOperators, AreThoseOfAHandComputedTetrahedron)
{
  TetrahedralMesh mesh{ PointMatrix(4, 3), TetrahedronMatrix(1, 4) };
  mesh.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.Tetrahedra << 0, 1, 2, 3;
  EXPECT_DOUBLE_EQ(SixfoldVolume(mesh, 0), 1.0);
  Eigen::Matrix4d expected;
  expected << 3, -1, -1, -1, -1, 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1;
  ExpectClose(Eigen::MatrixXd(VolumeStiffness(mesh)), expected / 6.0, 1e-15);
  ExpectClose(LumpedMass(mesh), Eigen::Vector4d::Constant(1.0 / 24.0), 1e-15);
  const auto faces = FindFaces(mesh);
  ASSERT_EQ(faces.Boundary.size(), 4U);
  EXPECT_NEAR(BoundaryMass(mesh, faces.Boundary).sum(), 1.5 + 0.5 * std::sqrt(3.0), 1e-14);
}

TEST(VolumeOperators, GiveTheEnergyOfLinearFunctionsAndTheVolume)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 5, 4, 3 }, { 2.0, 1.0, 0.5 }, 0.14);
  const Eigen::MatrixXd stiffness = VolumeStiffness(mesh);
  const Eigen::Vector3d slope(0.3, -1.2, 2.0);
  const Eigen::VectorXd linear = mesh.Points * slope;
  EXPECT_NEAR(LumpedMass(mesh).sum(), 1.0, 1e-13);
  EXPECT_NEAR(linear.dot(stiffness * linear), slope.squaredNorm(), 1e-11);
  EXPECT_LE((stiffness * Eigen::VectorXd::Ones(stiffness.rows())).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(stiffness, Eigen::MatrixXd(stiffness.transpose()));
  EXPECT_NEAR(BoundaryMass(mesh, FindFaces(mesh).Boundary).sum(), 2.0 * (2.0 + 1.0 + 0.5), 1e-12);
  const PointMatrix directions = Eigen::RowVector3d(0.0, -3.0, 0.0).replicate(mesh.NumberOfPoints(), 1);
  const Eigen::MatrixXd stretched = VolumeStiffness(mesh, DirectionTensors(mesh, directions, 8.0));
  const double expected = 0.25 * (0.09 + 4.0) + 16.0 * 1.44; // 8^(-2/3) across, 8^(4/3) along
  EXPECT_NEAR(linear.dot(stretched * linear), expected, 1e-10);
}

TEST(VolumeOperators, HaveTheSameBitsForEveryNumberOfThreads)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 30, 30, 30 });
  const auto assemble = [&mesh](int threads) {
    const ThreadScope scope(threads);
    return VolumeStiffness(mesh);
  };
  const SparseMatrix one = assemble(1);
  const SparseMatrix four = assemble(4);
  ASSERT_EQ(one.nonZeros(), four.nonZeros());
  EXPECT_EQ(0, std::memcmp(one.valuePtr(), four.valuePtr(), sizeof(double) * static_cast<std::size_t>(one.nonZeros())));
}

TEST(VolumeCheck, CountsInvertedTetrahedraWhichGiveTheSameField)
{
  TetrahedralMesh mesh = ThinBox();
  EXPECT_EQ(RequireValidVolume(mesh), 0);
  const Eigen::MatrixXd sample = MaternField(mesh, ByRange(0.5)).Sample();
  for (const Index t : { 0, 7, 100 })
  {
    std::swap(mesh.Tetrahedra(t, 0), mesh.Tetrahedra(t, 1));
  }
  EXPECT_EQ(RequireValidVolume(mesh), 3);
  ExpectClose(MaternField(mesh, ByRange(0.5)).Sample(), sample, 1e-10);
}

TEST(VolumeCheck, NamesEachDefect)
{
  const auto textOf = [](const std::function<void(TetrahedralMesh&)>& change) {
    TetrahedralMesh mesh = ThinBox();
    change(mesh);
    return TextOf<InvalidInput>([&] { RequireValidVolume(mesh, [](std::int64_t t) { return t + 1000; }); });
  };
  EXPECT_THAT(textOf([](auto& mesh) { mesh.Tetrahedra.resize(0, 4); }), HasSubstr("no tetrahedra"));
  EXPECT_THAT(textOf([](auto& mesh) { mesh.Tetrahedra(5, 2) = 100000; }), HasSubstr("first cell 1005"));
  EXPECT_THAT(textOf([](auto& mesh) { mesh.Tetrahedra(5, 2) = -1; }), HasSubstr("does not exist"));
  EXPECT_THAT(textOf([](auto& mesh) { mesh.Points(3, 1) = std::nan(""); }),
    HasSubstr("1 point(s) with a coordinate that is not finite, first point 3"));
  EXPECT_THAT(
    textOf([](auto& mesh) { mesh.Tetrahedra(9, 1) = mesh.Tetrahedra(9, 0); }), HasSubstr("use a point twice"));
  EXPECT_THAT(textOf([](auto& mesh) { mesh.Points.col(2).setZero(); }), HasSubstr("972 degenerate tetrahedra"));
  EXPECT_THAT(textOf([](auto& mesh) {
    mesh.Tetrahedra.row(1) = mesh.Tetrahedra.row(0);
    mesh.Tetrahedra.row(2) = mesh.Tetrahedra.row(0);
  }),
    HasSubstr("face(s) with more than two tetrahedra"));
}

TEST(VolumeCheck, IgnoresPointsThatNoTetrahedronUses)
{
  TetrahedralMesh mesh = ThinBox();
  const Index points = mesh.NumberOfPoints();
  mesh.Points.conservativeResize(points + 1, 3);
  mesh.Points.row(points).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(RequireValidVolume(mesh), 0);
  const Eigen::MatrixXd sample = MaternField(mesh, ByRange(0.5)).Sample();
  EXPECT_TRUE(sample.allFinite());
  EXPECT_EQ(sample(points, 0), 0.0);
}

TEST(VolumePlaces, AreTheNearestOnesWithBarycentricWeights)
{
  TetrahedralMesh mesh{ PointMatrix(4, 3), TetrahedronMatrix(1, 4) };
  mesh.Points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.Tetrahedra << 0, 1, 2, 3;
  const Eigen::Vector3d inside(0.2, 0.3, 0.1);
  EXPECT_LE((PositionOf(mesh, NearestInTetrahedron(mesh, 0, inside)) - inside).norm(), 1e-15);
  EXPECT_LE(
    (PositionOf(mesh, NearestInTetrahedron(mesh, 0, { 0.2, 0.3, -0.7 })) - Eigen::Vector3d(0.2, 0.3, 0.0)).norm(),
    1e-15);
  EXPECT_LE(
    (PositionOf(mesh, NearestInTetrahedron(mesh, 0, { 1, 1, 1 })) - Eigen::Vector3d::Constant(1.0 / 3.0)).norm(),
    1e-15);
  EXPECT_LE((PositionOf(mesh, NearestInTetrahedron(mesh, 0, { -1, -2, 5 })) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
}

TEST_P(VolumeFieldOfPower, HasTheSpectrumOfTheClosedForm)
{
  // Eigenfunctions of the cube with Neumann condition: products of cosines, lambda = pi^2 (i^2 + j^2 + k^2).
  const int power = GetParam();
  const double tau = 25.0;
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 20, 20, 20 });
  const MaternField field(mesh, ByScreening(tau, power));
  const Eigen::VectorXd mass = LumpedMass(mesh);
  for (const Eigen::Vector3d& wave : { Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 1, 1),
         Eigen::Vector3d(0, 2, 1), Eigen::Vector3d(3, 0, 0) })
  {
    const Eigen::VectorXd mode = (mesh.Points * (M_PI * wave).asDiagonal()).array().cos().rowwise().prod().matrix();
    const Eigen::VectorXd weighted = mass.cwiseProduct(mode);
    const double variance = weighted.dot(Eigen::VectorXd(field.SolvePrecision(weighted))) / weighted.dot(mode);
    const double lambda = M_PI * M_PI * wave.squaredNorm();
    // Linear elements of side h take the eigenvalue of cos(k x) for k^2 (1 - (k h)^2 / 12), to second order.
    const double shift = std::pow(M_PI, 4.0) * wave.array().pow(4.0).sum() / (12.0 * 20.0 * 20.0);
    EXPECT_NEAR(variance * std::pow(lambda + tau, power), 1.0 + power * shift / (lambda + tau), 0.01)
      << "wave " << wave.transpose();
  }
}

TEST_P(VolumeFieldOfPower, HasTheCovarianceOfDenseAlgebraTo1em8)
{
  const int power = GetParam();
  const TetrahedralMesh mesh = ThinBox();
  const Eigen::MatrixXd expected = DenseCovariance(DenseOperator(mesh, 40.0), LumpedMass(mesh), power);
  const MaternField field(mesh, ByScreening(40.0, power));
  ExpectClose(Covariance(field), expected, 1e-8);
  ExpectClose(field.MarginalVariances(), expected.diagonal(), 1e-8);
}

TEST(VolumeField, NextToAnIntegerPowerIsTheExactFieldTo2em4)
{
  const TetrahedralMesh mesh = ThinBox();
  for (const double power : { 2.0, 3.0 })
  {
    MaternFieldOptions options;
    options.CorrelationRange = 0.4;
    options.OperatorPower = power;
    const MaternField exact(mesh, options);
    for (const double step : { -1e-6, 1e-6 })
    {
      options.OperatorPower = power + step;
      const MaternField field(mesh, options);
      ExpectClose(Covariance(field), Covariance(exact), 2.02e-4);
      EXPECT_NEAR(field.Smoothness(), power - 1.5, 1.1e-6);
    }
  }
  // Between half the dimension and 2, with the deviation corrected.
  MaternFieldOptions options;
  options.CorrelationRange = 0.4;
  options.OperatorPower = 1.75;
  options.VarianceCorrection = true;
  const Eigen::VectorXd deviations = Covariance(MaternField(mesh, options)).diagonal().cwiseSqrt();
  EXPECT_LE((deviations.array() - 1.0).abs().maxCoeff(), 1e-8);
  options.OperatorPower = 1.5;
  EXPECT_THROW(MaternField(mesh, options), InvalidInput);
}

TEST_P(VolumeFieldOfPower, HasTheExactDeviationEverywhereAfterCorrection)
{
  MaternFieldOptions options = ByScreening(40.0, GetParam());
  options.VarianceCorrection = true;
  options.StandardDeviation = 1.5;
  const TetrahedralMesh mesh = ThinBox();
  const MaternField field(mesh, options);
  ExpectClose(field.MarginalVariances(), Eigen::VectorXd::Constant(mesh.NumberOfPoints(), 2.25), 1e-8);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
  SampleRequest request;
  request.NumberOfSamples = 25000;
  field.Sample(request, [&](std::uint32_t, const auto& values) { squares += values.col(0).cwiseAbs2(); });
  const Eigen::VectorXd deviation = (squares / 25000.0).cwiseSqrt();
  EXPECT_LE((deviation.array() / 1.5 - 1.0).abs().maxCoeff(), 0.02) << "4.5 standard errors";
}

TEST_P(VolumeFieldOfPower, CorrelatesAsTheClosedFormInsideACube)
{
  const int power = GetParam();
  if (power == 1)
  {
    EXPECT_THAT(TextOf<InvalidInput>([] { MaternField(ThinBox(), ByRange(0.5, 1)); }),
      HasSubstr("in a volume alpha = 1 has the smoothness nu = -1/2, no finite variance"));
    return;
  }
  const Cells cells{ 30, 30, 30 };
  const double range = 0.3; // nine edges; the boundary is 1.7 ranges away
  const MaternField field(BoxOfTetrahedra(cells), ByRange(range, power));
  const Eigen::VectorXd covariances = CovariancesWith(field, BoxVertex(cells, 15, 15, 15));
  // Rough fields lose variance below the edge length; covariances at a distance do not.
  EXPECT_NEAR(std::sqrt(covariances[BoxVertex(cells, 15, 15, 15)]), 1.0, power == 2 ? 0.1 : 0.03);
  for (const Index steps : { 3, 4, 6, 8 })
  {
    const double along = covariances[BoxVertex(cells, 15 + steps, 15, 15)];
    const double diagonal = covariances[BoxVertex(cells, 15, 15 + steps, 15 - steps)];
    EXPECT_NEAR(along, MaternCorrelation(steps / 30.0, range, power), 0.03) << steps;
    EXPECT_NEAR(diagonal, MaternCorrelation(std::sqrt(2.0) * steps / 30.0, range, power), 0.03) << steps;
  }
  EXPECT_NEAR(field.EffectiveCorrelationRange(), range, 1e-12);
  EXPECT_EQ(field.Smoothness(), power - 1.5);
}

TEST(VolumeField, HasSamplesWithTheCovarianceOfTheField)
{
  const Cells cells{ 14, 14, 14 };
  const TetrahedralMesh mesh = BoxOfTetrahedra(cells);
  const MaternField field(mesh, ByRange(0.5));
  const Index center = BoxVertex(cells, 7, 7, 7);
  const Eigen::VectorXd expected = CovariancesWith(field, center);
  constexpr std::uint32_t Samples = 4000;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
  SampleRequest request;
  request.Seed = 11;
  request.NumberOfSamples = Samples;
  field.Sample(request, [&](std::uint32_t, const auto& values) { sum += values(center, 0) * values.col(0); });
  // The standard error of a covariance c of two numbers of variance v is below v sqrt(2 / n).
  const double error = expected[center] * std::sqrt(2.0 / Samples);
  for (const Index k : { 7, 9, 11, 13 })
  {
    const Index v = BoxVertex(cells, k, 7, 7);
    EXPECT_NEAR(sum[v] / Samples, expected[v], 4.0 * error) << k;
  }
}

TEST(VolumeField, IsStretchedAlongADirectionByTheRatio)
{
  const Cells cells{ 56, 20, 20 };
  const TetrahedralMesh mesh = BoxOfTetrahedra(cells, { 2.8, 1.0, 1.0 });
  MaternFieldOptions options = ByRange(0.5, 3);
  options.AnisotropyRatio = 3.0;
  options.Arrays.Directions = Eigen::RowVector3d(2.0, 0.0, 0.0).replicate(mesh.NumberOfPoints(), 1);
  const Eigen::VectorXd covariances = CovariancesWith(MaternField(mesh, options), BoxVertex(cells, 28, 10, 10));
  const double variance = covariances[BoxVertex(cells, 28, 10, 10)];
  for (const Index steps : { 2, 3, 4 })
  {
    const double along = covariances[BoxVertex(cells, 28 + 3 * steps, 10, 10)] / variance;
    const double across = covariances[BoxVertex(cells, 28, 10 + steps, 10)] / variance;
    const double expected = MaternCorrelation(0.05 * steps, 0.5 / std::cbrt(3.0), 3);
    EXPECT_NEAR(along, expected, 0.04) << steps;
    EXPECT_NEAR(across, expected, 0.04) << steps;
  }
}

TEST(VolumeField, MeetsBoundaryConditionsOfDenseAlgebraTo1em8)
{
  const TetrahedralMesh mesh = ThinBox();
  const auto faces = FindFaces(mesh).Boundary;
  const Eigen::VectorXd area = BoundaryMass(mesh, faces);
  MaternFieldOptions options = ByScreening(40.0, 2);
  options.Boundary = BoundaryCondition::Robin;
  options.RobinCoefficient = 0.7;
  Eigen::MatrixXd matrix = DenseOperator(mesh, 40.0);
  matrix.diagonal() += 0.7 * std::sqrt(40.0) * area;
  ExpectClose(Covariance(MaternField(mesh, options)), DenseCovariance(matrix, LumpedMass(mesh), 2), 1e-8);
  options.Boundary = BoundaryCondition::Dirichlet;
  const Eigen::MatrixXd pinned = Covariance(MaternField(mesh, options));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_EQ(pinned(v, v) == 0.0, area[v] > 0.0) << v;
  }
  options.Arrays.BoundaryMask.assign(static_cast<std::size_t>(mesh.NumberOfPoints()), false);
  options.Arrays.BoundaryMask[50] = true;
  const Eigen::MatrixXd masked = Covariance(MaternField(mesh, options));
  EXPECT_EQ(masked.row(50).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_GT(masked(0, 0), 0.0);
}

TEST(VolumeField, HasTheDeviationOfTheInteriorAtAPlaneBoundaryWithTheRobinCoefficientOne)
{
  const Cells cells{ 20, 20, 20 };
  MaternFieldOptions options = ByRange(0.4);
  options.Boundary = BoundaryCondition::Robin;
  const auto ratio = [&](double coefficient) {
    options.RobinCoefficient = coefficient;
    const Eigen::VectorXd variances = MaternField(BoxOfTetrahedra(cells), options).MarginalVariances();
    return std::sqrt(variances[BoxVertex(cells, 0, 10, 10)] / variances[BoxVertex(cells, 10, 10, 10)]);
  };
  EXPECT_NEAR(ratio(1.0), 1.0, 0.08);
  EXPECT_NEAR(ratio(0.55), std::sqrt(2.0 / 1.55), 0.08);
}

TEST(VolumeField, DoesNotCrossABarrier)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 9, 5, 5 });
  MaternFieldOptions options = ByRange(1.0);
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    double x = 0.0;
    for (int k = 0; k < 4; ++k)
    {
      x += mesh.Points(mesh.Tetrahedra(t, k), 0) / 4.0;
    }
    options.Arrays.Barrier.push_back(x > 4.0 / 9.0 && x < 5.0 / 9.0);
  }
  const Eigen::MatrixXd covariance = Covariance(MaternField(mesh, options));
  const Cells cells{ 9, 5, 5 };
  EXPECT_NEAR(covariance(BoxVertex(cells, 4, 2, 2), BoxVertex(cells, 5, 2, 2)), 0.0, 1e-12);
  EXPECT_GT(covariance(BoxVertex(cells, 4, 2, 2), BoxVertex(cells, 2, 2, 2)), 0.1);
}

TEST(VolumeField, HasVariedRangesOfDenseAlgebraTo1em8)
{
  const TetrahedralMesh mesh = ThinBox();
  MaternFieldOptions options = ByScreening(40.0, 2);
  options.Arrays.RangeFactors = 0.5 + mesh.Points.col(0).array();
  Eigen::MatrixXd matrix = VolumeStiffness(mesh);
  matrix.diagonal() += (40.0 * LumpedMass(mesh).array() / options.Arrays.RangeFactors.array().square()).matrix();
  ExpectClose(Covariance(MaternField(mesh, options)), DenseCovariance(matrix, LumpedMass(mesh), 2), 1e-8);
}

TEST(VolumeField, GivenObservationsEqualsDenseKrigingTo1em8)
{
  const TetrahedralMesh mesh = ThinBox();
  const MaternField field(mesh, ByRange(0.5));
  std::vector<VolumePlace> places;
  for (const Index t : { 3, 200, 444, 801 })
  {
    places.push_back({ t, Eigen::Vector4d(0.1, 0.2, 0.3, 0.4) });
  }
  const SparseRowMatrix matrix = ObservationMatrix(mesh, places);
  const Eigen::Vector4d values(1.0, -0.5, 2.0, 0.3);
  const Eigen::Vector4d deviations(0.0, 0.2, 0.0, 0.5);
  const FieldConditioning conditioning(
    [&field](const Eigen::Ref<const Eigen::MatrixXd>& x) { return field.SolvePrecision(x); }, matrix, deviations,
    std::uint64_t(1) << 30U);
  const double scale = 1.0 / MarginalVarianceInVolume(8.0 * 0.5 / 0.25, LumpedMass(mesh).sum(), 2);
  const Eigen::MatrixXd prior = scale * DenseCovariance(DenseOperator(mesh, 16.0), LumpedMass(mesh), 2);
  const Eigen::MatrixXd h = matrix;
  Eigen::MatrixXd system = h * prior * h.transpose();
  system.diagonal() += deviations.cwiseAbs2();
  const Eigen::MatrixXd gain = prior * h.transpose() * system.inverse();
  ExpectClose(conditioning.Mean(values), gain * values, 1e-8);
  const Eigen::MatrixXd posterior = prior - gain * h * prior;
  ExpectClose(conditioning.Variance(field.MarginalVariances()), posterior.diagonal(), 1e-8);
  EXPECT_NEAR(h.row(0).dot(conditioning.Mean(values).col(0)), 1.0, 1e-8);
}

TEST(VolumeField, IsSolvedByMultigridWhereTheFactorExceedsTheLimit)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 16, 16, 16 }, Eigen::Vector3d::Ones(), 0.1);
  MaternFieldOptions options = ByRange(0.3);
  const MaternField factored(mesh, options);
  options.FactorMemoryLimit = 1000;
  const MaternField iterated(mesh, options);
  EXPECT_STREQ(factored.SolverName(), "Cholesky");
  EXPECT_STREQ(iterated.SolverName(), "Multigrid");
  ExpectClose(iterated.Sample(), factored.Sample(), 1e-8);
}

TEST(VolumeField, HasTheSameBitsForEveryNumberOfThreads)
{
  const TetrahedralMesh mesh = BoxOfTetrahedra({ 12, 12, 12 });
  const auto draw = [&mesh](int threads) {
    const ThreadScope scope(threads);
    return MaternField(mesh, ByRange(0.3, 3)).Sample();
  };
  const Eigen::MatrixXd one = draw(1);
  EXPECT_EQ(one, draw(2));
  EXPECT_EQ(one, draw(4));
}

TEST(VolumeField, TakesAllModelsAndModes)
{
  const TetrahedralMesh mesh = ThinBox();
  for (const NoiseModel model :
    { NoiseModel::PerVertex, NoiseModel::White, NoiseModel::Unscreened, NoiseModel::Spectral })
  {
    MaternFieldOptions options = ByRange(0.5);
    options.Model = model;
    options.NumberOfEigenpairs = 40;
    EXPECT_TRUE(MaternField(mesh, options).Sample().allFinite());
  }
  // Normalized screening does not change when the volume is scaled.
  MaternFieldOptions options;
  options.Mode = ScaleMode::NormalizedScreening;
  options.NormalizedScreening = 0.01;
  TetrahedralMesh large = mesh;
  large.Points *= 16.0;
  ExpectClose(MaternField(large, options).Sample(), MaternField(mesh, options).Sample(), 1e-10);
  EXPECT_EQ(MaternField(mesh, ByScreening(1.0, 1)).EffectiveCorrelationRange(), 0.0);
}

TEST(VolumeField, RefusesCoherentNoise)
{
  MaternFieldOptions options = ByRange(0.5);
  options.CoherentNoise = true;
  EXPECT_THAT(TextOf<InvalidInput>([&] { MaternField(ThinBox(), options); }), HasSubstr("coherent noise in a volume"));
}

TEST(VolumeField, ScalesEachComponentByItsVolume)
{
  TetrahedralMesh mesh = ThinBox();
  const Index points = mesh.NumberOfPoints();
  const Index cells = mesh.NumberOfTetrahedra();
  mesh.Points.conservativeResize(2 * points, 3);
  mesh.Points.bottomRows(points) = mesh.Points.topRows(points).rowwise() + Eigen::RowVector3d(5.0, 0.0, 0.0);
  mesh.Tetrahedra.conservativeResize(2 * cells, 4);
  mesh.Tetrahedra.bottomRows(cells) = mesh.Tetrahedra.topRows(cells).array() + points;
  const Eigen::VectorXd variances = MaternField(mesh, ByRange(3.0)).MarginalVariances();
  ExpectClose(variances.tail(points), variances.head(points), 1e-9);
  EXPECT_NEAR(std::sqrt(variances.mean()), 1.0, 0.1) << "the range is larger than the parts: the constant mode";
}
