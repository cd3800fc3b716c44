// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion between VTK's data objects and the library's own types, which happens here only, and the frame around
/// RequestData that all filters on surfaces share.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "OutputSeries.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkDataArray;
class vtkInformation;
class vtkInformationVector;
class vtkPolyData;

namespace surfsynth
{

/// Part of the work on a surface that falls to this rank: of many independent things, such as the samples of an
/// ensemble, those with index k for which k % Count == Index.
struct SurfacePart
{
  int Index = 0; ///< in [0, Count)
  int Count = 1; ///< number of ranks that work on the surface
};

/// Surface, or volume of tetrahedra, as the core sees it.
struct Surface
{
  TriangleMesh Mesh; ///< all points of the input in their order (float64), its polygons and strips as triangles
  /// The tables of Mesh, which the check has built; empty when the check was not needed (see ProcessSurfaces()).
  std::optional<MeshTopology> Topology;
  /// Cell of the input that each triangle, or tetrahedron, comes from; empty when triangle f is cell f.
  std::vector<std::int64_t> CellOfTriangle;
  /// 0 for a polydata input; the flat index of the block (1 or more) in a composite one.
  unsigned int FlatIndex = 0;
  /// Begins messages: "" for a polydata input; "Block 3", or "Block 3 \"hand\"" with a name, in a composite one.
  std::string Where;
  /// All of the work, except in a pipeline that runs on several MPI ranks.
  SurfacePart Part;
  /// Tetrahedra of a volume, whose Mesh has the points only; empty for a surface.
  std::optional<TetrahedralMesh> Volume;

  /// Cell id of triangle or tetrahedron @p f.
  std::int64_t Cell(std::int64_t f) const { return this->CellOfTriangle.empty() ? f : this->CellOfTriangle[f]; }

  /// ContentHash() of Mesh or Volume, by which caches know it: computed at the first call and kept, so that all caches
  /// together hash a mesh once for each update. The mesh must not change afterwards. To be called on one thread.
  std::uint64_t MeshHash() const
  {
    if (!this->KnownHash)
    {
      this->KnownHash = this->Volume ? ContentHash(*this->Volume) : ContentHash(this->Mesh);
    }
    return *this->KnownHash;
  }

private:
  mutable std::optional<std::uint64_t> KnownHash;
};

/// Converts @p input and checks it: triangles are taken as they are, polygons are triangulated by ear cutting, strips
/// are unrolled; vertices and lines are ignored. Cell ids count vertices, lines, polygons and strips, as in VTK.
///
/// @throws InvalidInput, naming the defect, how many, the first cell or point and the filter that repairs it, when the
/// input has no polygon, a cell names a point that does not exist, has fewer than three points or cannot be
/// triangulated, or the triangles do not meet @p requirements.
VTKSURFACESYNTHESISBRIDGE_EXPORT Surface ToSurface(vtkPolyData* input, const MeshRequirements& requirements);

/// Converts only, the first half of ToSurface(): ids are then in range and polygons are triangles. Throws what
/// ToSurface() throws.
VTKSURFACESYNTHESISBRIDGE_EXPORT Surface ConvertSurface(vtkPolyData* input);
/// Checks only, the second half of ToSurface(), and fills surface.Topology. Throws what ToSurface() throws.
VTKSURFACESYNTHESISBRIDGE_EXPORT void CheckSurface(Surface& surface, const MeshRequirements& requirements);

/// Returns the points of @p input in double precision, [V, 3].
/// @throws InvalidInput when there are more than 2^31 - 1, or they do not have three coordinates.
VTKSURFACESYNTHESISBRIDGE_EXPORT PointMatrix ConvertPoints(vtkPolyData* input);

/// Work of a filter on one surface: fills @p output, which already holds a shallow copy of the input.
using SurfaceWorker = std::function<void(const Surface& surface, vtkPolyData* output, const Progress& progress)>;

/// One rank's piece of a surface of which several ranks hold a piece.
struct SurfacePiece
{
  Surface Local; ///< all points of the piece, and its triangles without ghost cells; no tables; may be empty
  std::vector<std::int64_t> GlobalIds; ///< of the points; empty for none
};

/// Work of a filter on one surface that stays in its pieces: called on all ranks, throws on all ranks what it throws on one.
using PieceWorker = std::function<void(const SurfacePiece& piece, vtkPolyData* output, const Progress& progress)>;

/// Returns the number that each rank of the pipeline gives, in the order of ranks. Collective.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<std::int64_t> GatherFromRanks(std::int64_t number);

/// Work of a filter with several outputs on one surface. @p outputs holds a shallow copy of the input for each output
/// of the series; those with an index k for which k % surface.Part.Count == surface.Part.Index are to be filled.
using SurfaceSeriesWorker =
  std::function<void(const Surface& surface, const std::vector<vtkPolyData*>& outputs, const Progress& progress)>;

/// Last work on one output of one surface, after the work of all ranks: what depends on cells, moves points or chooses
/// the active arrays.
using OutputFinisher = std::function<void(vtkPolyData* output)>;

/// Several outputs of each surface.
struct SurfaceSeries
{
  OutputSeries Outputs;       ///< numbers and names
  SurfaceSeriesWorker Worker; ///< adds point arrays
  OutputFinisher Finish;      ///< called for each output of a surface that holds what the worker has added
};

/// True for a converted surface that is known to be valid, because the filter still holds what it made of the same
/// mesh.
using ValidSurface = std::function<bool(const Surface& surface)>;

/// Accepts vtkPolyData and vtkDataObjectTree on the port; for FillInputPortInformation.
VTKSURFACESYNTHESISBRIDGE_EXPORT int AcceptSurfaces(vtkInformation* info);

/// RequestData of a filter on surfaces. Converts and checks each block, calls @p worker, and
///  - binds progress to UpdateProgress() and cancellation to AbortExecute;
///  - leaves out the check, about a tenth of a second for a million triangles, where @p isKnownValid says so;
///  - limits the core to the threads that vtkSMPTools uses;
///  - turns every exception into one error event with its text, and the block's output into an empty one;
///  - leaves empty input empty, without an error, and keeps inputs alive when an observer connects others;
///  - on several MPI ranks, works on blocks where they lie, gathers a surface of which several ranks hold pieces,
///    shares its @p parts (independent things to make, each one point array, in order) among the ranks, hands the new
///    point arrays and the field data back to the pieces, and reports an error on all ranks. New cell arrays are an
///    error there; the arrays of pieces are not gathered. Work of one part is done where a surface lies whole. Points
///    of different pieces are the same when their global ids are, or else their coordinates; with global ids of points
///    and cells the result has the same bits as on one rank;
///  - leaves a surface of which several ranks hold pieces in these pieces where there is a @p pieceWorker.
/// @return 0 when a polydata input failed, else 1: in a composite input a failed block is reported and left empty, and
/// the others are kept. An abort is no failure: the output is empty, and the next update runs again.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const MeshRequirements& requirements, const SurfaceWorker& worker,
  const ValidSurface& isKnownValid = {}, int parts = 1, const PieceWorker& pieceWorker = {});

/// The same for a filter that makes several outputs of each surface, which are arranged as OutputSeries says. On
/// several MPI ranks the parts that ranks share are the outputs.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const MeshRequirements& requirements, const SurfaceSeries& series,
  const ValidSurface& isKnownValid = {});

} // namespace surfsynth
