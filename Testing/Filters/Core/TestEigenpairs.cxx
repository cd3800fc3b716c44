// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/LaplaceEigenpairs.h"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

using namespace surfsynth;

namespace
{

/// The eigenvalues of (L, M) on the vertices with mass, ascending, by the dense solver.
Eigen::VectorXd DenseEigenvalues(const SparseMatrix& stiffness, const Eigen::VectorXd& mass)
{
  std::vector<Eigen::Index> used;
  for (Eigen::Index v = 0; v < mass.size(); ++v)
  {
    if (mass[v] > 0.0)
    {
      used.push_back(v);
    }
  }
  const Eigen::MatrixXd dense = stiffness;
  const Eigen::MatrixXd l = dense(used, used);
  const Eigen::MatrixXd m = Eigen::VectorXd(mass(used)).asDiagonal();
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(l, m, Eigen::EigenvaluesOnly).eigenvalues();
}

class EigenpairsOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const TriangleMesh& Mesh = test::FromSuite(GetParam()).Mesh;
  const SparseMatrix Stiffness = CotangentStiffness(Mesh);
  const Eigen::VectorXd Mass = LumpedMass(Mesh);
  const Index Used = static_cast<Index>((Mass.array() > 0.0).count());
  const Index Count = std::min(Used - 1, Index(30));
};

INSTANTIATE_TEST_SUITE_P(
  Suite, EigenpairsOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

TEST_P(EigenpairsOnMesh, ValuesAgreeWithTheDenseSolver)
{
  const Eigen::VectorXd expected = DenseEigenvalues(this->Stiffness, this->Mass);
  const Eigenpairs pairs = LowestLaplaceEigenpairs(this->Stiffness, this->Mass, this->Count);
  ASSERT_EQ(pairs.Values.size(), this->Count);
  ASSERT_EQ(pairs.Vectors.rows(), this->Mesh.NumberOfPoints());
  ASSERT_EQ(pairs.Vectors.cols(), this->Count);
  // The dense solver's own error is relative to its largest eigenvalue.
  const double tolerance = 1e-9 * expected[this->Count - 1] + 1e-13 * expected[expected.size() - 1];
  for (Index i = 0; i < this->Count; ++i)
  {
    EXPECT_NEAR(pairs.Values[i], expected[i], tolerance) << i;
    EXPECT_GE(pairs.Values[i], i == 0 ? 0.0 : pairs.Values[i - 1]);
  }
}

TEST_P(EigenpairsOnMesh, VectorsAreMassOrthonormalAndSatisfyTheEquation)
{
  const Eigenpairs pairs = LowestLaplaceEigenpairs(this->Stiffness, this->Mass, this->Count);
  const Eigen::MatrixXd gram = pairs.Vectors.transpose() * this->Mass.asDiagonal() * pairs.Vectors;
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(this->Count, this->Count)).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::MatrixXd left = this->Stiffness * pairs.Vectors;
  const Eigen::MatrixXd right = this->Mass.asDiagonal() * pairs.Vectors * pairs.Values.asDiagonal();
  const double size = Eigen::MatrixXd(this->Stiffness).cwiseAbs().maxCoeff() * pairs.Vectors.cwiseAbs().maxCoeff();
  EXPECT_LE((left - right).cwiseAbs().maxCoeff(), 1e-8 * size);
  for (Index i = 0; i < this->Count; ++i)
  {
    Eigen::Index at = 0;
    pairs.Vectors.col(i).cwiseAbs().maxCoeff(&at);
    EXPECT_GT(pairs.Vectors(at, i), 0.0) << "sign of vector " << i;
  }
  for (Index v = 0; v < this->Mesh.NumberOfPoints(); ++v)
  {
    if (this->Mass[v] == 0.0)
    {
      EXPECT_EQ(pairs.Vectors.row(v).cwiseAbs().maxCoeff(), 0.0) << "unused vertex " << v;
    }
  }
}

