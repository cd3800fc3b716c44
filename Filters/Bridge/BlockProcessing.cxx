// SPDX-License-Identifier: BSD-3-Clause
#include "BlockBridge.h"

#include "DataObjects.h"
#include "DistributedSurfaces.h"
#include "ProcessingSupport.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <numeric>

namespace surfsynth
{

namespace
{
/// "a vtkImageData or a vtkPolyData"
std::string Alternatives(const std::vector<std::string>& classes)
{
  std::string text;
  for (const std::string& name : classes)
  {
    text += (text.empty() ? "a " : " or a ") + name;
  }
  return text;
}

/// One call of a filter's RequestData.
class BlockProcessing
{
public:
  BlockProcessing(vtkAlgorithm* self, const BlockTypes& types, const BlockWorker& worker)
    : Self(self)
    , Types(types)
    , Worker(worker)
    , Steps(self)
    , Controller(Ranks::Several())
  {}

  /// Fills @p outputs from @p input, which is no composite dataset.
  /// @return false after an error, which is reported here. Collective on several ranks.
  bool Dataset(vtkDataObject* input, const DataObjectList& outputs)
  {
    const Ranks ranks(this->Controller);
    const std::string rejection = ranks.FirstText(this->Accepts(input) ? "" : this->OtherType(input));
    if (!rejection.empty())
    {
      ReportError(this->Self, "", rejection);
      return false;
    }
    const auto sizes = ranks.Gather({ SizeOf(input) });
    const auto owners = std::count_if(sizes.begin(), sizes.end(), [](const auto& size) { return size[0] > 0; });
    if (owners > 1)
    {
      this->RejectPieces(owners, {});
      return false;
    }
    std::string error;
    bool cancelled = false;
    try
    {
      error = this->Attempted(input, outputs, {}, this->Steps.Within(0.0, 1.0));
    }
    catch (const Cancelled&)
    {
      cancelled = true;
    }
    CancelTogether(ranks, cancelled);
    return this->Conclude(ranks.FirstText(error), {}, outputs);
  }

  /// Fills @p outputs, trees with the structure of @p input, block by block. Collective on several ranks.
  /// @throws Cancelled
  void Tree(vtkDataObjectTree* input, const DataObjectList& outputs)
  {
    std::vector<std::int64_t> sizes;
    EachLeaf(input, [&](vtkDataObjectTreeIterator* place) { sizes.push_back(SizeOf(place->GetCurrentDataObject())); });
    std::vector<bool> shared(sizes.size(), false);
    if (this->Controller)
    {
      shared = SharedLeaves(this->Self, Ranks(this->Controller), input, sizes);
      if (shared.size() != sizes.size())
      {
        return;
      }
    }
    const double total = static_cast<double>(sizes.size()) + std::accumulate(sizes.begin(), sizes.end(), 0.0);
    double done = 0.0;
    std::size_t leaf = 0;
    EachLeaf(input, [&](vtkDataObjectTreeIterator* place) {
      const double before = done / total;
      const bool isShared = shared[leaf];
      done += 1.0 + static_cast<double>(sizes[leaf++]);
      this->Leaf(place, isShared, outputs, this->Steps.Within(before, done / total));
    });
  }

private:
  void Leaf(vtkDataObjectTreeIterator* place, bool isShared, const DataObjectList& outputs, const Progress& progress)
  {
    vtkDataObject* input = place->GetCurrentDataObject();
    const BlockPlace at = PlaceOf(place);
    if (isShared)
    {
      this->RejectPieces(2, at);
      return;
    }
    if (!input)
    {
      return;
    }
    if (!this->Accepts(input))
    {
      ReportError(this->Self, at.Name, this->OtherType(input));
      return;
    }
    DataObjectList results;
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      results.push_back(NewDataObject(this->Types.Output));
    }
    this->Conclude(this->Attempted(input, results, at, progress), at, results);
    for (std::size_t k = 0; k < outputs.size(); ++k)
    {
      vtkDataObjectTree::SafeDownCast(outputs[k])->SetDataSet(place, results[k]);
    }
  }

  bool Accepts(vtkDataObject* input) const
  {
    return std::any_of(this->Types.Input.begin(), this->Types.Input.end(),
      [input](const std::string& type) { return input->IsA(type.c_str()) != 0; });
  }

  /// Works on @p input; the text of what went wrong.
  /// @throws Cancelled
  std::string Attempted(
    vtkDataObject* input, const DataObjectList& outputs, const BlockPlace& at, const Progress& progress) const
  {
    return Attempt(input, [&] {
      Report(progress, 0.0);
      if (SizeOf(input) > 0)
      {
        this->Worker({ input, outputs.front(), at.FlatIndex, at.Name, { outputs.begin(), outputs.end() } }, progress);
      }
    });
  }

  /// Reports @p error, if there is one, and then empties @p outputs.
  bool Conclude(const std::string& error, const BlockPlace& at, const DataObjectList& outputs) const
  {
    if (error.empty())
    {
      return true;
    }
    ReportError(this->Self, at.Name, error);
    for (const auto& output : outputs)
    {
      output->Initialize();
    }
    return false;
  }

  std::string OtherType(vtkDataObject* input) const
  {
    return "A" + DescribeInput(input).substr(1) + " was found where " + Alternatives(this->Types.Input) +
      " is needed; " + this->Types.Advice + ".";
  }

  void RejectPieces(std::int64_t owners, const BlockPlace& at) const
  {
    ReportError(this->Self, at.Name,
      "The dataset lies in pieces on " + std::to_string(owners) + (at.FlatIndex > 0 ? " or more" : "") +
        " ranks, and the result of this filter on a piece differs from its result on the whole; bring the pieces "
        "together on one rank first (vtkAggregateDataSetFilter).");
  }

  vtkAlgorithm* Self;
  const BlockTypes& Types;
  const BlockWorker& Worker;
  PipelineProgress Steps;
  vtkMultiProcessController* Controller;
};
} // namespace

int AcceptBlocks(vtkInformation* info, const BlockTypes& types)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  for (const std::string& type : types.Input)
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), type.c_str());
    if (type == "vtkPolyData")
    {
      info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
    }
  }
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

int RequestBlocks(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const BlockTypes& types, bool isSeries)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
  if (!input)
  {
    ReportError(self, "", "There is no input; " + Alternatives(types.Input) + ", or a composite dataset, is needed.");
    return 0;
  }
  const std::string single = vtkDataObjectTree::SafeDownCast(input) ? input->GetClassName() : types.Output;
  SetOutputClass(outputVector, isSeries ? "vtkMultiBlockDataSet" : single);
  return 1;
}

int ProcessBlocks(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const BlockTypes& types, const BlockWorker& worker, const OutputSeries& series)
{
  return RunGuarded(self, outputVector, [&] {
    const auto input = AsSurfaces(vtkDataObject::GetData(inputVector[0]));
    const DataObjectList outputs = MakeOutputs(input, series, types.Output, vtkDataObject::GetData(outputVector));
    BlockProcessing processing(self, types, worker);
    auto* tree = vtkDataObjectTree::SafeDownCast(input);
    if (!tree)
    {
      return processing.Dataset(input, outputs);
    }
    processing.Tree(tree, outputs);
    return true;
  });
}

} // namespace surfsynth
