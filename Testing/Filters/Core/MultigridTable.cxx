// SPDX-License-Identifier: BSD-3-Clause
// Iterations, time and memory of MultigridSolver by size, as a table; fails when iterations grow with the size, a
// residual exceeds the tolerance, or a size exceeds its memory.
//
//   MultigridTable                  spheres and cubes up to 655,362 and 262,144 vertices, beside the Cholesky factor
//   MultigridTable sphere 10        one sphere of 10 * 4^10 + 2 vertices, without the factor
//   MultigridTable cube 70          one cube of 6 * 70^3 tetrahedra, without the factor
#include "ScreenedMatrices.h"

#include "Core/Solvers/MultigridSolver.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{
constexpr double MiB = 1048576.0;
constexpr double GiB = 1024.0;

/// A case, and the limits that it is held against.
struct Case
{
  std::string Kind; ///< sphere or cube
  int Size;         ///< level, or cells along a side
  bool WithFactor;
  double MostMiB; ///< peak of the process from the mesh in memory to the solution; 0 for none
};

double Seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double StatusMiB(const std::string& key)
{
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
  {
    double kibibytes = 0.0;
    if (word == key + ":" && status >> kibibytes)
    {
      return kibibytes / 1024.0;
    }
  }
  return 0.0;
}

void RestartPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// Measures a case and returns its number of iterations, or 0 when it misses a limit.
int Measure(const Case& of)
{
  TriangleMesh mesh = of.Kind == "sphere" ? test::LargeSphere(of.Size) : TriangleMesh();
  RestartPeak();
  test::ScreenedMatrix screened = of.Kind == "sphere" ? test::ScreenedSurface(mesh) : test::ScreenedCube(of.Size);
  const Index size = static_cast<Index>(screened.Matrix.rows());
  const std::int64_t entries = screened.Matrix.nonZeros();
  const double start = StatusMiB("VmRSS");
  const double peakOfAssembly = StatusMiB("VmHWM");
  RowMatrix sides = test::NoiseSides(screened.Mass, 1);
  std::optional<SparseMatrix> kept;
  if (of.WithFactor)
  {
    kept = screened.Matrix;
  }
  RestartPeak();
  const double began = Seconds();
  const MultigridSolver solver(std::move(screened.Matrix));
  const double built = Seconds();
  RowMatrix solutions = sides;
  solver.SolveInPlace(solutions);
  const double solved = Seconds();
  const double peak = StatusMiB("VmHWM");
  std::printf("%-7s %10d %6.2f %7d %6.2f %5d %9.1e | %8.2f %8.2f | %7.0f %7.0f %7.0f %9.0f |", of.Kind.c_str(), size,
    static_cast<double>(entries) / size, solver.NumberOfLevels(), solver.OperatorComplexity(), solver.Iterations(),
    solver.LargestResidual(), built - began, solved - built, static_cast<double>(solver.MemoryInUse()) / size,
    static_cast<double>(MultigridSolver::EstimateMemory(size, entries)) / size, (peak - start) * MiB / size,
    std::max(peak, peakOfAssembly));
  bool good = solver.LargestResidual() <= 1e-10;
  good = good && (of.MostMiB == 0.0 || std::max(peak, peakOfAssembly) <= of.MostMiB);
  if (kept)
  {
    const double before = Seconds();
    const CholeskySolver factor(*kept);
    const double factored = Seconds();
    RowMatrix expected = sides;
    factor.SolveInPlace(expected);
    const double difference = (solutions - expected).norm() / expected.norm();
    std::printf(" %8.2f %8.2f %7.0f %9.1e", factored - before, Seconds() - factored,
      8.0 * static_cast<double>(factor.FactorEntries()) / size, difference);
    good = good && difference <= 1e-8;
  }
  std::printf("%s\n", good ? "" : "   <- misses its limit");
  std::fflush(stdout);
  return good ? solver.Iterations() : 0;
}
} // namespace

int main(int argc, char** argv)
try
{
  std::vector<Case> cases;
  if (argc > 2)
  {
    const double most = std::string(argv[1]) == "sphere" ? 12.0 * GiB : 6.0 * GiB;
    cases = { { argv[1], std::atoi(argv[2]), false, most } };
  }
  else
  {
    for (const int level : { 5, 6, 7, 8 })
    {
      cases.push_back({ "sphere", level, true, 0.0 });
    }
    for (const int cells : { 16, 31, 63 })
    {
      cases.push_back({ "cube", cells, cells < 63, 0.0 });
    }
  }
  std::printf("%-7s %10s %6s %7s %6s %5s %9s | %8s %8s | %7s %7s %7s %9s | %8s %8s %7s %9s\n", "", "", "entries", "",
    "comp-", "iter-", "", "set-up", "solve", "held", "estim.", "peak", "process", "factor", "solve", "bytes", "");
  std::printf("%-7s %10s %6s %7s %6s %5s %9s | %8s %8s | %7s %7s %7s %9s | %8s %8s %7s %9s\n", "", "vertices", "/row",
    "levels", "lexity", "ations", "residual", "s", "s", "B/row", "B/row", "B/row", "MiB", "s", "s", "B/row",
    "difference");
  int least = 1000;
  int most = 0;
  for (const Case& of : cases)
  {
    const int iterations = Measure(of);
    if (iterations == 0)
    {
      return EXIT_FAILURE;
    }
    least = std::min(least, of.Kind == "sphere" ? iterations : least);
    most = std::max(most, of.Kind == "sphere" ? iterations : most);
  }
  return argc > 2 || most <= least + 6 ? EXIT_SUCCESS : EXIT_FAILURE;
}
catch (const std::exception& error)
{
  std::fprintf(stderr, "MultigridTable: %s\n", error.what());
  return EXIT_FAILURE;
}
