// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"
#include "ScreenedMatrices.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/MultigridSolver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{

const double NaN = std::numeric_limits<double>::quiet_NaN();

bool SameBits(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  return a.size() == b.size() &&
    std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

/// Relative difference to the solutions of the Cholesky factor.
double DifferenceToFactor(const test::ScreenedMatrix& screened, const RowMatrix& solutions, const RowMatrix& sides)
{
  RowMatrix expected = sides;
  CholeskySolver(screened.Matrix).SolveInPlace(expected);
  return (solutions - expected).norm() / expected.norm();
}

/// Rectangle of needles: triangles @p aspect times as long as wide, some of them obtuse.
TriangleMesh Needles(int cells, double aspect)
{
  TriangleMesh mesh = test::PlanePatch(cells, cells, 1.0, 1.0, 0.2);
  mesh.Points.col(0) *= aspect;
  return mesh;
}

std::string ThrownBy(const std::function<void()>& call)
{
  try
  {
    call();
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return {};
}

class MultigridOnMesh : public testing::TestWithParam<std::string>
{
protected:
  const test::ScreenedMatrix Screened = test::ScreenedSurface(test::FromSuite(GetParam()).Mesh);
};

INSTANTIATE_TEST_SUITE_P(
  Suite, MultigridOnMesh, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

// --- Solutions --------------------------------------------------------------------------------------------------

TEST_P(MultigridOnMesh, AgreesWithTheFactorTo1em8)
{
  RowMatrix sides(this->Screened.Matrix.rows(), 2);
  for (Eigen::Index i = 0; i < sides.size(); ++i)
  {
    sides.data()[i] = test::Uniform(static_cast<std::uint64_t>(i), 5);
  }
  RowMatrix solutions = sides;
  const MultigridSolver solver(this->Screened.Matrix);
  solver.SolveInPlace(solutions);
  EXPECT_LE(DifferenceToFactor(this->Screened, solutions, sides), 1e-8);
  EXPECT_LE(solver.LargestResidual(), 1e-10);
  EXPECT_LE(solver.RelativeResidual(solutions.col(0), sides.col(0)), 1.001e-10);
  EXPECT_GE(solver.Iterations(), 1);
  EXPECT_LE(solver.Iterations(), 60);
}

TEST(MultigridSolver, AgreesWithTheFactorOnTetrahedra)
{
  const test::ScreenedMatrix cube = test::ScreenedCube(14);
  const RowMatrix sides = test::NoiseSides(cube.Mass, 3);
  RowMatrix solutions = sides;
  const MultigridSolver solver(cube.Matrix);
  solver.SolveInPlace(solutions);
  EXPECT_LE(DifferenceToFactor(cube, solutions, sides), 1e-8);
  EXPECT_GE(solver.NumberOfLevels(), 2);
  EXPECT_LE(solver.Iterations(), 15);
}

TEST(MultigridSolver, AgreesWithTheFactorForAllTolerances)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(4));
  const RowMatrix sides = test::NoiseSides(surface.Mass, 1);
  int last = 0;
  for (const double tolerance : { 1e-2, 1e-4, 1e-8, 1e-12 })
  {
    MultigridOptions options;
    options.Tolerance = tolerance;
    const MultigridSolver solver(surface.Matrix, options);
    const Eigen::VectorXd solution = solver.Solve(sides.col(0));
    EXPECT_LE(solver.RelativeResidual(solution, sides.col(0)), 1.001 * tolerance);
    EXPECT_GT(solver.Iterations(), last);
    last = solver.Iterations();
  }
}

TEST(MultigridSolver, IterationsHardlyDependOnTheSize)
{
  std::vector<int> iterations;
  for (const int level : { 4, 5, 6 })
  {
    const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(level));
    const MultigridSolver solver(surface.Matrix);
    RowMatrix sides = test::NoiseSides(surface.Mass, 1);
    solver.SolveInPlace(sides);
    iterations.push_back(solver.Iterations());
    EXPECT_LE(solver.OperatorComplexity(), 1.7);
  }
  EXPECT_LE(iterations.back(), iterations.front() + 4);
  EXPECT_LE(iterations.back(), 20);
}

