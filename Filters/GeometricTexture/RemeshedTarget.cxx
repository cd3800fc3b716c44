// SPDX-License-Identifier: BSD-3-Clause
#include "RemeshedTarget.h"

#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/UsedPoints.h"
#include "Core/Operators/SurfaceOperators.h"

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
#include <utility>

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
  const double mean = MeanSideLength(target);
  return edge > 0.0 && mean > 0.0 ? std::clamp(edge / mean, 0.001, 1000.0) : 1.0;
}

#ifdef SURFACE_SYNTHESIS_CGAL
namespace
{
/// Angle above which vtkIsotropicRemeshFilter keeps creases by default, degrees.
constexpr double CreaseAngle = 60.0;
/// Ratio of the target to the mean edge length of a remeshing: edges are about 8 per cent shorter.
constexpr double ShortenedBy = 1.08;
/// Limit of the remeshing; with about half as many points, that of RemeshIsotropically() is not reached.
constexpr double MaximumNumberOfTriangles = 1.5e7;

/// Throws, before any work, when the levels would have too many triangles, or the surface is shorter than an edge.
/// @param lengths of the points, or empty for equal ones
void RequireFittingEdges(const TriangleMesh& mesh, double edgeLength, const std::vector<double>& lengths, int levels)
{
  const BoundingBox box = ComputeBoundingBox(mesh);
  if (edgeLength > (box.Upper - box.Lower).norm())
  {
    throw InvalidInput("Edges of length " + FormatNumber(edgeLength) +
      " are longer than the surface, whose longest side is " + FormatNumber(box.LongestSide()) +
      "; a smaller TextureScale is needed.");
  }
  double triangles = SurfaceArea(mesh) / (std::sqrt(3.0) / 4.0 * edgeLength * edgeLength);
  if (!lengths.empty())
  {
    const Eigen::VectorXd areas = FaceAreas(mesh);
    triangles = 0.0;
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const auto t = mesh.Triangles.row(f);
      const double length = (lengths[t(0)] + lengths[t(1)] + lengths[t(2)]) / 3.0;
      triangles += areas[f] / (std::sqrt(3.0) / 4.0 * length * length);
    }
  }
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

RemeshedTarget::RemeshedTarget(vtkPolyData* input, const Surface& surface, double scale, const Eigen::VectorXf& sizes,
  int levels, const Progress& progress)
  : Scale(scale)
  , Sizes(sizes)
  , Seams(SeamsOf(input, surface))
{
  const auto target = std::make_shared<Surface>(surface);
  CheckSurface(*target, RemeshingRequirements());
  const auto options = std::make_shared<RemeshingOptions>();
  options->EdgeLength = scale * MeanSideLength(surface.Mesh);
  options->MatchMeanEdgeLength = true;
  options->FeatureAngle = CreaseAngle;
  options->PointClasses = this->Seams;
  if (sizes.size() > 0)
  {
    const UsedPoints points(surface.Mesh);
    std::vector<double> lengths(static_cast<std::size_t>(surface.Mesh.NumberOfPoints()), options->EdgeLength);
    for (Index k = 0; k < points.Count(); ++k)
    {
      lengths[points.Id(k)] *= sizes[k];
    }
    RequireFittingEdges(surface.Mesh, options->EdgeLength, lengths, levels);
    for (double& length : lengths)
    {
      length *= ShortenedBy;
    }
    options->PointEdgeLengths = std::move(lengths);
  }
  else
  {
    RequireFittingEdges(surface.Mesh, options->EdgeLength, {}, levels);
  }
  this->Remeshed = RemeshSurface(target, options, progress);
}

void RemeshedTarget::Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const
{
  FillRemeshed(input, surface, this->Remeshed, output);
}
#else
RemeshedTarget::RemeshedTarget(vtkPolyData*, const Surface&, double scale, const Eigen::VectorXf&, int, const Progress&)
  : Scale(scale)
{
  throw InvalidInput("TargetPreparation is REMESH, which needs CGAL, and this library was built without "
                     "(SURFACE_SYNTHESIS_CGAL is off). AS_IS or SUBDIVIDE, or a build with CGAL, is needed.");
}

void RemeshedTarget::Fill(vtkPolyData*, const Surface&, vtkPolyData*) const {}
#endif

bool RemeshedTarget::Is(vtkPolyData* input, const Surface& surface, double scale, const Eigen::VectorXf& sizes) const
{
  return this->Scale == scale && this->Sizes.size() == sizes.size() && (this->Sizes.array() == sizes.array()).all() &&
    this->Seams == SeamsOf(input, surface);
}

} // namespace surfsynth
