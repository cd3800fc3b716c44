// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Volumes of tetrahedra in unstructured grids, and the frame around RequestData of filters that take them beside
/// surfaces.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "RandomFields.h"
#include "SurfaceBridge.h"

#include "Core/Mesh/VolumePlace.h"

#include <cstdint>
#include <functional>
#include <vector>

class vtkAlgorithm;
class vtkDataObject;
class vtkDataSet;
class vtkInformationVector;
class vtkUnstructuredGrid;

namespace surfsynth
{

/// True for a vtkUnstructuredGrid with a cell of three dimensions; others are surfaces, or nothing.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool IsVolume(vtkDataObject* data);

/// Converts the tetrahedra of @p input; vertices, lines and polygons beside them are ignored.
/// @throws InvalidInput when there are other cells of three dimensions, with the number of cells of each type, when
/// offsets do not fit the connectivity, or there are more than 2^31 - 1 points or tetrahedra.
VTKSURFACESYNTHESISBRIDGE_EXPORT Surface ConvertVolume(vtkUnstructuredGrid* input);

/// Finds the place nearest to each row of @p points [N, 3]; the mesh has at least one tetrahedron, and finite points.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<VolumePlace> FindNearestPlaces(
  const TetrahedralMesh& mesh, const PointMatrix& points);

/// RequestDataObject of a filter that adds arrays to surfaces and volumes: the output has the class of the input.
VTKSURFACESYNTHESISBRIDGE_EXPORT int RequestSurfacesOrVolumes(vtkDataObject* input, vtkInformationVector* outputVector);

/// Work of a filter on one volume: fills @p output, which already holds a shallow copy of the input.
using VolumeWorker = std::function<void(const Surface& volume, vtkDataSet* output, const Progress& progress)>;

/// True when the first input is a volume, on one of the MPI ranks. Collective.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool IsVolumeOnAnyRank(vtkInformationVector** inputVector);

/// RequestData of a filter on a volume, as ProcessSurfaces() for a surface. Warns of inverted tetrahedra where there
/// are others, too. On several MPI ranks the volume must lie on one.
/// @return 0 when the work failed, else 1.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessVolume(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const VolumeWorker& worker, const ValidSurface& isKnownValid = {});

/// RequestData of a filter that adds @p series to a volume: see ProcessRandomFields() and ProcessVolume().
template <typename Internals>
int ProcessRandomFieldOfVolume(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const SampleSeries& series, Internals& internals)
{
  if (!RequireSeries(self, series, inputVector, outputVector))
  {
    return 0;
  }
  internals.Begin();
  const auto addField = [&internals](const Surface& volume, vtkDataSet* output, const Progress& progress) {
    internals.AddField(volume, output, progress);
  };
  const auto isHeld = [&internals](const Surface& volume) { return internals.Find(volume) != nullptr; };
  const int success = ProcessVolume(self, inputVector, outputVector, addField, isHeld);
  if (success && !self->GetAbortExecute())
  {
    internals.Fields.DropUnused();
  }
  return success;
}

/// Calls @p process with an output of polygons, where the output is a vtkUnstructuredGrid, and fills the grid from it:
/// with the cells of the input where points and cells stay, else with triangles.
/// @return what @p process returns
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessAsSurface(vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const std::function<int(vtkInformationVector* outputVector)>& process);

} // namespace surfsynth
