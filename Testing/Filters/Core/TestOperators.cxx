// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Parallel.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynth;

namespace
{

constexpr double Pi = 3.14159265358979323846;

class OperatorsOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const TriangleMesh& Mesh = test::FromSuite(GetParam()).Mesh;
  const MeshTopology Topology{ Mesh };
};

INSTANTIATE_TEST_SUITE_P(
  Suite, OperatorsOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

Eigen::Vector3d FaceNormal(const TriangleMesh& mesh, Index f)
{
  const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(f, 0));
  const Eigen::Vector3d b = mesh.Points.row(mesh.Triangles(f, 1));
  const Eigen::Vector3d c = mesh.Points.row(mesh.Triangles(f, 2));
  return (b - a).cross(c - a);
}

/// Largest modulus of the entries, to which tolerances are relative.
template <typename Matrix>
double Largest(const Matrix& matrix)
{
  return Eigen::MatrixXd(matrix).cwiseAbs().maxCoeff();
}

/// The generalised eigenvalues of (L, M), ascending, by the dense solver.
Eigen::VectorXd DenseEigenvalues(const TriangleMesh& mesh)
{
  const Eigen::MatrixXd stiffness = CotangentStiffness(mesh);
  const Eigen::MatrixXd mass = LumpedMass(mesh).asDiagonal();
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(stiffness, mass, Eigen::EigenvaluesOnly)
    .eigenvalues();
}

} // namespace

// --- One triangle, by hand --------------------------------------------------------------------------------------

TEST(Operators, OfOneTriangleAreThoseComputedByHand)
{
  // (0,0), (2,0), (0,1): area 1; cotangents 0 at the right angle, 2 at vertex 1, 1/2 at vertex 2.
  const TriangleMesh mesh = test::SingleTriangle();
  EXPECT_DOUBLE_EQ(FaceAreas(mesh)[0], 1.0);
  EXPECT_TRUE(LumpedMass(mesh).isApprox(Eigen::Vector3d::Constant(1.0 / 3.0), 1e-15));
  Eigen::Matrix3d stiffness;
  stiffness << 1.25, -0.25, -1.0, //
    -0.25, 0.25, 0.0,             //
    -1.0, 0.0, 1.0;
  EXPECT_TRUE(Eigen::MatrixXd(CotangentStiffness(mesh)).isApprox(stiffness, 1e-14));
  Eigen::Matrix<double, 2, 3> gradient;
  gradient << -0.5, 0.5, 0.0, //
    -1.0, 0.0, 1.0;
  EXPECT_TRUE(Eigen::MatrixXd(IntrinsicGradient(mesh)).isApprox(gradient, 1e-14));
  // M^-1 L is 3 L: sum of squares 9 (1.5625 + 2/16 + 2 + 1/16 + 1) = 42.75.
  EXPECT_NEAR(LaplaceBeltramiNorm(CotangentStiffness(mesh), LumpedMass(mesh)), std::sqrt(42.75), 1e-13);
}

// --- Mass -------------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, MassSumsToTheArea)
{
  const double area = FaceAreas(this->Mesh).sum();
  EXPECT_NEAR(LumpedMass(this->Mesh, this->Topology).sum(), area, 1e-13 * area);
}

TEST_P(OperatorsOnMesh, MassIsAThirdOfTheAreaAround)
{
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(this->Mesh.NumberOfPoints());
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    for (int c = 0; c < 3; ++c)
    {
      expected[this->Mesh.Triangles(f, c)] += 0.5 * FaceNormal(this->Mesh, f).norm() / 3.0;
    }
  }
  const Eigen::VectorXd mass = LumpedMass(this->Mesh, this->Topology);
  EXPECT_LE((mass - expected).cwiseAbs().maxCoeff(), 1e-14 * expected.maxCoeff() * 10.0);
  EXPECT_EQ((mass.array() == 0.0).count(), test::FromSuite(this->GetParam()).UnusedPoints);
  EXPECT_EQ(LumpedMass(this->Mesh), mass) << "the overload without topology gives the same bits";
}

