// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/InstructionSet.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <thread>

using namespace surfsynth;

namespace
{

const double NaN = std::numeric_limits<double>::quiet_NaN();
const double Infinity = std::numeric_limits<double>::infinity();

/// L + tau M with a correlation range of about a fifth of the surface; 1 on the diagonal of unused points.
SparseMatrix ScreenedLaplacian(const TriangleMesh& mesh)
{
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const double tau = 100.0 / mass.sum();
  SparseMatrix matrix = CotangentStiffness(mesh);
  for (Index v = 0; v < mass.size(); ++v)
  {
    matrix.coeffRef(v, v) += mass[v] > 0.0 ? tau * mass[v] : 1.0;
  }
  return matrix;
}

RowMatrix RandomRightHandSides(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed = 1)
{
  RowMatrix sides(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
  {
    for (Eigen::Index j = 0; j < columns; ++j)
    {
      sides(i, j) = test::Uniform(static_cast<std::uint64_t>(i), seed * 1000U + static_cast<std::uint64_t>(j));
    }
  }
  return sides;
}

SparseMatrix Sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }

/// A row other than @p column with an entry in it.
Index NeighborOf(const SparseMatrix& matrix, Index column)
{
  SparseMatrix::InnerIterator entry(matrix, column);
  while (entry.row() == column)
  {
    ++entry;
  }
  return static_cast<Index>(entry.row());
}

bool SameBits(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  return a.size() == b.size() &&
    std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

class CholeskyOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const SparseMatrix Matrix = ScreenedLaplacian(test::FromSuite(GetParam()).Mesh);
};

INSTANTIATE_TEST_SUITE_P(
  Suite, CholeskyOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

// --- Answers ----------------------------------------------------------------------------------------------------

TEST_P(CholeskyOnMesh, AgreesWithEigenTo1em10)
{
  const CholeskySolver solver(this->Matrix);
  const Eigen::SimplicialLDLT<SparseMatrix> reference(this->Matrix);
  ASSERT_EQ(reference.info(), Eigen::Success);
  const RowMatrix sides = RandomRightHandSides(this->Matrix.rows(), 11);
  RowMatrix solutions = sides;
  solver.SolveInPlace(solutions);
  for (Eigen::Index j = 0; j < sides.cols(); ++j)
  {
    const Eigen::VectorXd expected = reference.solve(Eigen::VectorXd(sides.col(j)));
    EXPECT_LE((solutions.col(j) - expected).norm(), 1e-10 * expected.norm()) << "column " << j;
    const Eigen::VectorXd alone = solver.Solve(sides.col(j));
    EXPECT_LE((alone - expected).norm(), 1e-10 * expected.norm()) << "column " << j;
  }
  EXPECT_EQ(solver.Size(), this->Matrix.rows());
  EXPECT_GE(solver.FactorEntries(), (this->Matrix.nonZeros() + this->Matrix.rows()) / 2);
}

TEST_P(CholeskyOnMesh, ResidualIsAtMost1em10)
{
  const CholeskySolver solver(this->Matrix);
  const Eigen::VectorXd side = RandomRightHandSides(this->Matrix.rows(), 1);
  const Eigen::VectorXd solution = solver.Solve(side);
  const double residual = (this->Matrix * solution - side).norm() / side.norm();
  EXPECT_LE(residual, 1e-10);
  EXPECT_NEAR(solver.RelativeResidual(solution, side), residual, 1e-14);
  EXPECT_THROW(solver.RelativeResidual(solution, Eigen::VectorXd::Ones(side.size() + 1)), InvalidInput);
  EXPECT_THROW(solver.RelativeResidual(Eigen::VectorXd::Ones(side.size() + 1), side), InvalidInput);
}

TEST_P(CholeskyOnMesh, OneOffSolveIsTheSame)
{
  const Eigen::VectorXd side = RandomRightHandSides(this->Matrix.rows(), 1);
  EXPECT_TRUE(SameBits(SolveCholesky(this->Matrix, side), CholeskySolver(this->Matrix).Solve(side)));
}

TEST(CholeskySolver, SolvesWhatUnitVectorsMakeTheInverse)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::PlanePatch(7, 6, 1.0, 1.0, 0.2));
  RowMatrix identity = RowMatrix::Identity(matrix.rows(), matrix.cols());
  CholeskySolver(matrix).SolveInPlace(identity);
  EXPECT_TRUE((matrix * Eigen::MatrixXd(identity)).isIdentity(1e-11));
  EXPECT_LE((identity - identity.transpose()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(CholeskySolver, ResidualOfAWrongSolutionIsItsError)
{
  const SparseMatrix matrix = Sparse(Eigen::Vector2d(2.0, 4.0).asDiagonal().toDenseMatrix());
  const CholeskySolver solver(matrix);
  EXPECT_DOUBLE_EQ(solver.RelativeResidual(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(3.0, 4.0)), 1.0);
  EXPECT_DOUBLE_EQ(solver.RelativeResidual(Eigen::Vector2d(1.5, 2.0), Eigen::Vector2d(3.0, 4.0)), 4.0 / 5.0);
  EXPECT_EQ(solver.RelativeResidual(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.0, 0.0)), 0.0);
}

TEST(CholeskySolver, ZeroRightHandSidesHaveZeroSolutions)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(2));
  const CholeskySolver solver(matrix);
  EXPECT_EQ(solver.Solve(Eigen::VectorXd::Zero(matrix.rows())).cwiseAbs().maxCoeff(), 0.0);
  RowMatrix zeros = RowMatrix::Zero(matrix.rows(), 9);
  solver.SolveInPlace(zeros);
  EXPECT_EQ(zeros.cwiseAbs().maxCoeff(), 0.0);
}