TEST(MultigridSolver, NeedlesWithCotangentsOfBothSignsConverge)
{
  for (const double aspect : { 10.0, 100.0 })
  {
    const test::ScreenedMatrix needles = test::ScreenedSurface(Needles(60, aspect));
    double positive = 0.0;
    for (Index v = 0; v < needles.Matrix.cols(); ++v)
    {
      for (SparseMatrix::InnerIterator entry(needles.Matrix, v); entry; ++entry)
      {
        positive = std::max(positive, entry.row() == v ? 0.0 : entry.value());
      }
    }
    ASSERT_GT(positive, 1.0) << "no obtuse needles";
    const RowMatrix sides = test::NoiseSides(needles.Mass, 2);
    RowMatrix solutions = sides;
    const MultigridSolver solver(needles.Matrix);
    solver.SolveInPlace(solutions);
    EXPECT_LE(DifferenceToFactor(needles, solutions, sides), 1e-8) << aspect;
    EXPECT_LE(solver.Iterations(), 100) << aspect;
  }
}

TEST(MultigridSolver, ManyComponentsOfAllSizesAndUnusedPointsConverge)
{
  TriangleMesh mesh = test::BumpySurface(4);
  for (int k = 0; k < 40; ++k)
  {
    mesh = test::Join(
      mesh, test::Translated(k % 4 == 0 ? test::Icosphere(2, 0.1) : test::Tetrahedron(), { 3.0 + 2.0 * k, 0.0, 0.0 }));
  }
  const test::ScreenedMatrix joined = test::ScreenedSurface(test::WithUnreferencedPoints(mesh));
  const RowMatrix sides = test::NoiseSides(joined.Mass, 1);
  RowMatrix solutions = sides;
  const MultigridSolver solver(joined.Matrix);
  solver.SolveInPlace(solutions);
  EXPECT_LE(DifferenceToFactor(joined, solutions, sides), 1e-8);
  EXPECT_LE(solver.Iterations(), 25);
}

TEST(MultigridSolver, TinyAndHugeScreeningConverge)
{
  for (const double screening : { 1e-3, 1e-1, 1e4, 1e6, 1e9 })
  {
    const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(5), screening);
    const RowMatrix sides = test::NoiseSides(surface.Mass, 1);
    RowMatrix solutions = sides;
    const MultigridSolver solver(surface.Matrix);
    solver.SolveInPlace(solutions);
    EXPECT_LE(DifferenceToFactor(surface, solutions, sides), 1e-8) << screening;
    EXPECT_LE(solver.Iterations(), 25) << screening;
  }
}

TEST(MultigridSolver, ResidualIsThatOfRoundingWhereItHidesTheTolerance)
{
  // The solution is nearly constant and so large that rounding A x hides a residual of 1e-10.
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(5), 1e-6);
  const Eigen::VectorXd side = test::NoiseSides(surface.Mass, 1).col(0);
  const MultigridSolver solver(surface.Matrix);
  const CholeskySolver factor(surface.Matrix);
  const double residual = solver.RelativeResidual(solver.Solve(side), side);
  EXPECT_GT(residual, 1e-10);
  EXPECT_LE(residual, 10.0 * factor.RelativeResidual(factor.Solve(side), side));
  EXPECT_NEAR(solver.LargestResidual(), residual, 0.5 * residual);
}

TEST(MultigridSolver, SolutionsScaleWithMatrixAndRightHandSide)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(4));
  const Eigen::VectorXd side = test::NoiseSides(surface.Mass, 1).col(0);
  const Eigen::VectorXd reference = MultigridSolver(surface.Matrix).Solve(side);
  for (const double scale : { 1e-100, 1e-12, 1e12, 1e100 })
  {
    const MultigridSolver solver(SparseMatrix(surface.Matrix * scale));
    EXPECT_LE((solver.Solve(side) * scale - reference).norm(), 1e-9 * reference.norm()) << scale;
    EXPECT_LE((solver.Solve(side * scale) - reference).norm(), 1e-9 * reference.norm()) << scale;
  }
}

