// SPDX-License-Identifier: BSD-3-Clause
//
// Level sets of meshes.
#include "MeshProcessing/LevelSets/LevelSets.h"

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SeparateSheets.h"
#include "Core/Mesh/SurfacePlace.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace surfsynth
{

namespace
{
using Grid = openvdb::FloatGrid;
using Tree = Grid::TreeType;
using Leaf = Tree::LeafNodeType;
using openvdb::Coord;

/// Limit of the sum of the distances of two neighbours on different sides. The exact sum is at most 1; OpenVDB's
/// distances err by a few tenths of a voxel two or three voxels from the surface.
constexpr float LargestCrossing = 2.0F;
/// Half the thickness of the plates around parts of a mesh that enclose nothing, voxels.
constexpr float PlateHalfThickness = 1.0F;
/// Depth in the solid, in voxels, that a step of that length off a triangle must reach for the triangle to bound the
/// solid.
constexpr float DepthOfSolid = 0.25F;

/// Adapter of a mesh for OpenVDB.
struct VoxelMesh
{
  explicit VoxelMesh(const TriangleMesh& mesh)
  {
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      const auto point = mesh.Points.row(v).cast<float>();
      this->Points.emplace_back(point(0), point(1), point(2));
    }
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const auto t = mesh.Triangles.row(f).cast<openvdb::Index32>();
      this->Triangles.emplace_back(t(0), t(1), t(2));
    }
  }

  /// Distances up to @p width voxels; which triangle is nearest goes to @p nearest when that is not null.
  Grid::Ptr Distances(float width, int flags, openvdb::Int32Grid* nearest, StopInterrupter& interrupter) const
  {
    const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(
      this->Points, this->Triangles);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    openvdb::util::NullInterrupter& base = interrupter; // the type that OpenVDB is compiled for
    Grid::Ptr grid = openvdb::tools::meshToVolume<Grid>(base, adapter, *transform, width, width, flags, nearest);
    interrupter.Check();
    return grid;
  }

  std::vector<openvdb::Vec3s> Points;
  std::vector<openvdb::Vec3I> Triangles;
};

/// Finds the side of a closed mesh on which a point lies, from the nearest triangle [Baerentzen2005].
class Pseudonormals
{
public:
  explicit Pseudonormals(const TriangleMesh& mesh)
    : Mesh(mesh)
    , Topology(mesh)
    , OfFaces(mesh.NumberOfTriangles(), 3)
    , OfPoints(PointMatrix::Zero(mesh.NumberOfPoints(), 3))
  {
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const Eigen::Vector3d edge[3] = { this->Edge(f, 0), this->Edge(f, 1), this->Edge(f, 2) };
      this->OfFaces.row(f) = edge[0].cross(edge[1]).normalized().transpose();
      for (int k = 0; k < 3; ++k)
      {
        const Eigen::Vector3d& in = edge[(k + 2) % 3];
        const double angle = std::atan2(in.cross(edge[k]).norm(), -in.dot(edge[k]));
        this->OfPoints.row(mesh.Triangles(f, k)) += angle * this->OfFaces.row(f);
      }
    }
  }

  bool IsInside(const Eigen::Vector3d& point, Index nearestTriangle) const
  {
    const SurfacePlace place = NearestOnTriangle(this->Mesh, nearestTriangle, point);
    return (point - PositionOf(this->Mesh, place)).dot(this->At(place)) < 0.0;
  }

private:
  Eigen::Vector3d Edge(Index f, int k) const
  {
    const auto t = this->Mesh.Triangles.row(f);
    return (this->Mesh.Points.row(t((k + 1) % 3)) - this->Mesh.Points.row(t(k))).transpose();
  }

  /// Pseudonormal of the triangle, the edge or the point on which the place lies.
  Eigen::Vector3d At(const SurfacePlace& place) const
  {
    const auto zeros = (place.Weights.array() == 0.0).count();
    const auto corner = [&](int k) { return this->Mesh.Triangles(place.Triangle, k % 3); };
    Eigen::Vector3d normal = this->OfFaces.row(place.Triangle).transpose();
    int k = 0;
    if (zeros == 2)
    {
      place.Weights.maxCoeff(&k);
      normal = this->OfPoints.row(corner(k)).transpose();
    }
    else if (zeros == 1)
    {
      place.Weights.minCoeff(&k);
      const Index other = this->Across(place.Triangle, corner(k + 1), corner(k + 2));
      normal += this->OfFaces.row(other).transpose();
    }
    return normal;
  }

  /// The other triangle on the edge from @p a to @p b.
  Index Across(Index f, Index a, Index b) const
  {
    for (Index k = this->Topology.VertexTriangleStart[a]; k < this->Topology.VertexTriangleStart[a + 1]; ++k)
    {
      const Index g = this->Topology.VertexTriangles[k];
      if (g != f && (this->Mesh.Triangles.row(g).array() == b).any())
      {
        return g;
      }
    }
    return f;
  }

  const TriangleMesh& Mesh;
  MeshTopology Topology;
  PointMatrix OfFaces;
  PointMatrix OfPoints;
};