TEST(CholeskySolver, AcceptsNoColumns)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(1));
  RowMatrix none(matrix.rows(), 0);
  EXPECT_NO_THROW(CholeskySolver(matrix).SolveInPlace(none));
}

TEST(CholeskySolver, ScalesWithTheMatrix)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(3));
  const Eigen::VectorXd side = RandomRightHandSides(matrix.rows(), 1);
  const Eigen::VectorXd reference = CholeskySolver(matrix).Solve(side);
  for (const double scale : { 1e-100, 1e-12, 1e12, 1e100 })
  {
    const Eigen::VectorXd solution = CholeskySolver(SparseMatrix(matrix * scale)).Solve(side);
    EXPECT_LE((solution * scale - reference).norm(), 1e-10 * reference.norm()) << scale;
  }
}

// --- Bits -------------------------------------------------------------------------------------------------------

TEST(CholeskySolver, AColumnHasTheSameBitsAloneAndInEveryBatch)
{
  const TriangleMesh mesh = test::Join(test::BumpySurface(4), test::Translated(test::IrregularSphere(3), { 9, 0, 0 }));
  const SparseMatrix matrix = ScreenedLaplacian(mesh);
  const RowMatrix sides = RandomRightHandSides(matrix.rows(), 100);
  std::vector<Eigen::VectorXd> alone;
  {
    const ThreadScope one(1);
    const CholeskySolver solver(matrix);
    for (Eigen::Index j = 0; j < sides.cols(); ++j)
    {
      alone.push_back(solver.Solve(sides.col(j)));
    }
  }
  for (const int threads : { 1, 2, 3 })
  {
    const ThreadScope scope(threads);
    const CholeskySolver solver(matrix);
    for (const Eigen::Index columns : { 1, 3, 8, 9, 33, 100 })
    {
      RowMatrix solutions = sides.leftCols(columns);
      solver.SolveInPlace(solutions);
      for (Eigen::Index j = 0; j < columns; ++j)
      {
        EXPECT_TRUE(SameBits(solutions.col(j), alone[static_cast<std::size_t>(j)]))
          << "column " << j << " of " << columns << " at " << threads << " threads";
      }
    }
  }
}

TEST(CholeskySolver, AColumnHasTheSameBitsAtEveryPlaceOfABatch)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(3));
  const CholeskySolver solver(matrix);
  const Eigen::VectorXd side = RandomRightHandSides(matrix.rows(), 1, 7);
  const Eigen::VectorXd alone = solver.Solve(side);
  for (const Eigen::Index columns : { 2, 7, 16, 31, 40 })
  {
    RowMatrix sides = side.replicate(1, columns);
    solver.SolveInPlace(sides);
    for (Eigen::Index j = 0; j < columns; ++j)
    {
      EXPECT_TRUE(SameBits(sides.col(j), alone)) << "place " << j << " of " << columns;
    }
  }
}

TEST(CholeskySolver, AColumnHasTheSameBitsAloneWithEveryInstructionSet)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(4));
  const RowMatrix sides = RandomRightHandSides(matrix.rows(), 3);
  const InstructionSet before = CurrentInstructionSet();
  const CholeskySolver solver(matrix);
  for (const InstructionSet set : { InstructionSet::Generic, InstructionSet::Avx2, InstructionSet::Avx512 })
  {
    if (!HasInstructionSet(set))
    {
      continue;
    }
    SetInstructionSet(set);
    RowMatrix together = sides;
    solver.SolveInPlace(together);
    for (Eigen::Index j = 0; j < sides.cols(); ++j)
    {
      EXPECT_TRUE(SameBits(together.col(j), solver.Solve(sides.col(j)))) << "column " << j;
    }
  }
  SetInstructionSet(before);
}