TEST(MultigridSolver, SmallMatricesAreSolved)
{
  SparseMatrix one(1, 1);
  one.insert(0, 0) = 4.0;
  EXPECT_DOUBLE_EQ(MultigridSolver(one).Solve(Eigen::VectorXd::Constant(1, 8.0))[0], 2.0);
  const Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(3000, 1.0, 9e9);
  const SparseMatrix matrix = Eigen::MatrixXd(diagonal.head(50).asDiagonal()).sparseView();
  EXPECT_TRUE(MultigridSolver(matrix).Solve(diagonal.head(50)).isApprox(Eigen::VectorXd::Ones(50), 1e-10));
  SparseMatrix wide(3000, 3000);
  for (Index v = 0; v < 3000; ++v)
  {
    wide.insert(v, v) = diagonal[v];
  }
  EXPECT_TRUE(MultigridSolver(wide).Solve(diagonal).isApprox(Eigen::VectorXd::Ones(3000), 1e-10));
}

TEST(MultigridSolver, ZeroRightHandSidesHaveZeroSolutions)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::Icosphere(3));
  const MultigridSolver solver(surface.Matrix);
  RowMatrix zeros = RowMatrix::Zero(surface.Matrix.rows(), 9);
  solver.SolveInPlace(zeros);
  EXPECT_EQ(zeros.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(solver.Iterations(), 0);
  RowMatrix none(surface.Matrix.rows(), 0);
  EXPECT_NO_THROW(solver.SolveInPlace(none));
}

// --- Bits -------------------------------------------------------------------------------------------------------

TEST(MultigridSolver, AColumnHasTheSameBitsAloneInEveryBatchAndForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::Join(
    test::BumpySurface(6), test::Translated(test::IrregularSphere(3), { 9.0, 0.0, 0.0 }));
  const test::ScreenedMatrix surface = test::ScreenedSurface(mesh);
  RowMatrix sides = test::NoiseSides(surface.Mass, 9);
  sides.col(2).setZero();
  sides.col(5) = surface.Matrix * Eigen::VectorXd::Ones(surface.Matrix.rows()); // converges sooner than the others
  std::vector<Eigen::VectorXd> alone;
  {
    const ThreadScope one(1);
    const MultigridSolver solver(surface.Matrix);
    for (Eigen::Index c = 0; c < sides.cols(); ++c)
    {
      alone.push_back(solver.Solve(sides.col(c)));
    }
  }
  for (const int threads : { 1, 3 })
  {
    const ThreadScope scope(threads);
    const MultigridSolver solver(surface.Matrix);
    for (const Eigen::Index columns : { 3, 6, 9 })
    {
      RowMatrix solutions = sides.leftCols(columns);
      solver.SolveInPlace(solutions);
      for (Eigen::Index c = 0; c < columns; ++c)
      {
        EXPECT_TRUE(SameBits(solutions.col(c), alone[static_cast<std::size_t>(c)]))
          << "column " << c << " of " << columns << " at " << threads << " threads";
      }
    }
  }
}

TEST(MultigridSolver, OrderedSolvesHaveTheSameBits)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(4));
  const MultigridSolver solver(surface.Matrix);
  std::vector<Index> sorted = solver.Order();
  std::sort(sorted.begin(), sorted.end());
  for (Index v = 0; v < solver.Size(); ++v)
  {
    ASSERT_EQ(sorted[static_cast<std::size_t>(v)], v) << "not a permutation";
  }
  const RowMatrix sides = test::NoiseSides(surface.Mass, 5);
  RowMatrix expected = sides;
  solver.SolveInPlace(expected);
  RowMatrix ordered(sides.rows(), sides.cols());
  for (Index row = 0; row < solver.Size(); ++row)
  {
    ordered.row(row) = sides.row(solver.Order()[static_cast<std::size_t>(row)]);
  }
  solver.SolveOrderedInPlace(ordered);
  for (Index row = 0; row < solver.Size(); ++row)
  {
    ASSERT_EQ(ordered.row(row), expected.row(solver.Order()[static_cast<std::size_t>(row)])) << row;
  }
}

TEST(MultigridSolver, SolvesColumnsOfALargerMatrixInPlace)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(3));
  const MultigridSolver solver(surface.Matrix);
  const RowMatrix sides = test::NoiseSides(surface.Mass, 12);
  RowMatrix solutions = sides;
  solver.SolveInPlace(solutions.middleCols(3, 5)); // rows 12 numbers apart
  EXPECT_EQ(solutions.leftCols(3), sides.leftCols(3));
  EXPECT_EQ(solutions.rightCols(4), sides.rightCols(4));
  for (Eigen::Index c = 3; c < 8; ++c)
  {
    EXPECT_TRUE(SameBits(solutions.col(c), solver.Solve(sides.col(c)))) << c;
  }
}

