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

TEST(LatticeNoise, RefusesSidesThatAreNoPositiveNumbers)
{
  const TriangleMesh mesh = test::Icosphere(1);
  const MeshTopology topology(mesh);
  for (const double side : { 0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("") })
  {
    EXPECT_THROW(LatticeNoise(mesh, topology, side), InvalidInput);
  }
}
