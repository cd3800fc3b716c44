// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"
#include "SpectralSamples.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Noise/LatticeNoise.h"
#include "Core/Noise/MaternField.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>

using namespace surfsynth;

namespace
{

std::vector<NormalKey> Keys(std::uint32_t first, std::uint32_t count, std::uint64_t seed = 5)
{
  std::vector<NormalKey> keys;
  for (std::uint32_t k = 0; k < count; ++k)
  {
    NormalKey key;
    key.Seed = seed;
    key.Sample = first + k;
    keys.push_back(key);
  }
  return keys;
}

double Side(const TriangleMesh& mesh) { return 0.05 * ComputeBoundingBox(mesh).LongestSide(); }

class LatticeNoiseOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const TriangleMesh& Mesh = test::FromSuite(GetParam()).Mesh;
  const MeshTopology Topology{ Mesh };
  const Eigen::VectorXd Mass = LumpedMass(Mesh);
};

INSTANTIATE_TEST_SUITE_P(
  Suite, LatticeNoiseOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

TEST_P(LatticeNoiseOnMesh, CovariancesWithTheIntegralAreTheLumpedMass)
{
  // cov(b_i, sum of all b) = M_ii, and the variance of the integral is the area: exact for every side of the lattice.
  for (const double factor : { 0.2, 1.0, 5.0 })
  {
    const LatticeNoise noise(this->Mesh, this->Topology, factor * Side(this->Mesh));
    const Eigen::VectorXd integral = noise.Covariates(Eigen::VectorXd::Ones(this->Mass.size()));
    EXPECT_NEAR(integral.squaredNorm(), this->Mass.sum(), 1e-10 * this->Mass.sum());
    Eigen::MatrixXd functions = Eigen::MatrixXd::Zero(this->Mass.size(), 16);
    for (Index k = 0; k < 16; ++k)
    {
      functions(k * (this->Mass.size() - 1) / 15, k) += 1.0;
    }
    const Eigen::VectorXd covariance = noise.Covariates(functions).transpose() * integral;
    const Eigen::VectorXd expected = functions.transpose() * this->Mass;
    EXPECT_LE((covariance - expected).cwiseAbs().maxCoeff(), 1e-9 * this->Mass.maxCoeff());
  }
}

TEST_P(LatticeNoiseOnMesh, ColumnsHaveTheSameBitsAloneAndWithOthers)
{
  const LatticeNoise noise(this->Mesh, this->Topology, Side(this->Mesh));
  const LatticeNoise::Rows together = noise.Draw(Keys(3, 11));
  ASSERT_TRUE(together.allFinite());
  for (Eigen::Index k = 0; k < together.cols(); ++k)
  {
    const LatticeNoise::Rows alone = noise.Draw(Keys(3 + static_cast<std::uint32_t>(k), 1));
    const LatticeNoise::Rows column = together.col(k);
    EXPECT_EQ(std::memcmp(alone.data(), column.data(), static_cast<std::size_t>(alone.size()) * sizeof(double)), 0);
  }
  for (Eigen::Index v = 0; v < together.rows(); ++v)
  {
    EXPECT_TRUE(this->Mass[v] > 0.0 || together.row(v).isZero(0.0));
  }
}

TEST(LatticeNoise, DrawsHaveTheCovarianceOfTheCovariates)
{
  // 4,000 draws: sums of squares are chi-square; bounds of probability 1e-4 / 8 each side, z = 4.2.
  const TriangleMesh mesh = test::BumpySurface(3);
  const LatticeNoise noise(mesh, MeshTopology(mesh), 0.2);
  const Eigen::MatrixXd functions = LowestLaplaceEigenpairs(CotangentStiffness(mesh), LumpedMass(mesh), 8).Vectors;
  const Eigen::MatrixXd covariance = noise.Covariates(functions).transpose() * noise.Covariates(functions);
  constexpr std::uint32_t Draws = 4000;
  const Eigen::MatrixXd drawn = functions.transpose() * noise.Draw(Keys(0, Draws));
  for (Eigen::Index i = 0; i < 8; ++i)
  {
    const double ratio = drawn.row(i).squaredNorm() / covariance(i, i);
    EXPECT_GT(ratio, test::ChiSquareQuantile(Draws, -4.2)) << i;
    EXPECT_LT(ratio, test::ChiSquareQuantile(Draws, 4.2)) << i;
    for (Eigen::Index j = 0; j < i; ++j)
    {
      const double difference = drawn.row(i).dot(drawn.row(j)) / Draws - covariance(i, j);
      EXPECT_LT(std::abs(difference), 4.5 / std::sqrt(Draws)) << i << " and " << j;
    }
  }
}

TEST(LatticeNoise, IsWhiteOnCoarseAndFineTriangulations)
{
  // Expected variances, free of sampling error, of the first 100 coefficients; the side is an eighteenth of the range
  // for tau = 100. The scanned surface has an eigenvalue number 100 of 7 tau.
  for (const int which : { 0, 2 })
  {
    const test::SpectralSurface surface = test::WithEigenpairs("", test::Triangulation(which), 100);
    const LatticeNoise noise(surface.Mesh, MeshTopology(surface.Mesh), 1.0 / 64.0);
    const Eigen::MatrixXd covariates = noise.Covariates(surface.Pairs.Vectors);
    const Eigen::MatrixXd covariance = covariates.transpose() * covariates;
    EXPECT_NEAR(covariance.diagonal().mean(), 1.0, 0.01) << which;
    for (Eigen::Index i = 0; i < 100; ++i)
    {
      EXPECT_NEAR(covariance(i, i), 1.0, 0.03) << i;
      for (Eigen::Index j = 0; j < i; ++j)
      {
        EXPECT_LT(std::abs(covariance(i, j)), 0.02) << i << " and " << j;
      }
    }
  }
}

TEST(LatticeNoise, HasTheSameIntegralsOnAnotherTriangulation)
{
  const TriangleMesh first = test::Icosphere(5);
  const TriangleMesh second = test::IrregularSphere(4);
  const LatticeNoise onFirst(first, MeshTopology(first), 0.05);
  const LatticeNoise onSecond(second, MeshTopology(second), 0.05);
  const LatticeNoise::Rows a = onFirst.Draw(Keys(0, 200));
  const LatticeNoise::Rows b = onSecond.Draw(Keys(0, 200));
  const LatticeNoise::Rows other = onSecond.Draw(Keys(0, 200, 6));
  const auto functions = [](const TriangleMesh& mesh) {
    const Eigen::ArrayXd x = mesh.Points.col(0);
    const Eigen::ArrayXd y = mesh.Points.col(1);
    Eigen::MatrixXd values(mesh.NumberOfPoints(), 4);
    values << Eigen::ArrayXd::Ones(x.size()), x, (3.0 * y).sin(), x.cube() * y;
    return values;
  };
  const Eigen::MatrixXd inFirst = functions(first).transpose() * a;
  const Eigen::MatrixXd inSecond = functions(second).transpose() * b;
  const Eigen::MatrixXd inOther = functions(second).transpose() * other;
  for (Eigen::Index i = 0; i < inFirst.rows(); ++i)
  {
    const double norm = inFirst.row(i).norm();
    EXPECT_GT(inFirst.row(i).dot(inSecond.row(i)), 0.99 * norm * inSecond.row(i).norm()) << i;
    EXPECT_LT(std::abs(inFirst.row(i).dot(inOther.row(i))), 0.35 * norm * inOther.row(i).norm()) << "other seed, " << i;
  }
}

TEST(LatticeNoise, SheetsThatFaceOppositeWaysAreIndependent)
{
  const double side = 0.1;
  const TriangleMesh sheet = test::PlanePatch(20, 20, 1.0, 1.0, 0.2);
  TriangleMesh above = test::Translated(sheet, { 0.0, 0.0, 0.3 * side });
  const auto correlation = [&](const TriangleMesh& second) {
    const TriangleMesh both = test::Join(sheet, second);
    const LatticeNoise noise(both, MeshTopology(both), side);
    Eigen::MatrixXd inside = Eigen::MatrixXd::Zero(both.NumberOfPoints(), 2);
    inside.col(0).head(sheet.NumberOfPoints()).setOnes();
    inside.col(1).tail(second.NumberOfPoints()).setOnes();
    const Eigen::MatrixXd covariates = noise.Covariates(inside);
    return covariates.col(0).dot(covariates.col(1)) / (covariates.col(0).norm() * covariates.col(1).norm());
  };
  EXPECT_GT(correlation(above), 0.5) << "the documented correlation of sheets that face the same way";
  EXPECT_NEAR(correlation(test::Translated(sheet, { 0.0, 0.0, 2.5 * side })), 0.0, 1e-12) << "beyond 2 sides";
  above.Triangles.col(0).swap(above.Triangles.col(1));
  EXPECT_NEAR(correlation(above), 0.0, 1e-12);
}

namespace
{
/// The place on @p mesh nearest to @p point.
SurfacePlace NearestPlace(const TriangleMesh& mesh, const Eigen::Vector3d& point)
{
  SurfacePlace nearest;
  double least = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const SurfacePlace place = NearestOnTriangle(mesh, f, point);
    Eigen::Vector3d found = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      found += place.Weights[k] * mesh.Points.row(mesh.Triangles(f, k)).transpose();
    }
    if ((found - point).squaredNorm() < least)
    {
      least = (found - point).squaredNorm();
      nearest = place;
    }
  }
  return nearest;
}

