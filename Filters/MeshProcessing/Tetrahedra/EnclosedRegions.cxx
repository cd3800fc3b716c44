// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Tetrahedra/EnclosedRegions.h"

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

/// Cells: tetrahedra that can be reached from each other without crossing the surface.
struct Cells
{
  std::vector<Index> OfTetrahedron;
  std::vector<Index> Largest; ///< tetrahedron of each
  std::set<std::pair<Index, std::pair<Index, Index>>>
    Walls; ///< (patch, the lower and the higher cell on its two sides)
};

/// Numbers the tetrahedra by the cell that they are in.
class CellFinder
{
public:
  CellFinder(const SurfaceFaces& faces, const TetGenMesh& mesh, const PointMatrix& points)
    : Faces(faces)
    , Mesh(mesh)
    , Points(points)
  {
    this->Found.OfTetrahedron.assign(static_cast<std::size_t>(mesh.Tetrahedra.rows()), Outside);
  }

  Cells Find()
  {
    for (Index t = 0; t < static_cast<Index>(this->Mesh.Tetrahedra.rows()); ++t)
    {
      if (this->Found.OfTetrahedron[t] == Outside)
      {
        this->Fill(t);
      }
    }
    for (const auto& wall : this->Walls)
    {
      const Index beyond = wall[2] < 0 ? Outside : this->Found.OfTetrahedron[wall[2]];
      this->Found.Walls.insert({ wall[0], std::minmax({ this->Found.OfTetrahedron[wall[1]], beyond }) });
    }
    return std::move(this->Found);
  }

private:
  void Fill(Index first)
  {
    const Index cell = static_cast<Index>(this->Found.Largest.size());
    double largest = -1.0;
    this->Found.Largest.push_back(first);
    this->Found.OfTetrahedron[first] = cell;
    this->Stack.assign(1, first);
    while (!this->Stack.empty())
    {
      const Index t = this->Stack.back();
      this->Stack.pop_back();
      const double volume = SixfoldVolume(this->Points, this->Mesh.Tetrahedra, t);
      if (volume > largest)
      {
        largest = volume;
        this->Found.Largest[cell] = t;
      }
      this->LookAround(t, cell);
    }
  }

  void LookAround(Index t, Index cell)
  {
    for (int k = 0; k < 4; ++k)
    {
      const Index beyond = this->Mesh.Neighbors(t, k);
      const Index patch = this->Faces.PatchOf(FaceOpposite(this->Mesh.Tetrahedra, t, k));
      if (patch >= 0)
      {
        this->Walls.push_back({ patch, t, beyond });
      }
      else if (beyond >= 0 && this->Found.OfTetrahedron[beyond] == Outside)
      {
        this->Found.OfTetrahedron[beyond] = cell;
        this->Stack.push_back(beyond);
      }
    }
  }

  const SurfaceFaces& Faces;
  const TetGenMesh& Mesh;
  const PointMatrix& Points;
  Cells Found;
  std::vector<Index> Stack;
  std::vector<std::array<Index, 3>> Walls; ///< patch and the tetrahedra on its two sides
};
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
  const SurfaceFaces faces(patches, mesh);
  const Cells cells = CellFinder(faces, mesh, points).Find();
  const auto inconsistent = [] {
    throw SolverFailure(
      "TetGen's tetrahedra do not keep the parts of the surface apart, which happens where parts touch; "
      "separate them, or vtkVDBSurfaceFilter makes a closed manifold of them.");
  };
  if (cells.Walls.size() != static_cast<std::size_t>(patches.Count))
  {
    inconsistent();
  }
  // From the outside inwards: a patch encloses the cell on its other side.
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
