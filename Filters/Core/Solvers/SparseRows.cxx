// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/SparseRows.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"

#include <algorithm>
#include <atomic>

namespace surfsynth
{

namespace
{
constexpr Index RowsOfTask = 1024;

/// Consecutive rows of a product, as one task makes them.
struct ProductRows
{
  std::vector<Index> Length;
  std::vector<Index> Column;
  std::vector<double> Value;
};

/// Sums of one row of a product: the place of each column among those of the row, and their values.
class RowAccumulator
{
public:
  void Begin(Index columns) { this->PlaceOf.resize(static_cast<std::size_t>(columns), -1); }
  void Add(Index column, double value)
  {
    Index& place = this->PlaceOf[static_cast<std::size_t>(column)];
    if (place < 0)
    {
      place = static_cast<Index>(this->Column.size());
      this->Column.push_back(column);
      this->Value.push_back(value);
    }
    else
    {
      this->Value[static_cast<std::size_t>(place)] += value;
    }
  }
  /// Appends the row to @p rows and forgets it.
  void End(ProductRows& rows)
  {
    for (const Index column : this->Column)
    {
      this->PlaceOf[static_cast<std::size_t>(column)] = -1;
    }
    rows.Length.push_back(static_cast<Index>(this->Column.size()));
    rows.Column.insert(rows.Column.end(), this->Column.begin(), this->Column.end());
    rows.Value.insert(rows.Value.end(), this->Value.begin(), this->Value.end());
    this->Column.clear();
    this->Value.clear();
  }

private:
  std::vector<Index> PlaceOf; ///< [columns], -1 for columns without a sum
  std::vector<Index> Column;
  std::vector<double> Value;
};

/// Joins the rows of all tasks.
SparseRows Joined(std::vector<ProductRows> parts, Index size)
{
  SparseRows joined;
  joined.Rows = joined.Columns = size;
  joined.Start = LargeArray<Index>(static_cast<std::size_t>(size) + 1);
  std::vector<Index> first;
  Index row = 0;
  Index entries = 0;
  for (const ProductRows& part : parts)
  {
    first.push_back(entries);
    for (const Index length : part.Length)
    {
      joined.Start[static_cast<std::size_t>(row++)] = entries;
      entries += length;
    }
  }
  joined.Start[static_cast<std::size_t>(size)] = entries;
  joined.Column = LargeArray<Index>(static_cast<std::size_t>(entries));
  joined.Value = LargeArray<double>(static_cast<std::size_t>(entries));
  ParallelTasks(static_cast<std::int64_t>(parts.size()), [&](std::int64_t k) {
    ProductRows& part = parts[static_cast<std::size_t>(k)];
    std::copy(part.Column.begin(), part.Column.end(), joined.Column.data() + first[static_cast<std::size_t>(k)]);
    std::copy(part.Value.begin(), part.Value.end(), joined.Value.data() + first[static_cast<std::size_t>(k)]);
    part = ProductRows();
  });
  return joined;
}
} // namespace

std::int64_t SparseRows::Bytes() const
{
  return static_cast<std::int64_t>((this->Start.size() + this->Column.size()) * sizeof(Index) +
    this->Value.size() * sizeof(double) + this->Single.size() * sizeof(float));
}

std::vector<Index> BreadthFirstOrder(const SparseMatrix& matrix, const Progress& progress)
{
  constexpr std::size_t ReportEvery = std::size_t(1) << 18;
  const auto size = static_cast<std::size_t>(matrix.cols());
  const Index* start = matrix.outerIndexPtr();
  const Index* rows = matrix.innerIndexPtr();
  std::vector<Index> order;
  order.reserve(size);
  std::vector<bool> found(size, false);
  for (std::size_t seed = 0; seed < size; ++seed)
  {
    if (found[seed])
    {
      continue;
    }
    found[seed] = true;
    std::size_t next = order.size();
    order.push_back(static_cast<Index>(seed));
    for (; next < order.size(); ++next)
    {
      const Index vertex = order[next];
      for (Index k = start[vertex]; k < start[vertex + 1]; ++k)
      {
        const auto neighbor = static_cast<std::size_t>(rows[k]);
        if (!found[neighbor])
        {
          found[neighbor] = true;
          order.push_back(rows[k]);
        }
      }
      if (next % ReportEvery == 0)
      {
        Report(progress, static_cast<double>(next) / static_cast<double>(size));
      }
    }
  }
  return order;
}

SparseRows Reordered(const SparseMatrix& matrix, const std::vector<Index>& order)
{
  const auto size = static_cast<Index>(matrix.cols());
  const Index* start = matrix.outerIndexPtr();
  std::vector<Index> rowOf(order.size());
  SparseRows reordered;
  reordered.Rows = reordered.Columns = size;
  reordered.Start = LargeArray<Index>(order.size() + 1);
  Index entries = 0;
  for (std::size_t row = 0; row < order.size(); ++row)
  {
    rowOf[static_cast<std::size_t>(order[row])] = static_cast<Index>(row);
    reordered.Start[row] = entries;
    entries += start[order[row] + 1] - start[order[row]];
  }
  reordered.Start[order.size()] = entries;
  reordered.Column = LargeArray<Index>(static_cast<std::size_t>(entries));
  reordered.Value = LargeArray<double>(static_cast<std::size_t>(entries));
  ParallelFor(size, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = static_cast<std::size_t>(begin); row < static_cast<std::size_t>(end); ++row)
    {
      auto to = static_cast<std::size_t>(reordered.Start[row]);
      for (SparseMatrix::InnerIterator entry(matrix, order[row]); entry; ++entry, ++to)
      {
        reordered.Column[to] = rowOf[static_cast<std::size_t>(entry.row())];
        reordered.Value[to] = entry.value();
      }
    }
  });
  return reordered;
}