TEST(CholeskySolver, SolvesBlocksOfALargerMatrixInPlace)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(2));
  const CholeskySolver solver(matrix);
  const RowMatrix sides = RandomRightHandSides(matrix.rows(), 12);
  RowMatrix solutions = sides;
  solver.SolveInPlace(solutions.middleCols(3, 5)); // rows 12 numbers apart
  EXPECT_EQ(solutions.leftCols(3), sides.leftCols(3));
  EXPECT_EQ(solutions.rightCols(4), sides.rightCols(4));
  for (Eigen::Index j = 3; j < 8; ++j)
  {
    EXPECT_TRUE(SameBits(solutions.col(j), solver.Solve(sides.col(j)))) << j;
  }
}

TEST(CholeskySolver, OrderedSolvesHaveTheSameBits)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(3));
  const CholeskySolver solver(matrix);
  const std::vector<Index>& order = solver.Order();
  ASSERT_EQ(order.size(), static_cast<std::size_t>(matrix.rows()));
  std::vector<Index> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (Index v = 0; v < solver.Size(); ++v)
  {
    ASSERT_EQ(sorted[static_cast<std::size_t>(v)], v) << "not a permutation";
  }
  for (const Eigen::Index columns : { 1, 8, 32, 40 })
  {
    const RowMatrix sides = RandomRightHandSides(matrix.rows(), columns);
    RowMatrix expected = sides;
    solver.SolveInPlace(expected);
    RowMatrix ordered(sides.rows(), columns);
    for (Index row = 0; row < solver.Size(); ++row)
    {
      ordered.row(row) = sides.row(order[static_cast<std::size_t>(row)]);
    }
    solver.SolveOrderedInPlace(ordered);
    for (Index row = 0; row < solver.Size(); ++row)
    {
      ASSERT_EQ(ordered.row(row), expected.row(order[static_cast<std::size_t>(row)])) << row;
    }
  }
}

TEST(CholeskySolver, OrderedSolvesRejectOtherShapesAndStopOnRequest)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(4));
  const CholeskySolver solver(matrix);
  RowMatrix tooFewRows = RowMatrix::Ones(matrix.rows() - 1, 8);
  EXPECT_THROW(solver.SolveOrderedInPlace(tooFewRows), InvalidInput);
  RowMatrix sevenColumns = RowMatrix::Ones(matrix.rows(), 7);
  EXPECT_THROW(solver.SolveOrderedInPlace(sevenColumns), InvalidInput);
  RowMatrix sides = RowMatrix::Ones(matrix.rows(), 32);
  EXPECT_THROW(solver.SolveOrderedInPlace(sides, [](double) { return false; }), Cancelled);
}

