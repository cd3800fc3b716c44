// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"

#include "MeshProcessing/Tetrahedra/EnclosedRegions.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleAdjacency.h"

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
  require(options.Seconds >= 0.0, "TimeLimit", options.Seconds, "a number of at least 0 is needed");
}

/// Input of one run of TetGen; coordinates and volumes are of unit size.
TetGenCall MakeCall(const TetrahedralizeOptions& options, const UnitCoordinates& unit,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle)
{
  TetGenCall call;
  call.PreserveSurface = options.PreserveSurface;
  call.QualityRatio = options.QualityRatio;
  call.MinimumDihedralAngle = options.MinimumDihedralAngle;
  call.MaximumVolume = std::isfinite(options.MaximumVolume) ? unit.VolumeToUnit(options.MaximumVolume) : 0.0;
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
void RequireTetrahedra(const TetrahedralMesh& mesh, Index patches)
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

TetrahedralMesh Tetrahedralize(const TriangleMesh& surface, const TetrahedralizeOptions& options,
  const std::function<std::int64_t(std::int64_t)>& cellOfTriangle, const Progress& progress)
{
  RequireOptions(options);
  const UnitCoordinates unit(ComputeBoundingBox(surface));
  const TriangleMesh scaled{ unit.ToUnit(surface.Points), surface.Triangles };
  TetGenCall call = MakeCall(options, unit, cellOfTriangle);
  SurfacePatches patches = FindPatches(surface, TriangleAdjacency(surface, MeshTopology(surface)));
  Report(progress, 0.02);
  double begin = 0.02;
  if (patches.Count > 1)
  {
    begin = 0.35;
    call.Seeds = FindSeeds(scaled, patches, call, options.InnerSurfacesAreHoles, SubProgress(progress, 0.02, begin));
  }
  TetGenMesh made = RunTetGen(scaled, call, SubProgress(progress, begin, 0.95));
  TetrahedralMesh mesh;
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