/// Correlation, over 50 samples, of the fields on two triangulations at about 300 vertices of the second.
double CorrelationOfFields(const TriangleMesh& first, const TriangleMesh& second, double range, bool coherent)
{
  MaternFieldOptions options;
  options.CorrelationRange = range;
  options.CoherentNoise = coherent;
  SampleRequest request;
  request.NumberOfComponents = 50;
  const Eigen::MatrixXd onFirst = MaternField(first, options).Sample(request);
  const Eigen::MatrixXd onSecond = MaternField(second, options).Sample(request);
  double product = 0.0;
  double squaresOfFirst = 0.0;
  double squaresOfSecond = 0.0;
  for (Index v = 0; v < second.NumberOfPoints(); v += std::max<Index>(1, second.NumberOfPoints() / 300))
  {
    const SurfacePlace place = NearestPlace(first, second.Points.row(v).transpose());
    Eigen::RowVectorXd values = Eigen::RowVectorXd::Zero(50);
    for (int k = 0; k < 3; ++k)
    {
      values += place.Weights[k] * onFirst.row(first.Triangles(place.Triangle, k));
    }
    product += values.dot(onSecond.row(v));
    squaresOfFirst += values.squaredNorm();
    squaresOfSecond += onSecond.row(v).squaredNorm();
  }
  return product / std::sqrt(squaresOfFirst * squaresOfSecond);
}