TEST(CholeskySolver, SeveralThreadsMaySolveAtOnce)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(4));
  const CholeskySolver solver(matrix);
  const RowMatrix sides = RandomRightHandSides(matrix.rows(), 20);
  RowMatrix expected = sides;
  solver.SolveInPlace(expected);
  std::atomic<int> wrong{ 0 };
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
  {
    threads.emplace_back([&, t] {
      for (int repeat = 0; repeat < 5; ++repeat)
      {
        RowMatrix mine = sides.middleCols(5 * t, 5);
        solver.SolveInPlace(mine);
        wrong += mine == expected.middleCols(5 * t, 5) ? 0 : 1;
        wrong += solver.Solve(sides.col(t)) == Eigen::VectorXd(expected.col(t)) ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

/// Two dense blocks that are coupled by a third one only: a front with @p coupling rows below, which go to threads in
/// parts.
SparseMatrix CoupledBlocks(Index block, Index coupling)
{
  const Index size = 2 * block + coupling;
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index i = 0; i < size; ++i)
  {
    for (Index j = 0; j <= i; ++j)
    {
      if (i < 2 * block && i >= block && j < block)
      {
        continue;
      }
      const double value = i == j ? size : -1.0 / (1.0 + (7 * i + 3 * j) % 11);
      entries.emplace_back(i, j, value);
      if (i != j)
      {
        entries.emplace_back(j, i, value);
      }
    }
  }
  SparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

TEST(CholeskySolver, LargeFrontsHaveTheSameBitsForEveryNumberOfThreads)
{
  const SparseMatrix matrix = CoupledBlocks(300, 900);
  const Eigen::VectorXd side = Eigen::VectorXd::LinSpaced(matrix.rows(), -1.0, 2.0);
  const auto solve = [&](int threads) {
    const ThreadScope scope(threads);
    const CholeskySolver solver(matrix);
    EXPECT_LT(
      solver.FactorEntries(), 2000000); // two fronts, the first with 900 rows below; as one they are 2.25 million
    return solver.Solve(side);
  };
  const Eigen::VectorXd alone = solve(1);
  EXPECT_LE((matrix * alone - side).norm(), 1e-12 * side.norm());
  EXPECT_EQ(solve(2), alone);
  EXPECT_EQ(solve(3), alone);
}

TEST(CholeskySolver, MovesWithItsFactor)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(1));
  const Eigen::VectorXd side = RandomRightHandSides(matrix.rows(), 1);
  CholeskySolver first(matrix);
  const Eigen::VectorXd expected = first.Solve(side);
  CholeskySolver second(std::move(first));
  EXPECT_TRUE(SameBits(second.Solve(side), expected));
  CholeskySolver third(Sparse(Eigen::MatrixXd::Identity(2, 2)));
  third = std::move(second);
  EXPECT_TRUE(SameBits(third.Solve(side), expected));
}

// --- Small sizes ------------------------------------------------------------------------------------------------

TEST(CholeskySolver, OneByOne)
{
  EXPECT_DOUBLE_EQ(
    SolveCholesky(Sparse(Eigen::MatrixXd::Constant(1, 1, 4.0)), Eigen::VectorXd::Constant(1, 8.0))[0], 2.0);
}

TEST(CholeskySolver, TwoByTwo)
{
  Eigen::Matrix2d matrix;
  matrix << 2.0, 1.0, 1.0, 2.0;
  const Eigen::VectorXd solution = SolveCholesky(Sparse(matrix), Eigen::Vector2d(4.0, 5.0));
  EXPECT_NEAR(solution[0], 1.0, 1e-15);
  EXPECT_NEAR(solution[1], 2.0, 1e-15);
}

TEST(CholeskySolver, DiagonalMatrix)
{
  const Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(50, 1.0, 99.0);
  const Eigen::VectorXd solution = SolveCholesky(Sparse(diagonal.asDiagonal().toDenseMatrix()), diagonal);
  EXPECT_TRUE(solution.isApprox(Eigen::VectorXd::Ones(50), 1e-15));
}

TEST(CholeskySolver, DenseMatrix)
{
  for (const int size : { 3, 17, 64, 150 })
  {
    const Eigen::MatrixXd random = RandomRightHandSides(size, size);
    const Eigen::MatrixXd matrix = random * random.transpose() + size * Eigen::MatrixXd::Identity(size, size);
    const Eigen::VectorXd side = RandomRightHandSides(size, 1, 3);
    const Eigen::VectorXd expected = matrix.llt().solve(side);
    EXPECT_TRUE(SolveCholesky(Sparse(matrix), side).isApprox(expected, 1e-12)) << size;
  }
}

// --- Refusals ---------------------------------------------------------------------------------------------------

TEST(CholeskySolver, RejectsMatricesThatAreNotSquare)
{
  SparseMatrix matrix(3, 2);
  matrix.insert(0, 0) = 1.0;
  matrix.makeCompressed();
  EXPECT_THROW(CholeskySolver{ matrix }, InvalidInput);
}

TEST(CholeskySolver, RejectsMatricesThatAreNotFinite)
{
  for (const double bad : { NaN, Infinity, -Infinity })
  {
    SparseMatrix diagonal = ScreenedLaplacian(test::Icosphere(1));
    diagonal.coeffRef(7, 7) = bad;
    EXPECT_THROW(CholeskySolver{ diagonal }, InvalidInput) << bad;
    SparseMatrix pair = ScreenedLaplacian(test::Icosphere(1));
    const Index row = NeighborOf(pair, 7);
    pair.coeffRef(row, 7) = bad;
    pair.coeffRef(7, row) = bad;
    EXPECT_THROW(CholeskySolver{ pair }, InvalidInput) << bad;
    // A bad entry in one triangle only.
    SparseMatrix upper = ScreenedLaplacian(test::Icosphere(1));
    upper.coeffRef(std::min(row, 7), std::max(row, 7)) = bad;
    EXPECT_THROW(CholeskySolver{ upper }, InvalidInput) << bad;
  }
}

TEST(CholeskySolver, RejectsMatricesThatAreNotSymmetric)
{
  const SparseMatrix sound = ScreenedLaplacian(test::Icosphere(1));
  const Index row = NeighborOf(sound, 7);
  SparseMatrix value = sound;
  value.coeffRef(row, 7) *= 1.0 + 1e-8;
  EXPECT_THROW(CholeskySolver{ value }, InvalidInput);
  SparseMatrix rounding = sound;
  rounding.coeffRef(row, 7) *= 1.0 + 1e-13;
  EXPECT_NO_THROW(CholeskySolver{ rounding });
  // An entry without its mirror image, on either side.
  for (const bool lower : { true, false })
  {
    SparseMatrix pattern = sound;
    Index other = 0;
    while (other == 7 || pattern.coeff(other, 7) != 0.0)
    {
      ++other;
    }
    pattern.insert(
      lower ? std::max(other, 7) : std::min(other, 7), lower ? std::min(other, 7) : std::max(other, 7)) = 1e-3;
    pattern.makeCompressed();
    EXPECT_THROW(CholeskySolver{ pattern }, InvalidInput) << (lower ? "lower" : "upper");
  }
  // The lower triangle alone.
  EXPECT_THROW(CholeskySolver{ SparseMatrix(sound.triangularView<Eigen::Lower>()) }, InvalidInput);
}

TEST(CholeskySolver, RejectsMatricesThatAreNotPositiveDefinite)
{
  const TriangleMesh mesh = test::Icosphere(2);
  SparseMatrix indefinite = CotangentStiffness(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  for (Index v = 0; v < mass.size(); ++v)
  {
    indefinite.coeffRef(v, v) -= 3.0 * mass[v]; // between the first two eigenvalues, 2 and 6
  }
  EXPECT_THROW(CholeskySolver{ indefinite }, SolverFailure);
  EXPECT_THROW(CholeskySolver{ SparseMatrix(-1.0 * ScreenedLaplacian(mesh)) }, SolverFailure);
  EXPECT_THROW(CholeskySolver{ Sparse(Eigen::MatrixXd::Constant(1, 1, -1.0)) }, SolverFailure);
  SparseMatrix zero(4, 4);
  EXPECT_THROW(CholeskySolver{ zero }, SolverFailure);
  Eigen::Matrix2d singular;
  singular << 1.0, 1.0, 1.0, 1.0;
  EXPECT_THROW(CholeskySolver{ Sparse(singular) }, SolverFailure);
}

TEST(CholeskySolver, RejectsRightHandSidesOfTheWrongLength)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(1));
  const CholeskySolver solver(matrix);
  EXPECT_THROW(solver.Solve(Eigen::VectorXd::Ones(matrix.rows() - 1)), InvalidInput);
  EXPECT_THROW(solver.Solve(Eigen::VectorXd::Ones(matrix.rows() + 1)), InvalidInput);
  EXPECT_THROW(solver.Solve(Eigen::VectorXd()), InvalidInput);
  RowMatrix sides = RowMatrix::Ones(matrix.rows() + 1, 3);
  EXPECT_THROW(solver.SolveInPlace(sides), InvalidInput);
}

TEST(CholeskySolver, RejectsRightHandSidesThatAreNotFinite)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::Icosphere(1));
  const CholeskySolver solver(matrix);
  for (const double bad : { NaN, Infinity })
  {
    Eigen::VectorXd side = Eigen::VectorXd::Ones(matrix.rows());
    side[matrix.rows() - 1] = bad;
    EXPECT_THROW(solver.Solve(side), InvalidInput);
    RowMatrix sides = RowMatrix::Ones(matrix.rows(), 35);
    sides(20, 34) = bad;
    EXPECT_THROW(solver.SolveInPlace(sides), InvalidInput);
  }
}

// --- Progress ---------------------------------------------------------------------------------------------------

TEST(CholeskySolver, StopsOnRequest)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(6));
  int reports = 0;
  EXPECT_THROW(CholeskySolver(matrix,
                 [&](double) {
                   ++reports;
                   return false;
                 }),
    Cancelled);
  EXPECT_EQ(reports, 1) << "nothing is reported after the request";
}

TEST(CholeskySolver, ProgressNeverFallsAndDoesNotChangeTheAnswer)
{
  const SparseMatrix matrix = ScreenedLaplacian(test::BumpySurface(5));
  std::vector<double> seen = { 0.0 };
  const std::thread::id caller = std::this_thread::get_id();
  const CholeskySolver solver(matrix, [&](double fraction) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_GE(fraction, seen.back());
    EXPECT_LE(fraction, 1.0);
    seen.push_back(fraction);
    return true;
  });
  const Eigen::VectorXd side = RandomRightHandSides(matrix.rows(), 1);
  EXPECT_TRUE(SameBits(solver.Solve(side), CholeskySolver(matrix).Solve(side)));
}
