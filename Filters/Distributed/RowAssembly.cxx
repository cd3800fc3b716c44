// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/RowAssembly.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace surfsynth
{

namespace
{
/// Entry of a row that another rank owns.
struct RowEntry
{
  std::int64_t Row;
  std::int64_t Column;
  double Value;
};

/// Entries that come from other ranks, sorted by rows, and in each row in the order of ranks.
std::vector<RowEntry> EntriesOfOthers(const VertexOwners& owners, const SparseMatrix& matrix)
{
  std::vector<std::vector<RowEntry>> sent(static_cast<std::size_t>(owners.Group().Count()));
  for (Index v = 0; v < matrix.cols(); ++v)
  {
    if (!owners.IsOwn(v))
    {
      auto& entries = sent[static_cast<std::size_t>(owners.Owners[static_cast<std::size_t>(v)])];
      for (SparseMatrix::InnerIterator entry(matrix, v); entry; ++entry) // symmetric: columns are rows
      {
        entries.push_back({ owners.Rows[static_cast<std::size_t>(v)],
          owners.Rows[static_cast<std::size_t>(entry.row())], entry.value() });
      }
    }
  }
  std::vector<RowEntry> entries;
  for (const auto& ofRank : owners.Group().Exchange(sent))
  {
    entries.insert(entries.end(), ofRank.begin(), ofRank.end());
  }
  std::stable_sort(entries.begin(), entries.end(), [](const RowEntry& a, const RowEntry& b) { return a.Row < b.Row; });
  return entries;
}

/// Place of the diagonal entry of own row @p k.
std::size_t DiagonalOf(const DistributedRows& rows, std::size_t k)
{
  const auto first = rows.Columns.begin() + rows.Starts[k];
  const auto last = rows.Columns.begin() + rows.Starts[k + 1];
  return static_cast<std::size_t>(
    std::lower_bound(first, last, static_cast<std::int32_t>(rows.FirstRow + static_cast<std::int64_t>(k))) -
    rows.Columns.begin());
}
} // namespace

DistributedRows AssembleRows(const VertexOwners& owners, const SparseMatrix& matrix)
{
  owners.Group().Together([&] {
    if (owners.NumberOfRows > std::numeric_limits<std::int32_t>::max())
    {
      throw InvalidInput("AssembleRows: the surface has " + std::to_string(owners.NumberOfRows) +
        " points; expected at most 2147483647.");
    }
  });
  const std::vector<RowEntry> others = EntriesOfOthers(owners, matrix);
  DistributedRows rows;
  rows.FirstRow = owners.FirstRow;
  rows.NumberOfRows = owners.NumberOfRows;
  const auto most = static_cast<std::size_t>(matrix.nonZeros()) + others.size();
  rows.Columns.reserve(most);
  rows.Values.reserve(most);
  rows.Starts.push_back(0);
  auto next = others.begin();
  std::vector<std::pair<std::int64_t, double>> row;
  for (const Index v : owners.OwnVertices)
  {
    row.clear();
    for (SparseMatrix::InnerIterator entry(matrix, v); entry; ++entry)
    {
      row.emplace_back(owners.Rows[static_cast<std::size_t>(entry.row())], entry.value());
    }
    for (; next != others.end() && next->Row == owners.Rows[static_cast<std::size_t>(v)]; ++next)
    {
      row.emplace_back(next->Column, next->Value);
    }
    std::stable_sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t k = 0; k < row.size(); ++k)
    {
      if (k > 0 && row[k].first == row[k - 1].first)
      {
        rows.Values.back() += row[k].second;
        continue;
      }
      rows.Columns.push_back(static_cast<std::int32_t>(row[k].first));
      rows.Values.push_back(row[k].second);
    }
    rows.Starts.push_back(static_cast<std::int32_t>(rows.Columns.size()));
  }
  return rows;
}

void AddToDiagonal(DistributedRows& rows, const Eigen::VectorXd& diagonal, double factor)
{
  for (std::size_t k = 0; k + 1 < rows.Starts.size(); ++k)
  {
    const double value = diagonal[static_cast<Eigen::Index>(k)];
    rows.Values[DiagonalOf(rows, k)] += value > 0.0 ? factor * value : 1.0;
  }
}

double SquaredLaplacian(const DistributedRows& stiffness, const Eigen::VectorXd& mass)
{
  double total = 0.0;
  for (std::size_t k = 0; k + 1 < stiffness.Starts.size(); ++k)
  {
    double sum = 0.0;
    for (std::int32_t entry = stiffness.Starts[k]; entry < stiffness.Starts[k + 1]; ++entry)
    {
      sum += stiffness.Values[static_cast<std::size_t>(entry)] * stiffness.Values[static_cast<std::size_t>(entry)];
    }
    const double of = mass[static_cast<Eigen::Index>(k)];
    total += of > 0.0 ? sum / (of * of) : 0.0;
  }
  return total;
}

} // namespace surfsynth
