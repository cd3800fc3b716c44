// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeBridge.h"

#include "DistributedSurfaces.h"
#include "OutputSeries.h"
#include "ProcessingSupport.h"
#include "Reporting.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataObject.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <string>

namespace surfsynth
{

namespace
{
/// Checks the tetrahedra, and warns when some are inverted.
void CheckVolume(vtkAlgorithm* self, const Surface& volume)
{
  const std::int64_t inverted = RequireValidVolume(*volume.Volume, [&](std::int64_t t) { return volume.Cell(t); });
  const Index all = volume.Volume->NumberOfTetrahedra();
  if (inverted > 0 && inverted < all) // all of them: another convention of their order
  {
    ReportWarning(self, volume.Where,
      std::to_string(inverted) + " of " + std::to_string(all) +
        " tetrahedra are inverted (of negative volume); they are taken as if they were not. Tetrahedra that lie upon "
        "each "
        "other would be inverted, too: vtkTetrahedralizeFilter fills the surface (vtkDataSetSurfaceFilter) again.");
  }
}

/// Text of an error, on all ranks, when several ranks hold cells; collective.
std::string ProblemOfRanks(const Ranks& ranks, vtkUnstructuredGrid* grid)
{
  const auto counts = ranks.Gather({ grid && grid->GetNumberOfCells() > 0 ? 1 : 0 });
  const auto owners = std::count_if(counts.begin(), counts.end(), [](const auto& count) { return count[0] != 0; });
  return owners <= 1 ? ""
                     : "The pieces of the volume lie on " + std::to_string(owners) +
      " MPI ranks; bring them together on one rank first (vtkAggregateDataSetFilter).";
}

/// Fills a grid from the surface that was made of it.
void FillGrid(vtkUnstructuredGrid* input, vtkPolyData* made, vtkUnstructuredGrid* output)
{
  if (made->GetNumberOfPoints() == 0 && input->GetNumberOfPoints() > 0)
  {
    output->Initialize();
    return;
  }
  output->ShallowCopy(input);
  output->GetPointData()->ShallowCopy(made->GetPointData());
  output->GetFieldData()->ShallowCopy(made->GetFieldData());
  const bool isRefined = made->GetNumberOfPoints() != input->GetNumberOfPoints();
  if (isRefined)
  {
    output->SetPoints(made->GetPoints());
    output->SetCells(VTK_TRIANGLE, made->GetPolys());
    output->GetCellData()->ShallowCopy(made->GetCellData());
  }
}
} // namespace

int RequestSurfacesOrVolumes(vtkDataObject* input, vtkInformationVector* outputVector)
{
  if (vtkUnstructuredGrid::SafeDownCast(input))
  {
    SetOutputClass(outputVector, "vtkUnstructuredGrid");
    return 1;
  }
  return RequestSurfaces(input, outputVector);
}

bool IsVolumeOnAnyRank(vtkInformationVector** inputVector)
{
  const Ranks ranks(Ranks::Several());
  const auto flags = ranks.Gather({ IsVolume(vtkDataObject::GetData(inputVector[0])) ? 1 : 0 });
  return std::any_of(flags.begin(), flags.end(), [](const auto& flag) { return flag[0] != 0; });
}

int ProcessVolume(vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const VolumeWorker& worker, const ValidSurface& isKnownValid)
{
  return RunGuarded(self, outputVector, [&] {
    PipelineProgress steps(self);
    const Ranks ranks(Ranks::Several());
    auto* grid = vtkUnstructuredGrid::SafeDownCast(vtkDataObject::GetData(inputVector[0]));
    auto* output = vtkUnstructuredGrid::SafeDownCast(vtkDataObject::GetData(outputVector));
    std::string error = ProblemOfRanks(ranks, grid);
    bool cancelled = false;
    const auto work = [&] {
      try
      {
        output->ShallowCopy(grid);
        const Progress progress = steps.Within(0.0, 1.0);
        Report(progress, 0.0);
        const Surface volume = ConvertVolume(grid);
        if (!isKnownValid || !isKnownValid(volume))
        {
          CheckVolume(self, volume);
        }
        worker(volume, output, progress);
      }
      catch (const Cancelled&)
      {
        cancelled = true;
      }
    };
    if (error.empty() && IsVolume(grid))
    {
      error = Attempt(grid, work);
    }
    CancelTogether(ranks, cancelled);
    error = ranks.FirstText(error);
    if (!error.empty())
    {
      ReportError(self, "", error);
      vtkDataObject::GetData(outputVector)->Initialize();
    }
    return error.empty();
  });
}

int ProcessAsSurface(vtkInformationVector** inputVector, vtkInformationVector* outputVector,
  const std::function<int(vtkInformationVector* outputVector)>& process)
{
  auto* output = vtkUnstructuredGrid::SafeDownCast(vtkDataObject::GetData(outputVector));
  auto* input = vtkUnstructuredGrid::SafeDownCast(vtkDataObject::GetData(inputVector[0]));
  if (!output || !input)
  {
    return process(outputVector);
  }
  vtkNew<vtkPolyData> made;
  vtkNew<vtkInformation> information;
  information->Set(vtkDataObject::DATA_OBJECT(), made);
  vtkNew<vtkInformationVector> surfaces;
  surfaces->Append(information);
  const int success = process(surfaces);
  if (information->Has(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()))
  {
    outputVector->GetInformationObject(0)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
  }
  FillGrid(input, made, output);
  return success;
}

} // namespace surfsynth