TEST(MultigridSolver, SeveralThreadsMaySolveAtOnce)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(4));
  const MultigridSolver solver(surface.Matrix);
  const RowMatrix sides = test::NoiseSides(surface.Mass, 8);
  RowMatrix expected = sides;
  solver.SolveInPlace(expected);
  std::atomic<int> wrong{ 0 };
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
  {
    threads.emplace_back([&, t] {
      RowMatrix mine = sides.middleCols(2 * t, 2);
      solver.SolveInPlace(mine);
      wrong += mine == expected.middleCols(2 * t, 2) ? 0 : 1;
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

// --- Memory -----------------------------------------------------------------------------------------------------

TEST(MultigridSolver, EstimateBoundsWhatIsHeldAndRefusesTheRestBeforeTheWork)
{
  for (const test::ScreenedMatrix& screened :
    { test::ScreenedSurface(test::BumpySurface(5)), test::ScreenedSurface(Needles(60, 30.0)), test::ScreenedCube(12) })
  {
    const std::int64_t rows = screened.Matrix.rows();
    const std::int64_t entries = screened.Matrix.nonZeros();
    const std::uint64_t estimate = MultigridSolver::EstimateMemory(rows, entries);
    const MultigridSolver solver(screened.Matrix);
    EXPECT_LE(static_cast<std::uint64_t>(solver.MemoryInUse() + 56 * rows), estimate);
    EXPECT_GE(static_cast<std::uint64_t>(3 * solver.MemoryInUse()), estimate);
    MultigridOptions options;
    options.MemoryLimit = estimate - 1;
    int reports = 0;
    EXPECT_THAT(ThrownBy([&] {
      MultigridSolver(screened.Matrix, options, [&](double) {
        ++reports;
        return true;
      });
    }),
      HasSubstr("MiB; expected at most"));
    EXPECT_EQ(reports, 0);
    options.MemoryLimit = estimate;
    EXPECT_NO_THROW(MultigridSolver(screened.Matrix, options));
  }
  EXPECT_LT(MultigridSolver::EstimateMemory(1000, 7000, 4), MultigridSolver::EstimateMemory(1000, 7000, 8));
  EXPECT_EQ(MultigridSolver::EstimateMemory(1000, 7000, 8), MultigridSolver::EstimateMemory(1000, 7000, 100));
}

// --- Refusals ---------------------------------------------------------------------------------------------------

TEST(MultigridSolver, TooFewIterationsAreAFailureThatSaysTheResidual)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(5));
  MultigridOptions options;
  options.MaximumIterations = 3;
  const MultigridSolver solver(surface.Matrix, options);
  RowMatrix sides = test::NoiseSides(surface.Mass, 2);
  EXPECT_THROW(solver.SolveInPlace(sides), SolverFailure);
  EXPECT_THAT(ThrownBy([&] { solver.Solve(surface.Mass); }),
    testing::AllOf(HasSubstr("after 3 iterations"), HasSubstr("expected at most 1e-10")));
}

TEST(MultigridSolver, RejectsOptionsOutOfRange)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::Icosphere(1));
  for (const double tolerance : { 0.0, 1e-15, 0.2, NaN })
  {
    MultigridOptions options;
    options.Tolerance = tolerance;
    EXPECT_THROW(MultigridSolver(surface.Matrix, options), InvalidInput) << tolerance;
  }
  MultigridOptions options;
  options.MaximumIterations = 0;
  EXPECT_THROW(MultigridSolver(surface.Matrix, options), InvalidInput);
}

TEST(MultigridSolver, RejectsMatricesThatAreNotSymmetricOrNotFiniteOrNotSquare)
{
  const SparseMatrix sound = test::ScreenedSurface(test::Icosphere(1)).Matrix;
  SparseMatrix infinite = sound;
  infinite.coeffRef(3, 3) = NaN;
  EXPECT_THROW(MultigridSolver{ infinite }, InvalidInput);
  EXPECT_THROW(MultigridSolver{ SparseMatrix(sound.triangularView<Eigen::Lower>()) }, InvalidInput);
  EXPECT_THROW(MultigridSolver{ SparseMatrix(3, 2) }, InvalidInput);
  EXPECT_THROW(MultigridSolver{ SparseMatrix() }, InvalidInput);
}

