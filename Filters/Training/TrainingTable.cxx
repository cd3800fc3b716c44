// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingTable.h"

#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkTable.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace surfsynth
{

void FillTable(vtkTable* table, const std::vector<TrainingStep>& history)
{
  vtkNew<vtkIdTypeArray> iterations;
  iterations->SetName("iteration");
  iterations->SetNumberOfTuples(static_cast<vtkIdType>(history.size()));
  table->AddColumn(iterations);
  const std::pair<const char*, double TrainingStep::*> columns[] = { { "loss", &TrainingStep::Loss },
    { "vertex_loss", &TrainingStep::VertexLoss }, { "jacobian_loss", &TrainingStep::JacobianLoss },
    { "gradient_norm", &TrainingStep::GradientNorm }, { "learning_rate", &TrainingStep::LearningRate } };
  for (const auto& [name, member] : columns)
  {
    vtkNew<vtkDoubleArray> column;
    column->SetName(name);
    column->SetNumberOfTuples(static_cast<vtkIdType>(history.size()));
    for (std::size_t k = 0; k < history.size(); ++k)
    {
      column->SetValue(static_cast<vtkIdType>(k), history[k].*member);
      iterations->SetValue(static_cast<vtkIdType>(k), static_cast<vtkIdType>(history[k].Iteration));
    }
    table->AddColumn(column);
  }
}

double LastLoss(const std::vector<TrainingStep>& history)
{
  const auto count = static_cast<std::ptrdiff_t>(std::max<std::size_t>(history.size() / 20, 1));
  const auto add = [](double sum, const TrainingStep& step) { return sum + step.Loss; };
  return std::accumulate(history.end() - count, history.end(), 0.0, add) / static_cast<double>(count);
}

} // namespace surfsynth