// --- Stiffness --------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, StiffnessAgreesWithTheCotangentFormula)
{
  const Index points = this->Mesh.NumberOfPoints();
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(points, points);
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    for (int c = 0; c < 3; ++c)
    {
      const Index at = this->Mesh.Triangles(f, c);
      const Index i = this->Mesh.Triangles(f, (c + 1) % 3);
      const Index j = this->Mesh.Triangles(f, (c + 2) % 3);
      const Eigen::Vector3d a = this->Mesh.Points.row(i) - this->Mesh.Points.row(at);
      const Eigen::Vector3d b = this->Mesh.Points.row(j) - this->Mesh.Points.row(at);
      const double weight = 0.5 * a.dot(b) / a.cross(b).norm();
      expected(i, j) -= weight;
      expected(j, i) -= weight;
      expected(i, i) += weight;
      expected(j, j) += weight;
    }
  }
  const SparseMatrix stiffness = CotangentStiffness(this->Mesh, this->Topology);
  EXPECT_LE(Largest(Eigen::MatrixXd(stiffness) - expected), 1e-12 * Largest(expected));
}

TEST_P(OperatorsOnMesh, StiffnessIsStoredAsDocumented)
{
  const SparseMatrix stiffness = CotangentStiffness(this->Mesh, this->Topology);
  ASSERT_EQ(stiffness.rows(), this->Mesh.NumberOfPoints());
  ASSERT_EQ(stiffness.cols(), this->Mesh.NumberOfPoints());
  ASSERT_TRUE(stiffness.isCompressed());
  EXPECT_EQ(stiffness.nonZeros(), 2 * this->Topology.NumberOfEdges() + this->Topology.NumberOfPoints());
  for (Index column = 0; column < stiffness.cols(); ++column)
  {
    Index previous = -1;
    bool diagonal = false;
    for (SparseMatrix::InnerIterator entry(stiffness, column); entry; ++entry)
    {
      EXPECT_GT(entry.row(), previous);
      previous = entry.row();
      diagonal = diagonal || entry.row() == column;
    }
    EXPECT_TRUE(diagonal);
  }
  const SparseMatrix again = CotangentStiffness(this->Mesh);
  EXPECT_EQ(Largest(again - stiffness), 0.0) << "the overload without topology gives the same bits";
}

TEST_P(OperatorsOnMesh, StiffnessIsSymmetricWithZeroRowSumsAndNonNegative)
{
  const Eigen::MatrixXd stiffness = CotangentStiffness(this->Mesh, this->Topology);
  const double scale = Largest(stiffness);
  EXPECT_LE(Largest(stiffness - stiffness.transpose()), 1e-13 * scale);
  EXPECT_LE((stiffness * Eigen::VectorXd::Ones(stiffness.cols())).cwiseAbs().maxCoeff(), 1e-12 * scale);
  const Eigen::VectorXd values =
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(stiffness, Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_GE(values[0], -1e-11 * scale);
  // The null space: a constant for each component, and each unused point.
  const test::SuiteMesh& known = test::FromSuite(this->GetParam());
  const auto zeros = (values.array() < 1e-9 * scale).count();
  EXPECT_EQ(zeros, known.Components + known.UnusedPoints);
}

TEST_P(OperatorsOnMesh, StiffnessIsTheDivergenceOfTheGradient)
{
  const SparseRowMatrix gradient = IntrinsicGradient(this->Mesh);
  ASSERT_EQ(gradient.rows(), 2 * this->Mesh.NumberOfTriangles());
  ASSERT_EQ(gradient.cols(), this->Mesh.NumberOfPoints());
  const Eigen::VectorXd areas = FaceAreas(this->Mesh);
  Eigen::VectorXd twice(2 * areas.size());
  for (Eigen::Index f = 0; f < areas.size(); ++f)
  {
    twice[2 * f] = twice[2 * f + 1] = areas[f];
  }
  const Eigen::MatrixXd dense = gradient;
  const Eigen::MatrixXd product = dense.transpose() * twice.asDiagonal() * dense;
  const Eigen::MatrixXd stiffness = CotangentStiffness(this->Mesh, this->Topology);
  EXPECT_LE(Largest(product - stiffness), 1e-12 * Largest(stiffness));
}

TEST(Operators, StiffnessOfLinearFunctionsVanishesInsideAPlane)
{
  TriangleMesh mesh = test::PlanePatch(20, 15, 3.0, 2.0, 0.2);
  // Any plane in space.
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())).toRotationMatrix();
  mesh.Points = (mesh.Points * turn.transpose()).eval();
  const Eigen::VectorXd linear = mesh.Points * Eigen::Vector3d(0.3, -1.2, 2.0);
  const Eigen::VectorXd result = CotangentStiffness(mesh) * linear;
  for (int j = 1; j < 15; ++j)
  {
    for (int i = 1; i < 20; ++i)
    {
      EXPECT_NEAR(result[j * 21 + i], 0.0, 1e-12);
    }
  }
  EXPECT_GT(result.cwiseAbs().maxCoeff(), 1e-2) << "on the boundary it does not";
}