TEST(MultigridSolver, MatricesThatAreNotPositiveDefiniteAreAFailure)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(4));
  EXPECT_THROW(MultigridSolver{ SparseMatrix(-1.0 * surface.Matrix) }, SolverFailure);
  EXPECT_THROW(MultigridSolver{ SparseMatrix(4, 4) }, SolverFailure);
  SparseMatrix indefinite = surface.Matrix;
  const double area = surface.Mass.sum();
  for (Index v = 0; v < surface.Mass.size(); ++v)
  {
    indefinite.coeffRef(v, v) -= 2000.0 / area * surface.Mass[v]; // beyond about 150 eigenvalues
  }
  const RowMatrix sides = test::NoiseSides(surface.Mass, 1);
  EXPECT_THROW(MultigridSolver(indefinite).Solve(sides.col(0)), SolverFailure);
}

TEST(MultigridSolver, RejectsRightHandSidesOfTheWrongLengthOrNotFinite)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::Icosphere(2));
  const MultigridSolver solver(surface.Matrix);
  EXPECT_THROW(solver.Solve(Eigen::VectorXd::Ones(solver.Size() - 1)), InvalidInput);
  RowMatrix tooMany = RowMatrix::Ones(solver.Size() + 1, 3);
  EXPECT_THROW(solver.SolveInPlace(tooMany), InvalidInput);
  EXPECT_THROW(solver.SolveOrderedInPlace(tooMany), InvalidInput);
  RowMatrix sides = RowMatrix::Ones(solver.Size(), 3);
  sides(20, 2) = NaN;
  EXPECT_THROW(solver.SolveInPlace(sides), InvalidInput);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(solver.Size());
  EXPECT_THROW(solver.RelativeResidual(ones, Eigen::VectorXd::Ones(2)), InvalidInput);
}

// --- Progress ---------------------------------------------------------------------------------------------------

TEST(MultigridSolver, StopsOnRequestWhileBuildingAndSolving)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(5));
  for (const int allowed : { 0, 5, 12 })
  {
    int reports = 0;
    const Progress stop = [&](double) { return ++reports <= allowed; };
    EXPECT_THROW(MultigridSolver(surface.Matrix, {}, stop), Cancelled) << allowed;
    EXPECT_EQ(reports, allowed + 1) << "nothing is reported after the request";
    const MultigridSolver solver(surface.Matrix);
    RowMatrix sides = test::NoiseSides(surface.Mass, 3);
    reports = 0;
    EXPECT_THROW(solver.SolveInPlace(sides, stop), Cancelled) << allowed;
    EXPECT_EQ(reports, allowed + 1);
  }
}

TEST(MultigridSolver, ProgressNeverFallsEndsAt1AndDoesNotChangeTheAnswer)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(5));
  const std::thread::id caller = std::this_thread::get_id();
  double last = 0.0;
  const Progress check = [&](double fraction) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_GE(fraction, last);
    EXPECT_LE(fraction, 1.0);
    last = fraction;
    return true;
  };
  const MultigridSolver solver(surface.Matrix, {}, check);
  EXPECT_EQ(last, 1.0);
  const RowMatrix sides = test::NoiseSides(surface.Mass, 11);
  RowMatrix expected = sides;
  solver.SolveInPlace(expected);
  RowMatrix solutions = sides;
  last = 0.0;
  solver.SolveInPlace(solutions, check);
  EXPECT_EQ(last, 1.0);
  EXPECT_EQ(solutions, expected);
}

TEST(MultigridSolver, MovesWithItsHierarchy)
{
  const test::ScreenedMatrix surface = test::ScreenedSurface(test::BumpySurface(3));
  MultigridSolver first(surface.Matrix);
  const Eigen::VectorXd expected = first.Solve(surface.Mass);
  MultigridSolver second(std::move(first));
  EXPECT_TRUE(SameBits(second.Solve(surface.Mass), expected));
}

} // namespace
