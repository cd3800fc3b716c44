// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/LevelSets/VolumeSurface.h"

#include "MeshProcessing/LevelSets/LevelSets.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SeparateSheets.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
using Grid = openvdb::FloatGrid;

/// Voxels along a side that OpenVDB's coordinates, and single precision in them, can tell apart.
constexpr double LargestSide = 1 << 20;

/// Lengths whose fourth powers, in areas of triangles, neither overflow nor vanish.
constexpr double SmallestLength = 1e-60;
constexpr double LargestLength = 1e60;

/// Calls @p work with as many of TBB's threads as the core may use, and no more than TBB has.
template <typename Work>
TriangleMesh WithThreads(const Work& work)
{
  static const bool initialized = (openvdb::initialize(), true);
  static_cast<void>(initialized);
  TriangleMesh result;
  const std::size_t available = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  tbb::task_arena arena(static_cast<int>(std::min<std::size_t>(MaximumThreads(), available)));
  arena.execute([&] { result = work(); });
  return result;
}

double SignedVolume(const TriangleMesh& mesh)
{
  double sum = 0.0;
  const Eigen::Vector3d origin = mesh.Points.row(mesh.Triangles(0, 0)).transpose();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto corner = [&](int k) -> Eigen::Vector3d {
      return mesh.Points.row(mesh.Triangles(f, k)).transpose() - origin;
    };
    sum += corner(0).dot(corner(1).cross(corner(2)));
  }
  return sum / 6.0;
}

/// The options with an offset inwards of at most the longest side of @p mesh, of which nothing is left anyway.
LevelSetOptions WithBoundedOffset(LevelSetOptions options, const TriangleMesh& mesh)
{
  options.Offset = std::max(options.Offset, -ComputeBoundingBox(mesh).LongestSide());
  return options;
}

/// Motion of a level set, in world units.
struct Motion
{
  double Outwards = 0.0; ///< farthest place of the surface outside of where it was
  double Way = 0.0;      ///< sum of all ways
};

/// Ways of a level set by the offset and, with @p closing, there and back.
Motion MotionOf(const LevelSetOptions& options, double closing)
{
  return { std::max({ closing, options.Offset, 0.0 }), 2.0 * closing + std::abs(options.Offset) };
}

/// Visits of voxels by a motion for each voxel that is allowed: OpenVDB visits some ten million in a second.
constexpr double VisitsOfVoxel = 10.0;
/// Steps in which OpenVDB moves a surface by a voxel.
constexpr double StepsOfVoxel = 2.0;

/// Throws when a narrow band of @p halfWidth voxels of side @p voxelSize to either side of @p mesh, moved by @p motion,
/// holds too many voxels or is visited too often, before any memory is allocated for it.
void RequireFewVoxels(
  const TriangleMesh& mesh, double voxelSize, double halfWidth, const Motion& motion, const LevelSetOptions& options)
{
  const double side = ComputeBoundingBox(mesh).LongestSide() + 2.0 * motion.Outwards;
  // The area of a sphere of radius r grows by 8 pi r d + 4 pi d^2 over a distance d.
  const double grown = 4.0 * 3.14159265358979 * motion.Outwards * (side - motion.Outwards);
  const double voxels = 2.0 * (halfWidth + 1.0) * (SurfaceArea(mesh) + grown) / (voxelSize * voxelSize) +
    side / voxelSize;
  const double visits = StepsOfVoxel * motion.Way / voxelSize * voxels;
  const double mostVisits = VisitsOfVoxel * options.MaximumNumberOfVoxels;
  if (voxels <= options.MaximumNumberOfVoxels && side / voxelSize <= LargestSide && visits <= mostVisits)
  {
    return;
  }
  // The numbers decrease with the square and the cube of the size; a little is added, so that the size that is named fits.
  const double fitting = 1.05 *
    std::max({ voxelSize * std::sqrt(std::max(voxels / options.MaximumNumberOfVoxels, 1.0)),
      voxelSize * std::cbrt(std::max(visits / mostVisits, 1.0)), side / LargestSide });
  const std::string moved = visits > mostVisits
    ? " and visited " + FormatNumber(visits / voxels) + " times to move the surface by " + FormatNumber(motion.Way)
    : "";
  const std::string mostMoved = moved.empty() ? "" : ", visited " + FormatNumber(mostVisits) + " times in all,";
  throw InvalidInput("About " + FormatNumber(voxels) + " voxels of size " + FormatNumber(voxelSize) +
    " would be needed along the surface, " + FormatNumber(side / voxelSize) + " along its longest side" + moved +
    "; at most " + FormatNumber(options.MaximumNumberOfVoxels) + " and " + FormatNumber(LargestSide) + mostMoved +
    " are allowed. A VoxelSize of " + FormatNumber(fitting) + " fits; MaximumNumberOfVoxels raises the limit.");
}

