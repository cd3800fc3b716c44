// SPDX-License-Identifier: BSD-3-Clause
#include "EnclosedRegions.h"

#include "Core/Common/Errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

namespace surfsynth
{

namespace
{
using Corners = std::array<Index, 3>;

constexpr Index Outside = -1; ///< the region of no tetrahedron

Corners Sorted(Index a, Index b, Index c)
{
  Corners corners = { a, b, c };
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// The face of a tetrahedron opposite to its corner @p k.
Corners FaceOpposite(const TetrahedronMatrix& tetrahedra, Index t, int k)
{
  return Sorted(tetrahedra(t, (k + 1) % 4), tetrahedra(t, (k + 2) % 4), tetrahedra(t, (k + 3) % 4));
}

/// The patch of the surface that each of its faces in the mesh belongs to, sorted by corners for look-up.
class SurfaceFaces
{
public:
  SurfaceFaces(const SurfacePatches& patches, const TetGenMesh& mesh)
  {
    this->Faces.reserve(mesh.Triangles.size());
    for (std::size_t k = 0; k < mesh.Triangles.size(); ++k)
    {
      const auto t = mesh.Faces.row(static_cast<Eigen::Index>(k));
      this->Faces.emplace_back(Sorted(t(0), t(1), t(2)), patches.OfTriangle[mesh.Triangles[k]]);
    }
    std::sort(this->Faces.begin(), this->Faces.end());
  }
  /// -1 for a face that is not on the surface.
  Index PatchOf(const Corners& corners) const
  {
    const auto found = std::lower_bound(this->Faces.begin(), this->Faces.end(), std::make_pair(corners, Index(-1)));
    return found != this->Faces.end() && found->first == corners ? found->second : -1;
  }

private:
  std::vector<std::pair<Corners, Index>> Faces;
};

/// Which tetrahedra can be reached from each other without crossing the surface.
struct Cells
{
  std::vector<Index> OfTetrahedron;
  std::vector<Index> Largest;                    ///< tetrahedron of each
  std::set<std::pair<Index, std::pair<Index, Index>>> Walls; ///< (patch, the lower and the higher cell on its two sides)
};

Cells FindCells(const SurfaceFaces& faces, const TetGenMesh& mesh, const PointMatrix& points)
{
  const Index count = static_cast<Index>(mesh.Tetrahedra.rows());
  Cells cells;
  cells.OfTetrahedron.assign(static_cast<std::size_t>(count), Outside);
  std::vector<Index> stack;
  std::vector<std::array<Index, 3>> walls; // patch and the tetrahedra on its two sides
  for (Index first = 0; first < count; ++first)
  {
    if (cells.OfTetrahedron[first] != Outside)
    {
      continue;
    }
    const Index cell = static_cast<Index>(cells.Largest.size());
    double largest = -1.0;
    cells.Largest.push_back(first);
    cells.OfTetrahedron[first] = cell;
    stack.assign(1, first);
    while (!stack.empty())
    {
      const Index t = stack.back();
      stack.pop_back();
      const double volume = SixfoldVolume(points, mesh.Tetrahedra, t);
      if (volume > largest)
      {
        largest = volume;
        cells.Largest[cell] = t;
      }
      for (int k = 0; k < 4; ++k)
      {
        const Index beyond = mesh.Neighbours(t, k);
        const Index patch = faces.PatchOf(FaceOpposite(mesh.Tetrahedra, t, k));
        if (patch >= 0)
        {
          walls.push_back({ patch, t, beyond });
        }
        else if (beyond >= 0 && cells.OfTetrahedron[beyond] == Outside)
        {
          cells.OfTetrahedron[beyond] = cell;
          stack.push_back(beyond);
        }
      }
    }
  }
  for (const auto& wall : walls)
  {
    const auto sides = std::minmax(
      { cells.OfTetrahedron[wall[1]], wall[2] < 0 ? Outside : cells.OfTetrahedron[wall[2]] });
    cells.Walls.insert({ wall[0], { sides.first, sides.second } });
  }
  return cells;
}
} // namespace

double SixfoldVolume(const PointMatrix& points, const TetrahedronMatrix& tetrahedra, Index t)
{
  const auto corner = [&](int k) { return points.row(tetrahedra(t, k)); };
  const Eigen::Vector3d a = (corner(1) - corner(0)).transpose();
  const Eigen::Vector3d b = (corner(2) - corner(0)).transpose();
  const Eigen::Vector3d c = (corner(3) - corner(0)).transpose();
  return a.cross(b).dot(c);
}

std::vector<EnclosedRegion> FindEnclosedRegions(
  const SurfacePatches& patches, const TetGenMesh& mesh, const PointMatrix& points)
{
  const Cells cells = FindCells(SurfaceFaces(patches, mesh), mesh, points);
  const auto inconsistent = [] {
    throw SolverFailure("TetGen's tetrahedra do not keep the parts of the surface apart, which happens where parts touch; "
                        "separate them, or vtkVDBSurfaceFilter makes a closed manifold of them.");
  };
  if (cells.Walls.size() != static_cast<std::size_t>(patches.Count))
  {
    inconsistent();
  }
  // From the outside inwards: what lies on the other side of a patch is what it encloses.
  std::vector<EnclosedRegion> regions(static_cast<std::size_t>(patches.Count));
  std::multimap<Index, std::pair<Index, Index>> beyond; // cell -> (patch, the cell on its other side)
  for (const auto& wall : cells.Walls)
  {
    beyond.insert({ wall.second.first, { wall.first, wall.second.second } });
    beyond.insert({ wall.second.second, { wall.first, wall.second.first } });
  }
  std::vector<std::pair<Index, int>> reached = { { Outside, 0 } };
  for (std::size_t k = 0; k < reached.size(); ++k)
  {
    const auto [cell, depth] = reached[k];
    const auto [first, last] = beyond.equal_range(cell);
    for (auto entry = first; entry != last; ++entry)
    {
      EnclosedRegion& region = regions[entry->second.first];
      const Index inner = entry->second.second;
      if (region.Depth < 0 && inner != Outside)
      {
        region.Depth = depth;
        region.LargestTetrahedron = cells.Largest[inner];
        reached.emplace_back(inner, depth + 1);
      }
    }
  }
  if (std::any_of(regions.begin(), regions.end(), [](const EnclosedRegion& region) { return region.Depth < 0; }))
  {
    inconsistent();
  }
  return regions;
}

} // namespace surfsynth
