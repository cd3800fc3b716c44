// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SymmetricMatrix.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
std::string NameOfEntry(Index row, Index column)
{
  return "(" + std::to_string(row) + ", " + std::to_string(column) + ")";
}

bool IsSorted(const SparseMatrix& matrix)
{
  if (!matrix.isCompressed())
  {
    return false;
  }
  for (Index column = 0; column < matrix.cols(); ++column)
  {
    const Index* first = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column];
    const Index* last = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1];
    if (!std::is_sorted(first, last))
    {
      return false;
    }
  }
  return true;
}
} // namespace

SparseMatrix Sorted(SparseMatrix matrix)
{
  if (IsSorted(matrix))
  {
    return matrix;
  }
  SparseMatrix sorted = SparseMatrix(SparseRowMatrix(matrix)); // converting sorts
  sorted.makeCompressed();
  return sorted;
}

void RequireSquare(const SparseMatrix& matrix, const char* caller)
{
  if (matrix.rows() != matrix.cols() || matrix.rows() == 0)
  {
    throw InvalidInput(std::string(caller) + ": the matrix is " + std::to_string(matrix.rows()) + " by " +
      std::to_string(matrix.cols()) + "; expected a square matrix of at least one row.");
  }
}

void RequireSymmetric(const SparseMatrix& matrix, const char* caller)
{
  // Going through the columns in order meets the mirror images of each column in order as well, so that one cursor for
  // each column suffices.
  const Index* start = matrix.outerIndexPtr();
  const Index* rows = matrix.innerIndexPtr();
  const double* values = matrix.valuePtr();
  const Index entries = start[matrix.cols()];
  const double largest = entries > 0
    ? Eigen::Map<const Eigen::ArrayXd>(values, entries).abs().maxCoeff<Eigen::PropagateNaN>()
    : 0.0;
  std::vector<Index> cursor(start, start + matrix.cols());
  for (Index column = 0; column < matrix.cols(); ++column)
  {
    for (Index k = start[column]; k < start[column + 1]; ++k)
    {
      if (!std::isfinite(values[k]))
      {
        throw InvalidInput(std::string(caller) + ": entry " + NameOfEntry(rows[k], column) + " is not finite.");
      }
      if (rows[k] <= column)
      {
        continue;
      }
      Index& mirror = cursor[rows[k]];
      const bool found = mirror < start[rows[k] + 1] && rows[mirror] == column;
      const double other = found ? values[mirror] : 0.0;
      const double tolerance = 1e-10 * std::max(std::abs(values[k]), std::abs(other)) + 1e-14 * largest;
      if (!found || !(std::abs(values[k] - other) <= tolerance))
      {
        throw InvalidInput(std::string(caller) + ": entry " + NameOfEntry(rows[k], column) + " is " +
          FormatNumber(values[k]) + " but entry " + NameOfEntry(column, rows[k]) + " is " + FormatNumber(other) +
          "; expected a symmetric matrix.");
      }
      ++mirror;
    }
    // The rest of the column above the diagonal has no mirror image.
    const Index next = cursor[column];
    if (next < start[column + 1] && rows[next] < column)
    {
      throw InvalidInput(std::string(caller) + ": entry " + NameOfEntry(rows[next], column) + " has no entry " +
        NameOfEntry(column, rows[next]) + "; expected a symmetric matrix.");
    }
  }
}

} // namespace surfsynth
