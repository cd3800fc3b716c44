// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <exception>
#include <new>

namespace surfsynth
{

namespace
{
/// Whether the user asked to stop: vtkAlgorithm::CheckAbort() where VTK has it (9.3 and ParaView 5.11), else the flag.
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

/// @p text followed by @p where, inside the final full stop.
std::string At(std::string text, const std::string& where)
{
  const bool stop = !text.empty() && text.back() == '.';
  if (stop)
  {
    text.pop_back();
  }
  return text + where + (stop ? "." : "");
}

vtkIdType Cells(vtkPolyData* block) { return std::max<vtkIdType>(block->GetNumberOfCells(), 0); }

/// One call of a filter's RequestData.
class Processing
{
public:
  Processing(vtkAlgorithm* self, const MeshRequirements& requirements, const SurfaceWorker& worker,
    const SoundSurface& isKnownSound)
    : Self(self)
    , Requirements(requirements)
    , Worker(worker)
    , IsKnownSound(isKnownSound)
  {}

  /// The callback that covers [@p begin, @p end] of this filter's progress.
  Progress Within(double begin, double end)
  {
    return [this, begin, end](double fraction) {
      this->Done = std::max(this->Done, begin + std::clamp(fraction, 0.0, 1.0) * (end - begin));
      this->Self->UpdateProgress(this->Done);
      return !AbortRequested(this->Self, 0);
    };
  }

  /// Fills @p output from @p input; after an error, which is reported here, it is empty.
  /// @return false after an error.
  /// @throws Cancelled
  bool Polygons(vtkPolyData* input, vtkPolyData* output, unsigned int flatIndex, const Progress& progress) const
  {
    const std::string where = flatIndex == 0 ? "" : " in block " + std::to_string(flatIndex);
    try
    {
      Report(progress, 0.0);
      output->ShallowCopy(input);
      if (input->GetNumberOfPoints() == 0 && Cells(input) == 0)
      {
        return true;
      }
      Surface surface = ConvertSurface(input);
      surface.FlatIndex = flatIndex;
      surface.Where = where;
      if (!this->IsKnownSound || !this->IsKnownSound(surface))
      {
        CheckSurface(surface, this->Requirements);
      }
      this->Worker(surface, output, progress);
      return true;
    }
    catch (const Cancelled&)
    {
      throw;
    }
    catch (const std::bad_alloc&)
    {
      this->Fail("There is not enough memory for a surface of " + std::to_string(input->GetNumberOfPoints()) +
          " points and " + std::to_string(Cells(input)) + " cells.",
        where);
    }
    catch (const std::exception& error)
    {
      this->Fail(error.what(), where);
    }
    catch (...)
    {
      this->Fail("An error of unknown type was thrown.", where);
    }
    output->Initialize();
    return false;
  }

  /// Fills @p output, which has the structure of @p input, block by block.
  /// @throws Cancelled
  void Blocks(vtkDataObjectTree* input, vtkDataObjectTree* output)
  {
    double cells = 0.0;
    this->EachLeaf(input, [&](vtkDataObjectTreeIterator*, vtkPolyData* block) { cells += Weight(block); });
    double done = 0.0;
    this->EachLeaf(input, [&](vtkDataObjectTreeIterator* place, vtkPolyData* block) {
      if (!block)
      {
        this->Fail(std::string("A ") + place->GetCurrentDataObject()->GetClassName() +
            " was found where a vtkPolyData is needed; vtkDataSetSurfaceFilter extracts a surface.",
          " in block " + std::to_string(place->GetCurrentFlatIndex()));
        return;
      }
      const double before = done / cells;
      done += Weight(block);
      vtkNew<vtkPolyData> result;
      this->Polygons(block, result, place->GetCurrentFlatIndex(), this->Within(before, done / cells));
      output->SetDataSet(place, result);
    });
  }

private:
  static double Weight(vtkPolyData* block) { return block ? 1.0 + static_cast<double>(Cells(block)) : 0.0; }

  /// Calls visit(place, polydata) for every leaf that is not null; the polydata is null when it is something else.
  template <typename Visit>
  static void EachLeaf(vtkDataObjectTree* tree, const Visit& visit)
  {
    const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    place->VisitOnlyLeavesOn();
    place->TraverseSubTreeOn();
    place->SkipEmptyNodesOn();
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      visit(place.Get(), vtkPolyData::SafeDownCast(place->GetCurrentDataObject()));
    }
  }

  void Fail(const std::string& text, const std::string& where) const
  {
    vtkErrorWithObjectMacro(this->Self, << At(text, where));
  }

  vtkAlgorithm* Self;
  const MeshRequirements& Requirements;
  const SurfaceWorker& Worker;
  const SoundSurface& IsKnownSound;
  double Done = 0.0;
};

/// Throws Cancelled; reports inputs of another type.
bool Process(Processing& processing, vtkAlgorithm* self, vtkDataObject* input, vtkDataObject* output)
{
  if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    auto* outputTree = vtkDataObjectTree::SafeDownCast(output);
    outputTree->CopyStructure(tree);
    outputTree->GetFieldData()->ShallowCopy(tree->GetFieldData());
    processing.Blocks(tree, outputTree);
    return true;
  }
  if (auto* polygons = vtkPolyData::SafeDownCast(input))
  {
    return processing.Polygons(polygons, vtkPolyData::SafeDownCast(output), 0, processing.Within(0.0, 1.0));
  }
  vtkErrorWithObjectMacro(self, << "The input is "
                                << (input ? std::string("a ") + input->GetClassName() : std::string("missing"))
                                << "; a vtkPolyData or a composite dataset of them is needed, and "
                                   "vtkDataSetSurfaceFilter extracts a surface.");
  return false;
}
} // namespace

int AcceptSurfaces(vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

int ProcessSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const MeshRequirements& requirements, const SurfaceWorker& worker, const SoundSurface& isKnownSound)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
  vtkDataObject* output = vtkDataObject::GetData(outputVector);
  const ThreadScope threads(std::min(MaximumThreads(), vtkSMPTools::GetEstimatedNumberOfThreads()));
  try
  {
    Processing processing(self, requirements, worker, isKnownSound);
    return Process(processing, self, input, output) ? 1 : 0;
  }
  catch (const Cancelled&)
  {
    // Not an error. Marked as not generated, so that the next update runs again without a change of the filter.
    output->Initialize();
    outputVector->GetInformationObject(0)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
  }
  catch (const std::exception& error)
  {
    output->Initialize();
    vtkErrorWithObjectMacro(self, << error.what());
  }
  return 0;
}

} // namespace surfsynth
