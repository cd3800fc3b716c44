// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"

#include "MeshProcessing/Tetrahedra/EnclosedRegions.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleAdjacency.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
/// Map from world units to coordinates of about unit size and back. Both ways are exact, except for the rounding of new
/// points in world units: the factor is a power of two, and an offset is only subtracted if it is so much larger than
/// the surface that the difference of two coordinates has no rounding error (Sterbenz).
class UnitCoordinates
{
public:
  explicit UnitCoordinates(const BoundingBox& box)
  {
    const double size = box.LongestSide();
    const Eigen::Vector3d middle = 0.5 * box.Lower + 0.5 * box.Upper;
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Origin[axis] = std::abs(middle[axis]) > size ? middle[axis] : 0.0;
    }
    std::frexp(size, &this->Exponent);
  }

  PointMatrix ToUnit(const PointMatrix& points) const
  {
    return ((points.rowwise() - this->Origin) * std::ldexp(1.0, -this->Exponent)).eval();
  }
  PointMatrix ToWorld(const PointMatrix& points) const
  {
    return ((points * std::ldexp(1.0, this->Exponent)).rowwise() + this->Origin).eval();
  }
  double VolumeToUnit(double volume) const { return std::ldexp(volume, -3 * this->Exponent); }

private:
  Eigen::RowVector3d Origin = Eigen::RowVector3d::Zero();
  int Exponent = 0;
};

void RequireOptions(const TetrahedralizeOptions& options)
{
  const auto require = [](bool fine, const char* name, double value, const char* expected) {
    if (!fine)
    {
      throw InvalidInput(std::string(name) + " is " + FormatNumber(value) + "; " + expected + ".");
    }
  };
  const double ratio = options.QualityRatio;
  require(ratio == 0.0 || (ratio >= 1.0 && std::isfinite(ratio)), "QualityRatio", ratio,
    "0 for no bound, or a finite number of at least 1, is needed");
  const double angle = options.MinimumDihedralAngle;
  require(angle >= 0.0 && angle <= 60.0, "MinimumDihedralAngle", angle, "an angle from 0 to 60 degrees is needed");
  require(options.MaximumVolume >= 0.0, "MaximumVolume", options.MaximumVolume, "a number of at least 0 is needed");
  require(
    options.TargetEdgeLength >= 0.0, "TargetEdgeLength", options.TargetEdgeLength, "a number of at least 0 is needed");
  require(options.Seconds >= 0.0, "TimeLimit", options.Seconds, "a number of at least 0 is needed");
}

/// Volume bound of a tetrahedron, cubic world units; 0 for none.
double VolumeBound(const TetrahedralizeOptions& options)
{
  const double length = options.TargetEdgeLength;
  const double regular = length * length * length / (6.0 * std::sqrt(2.0));
  const bool byLength = length > 0.0 && (options.MaximumVolume == 0.0 || regular < options.MaximumVolume);
  return byLength ? regular : options.MaximumVolume;
}

/// Volume that the patches enclose and that is filled, about: a patch counts as lying inside those whose bounding boxes
/// hold its own.
double FilledVolume(const TriangleMesh& surface, const SurfacePatches& patches, bool innerSurfacesAreHoles)
{
  const auto count = static_cast<std::size_t>(patches.Count);
  std::vector<double> volumes(count, 0.0);
  std::vector<Eigen::AlignedBox3d> boxes(count);
  const Eigen::RowVector3d origin = surface.Points.row(surface.Triangles(0, 0));
  for (Index f = 0; f < surface.NumberOfTriangles(); ++f)
  {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
    {
      corners.row(k) = surface.Points.row(surface.Triangles(f, k)) - origin;
      boxes[patches.OfTriangle[f]].extend(corners.row(k).transpose());
    }
    volumes[patches.OfTriangle[f]] += corners.determinant() / 6.0;
  }
  double filled = 0.0;
  for (std::size_t patch = 0; patch < count; ++patch)
  {
    const auto holds = [&](const Eigen::AlignedBox3d& box) { return box.contains(boxes[patch]); };
    const auto depth = std::count_if(boxes.begin(), boxes.end(), holds) - 1; // its own box holds it
    const double hole = depth % 2 == 1 ? -1.0 : 1.0;
    filled += std::abs(volumes[patch]) * (innerSurfacesAreHoles ? hole : depth == 0 ? 1.0 : 0.0);
  }
  return filled;
}

/// @throws InvalidInput when the bound of the volume asks for too many tetrahedra.
void RequireFeasible(const TriangleMesh& surface, const SurfacePatches& patches, const TetrahedralizeOptions& options)
{
  const double bound = VolumeBound(options);
  if (bound == 0.0)
  {
    return;
  }
  // TetGen's tetrahedra are of 4/5 of the bound on average, with a surface that is split of half of it.
  const double expected = (options.PreserveSurface ? 1.25 : 2.0) *
    FilledVolume(surface, patches, options.InnerSurfacesAreHoles) / bound;
  const double factor = 1.05 * expected / options.MaximumNumberOfTetrahedra; // a little is added, so that it fits
  if (expected <= options.MaximumNumberOfTetrahedra)
  {
    return;
  }
  const bool byVolume = bound == options.MaximumVolume;
  const double length = options.TargetEdgeLength;
  throw InvalidInput("About " + FormatNumber(expected) + " tetrahedra would be needed for " +
    (byVolume ? "a largest volume of " + FormatNumber(bound) : "edges of length " + FormatNumber(length)) +
    "; at most " + FormatNumber(options.MaximumNumberOfTetrahedra) + " (MaximumNumberOfTetrahedra) are allowed. " +
    (byVolume ? "A MaximumVolume of " + FormatNumber(factor * bound)
              : "A TargetEdgeLength of " + FormatNumber(std::cbrt(factor) * length)) +
    " fits.");
}