// --- Gradient ---------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, GradientOfALinearFunctionIsExact)
{
  const Eigen::Vector3d direction(0.4, -1.1, 0.8);
  const Eigen::VectorXd gradient = IntrinsicGradient(this->Mesh) * (this->Mesh.Points * direction);
  const double diameter = this->Mesh.Points.cwiseAbs().maxCoeff();
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    const Eigen::Vector3d edge = this->Mesh.Points.row(this->Mesh.Triangles(f, 1)) -
      this->Mesh.Points.row(this->Mesh.Triangles(f, 0));
    const Eigen::Vector3d x = edge.normalized();
    const Eigen::Vector3d y = FaceNormal(this->Mesh, f).normalized().cross(x);
    // Differences of values of size `diameter` over lengths of size `edge` lose that many digits.
    const double tolerance = 1e-13 * diameter / edge.norm() + 1e-13;
    EXPECT_NEAR(gradient[2 * f], x.dot(direction), 10.0 * tolerance);
    EXPECT_NEAR(gradient[2 * f + 1], y.dot(direction), 10.0 * tolerance);
  }
}

TEST_P(OperatorsOnMesh, GradientRowsAreSortedAndVanishOnConstants)
{
  const SparseRowMatrix gradient = IntrinsicGradient(this->Mesh);
  ASSERT_TRUE(gradient.isCompressed());
  for (Index row = 0; row < gradient.rows(); ++row)
  {
    Index previous = -1;
    double sum = 0.0;
    double size = 0.0;
    for (SparseRowMatrix::InnerIterator entry(gradient, row); entry; ++entry)
    {
      EXPECT_GT(entry.col(), previous);
      previous = static_cast<Index>(entry.col());
      sum += entry.value();
      size += std::abs(entry.value());
    }
    EXPECT_NEAR(sum, 0.0, 1e-13 * size);
  }
}

// --- Scaling ----------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, ScalingLaws)
{
  const double k = 3.7;
  const TriangleMesh scaled = test::Scaled(this->Mesh, k);
  // Rounding of coordinates far from the origin reaches lengths and angles.
  const double tolerance = this->GetParam() == "FarFromOrigin" ? 1e-9 : 1e-12;
  EXPECT_TRUE(FaceAreas(scaled).isApprox(k * k * FaceAreas(this->Mesh), tolerance));
  EXPECT_TRUE(LumpedMass(scaled).isApprox(k * k * LumpedMass(this->Mesh), tolerance));
  const SparseMatrix stiffness = CotangentStiffness(this->Mesh);
  EXPECT_LE(Largest(CotangentStiffness(scaled) - stiffness), tolerance * Largest(stiffness));
  const SparseRowMatrix gradient = IntrinsicGradient(this->Mesh);
  EXPECT_LE(Largest(k * IntrinsicGradient(scaled) - gradient), tolerance * Largest(gradient));
  const double norm = LaplaceBeltramiNorm(stiffness, LumpedMass(this->Mesh));
  EXPECT_NEAR(LaplaceBeltramiNorm(CotangentStiffness(scaled), LumpedMass(scaled)) * k * k, norm, tolerance * norm);
}