double MeanEdge(const TriangleMesh& mesh) { return std::sqrt(FaceAreas(mesh).mean() * 4.0 / std::sqrt(3.0)); }
} // namespace

TEST(CoherentNoise, FieldsOnADecimatedScanCorrelateAboveNinetyFivePercent)
{
  // The scanned surface with 26,002 points and decimated to 2,000; 10 mean edges of the coarse one, and half of that.
  const TriangleMesh fine = test::ScannedSurface();
  const TriangleMesh coarse = test::Decimate(fine, 2000);
  const double edge = MeanEdge(coarse);
  const double correlation = CorrelationOfFields(fine, coarse, 10.0 * edge, true);
  RecordProperty("correlation", std::to_string(correlation));
  std::cout << "correlation at ten edges: " << correlation << "\n";
  EXPECT_GT(correlation, 0.95);
  EXPECT_GT(CorrelationOfFields(fine, coarse, 5.0 * edge, true), 0.9);
  EXPECT_LT(std::abs(CorrelationOfFields(fine, coarse, 10.0 * edge, false)), 0.5) << "numbers for each vertex";
}

TEST(CoherentNoise, FieldsOnOtherTriangulationsOfASphereCorrelateAboveNinetyFivePercent)
{
  const TriangleMesh first = test::Icosphere(4);
  EXPECT_GT(
    CorrelationOfFields(first, test::IrregularSphere(3), 10.0 * MeanEdge(test::IrregularSphere(3)), true), 0.95);
  EXPECT_GT(CorrelationOfFields(first, test::UvSphere(40, 60), 10.0 * MeanEdge(first), true), 0.95);
}

TEST(CoherentNoise, RefusesTheOperatorPowersOneAndThree)
{
  MaternFieldOptions options;
  options.CoherentNoise = true;
  options.OperatorPower = 3;
  EXPECT_THROW(MaternField(test::Icosphere(2), options), InvalidInput);
  options.OperatorPower = 4;
  EXPECT_TRUE(MaternField(test::Icosphere(2), options).Sample().allFinite());
}

TEST(LatticeNoise, RefusesSidesThatAreNoPositiveNumbers)
{
  const TriangleMesh mesh = test::Icosphere(1);
  const MeshTopology topology(mesh);
  for (const double side : { 0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("") })
  {
    EXPECT_THROW(LatticeNoise(mesh, topology, side), InvalidInput);
  }
}
