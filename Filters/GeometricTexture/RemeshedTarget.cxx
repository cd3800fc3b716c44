// SPDX-License-Identifier: BSD-3-Clause
#include "RemeshedTarget.h"

#include "GeometricTextureMask.h"
#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/UsedPoints.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "RemeshedDataset.h"
#endif

#include <vtkNew.h>
#include <vtkPolyData.h>

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
  const double mean = MeanSideLength(target);
  return edge > 0.0 && mean > 0.0 ? std::clamp(edge / mean, 0.001, 1000.0) : 1.0;
}

#ifdef SURFACE_SYNTHESIS_CGAL
namespace
{
/// Angle above which vtkIsotropicRemeshFilter keeps creases by default, degrees.
constexpr double CreaseAngle = 60.0;
/// Limit of the remeshing; with about half as many points, that of RemeshIsotropically() is not reached.
constexpr double MaximumNumberOfTriangles = 1.5e7;

/// Edge lengths at the points of a target, for messages.
struct EdgeLengths
{
  double Shortest;
  double Longest;
  std::string Words;  ///< "length 1" or "length 1 to 2"
  std::string Remedy; ///< the properties that set them
};

EdgeLengths DescribeEdgeLengths(const TriangleMesh& mesh, const RemeshingOptions& options)
{
  const std::vector<double>& lengths = options.PointEdgeLengths;
  if (lengths.empty())
  {
    return { options.EdgeLength, options.EdgeLength, "length " + FormatNumber(options.EdgeLength), "TextureScale" };
  }
  EdgeLengths found{ std::numeric_limits<double>::infinity(), 0.0, "", "TextureScale, or other sizes," };
  for (Index k = 0; k < static_cast<Index>(mesh.Triangles.size()); ++k)
  {
    const double length = lengths[static_cast<std::size_t>(mesh.Triangles.data()[k])];
    found.Shortest = std::min(found.Shortest, length);
    found.Longest = std::max(found.Longest, length);
  }
  found.Words = "length " + FormatNumber(found.Shortest) + " to " + FormatNumber(found.Longest);
  return found;
}

/// Throws, before any work, when the levels would have too many triangles, or an edge is longer than the surface.
void RequireFittingEdges(const TriangleMesh& mesh, const RemeshingOptions& options, int levels)
{
  const EdgeLengths lengths = DescribeEdgeLengths(mesh, options);
  const BoundingBox box = ComputeBoundingBox(mesh);
  if (lengths.Longest > (box.Upper - box.Lower).norm())
  {
    throw InvalidInput("Edges of " + lengths.Words + " are longer than the surface, whose longest side is " +
      FormatNumber(box.LongestSide()) + "; a smaller " + lengths.Remedy + " is needed.");
  }
  const double triangles = 2.0 * ExpectedNumberOfPoints(mesh, options);
  const double finest = triangles * std::pow(4.0, levels - 1);
  const std::string found = "Remeshed with edges of " + lengths.Words + " the surface would have about " +
    FormatNumber(triangles) + " triangles";
  if (triangles > MaximumNumberOfTriangles)
  {
    throw InvalidInput(found + "; at most " + FormatNumber(MaximumNumberOfTriangles) + " are allowed. A larger " +
      lengths.Remedy + " is needed.");
  }
  if (finest > std::numeric_limits<Index>::max())
  {
    throw InvalidInput(found + ", which " + std::to_string(levels) + " levels make " + FormatNumber(finest) +
      "; at most 2147483647 are possible. Fewer levels or a larger " + lengths.Remedy + " are needed.");
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
    options->PointEdgeLengths.assign(static_cast<std::size_t>(surface.Mesh.NumberOfPoints()), options->EdgeLength);
    for (Index k = 0; k < points.Count(); ++k)
    {
      options->PointEdgeLengths[points.Id(k)] *= sizes[k];
    }
  }
  RequireFittingEdges(surface.Mesh, *options, levels);
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
  return this->Scale == scale && SameValues(this->Sizes, sizes) && this->Seams == SeamsOf(input, surface);
}

} // namespace surfsynth