// --- Frames -----------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, TangentFramesAreOrthonormalAndRightHanded)
{
  const VertexFrames frames = TangentFrames(this->Mesh, this->Topology);
  ASSERT_EQ(frames.Normal.rows(), this->Mesh.NumberOfPoints());
  for (Index v = 0; v < this->Mesh.NumberOfPoints(); ++v)
  {
    Eigen::Matrix3d frame;
    frame << frames.X.row(v), frames.Y.row(v), frames.Normal.row(v);
    EXPECT_TRUE((frame * frame.transpose()).isIdentity(1e-14)) << v;
    EXPECT_NEAR(frame.determinant(), 1.0, 1e-14) << v;
  }
}

TEST_P(OperatorsOnMesh, VertexNormalsAreTheAreaWeightedMeansOfFaceNormals)
{
  PointMatrix sum = PointMatrix::Zero(this->Mesh.NumberOfPoints(), 3);
  Eigen::VectorXd size = Eigen::VectorXd::Zero(this->Mesh.NumberOfPoints());
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    for (int c = 0; c < 3; ++c)
    {
      sum.row(this->Mesh.Triangles(f, c)) += FaceNormal(this->Mesh, f);
      size[this->Mesh.Triangles(f, c)] += FaceNormal(this->Mesh, f).norm();
    }
  }
  const VertexFrames frames = TangentFrames(this->Mesh, this->Topology);
  for (Index v = 0; v < this->Mesh.NumberOfPoints(); ++v)
  {
    if (sum.row(v).norm() > 1e-6 * size[v])
    {
      EXPECT_LE((frames.Normal.row(v) - sum.row(v).normalized()).norm(), 1e-9) << v;
    }
    if (size[v] == 0.0)
    {
      EXPECT_EQ(frames.Normal.row(v), Eigen::RowVector3d(0, 0, 1)) << v;
      EXPECT_EQ(frames.X.row(v), Eigen::RowVector3d(1, 0, 0)) << v;
      EXPECT_EQ(frames.Y.row(v), Eigen::RowVector3d(0, 1, 0)) << v;
    }
  }
}

TEST(Operators, VertexNormalsOfASpherePointOutwards)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  const VertexFrames frames = TangentFrames(mesh, MeshTopology(mesh));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_GT(frames.Normal.row(v).dot(mesh.Points.row(v)), 0.97);
  }
}

// --- Norm -------------------------------------------------------------------------------------------------------

TEST_P(OperatorsOnMesh, NormAgreesWithTheDenseMatrix)
{
  const SparseMatrix stiffness = CotangentStiffness(this->Mesh, this->Topology);
  const Eigen::VectorXd mass = LumpedMass(this->Mesh, this->Topology);
  Eigen::MatrixXd laplacian = stiffness;
  for (Eigen::Index v = 0; v < mass.size(); ++v)
  {
    laplacian.row(v) *= mass[v] > 0.0 ? 1.0 / mass[v] : 0.0;
  }
  EXPECT_NEAR(LaplaceBeltramiNorm(stiffness, mass), laplacian.norm(), 1e-12 * laplacian.norm());
}

TEST(Operators, NormSquaredIsAboutTheSumOfSquaredEigenvalues)
{
  // Equal on a mesh of equal masses; the icosphere's differ by up to a third.
  const TriangleMesh mesh = test::Icosphere(2);
  const double norm = LaplaceBeltramiNorm(CotangentStiffness(mesh), LumpedMass(mesh));
  EXPECT_NEAR(norm, DenseEigenvalues(mesh).norm(), 0.02 * norm);
}

