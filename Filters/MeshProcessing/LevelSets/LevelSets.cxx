// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/LevelSets/LevelSets.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <openvdb/tree/LeafManager.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <memory>

namespace surfsynth
{

namespace
{
using Grid = openvdb::FloatGrid;
using Tree = Grid::TreeType;
using Leaf = Tree::LeafNodeType;
using openvdb::Coord;

constexpr int LeafSide = static_cast<int>(Leaf::DIM);
/// The smallest distance from 0 of a value whose sign is changed.
constexpr float SmallestValue = 1e-6F;

enum class BlockSign : char
{
  Inside,
  Outside,
  Mixed
};

/// The samples, and the layer around them, in blocks of the size of leaves.
class SampleBlocks
{
public:
  explicit SampleBlocks(const VolumeSamples& samples)
    : Samples(samples)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Counts[axis] = samples.Dimensions[axis] / LeafSide + 2; // from -LeafSide to beyond the layer
    }
    this->Signs.resize(static_cast<std::size_t>(this->Counts[0]) * this->Counts[1] * this->Counts[2]);
  }

  std::int64_t Count() const { return static_cast<std::int64_t>(this->Signs.size()); }
  std::array<int, 3> Place(std::int64_t block) const
  {
    const std::int64_t row = block / this->Counts[0];
    return { { static_cast<int>(block % this->Counts[0]), static_cast<int>(row % this->Counts[1]),
      static_cast<int>(row / this->Counts[1]) } };
  }
  Coord Origin(std::int64_t block) const
  {
    const auto place = this->Place(block);
    return Coord(LeafSide * (place[0] - 1), LeafSide * (place[1] - 1), LeafSide * (place[2] - 1));
  }

  /// The sample or, outside, the nearest one mirrored to the outside: the volume ends half way.
  float Value(const Coord& at) const
  {
    const auto& n = this->Samples.Dimensions;
    std::array<std::int64_t, 3> nearest;
    bool outside = false;
    for (int axis = 0; axis < 3; ++axis)
    {
      nearest[axis] = std::clamp(at[axis], 0, n[axis] - 1);
      outside = outside || nearest[axis] != at[axis];
    }
    const float value = this->Samples.Values[(nearest[2] * n[1] + nearest[1]) * n[0] + nearest[0]];
    return outside ? std::abs(value) : value;
  }

  void FindSign(std::int64_t block)
  {
    const Coord origin = this->Origin(block);
    bool inside = false;
    bool outside = false;
    for (int n = 0; n < static_cast<int>(Leaf::SIZE) && !(inside && outside); ++n)
    {
      const bool negative = this->Value(origin + Leaf::offsetToLocalCoord(n)) < 0.0F;
      inside = inside || negative;
      outside = outside || !negative;
    }
    this->Signs[block] = inside && outside ? BlockSign::Mixed : inside ? BlockSign::Inside : BlockSign::Outside;
  }

  BlockSign Sign(std::int64_t block) const { return this->Signs[block]; }

  /// True when the surface passes through the block or between it and one of its neighbours.
  bool NeedsLeaf(std::int64_t block) const
  {
    const auto place = this->Place(block);
    const BlockSign own = this->Signs[block];
    for (int n = 0; n < 27; ++n)
    {
      const int x = place[0] + n % 3 - 1, y = place[1] + n / 3 % 3 - 1, z = place[2] + n / 9 - 1;
      const bool exists = x >= 0 && y >= 0 && z >= 0 && x < this->Counts[0] && y < this->Counts[1] &&
        z < this->Counts[2];
      const std::int64_t other = (std::int64_t(z) * this->Counts[1] + y) * this->Counts[0] + x;
      if (exists && (own == BlockSign::Mixed || this->Signs[other] != own))
      {
        return true;
      }
    }
    return false;
  }