/// The triangles of @p mesh that neither bound the solid nor lie within it: a step off them to either side does not
/// lead well into it.
TriangleMesh LeftOut(const TriangleMesh& mesh, const Grid& solid)
{
  TriangleMesh rest;
  rest.Points = mesh.Points;
  rest.Triangles.resize(mesh.NumberOfTriangles(), 3);
  auto accessor = solid.getConstAccessor();
  const auto depth = [&](const Eigen::Vector3d& at) {
    return -openvdb::tools::BoxSampler::sample(accessor, openvdb::Vec3R(at[0], at[1], at[2]));
  };
  Index kept = 0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    const Eigen::Vector3d a = mesh.Points.row(t(0)).transpose();
    const Eigen::Vector3d b = mesh.Points.row(t(1)).transpose();
    const Eigen::Vector3d c = mesh.Points.row(t(2)).transpose();
    const Eigen::Vector3d step = PlateHalfThickness * (b - a).cross(c - a).normalized();
    bool bounds = true;
    for (const Eigen::Vector3d& at : { Eigen::Vector3d((a + b + c) / 3.0), Eigen::Vector3d(0.8 * a + 0.1 * (b + c)),
           Eigen::Vector3d(0.8 * b + 0.1 * (c + a)), Eigen::Vector3d(0.8 * c + 0.1 * (a + b)) })
    {
      bounds = bounds && std::max(depth(at + step), depth(at - step)) > DepthOfSolid;
    }
    if (!bounds)
    {
      rest.Triangles.row(kept++) = t;
    }
  }
  rest.Triangles.conservativeResize(kept, 3);
  return rest;
}

/// Level set of all places within @p thickness voxels of the mesh.
Grid::Ptr PlateAround(const TriangleMesh& mesh, float thickness, StopInterrupter& interrupter)
{
  Grid::Ptr grid = VoxelMesh(mesh).Distances(
    HalfWidth + thickness, openvdb::tools::UNSIGNED_DISTANCE_FIELD, nullptr, interrupter);
  openvdb::tree::LeafManager<Tree> leaves(grid->tree());
  leaves.foreach ([&](Leaf& leaf, std::size_t) {
    for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
    {
      leaf.setValueOnly(n, leaf.getValue(n) - thickness);
    }
  });
  openvdb::tools::changeBackground(grid->tree(), HalfWidth);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  return grid;
}

/// Solid that the mesh encloses after gaps up to twice @p closing are bridged: all places within @p closing of the mesh
/// and inside it, shrunk by the same distance.
Grid::Ptr ClosedSolid(const TriangleMesh& mesh, double closing, StopInterrupter& interrupter)
{
  Grid::Ptr wide = PlateAround(mesh, static_cast<float>(closing), interrupter);
  FillCavities(*wide);
  const TriangleMesh boundary = SeparateSheets(RemoveDegenerateTriangles(MeshOfGrid(*wide, 0.0, 0.0)));
  if (boundary.NumberOfTriangles() == 0)
  {
    return Grid::create(HalfWidth);
  }
  Grid::Ptr solid = LevelSetOfOrientedMesh(boundary, interrupter);
  MoveSurface(*solid, -closing, interrupter);
  return solid;
}
} // namespace

openvdb::FloatGrid::Ptr LevelSetOfOrientedMesh(const TriangleMesh& mesh, StopInterrupter& interrupter)
{
  openvdb::Int32Grid nearest;
  Grid::Ptr grid = VoxelMesh(mesh).Distances(HalfWidth, openvdb::tools::UNSIGNED_DISTANCE_FIELD, &nearest, interrupter);
  const Pseudonormals normals(mesh);
  openvdb::tree::LeafManager<Tree> leaves(grid->tree());
  leaves.foreach ([&](Leaf& leaf, std::size_t) {
    if (interrupter.wasInterrupted())
    {
      return;
    }
    auto triangles = nearest.getConstAccessor();
    for (auto voxel = leaf.beginValueOn(); voxel; ++voxel)
    {
      const Coord at = voxel.getCoord();
      const bool inside = normals.IsInside({ double(at[0]), double(at[1]), double(at[2]) }, triangles.getValue(at));
      voxel.setValue(inside ? -*voxel : *voxel);
    }
  });
  interrupter.Check();
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

bool IsConsistent(const openvdb::FloatGrid& levelSet)
{
  std::atomic<bool> consistent{ true };
  openvdb::tree::LeafManager<const Tree> leaves(levelSet.tree());
  leaves.foreach ([&](const Leaf& leaf, std::size_t) {
    auto accessor = levelSet.getConstAccessor();
    for (openvdb::Index n = 0; n < Leaf::SIZE && consistent.load(std::memory_order_relaxed); ++n)
    {
      const Coord at = leaf.offsetToGlobalCoord(n);
      for (int side = 0; side < 6; ++side)
      {
        Coord next = at;
        next[side / 2] += side % 2 == 0 ? 1 : -1;
        const float value = leaf.getValue(n);
        const float other = accessor.getValue(next);
        if ((value < 0.0F) != (other < 0.0F) && std::abs(value) + std::abs(other) > LargestCrossing)
        {
          consistent.store(false, std::memory_order_relaxed);
        }
      }
    }
  });
  return consistent.load();
}

openvdb::FloatGrid::Ptr LevelSetOfSoup(const TriangleMesh& mesh, double closing, StopInterrupter& interrupter)
{
  Grid::Ptr solid = closing > 0.0 ? ClosedSolid(mesh, closing, interrupter)
                                  : VoxelMesh(mesh).Distances(HalfWidth, 0, nullptr, interrupter);
  const TriangleMesh rest = LeftOut(mesh, *solid);
  if (rest.NumberOfTriangles() > 0)
  {
    const Grid::Ptr plates = PlateAround(rest, PlateHalfThickness, interrupter);
    openvdb::tools::csgUnion(*solid, *plates);
  }
  return solid;
}

} // namespace surfsynth
