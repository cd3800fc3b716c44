// SPDX-License-Identifier: BSD-3-Clause
#include "LatentTriangulation.h"

#include "RegularRings.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/UsedPoints.h"
#include "Core/Random/CounterUniforms.h"
#include "Core/Tangent/TangentHierarchy.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "RemeshedDataset.h"
#endif

#include <memory>
#include <string>
#include <utility>

namespace surfsynth
{

struct LatentTriangulation::Parts
{
  bool IsRemeshed = false;
  std::vector<SurfacePlace> Places;
  Surface Triangles;
};

namespace
{
/// The surface with one point for all at the same place, and only the points that triangles use. @throws InvalidInput
Surface WeldedPart(const Surface& surface)
{
  const WeldedSurface welded(surface); // the check
  Surface part;
  part.Mesh = UsedPoints(welded.Mesh).Compact(welded.Mesh);
  part.CellOfTriangle = surface.CellOfTriangle;
  part.Where = surface.Where;
  return part;
}

/// Place of each vertex at a corner of the first of its triangles.
std::vector<SurfacePlace> CornerPlaces(const TriangleMesh& mesh)
{
  std::vector<SurfacePlace> places(static_cast<std::size_t>(mesh.NumberOfPoints()));
  for (Index corner = 0; corner < 3 * mesh.NumberOfTriangles(); ++corner)
  {
    SurfacePlace& place = places[static_cast<std::size_t>(mesh.Triangles(corner / 3, corner % 3))];
    if (place.Triangle < 0)
    {
      place.Triangle = corner / 3;
      place.Weights[corner % 3] = 1.0;
    }
  }
  return places;
}

#ifdef SURFACE_SYNTHESIS_CGAL
/// Angle above which vtkIsotropicRemeshFilter keeps creases by default, degrees.
constexpr double CreaseAngle = 60.0;
/// Half of the range of the random factors of edge lengths.
constexpr double LengthVariation = 0.2;

RemeshedSurface Remesh(const Surface& surface, std::int64_t numberOfPoints, const Progress& progress,
  const std::optional<NormalKey>& variation)
{
  const auto options = std::make_shared<RemeshingOptions>();
  options->EdgeLength = MeanSideLength(surface.Mesh); // scaled until the number of points fits
  options->NumberOfPoints = numberOfPoints;
  options->FeatureAngle = CreaseAngle;
  options->FindOrigins = false;
  for (Index v = 0; variation && v < surface.Mesh.NumberOfPoints(); ++v)
  {
    const double factor = 1.0 + LengthVariation * (2.0 * Uniform(*variation, v) - 1.0);
    options->PointEdgeLengths.push_back(factor * options->EdgeLength);
  }
  return RemeshSurface(std::make_shared<const Surface>(surface), options, progress);
}
#endif
} // namespace

LatentTriangulation::Parts LatentTriangulation::Make(const Surface& surface, std::int64_t numberOfPoints,
  const Progress& progress, const std::optional<NormalKey>& variation)
{
  Parts parts;
  parts.IsRemeshed = numberOfPoints > 0;
  parts.Triangles = WeldedPart(surface);
  Report(progress, 0.0);
  if (!parts.IsRemeshed)
  {
    parts.Places = CornerPlaces(parts.Triangles.Mesh);
    return parts;
  }
#ifdef SURFACE_SYNTHESIS_CGAL
  RemeshedSurface remeshed = Remesh(parts.Triangles, numberOfPoints, progress, variation);
  const TriangleMesh source = std::move(parts.Triangles.Mesh);
  parts.Triangles.CellOfTriangle.clear();
  parts.Triangles.Mesh = std::move(remeshed.Mesh);
  parts.Places = std::move(remeshed.PlaceOfPoint);
  MoveRegularVertices(source, parts.Triangles, parts.Places);
  return parts;
#else
  static_cast<void>(variation);
  throw InvalidInput("Remeshing to " + std::to_string(numberOfPoints) +
    " points needs CGAL, and this library was built without (SURFACE_SYNTHESIS_CGAL is off). The triangulation AS_IS, "
    "or a "
    "build with CGAL, is needed.");
#endif
}

LatentTriangulation::LatentTriangulation(const Surface& surface, std::int64_t numberOfPoints, const Progress& progress,
  const std::optional<NormalKey>& variation)
  : LatentTriangulation(Make(surface, numberOfPoints, progress, variation))
{}

LatentTriangulation::LatentTriangulation(Parts parts)
  : Remeshed(parts.IsRemeshed)
  , PlaceOfVertex(std::move(parts.Places))
  , Content(parts.Triangles)
  , RegularVertexCount(static_cast<std::int64_t>(RegularVertices(this->Content.Rings).size()))
{}

} // namespace surfsynth