  std::unique_ptr<Leaf> MakeLeaf(std::int64_t block) const
  {
    auto leaf = std::make_unique<Leaf>(this->Origin(block), 1.0F, true);
    for (int n = 0; n < static_cast<int>(Leaf::SIZE); ++n)
    {
      leaf->setValueOnly(n, this->Value(leaf->offsetToGlobalCoord(n)));
    }
    return leaf;
  }

private:
  const VolumeSamples& Samples;
  std::array<int, 3> Counts;
  std::vector<BlockSign> Signs;
};

/// Calls change(value, coordinate) for every value of the grid, voxel or tile, and stores what it returns.
template <typename Change>
void ChangeValues(Grid& grid, const Change& change)
{
  openvdb::tree::LeafManager<Tree> leaves(grid.tree());
  leaves.foreach ([&](Leaf& leaf, std::size_t) {
    for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
    {
      leaf.setValueOnly(n, change(leaf.getValue(n), leaf.offsetToGlobalCoord(n)));
    }
  });
  auto tile = grid.tree().beginValueAll();
  tile.setMaxDepth(Tree::ValueAllIter::LEAF_DEPTH - 1);
  for (; tile; ++tile)
  {
    tile.setValue(change(tile.getValue(), tile.getCoord()));
  }
}

/// Quality of a triangle: area over the square of its longest edge.
double Quality(const openvdb::Vec3d& a, const openvdb::Vec3d& b, const openvdb::Vec3d& c)
{
  const double longest = std::max({ (b - a).lengthSqr(), (c - b).lengthSqr(), (a - c).lengthSqr() });
  return longest > 0.0 ? (b - a).cross(c - a).length() / longest : 0.0;
}

/// Cuts a quadrilateral along the diagonal whose worse triangle is the better one, and reverses the winding: OpenVDB
/// winds polygons clockwise, seen from outside.
void CutQuad(const openvdb::tools::PointList& points, const openvdb::Vec4I& quad, Index* target)
{
  openvdb::Vec3d p[4];
  for (int k = 0; k < 4; ++k)
  {
    p[k] = openvdb::Vec3d(points[quad[k]]);
  }
  const double first = std::min(Quality(p[0], p[1], p[2]), Quality(p[0], p[2], p[3]));
  const double second = std::min(Quality(p[1], p[2], p[3]), Quality(p[1], p[3], p[0]));
  const int k = second > first ? 1 : 0;
  const int order[6] = { k, k + 2, k + 1, k, (k + 3) % 4, k + 2 };
  for (int n = 0; n < 6; ++n)
  {
    target[n] = static_cast<Index>(quad[order[n] % 4]);
  }
}
} // namespace

void StopInterrupter::Check() const
{
  if (this->Stop.load())
  {
    throw Cancelled("Stopped on request.");
  }
}

openvdb::FloatGrid::Ptr GridOfSamples(const VolumeSamples& samples)
{
  SampleBlocks blocks(samples);
  ParallelFor(blocks.Count(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block)
    {
      blocks.FindSign(block);
    }
  });
  std::vector<std::unique_ptr<Leaf>> leaves(static_cast<std::size_t>(blocks.Count()));
  ParallelFor(blocks.Count(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block)
    {
      leaves[block] = blocks.NeedsLeaf(block) ? blocks.MakeLeaf(block) : nullptr;
    }
  });
  Grid::Ptr grid = Grid::create(1.0F);
  grid->setGridClass(openvdb::GRID_LEVEL_SET); // fixes which side the meshing takes for the inside
  for (std::int64_t block = 0; block < blocks.Count(); ++block)
  {
    if (leaves[block])
    {
      grid->tree().addLeaf(leaves[block].release());
    }
    else if (blocks.Sign(block) == BlockSign::Inside)
    {
      grid->tree().addTile(1, blocks.Origin(block), -1.0F, false);
    }
  }
  return grid;
}