/// Input of one run of TetGen; coordinates and volumes are of unit size.
TetGenCall MakeCall(const TetrahedralizeOptions& options, const UnitCoordinates& unit,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle)
{
  TetGenCall call;
  call.PreserveSurface = options.PreserveSurface;
  call.QualityRatio = options.QualityRatio;
  call.MinimumDihedralAngle = options.MinimumDihedralAngle;
  const double bound = VolumeBound(options);
  call.MaximumVolume = std::isfinite(bound) ? unit.VolumeToUnit(bound) : 0.0;
  call.MaximumVolume = std::isfinite(call.MaximumVolume) ? call.MaximumVolume : 0.0;
  call.Seconds = options.Seconds;
  call.MemoryLimit = options.MemoryLimit;
  call.CellOfTriangle = cellOfTriangle;
  return call;
}

PointMatrix Joined(const PointMatrix& first, const PointMatrix& second)
{
  PointMatrix points(first.rows() + second.rows(), 3);
  points << first, second;
  return points;
}

/// A place in each region, from a first mesh without any bounds.
std::vector<tetgen::Seed> FindSeeds(const TriangleMesh& surface, const SurfacePatches& patches, TetGenCall call,
  bool innerSurfacesAreHoles, const Progress& progress)
{
  call.QualityRatio = call.MinimumDihedralAngle = call.MaximumVolume = 0.0;
  call.WantNeighbors = true;
  const TetGenMesh coarse = RunTetGen(surface, call, progress);
  const PointMatrix points = Joined(surface.Points, coarse.NewPoints);
  std::vector<tetgen::Seed> seeds;
  for (const EnclosedRegion& region : FindEnclosedRegions(patches, coarse, points))
  {
    const auto corners = coarse.Tetrahedra.row(region.LargestTetrahedron);
    tetgen::Seed seed{};
    for (int axis = 0; axis < 3; ++axis)
    {
      seed.Place[axis] = 0.25 *
        (points(corners(0), axis) + points(corners(1), axis) + points(corners(2), axis) + points(corners(3), axis));
    }
    const bool hole = innerSurfacesAreHoles && region.Depth % 2 == 1;
    seed.Region = hole ? -1 : static_cast<std::int64_t>(seeds.size());
    seeds.push_back(seed);
  }
  return seeds;
}

/// @throws SolverFailure when a tetrahedron has no volume in world coordinates, or belongs to no region
void RequireTetrahedra(const FilledSurface& mesh, Index patches)
{
  std::int64_t flat = 0;
  std::int64_t lost = 0;
  for (Index t = 0; t < static_cast<Index>(mesh.Tetrahedra.rows()); ++t)
  {
    flat += SixfoldVolume(mesh.Points, mesh.Tetrahedra, t) > 0.0 ? 0 : 1;
    lost += mesh.Regions[t] >= 0 && mesh.Regions[t] < patches ? 0 : 1;
  }
  if (flat > 0)
  {
    throw SolverFailure("Of " + std::to_string(mesh.Tetrahedra.rows()) + " tetrahedra " + std::to_string(flat) +
      " have no volume in the precision of the coordinates; move the surface closer to the origin, or remesh it: "
      "vtkIsotropicRemeshFilter makes triangles of one size.");
  }
  if (lost > 0)
  {
    throw SolverFailure("Of " + std::to_string(mesh.Tetrahedra.rows()) + " tetrahedra " + std::to_string(lost) +
      " lie in none of the regions that the surface encloses, which happens where its parts touch; separate them, or "
      "vtkVDBSurfaceFilter makes a closed manifold of them.");
  }
}
} // namespace

FilledSurface Tetrahedralize(const TriangleMesh& surface, const TetrahedralizeOptions& options,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle, const Progress& progress)
{
  RequireOptions(options);
  const UnitCoordinates unit(ComputeBoundingBox(surface));
  const TriangleMesh scaled{ unit.ToUnit(surface.Points), surface.Triangles };
  TetGenCall call = MakeCall(options, unit, cellOfTriangle);
  SurfacePatches patches = FindPatches(surface, TriangleAdjacency(surface, MeshTopology(surface)));
  RequireFeasible(surface, patches, options);
  Report(progress, 0.02);
  double begin = 0.02;
  if (patches.Count > 1)
  {
    begin = 0.35;
    call.Seeds = FindSeeds(scaled, patches, call, options.InnerSurfacesAreHoles, SubProgress(progress, 0.02, begin));
  }
  TetGenMesh made = RunTetGen(scaled, call, SubProgress(progress, begin, 0.95));
  FilledSurface mesh;
  mesh.Points = Joined(surface.Points, unit.ToWorld(made.NewPoints));
  mesh.Tetrahedra = std::move(made.Tetrahedra);
  mesh.Regions = std::move(made.Regions);
  mesh.Faces = std::move(made.Faces);
  mesh.Triangles = std::move(made.Triangles);
  RequireTetrahedra(mesh, patches.Count);
  mesh.Patches = std::move(patches.OfTriangle);
  return mesh;
}

} // namespace surfsynth