// --- The sphere -------------------------------------------------------------------------------------------------

TEST(Operators, EigenvaluesOfTheSphereConvergeToTheirExactValues)
{
  // l (l + 1), 2 l + 1 times each. Linear elements converge with the square of the edge length: a factor 4 per level.
  double before = 0.0;
  for (const int level : { 2, 3 })
  {
    const Eigen::VectorXd values = DenseEigenvalues(test::Icosphere(level));
    EXPECT_NEAR(values[0], 0.0, 1e-10);
    double error = 0.0;
    for (int l = 1; l <= 4; ++l)
    {
      for (int m = 0; m <= 2 * l; ++m)
      {
        error = std::max(error, std::abs(values[l * l + m] / (l * (l + 1.0)) - 1.0));
      }
    }
    if (level == 2)
    {
      before = error;
      EXPECT_LT(error, 0.15);
    }
    else
    {
      EXPECT_NEAR(before / error, 4.0, 1.0);
    }
  }
}

TEST(Operators, AreaOfTheSphereConverges)
{
  const double coarse = 4.0 * Pi - FaceAreas(test::Icosphere(3)).sum();
  const double fine = 4.0 * Pi - FaceAreas(test::Icosphere(4)).sum();
  EXPECT_GT(fine, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
}

// --- Threads ----------------------------------------------------------------------------------------------------

TEST(Operators, HaveTheSameBitsForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(6); // 81,920 triangles: above any sensible grain
  const MeshTopology topology(mesh);
  const ThreadScope one(1);
  const Eigen::VectorXd areas = FaceAreas(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh, topology);
  const SparseMatrix stiffness = CotangentStiffness(mesh, topology);
  const SparseRowMatrix gradient = IntrinsicGradient(mesh);
  const VertexFrames frames = TangentFrames(mesh, topology);
  const double norm = LaplaceBeltramiNorm(stiffness, mass);
  for (const int threads : { 2, 3 })
  {
    const ThreadScope scope(threads);
    EXPECT_EQ(FaceAreas(mesh), areas);
    EXPECT_EQ(LumpedMass(mesh, topology), mass);
    const SparseMatrix again = CotangentStiffness(mesh, topology);
    ASSERT_EQ(again.nonZeros(), stiffness.nonZeros());
    EXPECT_TRUE(std::equal(again.valuePtr(), again.valuePtr() + again.nonZeros(), stiffness.valuePtr()));
    EXPECT_TRUE(std::equal(again.innerIndexPtr(), again.innerIndexPtr() + again.nonZeros(), stiffness.innerIndexPtr()));
    const SparseRowMatrix slope = IntrinsicGradient(mesh);
    ASSERT_EQ(slope.nonZeros(), gradient.nonZeros());
    EXPECT_TRUE(std::equal(slope.valuePtr(), slope.valuePtr() + slope.nonZeros(), gradient.valuePtr()));
    const VertexFrames other = TangentFrames(mesh, topology);
    EXPECT_EQ(other.Normal, frames.Normal);
    EXPECT_EQ(other.X, frames.X);
    EXPECT_EQ(other.Y, frames.Y);
    EXPECT_EQ(LaplaceBeltramiNorm(stiffness, mass), norm);
  }
}

TEST(Operators, AShiftOfTheSquaredAreaBoundsTheWeights)
{
  // Twice the area is 2: adding 12 to its square doubles the denominator of every cotangent.
  const TriangleMesh triangle = test::SingleTriangle();
  const MeshTopology topology(triangle);
  const Eigen::MatrixXd plain = CotangentStiffness(triangle, topology);
  EXPECT_TRUE(Eigen::MatrixXd(CotangentStiffness(triangle, topology, 12.0)).isApprox(0.5 * plain, 1e-14));
  EXPECT_EQ(Eigen::MatrixXd(CotangentStiffness(triangle, topology, 0.0)), plain);
}
