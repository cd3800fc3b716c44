// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Transfer of geometry and attributes between VTK's datasets and new meshes.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

class vtkDataSet;
class vtkDataSetAttributes;
class vtkPolyData;

namespace surfsynth
{

/// Replaces the geometry of @p output by @p mesh; its arrays go. Points are stored in double or single precision.
VTKSURFACESYNTHESISBRIDGE_EXPORT void SetGeometry(vtkPolyData* output, const TriangleMesh& mesh, bool doublePrecision);

/// True when the points of @p surface are stored in double precision, as those of its result should then be.
VTKSURFACESYNTHESISBRIDGE_EXPORT bool HasDoublePoints(vtkPolyData* surface);

/// Removes the normals of @p surface, which mean nothing once its points have moved: the active ones and arrays named
/// "Normals", of points and of cells.
VTKSURFACESYNTHESISBRIDGE_EXPORT void DropNormals(vtkDataSet* surface);

/// Makes the array @p name of @p data, the main result of a filter, active: as scalars where @p data has no active
/// scalars and, with three components, as vectors where it has no active vectors. vtkWarpVector then takes it unasked.
VTKSURFACESYNTHESISBRIDGE_EXPORT void SetActiveWhereNone(vtkDataSetAttributes* data, const char* name);

/// Finds the nearest places on a triangle mesh with finite points, by vtkStaticCellLocator.
class VTKSURFACESYNTHESISBRIDGE_EXPORT NearestPlaces
{
public:
  /// @param mesh must outlive this object and have at least one triangle.
  explicit NearestPlaces(const TriangleMesh& mesh);
  ~NearestPlaces();
  NearestPlaces(const NearestPlaces&) = delete;
  NearestPlaces& operator=(const NearestPlaces&) = delete;

  /// Returns the place that is nearest to each point of @p points, [N, 3], in parallel.
  std::vector<SurfacePlace> Find(const PointMatrix& points) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Does the same in one call: a PlaceFinder.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<SurfacePlace> FindNearestPlaces(
  const TriangleMesh& mesh, const PointMatrix& points);

/// Fills @p target, one tuple for each place, with the point arrays @p source interpolated on @p mesh: floating-point
/// arrays linearly, normals then scaled to unit length; integers and text, which are labels, from the nearest corner.
/// Arrays that only mean something on the old mesh (global and pedigree ids, ghost flags) are left out, and so are
/// those too short for the mesh. The active scalars, vectors, normals, texture coordinates and tensors stay the active
/// ones.
VTKSURFACESYNTHESISBRIDGE_EXPORT void InterpolateArrays(vtkDataSetAttributes* source, const TriangleMesh& mesh,
  const std::vector<SurfacePlace>& places, vtkDataSetAttributes* target);

/// Fills @p target with the tuples @p ids of @p source, with the same arrays left out.
VTKSURFACESYNTHESISBRIDGE_EXPORT void PickArrays(
  vtkDataSetAttributes* source, const std::vector<std::int64_t>& ids, vtkDataSetAttributes* target);

/// Returns a class for each point of @p surface, [V], whose coordinates are @p points, [V, 3]: two points are in one
/// class when they have the same coordinates and, in all point arrays that InterpolateArrays() carries over, the same
/// values up to a millionth of the array's range. Points of equal coordinates in different classes lie at a seam, for
/// instance of texture coordinates. A class is named by its lowest point.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<Index> AttributeClasses(vtkPolyData* surface, const PointMatrix& points);

} // namespace surfsynth