void MoveSurface(openvdb::FloatGrid& levelSet, double distance, StopInterrupter& interrupter)
{
  if (distance == 0.0 || levelSet.empty())
  {
    return;
  }
  openvdb::tools::LevelSetFilter<Grid> filter(levelSet, &interrupter);
  filter.offset(static_cast<float>(-distance));
  interrupter.Check();
}

void Smooth(openvdb::FloatGrid& levelSet, LevelSetSmoothing kind, int iterations, StopInterrupter& interrupter)
{
  openvdb::tools::LevelSetFilter<Grid> filter(levelSet, &interrupter);
  for (int k = 0; k < iterations && kind != LevelSetSmoothing::None && !levelSet.empty(); ++k)
  {
    switch (kind)
    {
      case LevelSetSmoothing::Gaussian:
        filter.gaussian();
        break;
      case LevelSetSmoothing::MeanCurvature:
        filter.meanCurvature();
        break;
      case LevelSetSmoothing::Median:
        filter.median();
        break;
      default:
        filter.laplacian();
    }
    interrupter.Check();
  }
}

void FillCavities(openvdb::FloatGrid& grid)
{
  const auto enclosed = openvdb::tools::extractEnclosedRegion(grid);
  const auto& mask = enclosed->tree();
  ChangeValues(grid, [&](float value, const Coord& at) {
    return !(value < 0.0F) && mask.isValueOn(at) ? -std::max(value, SmallestValue) : value;
  });
}

void KeepLargestPart(openvdb::FloatGrid& grid)
{
  const auto inside = openvdb::tools::sdfInteriorMask(grid, 0.0F);
  std::vector<openvdb::BoolGrid::Ptr> parts;
  openvdb::tools::segmentActiveVoxels(*inside, parts);
  if (parts.size() < 2)
  {
    return;
  }
  const auto& mask = parts.front()->tree();
  ChangeValues(grid, [&](float value, const Coord& at) {
    return value < 0.0F && !mask.isValueOn(at) ? std::max(-value, SmallestValue) : value;
  });
}

TriangleMesh MeshOfGrid(const openvdb::FloatGrid& grid, double isoValue, double adaptivity)
{
  openvdb::tools::VolumeToMesh mesher(isoValue, adaptivity);
  mesher(grid);
  TriangleMesh mesh;
  mesh.Points.resize(static_cast<Eigen::Index>(mesher.pointListSize()), 3);
  for (std::size_t v = 0; v < mesher.pointListSize(); ++v)
  {
    const openvdb::Vec3s& point = mesher.pointList()[v];
    mesh.Points.row(static_cast<Eigen::Index>(v)) << point[0], point[1], point[2];
  }
  std::vector<std::int64_t> start(mesher.polygonPoolListSize() + 1, 0);
  for (std::size_t n = 0; n < mesher.polygonPoolListSize(); ++n)
  {
    const auto& pool = mesher.polygonPoolList()[n];
    start[n + 1] = start[n] + static_cast<std::int64_t>(2 * pool.numQuads() + pool.numTriangles());
  }
  mesh.Triangles.resize(start.back(), 3);
  ParallelFor(static_cast<std::int64_t>(mesher.polygonPoolListSize()), 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t n = begin; n < end; ++n)
    {
      const auto& pool = mesher.polygonPoolList()[n];
      Index* target = mesh.Triangles.data() + 3 * start[n];
      for (std::size_t q = 0; q < pool.numQuads(); ++q, target += 6)
      {
        CutQuad(mesher.pointList(), pool.quad(q), target);
      }
      for (std::size_t t = 0; t < pool.numTriangles(); ++t, target += 3)
      {
        const openvdb::Vec3I& triangle = pool.triangle(t);
        target[0] = static_cast<Index>(triangle[0]);
        target[1] = static_cast<Index>(triangle[2]);
        target[2] = static_cast<Index>(triangle[1]);
      }
    }
  });
  return mesh;
}

} // namespace surfsynth
