// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The losses of a training as a table. Private to the module.
#pragma once

#include "Learning/Training/TrainingOptions.h"

#include <vector>

class vtkTable;

namespace surfsynth
{

/// Adds the columns iteration (vtkIdType), loss, vertex_loss, jacobian_loss, gradient_norm and learning_rate (float64),
/// with a row for each step.
void FillTable(vtkTable* table, const std::vector<TrainingStep>& history);

/// The mean of the last twentieth of the losses, of the last one at least. @p history must not be empty.
double LastLoss(const std::vector<TrainingStep>& history);

} // namespace surfsynth
