// SPDX-License-Identifier: BSD-3-Clause
#include "RemeshedTarget.h"

#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "RemeshedDataset.h"
#endif

#include <vtkNew.h>
#include <vtkPolyData.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
/// Computes classes of the points that mark the seams of arrays. Normals, which a texture drops, make no seam.
std::vector<Index> SeamsOf(vtkPolyData* input, const Surface& surface)
{
  vtkNew<vtkPolyData> withoutNormals;
  withoutNormals->ShallowCopy(input);
  DropNormals(withoutNormals);
  return AttributeClasses(withoutNormals, surface.Mesh.Points);
}

/// Number of even triangles on which a texture begins by itself.
constexpr double AutomaticTriangles = 7000.0;
} // namespace

double AutomaticTextureScale(const TriangleMesh& target)
{
  const double edge = std::sqrt(4.0 / std::sqrt(3.0) * SurfaceArea(target) / AutomaticTriangles);
  const double mean = MeanEdgeLength(target);
  return edge > 0.0 && mean > 0.0 ? std::clamp(edge / mean, 0.001, 1000.0) : 1.0;
}

#ifdef SURFACE_SYNTHESIS_CGAL
namespace
{
/// Angle above which vtkIsotropicRemeshFilter keeps creases by default, degrees.
constexpr double CreaseAngle = 60.0;
/// Limit of the remeshing; with about half as many points, that of RemeshIsotropically() is not reached.
constexpr double MaximumNumberOfTriangles = 1.5e7;

/// Throws, before any work, when the levels would have too many triangles, or the surface is shorter than an edge.
void RequireFittingEdges(const TriangleMesh& mesh, double edgeLength, int levels)
{
  const BoundingBox box = ComputeBoundingBox(mesh);
  if (edgeLength > (box.Upper - box.Lower).norm())
  {
    throw InvalidInput("Edges of length " + FormatNumber(edgeLength) +
      " are longer than the surface, whose longest side is " + FormatNumber(box.LongestSide()) +
      "; a smaller TextureScale is needed.");
  }
  const double triangles = SurfaceArea(mesh) / (std::sqrt(3.0) / 4.0 * edgeLength * edgeLength);
  const double finest = triangles * std::pow(4.0, levels - 1);
  const std::string found = "Remeshed with edges of length " + FormatNumber(edgeLength) +
    " the surface would have about " + FormatNumber(triangles) + " triangles";
  if (triangles > MaximumNumberOfTriangles)
  {
    throw InvalidInput(
      found + "; at most " + FormatNumber(MaximumNumberOfTriangles) + " are allowed. A larger TextureScale is needed.");
  }
  if (finest > std::numeric_limits<Index>::max())
  {
    throw InvalidInput(found + ", which " + std::to_string(levels) + " levels make " + FormatNumber(finest) +
      "; at most 2147483647 are possible. Fewer levels or a larger TextureScale are needed.");
  }
}
} // namespace

RemeshedTarget::RemeshedTarget(
  vtkPolyData* input, const Surface& surface, double scale, int levels, const Progress& progress)
  : Scale(scale)
  , Seams(SeamsOf(input, surface))
{
  const auto target = std::make_shared<Surface>(surface);
  CheckSurface(*target, RemeshingRequirements());
  const auto options = std::make_shared<RemeshingOptions>();
  options->EdgeLength = scale * MeanEdgeLength(surface.Mesh);
  options->MatchMeanEdgeLength = true;
  options->FeatureAngle = CreaseAngle;
  options->PointClasses = this->Seams;
  RequireFittingEdges(surface.Mesh, options->EdgeLength, levels);
  this->Remeshed = RemeshSurface(target, options, progress);
}

void RemeshedTarget::Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const
{
  FillRemeshed(input, surface, this->Remeshed, output);
}
#else
RemeshedTarget::RemeshedTarget(vtkPolyData*, const Surface&, double scale, int, const Progress&)
  : Scale(scale)
{
  throw InvalidInput("TargetPreparation is REMESH, which needs CGAL, and this library was built without "
                     "(SURFACE_SYNTHESIS_CGAL is off). AS_IS or SUBDIVIDE, or a build with CGAL, is needed.");
}

void RemeshedTarget::Fill(vtkPolyData*, const Surface&, vtkPolyData*) const {}
#endif

bool RemeshedTarget::Is(vtkPolyData* input, const Surface& surface, double scale) const
{
  return this->Scale == scale && this->Seams == SeamsOf(input, surface);
}

} // namespace surfsynth
