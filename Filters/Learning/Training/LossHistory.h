// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The losses of a training. No torch.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace surfsynth
{

/// A table with a row for each iteration of a training and a named column for each quantity. The first columns hold
/// whole numbers, the others losses, norms and rates, all as float64.
class LossHistory
{
public:
  /// A table without columns, which takes no rows.
  LossHistory() = default;
  /// A table without rows.
  /// @param counts names of the columns of whole numbers, which come first.
  /// @param values names of the other columns.
  /// @param monitored name of the column that tells how the training goes.
  /// @throws InvalidInput when @p monitored is no column.
  LossHistory(
    const std::vector<std::string>& counts, const std::vector<std::string>& values, const std::string& monitored);

  const std::vector<std::string>& Columns() const { return this->Names; }
  /// Number of the columns of whole numbers.
  std::size_t NumberOfCounts() const { return this->Counts; }
  /// Number of rows, one for each iteration.
  std::size_t Size() const { return this->Rows.size(); }
  bool IsEmpty() const { return this->Rows.empty(); }

  /// Adds a row with a number for each column. @throws InvalidInput when there are more or fewer.
  void Append(std::vector<double> row);

  /// The numbers of one row, in the order of the columns. @p row is below Size().
  const std::vector<double>& Row(std::size_t row) const { return this->Rows[row]; }
  /// The number in one cell. @p row is below Size(). @throws InvalidInput when there is no such column.
  double Value(std::size_t row, const std::string& column) const;
  /// The numbers of one column, [Size()]. @throws InvalidInput when there is no such column.
  std::vector<double> Column(const std::string& column) const;
  /// The monitored loss of the last row. @throws InvalidInput when there is no row.
  double Last() const;
  /// Mean of the monitored loss over the last twentieth of the rows, at least one.
  /// @throws InvalidInput when there is no row.
  double LastMean() const;

  /// Writes a CSV file: a line of column names, then a line with nine significant digits for each row. Replaces the file
  /// only when all is written.
  /// @throws InvalidInput when the file cannot be written.
  void WriteCsv(const std::string& path) const;

private:
  std::size_t Find(const std::string& column) const;
  void RequireRows() const;

  std::vector<std::string> Names;
  std::size_t Counts = 0;
  std::size_t Monitored = 0;
  std::vector<std::vector<double>> Rows;
};

/// True when columns and rows are the same.
bool operator==(const LossHistory& a, const LossHistory& b);

} // namespace surfsynth
