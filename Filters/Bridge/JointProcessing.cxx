// SPDX-License-Identifier: BSD-3-Clause
#include "JointProcessing.h"

#include "DistributedSurfaces.h"
#include "ProcessingSupport.h"

#include "Core/Common/Errors.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>

#include <algorithm>

namespace surfsynth
{

namespace
{
std::int64_t PointsOf(vtkDataObject* data)
{
  return data ? std::max<vtkIdType>(data->GetNumberOfElements(vtkDataObject::POINT), 0) : 0;
}

/// True when this rank holds anything of the inputs.
bool HoldsInput(vtkAlgorithm* self, vtkInformationVector** inputVector)
{
  std::int64_t points = 0;
  for (int port = 0; port < self->GetNumberOfInputPorts(); ++port)
  {
    vtkDataObject* input = vtkDataObject::GetData(inputVector[port]);
    if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
    {
      EachLeaf(tree, [&](vtkDataObjectTreeIterator* place) { points += PointsOf(place->GetCurrentDataObject()); });
    }
    else
    {
      points += PointsOf(input);
    }
  }
  return points > 0;
}

/// Calls @p worker on the rank that has the inputs, or on the first where none does. Collective on several ranks.
/// @return the text of what went wrong, the same on all ranks; empty when nothing did.
/// @throws Cancelled
std::string WorkWhereInputsLie(
  vtkAlgorithm* self, vtkInformationVector** inputVector, const JointWorker& worker, const Progress& progress)
{
  const Ranks ranks(Ranks::Several());
  const bool holdsInput = HoldsInput(self, inputVector);
  const auto holders = ranks.Gather({ holdsInput });
  const auto count = std::count_if(holders.begin(), holders.end(), [](const auto& rank) { return rank[0] != 0; });
  if (count > 1)
  {
    return "The inputs lie on " + std::to_string(count) +
      " ranks, and the result of this filter on a part differs from its result on the whole; bring the datasets "
      "together on one rank first (vtkAggregateDataSetFilter).";
  }
  std::string error;
  bool cancelled = false;
  if (holdsInput || (count == 0 && ranks.Rank() == 0))
  {
    try
    {
      error = Attempt(vtkDataObject::GetData(inputVector[0]), [&] { worker(progress); });
    }
    catch (const Cancelled&)
    {
      cancelled = true;
    }
  }
  CancelTogether(ranks, cancelled);
  return ranks.FirstText(error);
}
} // namespace

int ProcessJointly(
  vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector, const JointWorker& worker)
{
  const auto emptyOutputs = [&] {
    for (int port = 0; port < self->GetNumberOfOutputPorts(); ++port)
    {
      vtkDataObject::GetData(outputVector, port)->Initialize();
    }
  };
  emptyOutputs();
  const int success = RunGuarded(self, outputVector, [&] {
    PipelineProgress steps(self);
    const std::string error = WorkWhereInputsLie(self, inputVector, worker, steps.Within(0.0, 1.0));
    if (!error.empty())
    {
      ReportError(self, "", error);
    }
    return error.empty();
  });
  const bool cancelled = outputVector->GetInformationObject(0)->Has(vtkDemandDrivenPipeline::DATA_NOT_GENERATED());
  if (!success || cancelled)
  {
    emptyOutputs();
  }
  for (int port = 1; cancelled && port < self->GetNumberOfOutputPorts(); ++port)
  {
    outputVector->GetInformationObject(port)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
  }
  return success;
}

} // namespace surfsynth