/// Throws when a voxel of the size that is asked for is larger than @p mesh with its offset, of which a box would be left.
void RequireSmallVoxels(const TriangleMesh& mesh, const LevelSetOptions& options)
{
  const double outwards = std::max(options.Offset, 0.0);
  const double side = ComputeBoundingBox(mesh).LongestSide() + 2.0 * outwards;
  if (options.VoxelSize > side)
  {
    throw InvalidInput("VoxelSize is " + FormatNumber(options.VoxelSize) +
      ", larger than the surface, which spans a box of longest side " + FormatNumber(side) +
      (outwards > 0.0 ? " with its Offset" : "") + "; a size below that is needed, in the units of the surface.");
  }
}

TriangleMesh Mapped(TriangleMesh mesh, const Eigen::RowVector3d& scale, const Eigen::RowVector3d& offset)
{
  mesh.Points = (mesh.Points.array().rowwise() * scale.array()).rowwise() + offset.array();
  return mesh;
}

/// Removes all defects, in the precision of the stored points.
TriangleMesh MadeManifold(TriangleMesh mesh, bool singlePrecision)
{
  if (singlePrecision)
  {
    mesh.Points = mesh.Points.cast<float>().cast<double>();
  }
  return SeparateSheets(RemoveDegenerateTriangles(mesh));
}

void SelectParts(Grid& grid, const LevelSetOptions& options)
{
  if (options.FillCavities)
  {
    FillCavities(grid);
  }
  if (options.LargestComponent)
  {
    KeepLargestPart(grid);
  }
}

/// Processes the level set of the input and extracts its surface; @p closing is the rest of the closing, in voxels.
TriangleMesh Finish(
  Grid& grid, double voxelSize, double closing, const LevelSetOptions& options, StopInterrupter& interrupter)
{
  MoveSurface(grid, closing, interrupter);
  MoveSurface(grid, -closing, interrupter);
  Smooth(grid, options.Smoothing, options.SmoothingIterations, interrupter);
  MoveSurface(grid, options.Offset / voxelSize, interrupter);
  SelectParts(grid, options);
  interrupter.Check();
  return MeshOfGrid(grid, 0.0, options.Adaptivity);
}

/// True when a part is wound inwards and lies within no other's bounding box: then the outside is solid.
bool HasInvertedPart(const TriangleMesh& mesh, const MeshTopology& topology)
{
  const MeshComponents parts = ComputeComponents(topology, Eigen::VectorXd::Zero(mesh.NumberOfPoints()));
  std::vector<double> volume(static_cast<std::size_t>(parts.Count), 0.0);
  std::vector<Eigen::AlignedBox3d> box(volume.size());
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const Index part = parts.OfVertex[mesh.Triangles(f, 0)];
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
    {
      corners.col(k) = mesh.Points.row(mesh.Triangles(f, k)).transpose();
      box[part].extend(corners.col(k));
    }
    volume[part] += corners.col(0).dot(corners.col(1).cross(corners.col(2)));
  }
  for (std::size_t inner = 0; inner < volume.size(); ++inner)
  {
    const auto holds = [&](std::size_t outer) { return volume[outer] > 0.0 && box[outer].contains(box[inner]); };
    bool held = volume[inner] > 0.0;
    for (std::size_t outer = 0; !held && outer < volume.size(); ++outer)
    {
      held = holds(outer);
    }
    if (!held)
    {
      return true;
    }
  }
  return false;
}

/// Level set of a mesh by its winding; null when the winding does not separate inside from outside.
Grid::Ptr TrustingTheWinding(TriangleMesh mesh, StopInterrupter& interrupter)
{
  MeshRequirements closed;
  closed.ManifoldVertices = closed.ConsistentWinding = closed.Closed = true;
  if (!CheckMesh(mesh, closed).empty())
  {
    return nullptr;
  }
  if (SignedVolume(mesh) < 0.0)
  {
    mesh.Triangles.col(1).swap(mesh.Triangles.col(2));
  }
  if (HasInvertedPart(mesh, MeshTopology(mesh)))
  {
    return nullptr;
  }
  Grid::Ptr grid = LevelSetOfOrientedMesh(mesh, interrupter);
  return IsConsistent(*grid) ? grid : nullptr;
}