SparseRows Transposed(const SparseRows& matrix)
{
  SparseRows transposed;
  transposed.Rows = matrix.Columns;
  transposed.Columns = matrix.Rows;
  const auto entries = static_cast<std::size_t>(matrix.Entries());
  const auto rows = static_cast<std::size_t>(transposed.Rows);
  transposed.Start = LargeArray<Index>(rows + 1);
  transposed.Column = LargeArray<Index>(entries);
  transposed.Single = LargeArray<float>(entries);
  // Counts of the rows one place further on: filling moves each start to the end of its row.
  std::vector<Index> next(rows + 1, 0);
  for (std::size_t k = 0; k < entries; ++k)
  {
    ++next[static_cast<std::size_t>(matrix.Column[k]) + 1];
  }
  for (std::size_t row = 0; row < rows; ++row)
  {
    transposed.Start[row] = next[row];
    next[row + 1] += next[row];
  }
  transposed.Start[rows] = static_cast<Index>(entries);
  for (Index row = 0; row < matrix.Rows; ++row)
  {
    const auto last = static_cast<std::size_t>(matrix.Start[static_cast<std::size_t>(row) + 1]);
    for (auto k = static_cast<std::size_t>(matrix.Start[static_cast<std::size_t>(row)]); k < last; ++k)
    {
      const auto to = static_cast<std::size_t>(next[static_cast<std::size_t>(matrix.Column[k])]++);
      transposed.Column[to] = row;
      transposed.Single[to] = matrix.Single[k];
    }
  }
  return transposed;
}

SparseRows GalerkinProduct(const SparseRows& matrix, const LargeArray<double>& root, const SparseRows& prolongation,
  const SparseRows& restriction, const Progress& progress)
{
  const Index size = restriction.Rows;
  const auto scale = [&root](Index row) { return root.size() > 0 ? 1.0 / root[static_cast<std::size_t>(row)] : 1.0; };
  std::vector<ProductRows> parts(static_cast<std::size_t>((size + RowsOfTask - 1) / RowsOfTask));
  ScratchPool<RowAccumulator> accumulators;
  std::atomic<std::int64_t> done{ 0 };
  const auto makeRows = [&](std::int64_t task) {
    RowAccumulator row = accumulators.Borrow();
    row.Begin(size);
    const auto end = std::min<std::int64_t>((task + 1) * RowsOfTask, size);
    for (std::int64_t coarse = task * RowsOfTask; coarse < end; ++coarse)
    {
      for (Index k = restriction.Start.data()[coarse]; k < restriction.Start.data()[coarse + 1]; ++k)
      {
        const Index i = restriction.Column.data()[k];
        const double left = scale(i) * static_cast<double>(restriction.Single.data()[k]);
        for (Index m = matrix.Start.data()[i]; m < matrix.Start.data()[i + 1]; ++m)
        {
          const Index j = matrix.Column.data()[m];
          const double middle = left * matrix.Value.data()[m] * scale(j);
          for (Index n = prolongation.Start.data()[j]; n < prolongation.Start.data()[j + 1]; ++n)
          {
            row.Add(prolongation.Column.data()[n], middle * static_cast<double>(prolongation.Single.data()[n]));
          }
        }
      }
      row.End(parts[static_cast<std::size_t>(task)]);
    }
    accumulators.Return(std::move(row));
    ++done;
  };
  ParallelTasks(static_cast<std::int64_t>(parts.size()), makeRows,
    [&] { Report(progress, static_cast<double>(done) / static_cast<double>(parts.size())); });
  return Joined(std::move(parts), size);
}

} // namespace surfsynth
