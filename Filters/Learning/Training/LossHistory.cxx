// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/LossHistory.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"

#include <algorithm>
#include <locale>
#include <sstream>
#include <utility>

namespace surfsynth
{

LossHistory::LossHistory(
  const std::vector<std::string>& counts, const std::vector<std::string>& values, const std::string& monitored)
  : Names(counts)
  , Counts(counts.size())
{
  this->Names.insert(this->Names.end(), values.begin(), values.end());
  this->Monitored = this->Find(monitored);
}

std::size_t LossHistory::Find(const std::string& column) const
{
  const auto found = std::find(this->Names.begin(), this->Names.end(), column);
  if (found == this->Names.end())
  {
    std::string known;
    for (const std::string& name : this->Names)
    {
      known += (known.empty() ? "" : ", ") + name;
    }
    throw InvalidInput("LossHistory: there is no column \"" + column + "\"; expected one of " + known + ".");
  }
  return static_cast<std::size_t>(found - this->Names.begin());
}

void LossHistory::RequireRows() const
{
  if (this->Rows.empty())
  {
    throw InvalidInput("LossHistory: there is no row; expected at least one iteration.");
  }
}

void LossHistory::Append(std::vector<double> row)
{
  if (row.size() != this->Names.size())
  {
    throw InvalidInput("LossHistory: a row has " + std::to_string(row.size()) + " numbers; expected " +
      std::to_string(this->Names.size()) + ", one for each column.");
  }
  this->Rows.push_back(std::move(row));
}

double LossHistory::Value(std::size_t row, const std::string& column) const
{
  return this->Rows[row][this->Find(column)];
}

std::vector<double> LossHistory::Column(const std::string& column) const
{
  const std::size_t number = this->Find(column);
  std::vector<double> values;
  values.reserve(this->Rows.size());
  for (const std::vector<double>& row : this->Rows)
  {
    values.push_back(row[number]);
  }
  return values;
}

double LossHistory::Last() const
{
  this->RequireRows();
  return this->Rows.back()[this->Monitored];
}

double LossHistory::LastMean() const
{
  this->RequireRows();
  const std::size_t count = std::max<std::size_t>(this->Rows.size() / 20, 1);
  double sum = 0.0;
  for (std::size_t k = this->Rows.size() - count; k < this->Rows.size(); ++k)
  {
    sum += this->Rows[k][this->Monitored];
  }
  return sum / static_cast<double>(count);
}

void LossHistory::WriteCsv(const std::string& path) const
{
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(9);
  const auto writeLine = [&text](const auto& cells) {
    for (std::size_t k = 0; k < cells.size(); ++k)
    {
      text << (k > 0 ? "," : "") << cells[k];
    }
    text << '\n';
  };
  writeLine(this->Names);
  std::for_each(this->Rows.begin(), this->Rows.end(), writeLine);
  WriteOutputFile(path, text.str(), "LossHistory");
}

bool operator==(const LossHistory& a, const LossHistory& b)
{
  if (a.Columns() != b.Columns() || a.Size() != b.Size())
  {
    return false;
  }
  for (std::size_t k = 0; k < a.Size(); ++k)
  {
    if (a.Row(k) != b.Row(k))
    {
      return false;
    }
  }
  return true;
}

} // namespace surfsynth
