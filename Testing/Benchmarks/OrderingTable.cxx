// SPDX-License-Identifier: BSD-3-Clause
//
// Orders of the matrices of volumes and surfaces as a table: entries and arithmetic of the factor, and the time of
// ordering and symbolic analysis, by CHOLMOD's AMD, by METIS, by NestedDissectionOrder() and by
// WindowedMinimumDegreeOrder(). The latter two are arguments of CHOLMOD's analysis here; AnalyzeSupernodes() gives it a
// matrix that is in order.
//
//   SurfaceSynthesisOrderingTable [CELLS | SURFACE.off]...
//
// The volumes are cubes with CELLS^3 cells (19, 31 and 49 by default) of six tetrahedra each;
// SurfaceSynthesisBenchmarks --write-mesh=603000:SURFACE.off writes a surface.
#include "ExampleMeshes.h"
#include "ScreenedMatrices.h"

#include "Core/Solvers/NestedDissection.h"
#include "Core/Solvers/WindowedMinimumDegree.h"

#include <Eigen/CholmodSupport>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{

using Order = std::vector<Index> (*)(const SparseMatrix&);

/// Prints a row: the analysis by one of CHOLMOD's orderings, or CHOLMOD_GIVEN for @p own, one of the library.
bool PrintRow(const char* name, int ordering, const SparseMatrix& matrix, Order own = nullptr)
{
  const auto begin = std::chrono::steady_clock::now();
  std::vector<Index> order = own != nullptr ? own(matrix) : std::vector<Index>();
  cholmod_common common;
  cholmod_start(&common);
  common.nmethods = 1;
  common.method[0].ordering = ordering;
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_sparse view = Eigen::viewAsCholmod(matrix.selfadjointView<Eigen::Lower>());
  cholmod_factor* factor = cholmod_analyze_p(&view, order.empty() ? nullptr : order.data(), nullptr, 0, &common);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  const bool isDone = factor != nullptr && common.status == CHOLMOD_OK;
  std::printf("| %lld | %s | %.2f M | %.2f | %.2f s |\n", static_cast<long long>(matrix.rows()), name,
    1e-6 * common.lnz, 1e-9 * common.fl, seconds.count());
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  return isDone;
}

/// The matrix of an argument: a surface's where it names a file, a volume's where it is a number of cells.
SparseMatrix MatrixOf(const std::string& argument)
{
  if (argument.size() > 4 && argument.compare(argument.size() - 4, 4, ".off") == 0)
  {
    return test::ScreenedSurface(test::ReadOff(argument)).Matrix;
  }
  const int cells = std::atoi(argument.c_str());
  if (cells < 1 || cells > 200)
  {
    throw std::runtime_error(
      "SurfaceSynthesisOrderingTable: \"" + argument + "\"; expected numbers of cells from 1 to 200 or files *.off.");
  }
  return test::ScreenedCube(cells).Matrix;
}

} // namespace

int main(int argc, char** argv)
{
  std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty())
  {
    arguments = { "19", "31", "49" };
  }
  bool isDone = true;
  try
  {
    std::printf("| points | | entries | GFLOP | ordering and analysis |\n|---:|---|---:|---:|---:|\n");
    for (const std::string& argument : arguments)
    {
      const SparseMatrix matrix = MatrixOf(argument);
      isDone = PrintRow("AMD", CHOLMOD_AMD, matrix) && isDone;
      isDone = PrintRow("METIS", CHOLMOD_METIS, matrix) && isDone;
      isDone = PrintRow("NestedDissectionOrder()", CHOLMOD_GIVEN, matrix, NestedDissectionOrder) && isDone;
      isDone = PrintRow("WindowedMinimumDegreeOrder()", CHOLMOD_GIVEN, matrix,
                 [](const SparseMatrix& m) { return WindowedMinimumDegreeOrder(m); }) &&
        isDone;
    }
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return isDone ? 0 : 1;
}
