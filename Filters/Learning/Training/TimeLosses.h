// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Losses of a training by parts of the time of its flow or diffusion. Private to the training; no torch.
#pragma once

#include "Inference/Common/ModelTensor.h"
#include "Learning/Training/LossHistory.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace surfsynth
{

/// Number of equal parts of the time, each with a column of its own.
constexpr std::size_t NumberOfTimeLosses = 8;

/// Losses of the samples of one iteration, by the part of the time that they are in.
using TimeLosses = std::array<std::vector<double>, NumberOfTimeLosses>;

/// Appends the names of the columns, @p prefix and "1" to "8". They are the last columns of a history.
void AppendTimeColumns(std::vector<std::string>& columns, const std::string& prefix);

/// Appends the mean loss of each part of the time to the row that @p history gets next. A part without a sample keeps the
/// number of the last row, and has 0 before the first one. Numbers are rounded to float32, as checkpoints hold them.
void AppendTimeMeans(const TimeLosses& losses, const LossHistory& history, std::vector<double>& row);

/// Name of the tensor of TimeColumns() in checkpoints.
constexpr const char* TimeLossesName = "losses.time";

/// Returns the last columns of a history, [Size(), 8], for a checkpoint.
ModelTensor TimeColumns(const LossHistory& history);

/// Appends a row of such a tensor to a row of a history.
void AppendTimeRow(const ModelTensor& losses, std::size_t number, std::vector<double>& row);

} // namespace surfsynth
