// SPDX-License-Identifier: BSD-3-Clause
#include "RemeshedDataset.h"

#include "SurfaceArrays.h"

#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <utility>
#include <vector>

namespace surfsynth
{

MeshRequirements RemeshingRequirements()
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  return requirements;
}

RemeshedSurface RemeshSurface(
  std::shared_ptr<const Surface> surface, std::shared_ptr<const RemeshingOptions> options, const Progress& progress)
{
  const double expectedSeconds = 0.2 + 2e-5 * surface->Mesh.NumberOfTriangles();
  const auto remeshed = std::make_shared<RemeshedSurface>(); // shared with the work, which outlives a cancelled call
  const auto work = [surface, options, remeshed](const std::atomic<bool>& stop) {
    RemeshingOptions withFinder = *options;
    withFinder.Finder = FindNearestPlaces;
    *remeshed = RemeshIsotropically(surface->Mesh, withFinder, &stop);
  };
  RunCancellable(work, expectedSeconds, progress);
  return std::move(*remeshed);
}

void FillRemeshed(vtkPolyData* input, const Surface& surface, const RemeshedSurface& remeshed, vtkPolyData* output)
{
  SetGeometry(output, remeshed.Mesh, HasDoublePoints(input));
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  if (input->GetPointData()->GetNumberOfArrays() > 0)
  {
    InterpolateArrays(input->GetPointData(), surface.Mesh, remeshed.PlaceOfPoint, output->GetPointData());
  }
  if (input->GetCellData()->GetNumberOfArrays() == 0)
  {
    return;
  }
  std::vector<std::int64_t> cells(remeshed.OriginOfTriangle.size());
  for (std::size_t f = 0; f < cells.size(); ++f)
  {
    cells[f] = surface.Cell(remeshed.OriginOfTriangle[f]);
  }
  PickArrays(input->GetCellData(), cells, output->GetCellData());
}

} // namespace surfsynth