TEST(LaplaceEigenpairs, OneZeroForEachComponent)
{
  const test::SuiteMesh& two = test::FromSuite("TwoComponents");
  const Eigenpairs pairs = LowestLaplaceEigenpairs(CotangentStiffness(two.Mesh), LumpedMass(two.Mesh), 3);
  EXPECT_NEAR(pairs.Values[0], 0.0, 1e-9);
  EXPECT_NEAR(pairs.Values[1], 0.0, 1e-9);
  EXPECT_GT(pairs.Values[2], 1e-3);
}

TEST(LaplaceEigenpairs, OfTheSphereConverge)
{
  // l (l + 1) with multiplicity 2 l + 1, to 1 per cent for l up to 8 on 10,242 vertices.
  const TriangleMesh mesh = test::Icosphere(5);
  const Eigenpairs pairs = LowestLaplaceEigenpairs(CotangentStiffness(mesh), LumpedMass(mesh), 81);
  for (int l = 0; l <= 8; ++l)
  {
    for (int m = 0; m <= 2 * l; ++m)
    {
      EXPECT_NEAR(pairs.Values[l * l + m], l * (l + 1.0), 0.01 * l * (l + 1.0) + 1e-9) << l << ", " << m;
    }
  }
}

TEST(LaplaceEigenpairs, ScaleWithTheMesh)
{
  const std::vector<std::pair<int, double>> cases = { { 2, 1e-6 }, { 2, 1e6 }, { 3, 1e-9 }, { 3, 1e-6 }, { 3, 1e6 } };
  for (const auto& [level, scale] : cases)
  {
    const TriangleMesh mesh = test::BumpySurface(level); // the dense solver at level 2, Lanczos at level 3
    const TriangleMesh scaled = test::Scaled(mesh, scale);
    const Eigenpairs reference = LowestLaplaceEigenpairs(CotangentStiffness(mesh), LumpedMass(mesh), 12);
    const Eigenpairs pairs = LowestLaplaceEigenpairs(CotangentStiffness(scaled), LumpedMass(scaled), 12);
    for (Index i = 0; i < 12; ++i)
    {
      EXPECT_NEAR(pairs.Values[i] * scale * scale, reference.Values[i], 1e-9 * reference.Values[11]) << i;
    }
    EXPECT_LE((pairs.Vectors * scale - reference.Vectors).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(LaplaceEigenpairs, AreDeterministicForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const SparseMatrix stiffness = CotangentStiffness(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const Eigenpairs reference = LowestLaplaceEigenpairs(stiffness, mass, 40);
  for (const int threads : { 1, 2, 3 })
  {
    const ThreadScope scope(threads);
    const Eigenpairs pairs = LowestLaplaceEigenpairs(stiffness, mass, 40);
    EXPECT_EQ(pairs.Values, reference.Values);
    EXPECT_EQ(pairs.Vectors, reference.Vectors);
  }
}

TEST(LaplaceEigenpairs, AcceptTheWholeRangeOfCounts)
{
  const TriangleMesh mesh = test::BumpySurface(1); // 42 vertices
  const SparseMatrix stiffness = CotangentStiffness(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const Eigen::VectorXd expected = DenseEigenvalues(stiffness, mass);
  for (const Index count : { 1, 2, 20, 40, 41 })
  {
    const Eigenpairs pairs = LowestLaplaceEigenpairs(stiffness, mass, count);
    EXPECT_LE((pairs.Values - expected.head(count)).cwiseAbs().maxCoeff(), 1e-9 * expected[41]) << count;
  }
}

TEST(LaplaceEigenpairs, RejectCountsOutOfRange)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::Icosphere(1)); // 42 used
  const SparseMatrix stiffness = CotangentStiffness(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  for (const Index count : { -1, 0, 42, 43, 100 })
  {
    EXPECT_THROW(LowestLaplaceEigenpairs(stiffness, mass, count), InvalidInput) << count;
  }
  EXPECT_NO_THROW(LowestLaplaceEigenpairs(stiffness, mass, 41));
}

TEST(LaplaceEigenpairs, StopOnRequest)
{
  const TriangleMesh mesh = test::BumpySurface(5);
  EXPECT_THROW(
    LowestLaplaceEigenpairs(CotangentStiffness(mesh), LumpedMass(mesh), 60, [](double) { return false; }), Cancelled);
}