/// The triangles of @p mesh that have an area, however small.
TriangleMesh WithArea(const TriangleMesh& mesh)
{
  TriangleMesh result;
  result.Points = mesh.Points;
  result.Triangles.resize(mesh.NumberOfTriangles(), 3);
  Index kept = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d a = (mesh.Points.row(t(1)) - mesh.Points.row(t(0))).transpose();
    const Eigen::Vector3d b = (mesh.Points.row(t(2)) - mesh.Points.row(t(0))).transpose();
    if (a.cross(b).norm() > 1e-14 * std::max(a.squaredNorm(), b.squaredNorm()))
    {
      result.Triangles.row(kept++) = t;
    }
  }
  result.Triangles.conservativeResize(kept, 3);
  return result;
}
} // namespace

TriangleMesh SurfaceOfVolume(const VolumeSamples& samples, const LevelSetOptions& given, const StopFlag& stop)
{
  return WithThreads([&]() -> TriangleMesh {
    LevelSetOptions options = given;
    StopInterrupter interrupter(stop);
    const Grid::Ptr grid = GridOfSamples(samples);
    interrupter.Check();
    const Eigen::RowVector3d spacing = samples.Spacing.transpose();
    const Eigen::RowVector3d origin = Eigen::RowVector3d::Zero();
    if (options.LeavesLevelSetAlone())
    {
      SelectParts(*grid, options);
      interrupter.Check();
      const TriangleMesh mesh = MeshOfGrid(*grid, 0.0, options.Adaptivity);
      return MadeManifold(Mapped(mesh, spacing, origin), options.SinglePrecision);
    }
    const double voxelSize = options.VoxelSize > 0.0 ? options.VoxelSize : samples.Spacing.minCoeff();
    const TriangleMesh surface = MadeManifold(Mapped(MeshOfGrid(*grid, 0.0, 0.0), spacing, origin), false);
    if (surface.NumberOfTriangles() == 0)
    {
      return surface;
    }
    RequireSmallVoxels(surface, options);
    options = WithBoundedOffset(options, surface);
    RequireFewVoxels(surface, voxelSize, HalfWidth, MotionOf(options, options.Closing), options);
    interrupter.Check();
    const Eigen::RowVector3d scale = Eigen::RowVector3d::Constant(voxelSize);
    const Grid::Ptr levelSet = LevelSetOfOrientedMesh(Mapped(surface, scale.cwiseInverse(), origin), interrupter);
    const TriangleMesh mesh = Finish(*levelSet, voxelSize, options.Closing / voxelSize, options, interrupter);
    return MadeManifold(Mapped(mesh, scale, origin), options.SinglePrecision);
  });
}

TriangleMesh SurfaceOfMesh(const TriangleMesh& mesh, const LevelSetOptions& given, const StopFlag& stop)
{
  const LevelSetOptions options = WithBoundedOffset(given, mesh);
  const BoundingBox box = ComputeBoundingBox(mesh);
  const double voxelSize = options.VoxelSize > 0.0 ? options.VoxelSize : box.LongestSide() / 128.0;
  if (!(box.LongestSide() > SmallestLength && box.LongestSide() < LargestLength && voxelSize > SmallestLength))
  {
    throw InvalidInput("The points of the surface span a box of longest side " + FormatNumber(box.LongestSide()) +
      ", to be divided into voxels of size " + FormatNumber(voxelSize) + "; lengths from " +
      FormatNumber(SmallestLength) + " to " + FormatNumber(LargestLength) +
      " are needed. vtkTransformPolyDataFilter scales the surface.");
  }
  RequireSmallVoxels(mesh, options);
  const double closing = options.Closing / voxelSize;
  RequireFewVoxels(mesh, voxelSize, std::max<double>(HalfWidth, closing), MotionOf(options, 0.0), options);
  return WithThreads([&]() -> TriangleMesh {
    StopInterrupter interrupter(stop);
    const Eigen::RowVector3d scale = Eigen::RowVector3d::Constant(voxelSize);
    const Eigen::RowVector3d lower = box.Lower.transpose();
    TriangleMesh scaled = mesh;
    scaled.Points = (mesh.Points.rowwise() - lower) / voxelSize;
    scaled = WithArea(scaled);
    if (scaled.NumberOfTriangles() == 0)
    {
      throw InvalidInput("No triangle of the surface has an area; the solid that it bounds is empty.");
    }
    Grid::Ptr grid = TrustingTheWinding(scaled, interrupter);
    const bool trusted = grid != nullptr;
    if (!trusted)
    {
      grid = LevelSetOfSoup(scaled, closing, interrupter);
    }
    const TriangleMesh surface = Finish(*grid, voxelSize, trusted ? closing : 0.0, options, interrupter);
    return MadeManifold(Mapped(surface, scale, lower), options.SinglePrecision);
  });
}

} // namespace surfsynth
