// SPDX-License-Identifier: BSD-3-Clause
#include "ProcessingSupport.h"

#include "DistributedSurfaces.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <vtkAlgorithm.h>
#include <vtkCompositeDataSet.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObject.h>
#include <vtkSMPTools.h>

#include <algorithm>
#include <exception>
#include <new>

namespace surfsynth
{

namespace
{
/// True when the user asked to stop: vtkAlgorithm::CheckAbort() where VTK has it (9.3 and ParaView 5.11), else the
/// flag.
template <typename Algorithm>
auto AbortRequested(Algorithm* self, int) -> decltype(static_cast<bool>(self->CheckAbort()))
{
  return static_cast<bool>(self->CheckAbort());
}
template <typename Algorithm>
bool AbortRequested(Algorithm* self, long)
{
  return self->GetAbortExecute() != 0;
}

/// References to the data objects on all inputs.
std::vector<vtkSmartPointer<vtkDataObject>> HoldInputs(vtkAlgorithm* self)
{
  std::vector<vtkSmartPointer<vtkDataObject>> inputs;
  for (int port = 0; port < self->GetNumberOfInputPorts(); ++port)
  {
    for (int connection = 0; connection < self->GetNumberOfInputConnections(port); ++connection)
    {
      inputs.emplace_back(self->GetInputDataObject(port, connection));
    }
  }
  return inputs;
}
} // namespace

Progress PipelineProgress::Within(double begin, double end)
{
  return [this, begin, end](double fraction) {
    this->Done = std::max(this->Done, begin + std::clamp(fraction, 0.0, 1.0) * (end - begin));
    this->Self->UpdateProgress(this->Done);
    return !AbortRequested(this->Self, 0);
  };
}

BlockPlace PlaceOf(vtkDataObjectTreeIterator* place)
{
  BlockPlace result;
  result.FlatIndex = place->GetCurrentFlatIndex();
  result.Name = "Block " + std::to_string(result.FlatIndex);
  const char* name = place->HasCurrentMetaData() ? place->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME())
                                                 : nullptr;
  if (name && *name)
  {
    result.Name += std::string(" \"") + name + "\"";
  }
  return result;
}

std::string Attempt(vtkDataObject* input, const std::function<void()>& work)
{
  try
  {
    work();
    return {};
  }
  catch (const Cancelled&)
  {
    throw;
  }
  catch (const std::bad_alloc&)
  {
    if (!input)
    {
      return "There is not enough memory.";
    }
    return "There is not enough memory for a dataset of " +
      std::to_string(input->GetNumberOfElements(vtkDataObject::POINT)) + " points and " +
      std::to_string(std::max<vtkIdType>(input->GetNumberOfElements(vtkDataObject::CELL), 0)) + " cells.";
  }
  catch (const std::exception& error)
  {
    return error.what();
  }
  catch (...)
  {
    return "An error of unknown type was thrown.";
  }
}

int RunGuarded(vtkAlgorithm* self, vtkInformationVector* outputVector, const std::function<bool()>& work)
{
  const ThreadScope threads(std::min(MaximumThreads(), vtkSMPTools::GetEstimatedNumberOfThreads()));
  const auto inputs = HoldInputs(self); // an observer of progress may connect others
  vtkDataObject* output = vtkDataObject::GetData(outputVector);
  try
  {
    return work() ? 1 : 0;
  }
  catch (const Cancelled&)
  {
    // Not an error. Marked as not generated, so that the next update runs again without a change of the filter.
    output->Initialize();
    outputVector->GetInformationObject(0)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
    return 1;
  }
  catch (const std::exception& error)
  {
    output->Initialize();
    ReportError(self, "", error.what());
  }
  return 0;
}

void CancelTogether(const Ranks& ranks, bool cancelled)
{
  const auto flags = ranks.Gather({ cancelled });
  if (std::any_of(flags.begin(), flags.end(), [](const auto& flag) { return flag[0] != 0; }))
  {
    throw Cancelled("Stopped on request.");
  }
}

std::vector<bool> SharedLeaves(
  vtkAlgorithm* self, const Ranks& ranks, vtkDataObjectTree* tree, const std::vector<std::int64_t>& sizes)
{
  std::vector<std::int64_t> indices;
  EachLeaf(tree, [&](vtkDataObjectTreeIterator* place) { indices.push_back(place->GetCurrentFlatIndex()); });
  const auto counts = ranks.Gather({ static_cast<std::int64_t>(indices.size()) });
  const auto sameCount = [&](const auto& count) { return count == counts[0]; };
  const auto structures = std::all_of(counts.begin(), counts.end(), sameCount) ? ranks.Gather(indices)
                                                                               : decltype(counts)();
  const auto sameStructure = [&](const auto& structure) { return structure == structures[0]; };
  if (structures.empty() || !std::all_of(structures.begin(), structures.end(), sameStructure))
  {
    ReportError(self, "",
      "The blocks are not numbered alike on all ranks, so that the result would depend on how they are distributed; "
      "give all ranks the same tree of blocks, empty where the data lies elsewhere.");
    return {};
  }
  const auto sizesOfRank = ranks.Gather(sizes);
  std::vector<bool> shared(sizes.size());
  for (std::size_t leaf = 0; leaf < sizes.size(); ++leaf)
  {
    shared[leaf] = std::count_if(sizesOfRank.begin(), sizesOfRank.end(), [&](const auto& of) { return of[leaf] > 0; }) >
      1;
  }
  return shared;
}

} // namespace surfsynth
