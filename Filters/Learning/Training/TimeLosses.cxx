// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TimeLosses.h"

#include <algorithm>
#include <iterator>

namespace surfsynth
{

void AppendTimeColumns(std::vector<std::string>& columns, const std::string& prefix)
{
  for (std::size_t part = 1; part <= NumberOfTimeLosses; ++part)
  {
    columns.push_back(prefix + std::to_string(part));
  }
}

void AppendTimeMeans(const TimeLosses& losses, const LossHistory& history, std::vector<double>& row)
{
  const std::size_t first = history.Columns().size() - NumberOfTimeLosses;
  for (std::size_t part = 0; part < NumberOfTimeLosses; ++part)
  {
    if (losses[part].empty())
    {
      row.push_back(history.IsEmpty() ? 0.0 : history.Row(history.Size() - 1)[first + part]);
      continue;
    }
    double sum = 0.0;
    for (const double loss : losses[part])
    {
      sum += loss / static_cast<double>(losses[part].size());
    }
    row.push_back(static_cast<double>(static_cast<float>(sum)));
  }
}

ModelTensor TimeColumns(const LossHistory& history)
{
  ModelTensor tensor{ { static_cast<std::int64_t>(history.Size()), static_cast<std::int64_t>(NumberOfTimeLosses) },
    {} };
  for (std::size_t k = 0; k < history.Size(); ++k)
  {
    const std::vector<double>& row = history.Row(k);
    std::transform(row.end() - static_cast<std::ptrdiff_t>(NumberOfTimeLosses), row.end(),
      std::back_inserter(tensor.Values), [](double value) { return static_cast<float>(value); });
  }
  return tensor;
}

void AppendTimeRow(const ModelTensor& losses, std::size_t number, std::vector<double>& row)
{
  const float* values = losses.Values.data() + number * NumberOfTimeLosses;
  row.insert(row.end(), values, values + NumberOfTimeLosses);
}

} // namespace surfsynth
