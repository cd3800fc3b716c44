// SPDX-License-Identifier: BSD-3-Clause
//
// Orders of the matrices of volumes as a table: entries and arithmetic of the factor, and the time of ordering and symbolic
// analysis, by CHOLMOD's AMD, by METIS and by NestedDissectionOrder().
//
//   SurfaceSynthesisOrderingTable [CELLS...]
//
// The volumes are cubes with CELLS^3 cells (19, 31 and 49 by default) of six tetrahedra each.
#include "ScreenedMatrices.h"

#include "Core/Solvers/NestedDissection.h"

#include <cholmod.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

using namespace surfsynth;

namespace
{

/// Prints a row: the analysis by one of CHOLMOD's orderings, or CHOLMOD_GIVEN for that of the library.
bool PrintRow(const char* name, int ordering, const SparseMatrix& matrix)
{
  const auto begin = std::chrono::steady_clock::now();
  std::vector<Index> order = ordering == CHOLMOD_GIVEN ? NestedDissectionOrder(matrix) : std::vector<Index>();
  cholmod_common common;
  cholmod_start(&common);
  common.nmethods = 1;
  common.method[0].ordering = ordering;
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(matrix.rows());
  view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
  view.p = const_cast<Index*>(matrix.outerIndexPtr());
  view.i = const_cast<Index*>(matrix.innerIndexPtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_PATTERN;
  view.sorted = view.packed = 1;
  cholmod_factor* factor = cholmod_analyze_p(&view, order.empty() ? nullptr : order.data(), nullptr, 0, &common);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  const bool isDone = factor != nullptr && common.status == CHOLMOD_OK;
  std::printf("| %lld | %s | %.2f M | %.2f | %.2f s |\n", static_cast<long long>(matrix.rows()), name,
    1e-6 * common.lnz, 1e-9 * common.fl, seconds.count());
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  return isDone;
}

} // namespace

int main(int argc, char** argv)
{
  std::vector<int> sides;
  for (int k = 1; k < argc; ++k)
  {
    sides.push_back(std::atoi(argv[k]));
    if (sides.back() < 1 || sides.back() > 200)
    {
      std::fprintf(stderr, "SurfaceSynthesisOrderingTable: \"%s\" cells; expected numbers from 1 to 200.\n", argv[k]);
      return 2;
    }
  }
  if (sides.empty())
  {
    sides = { 19, 31, 49 };
  }
  std::printf("| points | | entries | GFLOP | ordering and analysis |\n|---:|---|---:|---:|---:|\n");
  bool isDone = true;
  for (const int cells : sides)
  {
    const SparseMatrix matrix = test::ScreenedCube(cells).Matrix;
    isDone = PrintRow("AMD", CHOLMOD_AMD, matrix) && isDone;
    isDone = PrintRow("METIS", CHOLMOD_METIS, matrix) && isDone;
    isDone = PrintRow("NestedDissectionOrder()", CHOLMOD_GIVEN, matrix) && isDone;
  }
  return isDone ? 0 : 1;
}
