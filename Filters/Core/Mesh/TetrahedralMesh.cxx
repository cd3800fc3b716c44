// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TetrahedralMesh.h"

#include "Core/Common/Errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Sixfold volume over the cube of the longest edge below which a tetrahedron is degenerate.
constexpr double FlatTetrahedronRatio = 1e-12;

double SquaredLongestEdge(const TetrahedralMesh& mesh, Index t)
{
  double longest = 0.0;
  for (int i = 0; i < 4; ++i)
  {
    for (int j = i + 1; j < 4; ++j)
    {
      const auto edge = mesh.Points.row(mesh.Tetrahedra(t, i)) - mesh.Points.row(mesh.Tetrahedra(t, j));
      longest = std::max(longest, edge.squaredNorm());
    }
  }
  return longest;
}

/// Number of things with a defect, and the first of them.
struct DefectCount
{
  std::int64_t Count = 0;
  std::int64_t First = 0;

  void Add(std::int64_t id) { this->First = this->Count++ == 0 ? id : this->First; }
};

/// Counts the tetrahedra for which @p has(t) is true.
template <typename Predicate>
DefectCount CountTetrahedra(const TetrahedralMesh& mesh, const Predicate& has)
{
  DefectCount found;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    if (has(t))
    {
      found.Add(t);
    }
  }
  return found;
}

void RequireNone(const DefectCount& found, const std::string& what, const std::string& where, const std::string& repair)
{
  if (found.Count > 0)
  {
    throw InvalidInput("The volume has " + std::to_string(found.Count) + " " + what + ", first " + where + " " +
      std::to_string(found.First) + "; " + repair);
  }
}

void RequireFiniteUsedPoints(const TetrahedralMesh& mesh)
{
  std::vector<bool> isBad(static_cast<std::size_t>(mesh.NumberOfPoints()), false);
  for (Eigen::Index k = 0; k < mesh.Tetrahedra.size(); ++k)
  {
    const Index v = mesh.Tetrahedra.data()[k];
    isBad[v] = !mesh.Points.row(v).allFinite();
  }
  DefectCount found;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (isBad[v])
    {
      found.Add(v);
    }
  }
  RequireNone(found, "point(s) with a coordinate that is not finite", "point",
    "write the dataset again with the program that made it, or leave out their cells (vtkThreshold).");
}

bool RepeatsCorner(const TetrahedralMesh& mesh, Index t)
{
  std::array<Index, 4> ids{};
  std::copy_n(mesh.Tetrahedra.row(t).data(), 4, ids.begin());
  std::sort(ids.begin(), ids.end());
  return std::adjacent_find(ids.begin(), ids.end()) != ids.end();
}

Index FindRoot(std::vector<Index>& parent, Index v)
{
  while (parent[v] != v)
  {
    parent[v] = parent[parent[v]];
    v = parent[v];
  }
  return v;
}
} // namespace

BoundingBox ComputeBoundingBox(const TetrahedralMesh& mesh)
{
  BoundingBox box;
  if (mesh.NumberOfTetrahedra() == 0)
  {
    return box;
  }
  box.Lower = box.Upper = mesh.Points.row(mesh.Tetrahedra(0, 0)).transpose();
  for (Eigen::Index k = 0; k < mesh.Tetrahedra.size(); ++k)
  {
    const auto point = mesh.Points.row(mesh.Tetrahedra.data()[k]).transpose();
    box.Lower = box.Lower.cwiseMin(point);
    box.Upper = box.Upper.cwiseMax(point);
  }
  return box;
}

std::uint64_t ContentHash(const TetrahedralMesh& mesh)
{
  // Tetrahedra as rows of three ids: padded with an id that no mesh has.
  TriangleMesh rows{ mesh.Points, TriangleMatrix::Constant((mesh.Tetrahedra.size() + 2) / 3 + 1, 3, -4) };
  std::copy_n(mesh.Tetrahedra.data(), mesh.Tetrahedra.size(), rows.Triangles.data());
  return ContentHash(rows);
}

double FindLongestEdge(const TetrahedralMesh& mesh)
{
  double longest = 0.0;
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    longest = std::max(longest, SquaredLongestEdge(mesh, t));
  }
  return std::sqrt(longest);
}

double SixfoldVolume(const TetrahedralMesh& mesh, Index t)
{
  const auto ids = mesh.Tetrahedra.row(t);
  const Eigen::Vector3d origin = mesh.Points.row(ids(0));
  const Eigen::Vector3d a = mesh.Points.row(ids(1)).transpose() - origin;
  const Eigen::Vector3d b = mesh.Points.row(ids(2)).transpose() - origin;
  const Eigen::Vector3d c = mesh.Points.row(ids(3)).transpose() - origin;
  return a.dot(b.cross(c));
}

TetrahedronFaces FindFaces(const TetrahedralMesh& mesh)
{
  // Faces in buckets by their lowest vertex, each with its other two.
  std::vector<std::int64_t> start(static_cast<std::size_t>(mesh.NumberOfPoints()) + 1, 0);
  const auto eachFace = [&mesh](const auto& visit) {
    for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
    {
      std::array<Index, 4> ids{};
      std::copy_n(mesh.Tetrahedra.row(t).data(), 4, ids.begin());
      std::sort(ids.begin(), ids.end());
      visit(ids[0], ids[1], ids[2]);
      visit(ids[0], ids[1], ids[3]);
      visit(ids[0], ids[2], ids[3]);
      visit(ids[1], ids[2], ids[3]);
    }
  };
  eachFace([&](Index a, Index, Index) { ++start[static_cast<std::size_t>(a) + 1]; });
  for (std::size_t v = 1; v < start.size(); ++v)
  {
    start[v] += start[v - 1];
  }
  std::vector<std::pair<Index, Index>> others(static_cast<std::size_t>(start.back()));
  std::vector<std::int64_t> next(start.begin(), start.end() - 1);
  eachFace([&](Index a, Index b, Index c) { others[static_cast<std::size_t>(next[a]++)] = { b, c }; });
  TetrahedronFaces faces;
  for (Index a = 0; a < mesh.NumberOfPoints(); ++a)
  {
    const auto first = others.begin() + start[a];
    const auto last = others.begin() + start[static_cast<std::size_t>(a) + 1];
    std::sort(first, last);
    for (auto face = first; face != last;)
    {
      const auto end = std::upper_bound(face, last, *face);
      const FaceVertices vertices{ a, face->first, face->second };
      if (end - face == 1)
      {
        faces.Boundary.push_back(vertices);
      }
      else if (end - face > 2 && faces.NumberOfShared++ == 0)
      {
        faces.FirstShared = vertices;
      }
      face = end;
    }
  }
  return faces;
}

MeshComponents ComputeComponents(const TetrahedralMesh& mesh, const Eigen::VectorXd& mass)
{
  std::vector<Index> parent(static_cast<std::size_t>(mesh.NumberOfPoints()));
  std::vector<bool> isUsed(parent.size(), false);
  for (std::size_t v = 0; v < parent.size(); ++v)
  {
    parent[v] = static_cast<Index>(v);
  }
  for (Index t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    for (int k = 0; k < 4; ++k)
    {
      const Index a = FindRoot(parent, mesh.Tetrahedra(t, 0));
      const Index b = FindRoot(parent, mesh.Tetrahedra(t, k));
      parent[std::max(a, b)] = std::min(a, b);
      isUsed[mesh.Tetrahedra(t, k)] = true;
    }
  }
  MeshComponents components;
  components.OfVertex.assign(parent.size(), -1);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (isUsed[v])
    {
      const Index root = FindRoot(parent, v); // the lowest vertex of the component
      if (root == v)
      {
        components.OfVertex[v] = components.Count++;
        components.Area.push_back(0.0);
      }
      components.OfVertex[v] = components.OfVertex[root];
      components.Area[components.OfVertex[v]] += mass[v];
    }
  }
  components.EulerCharacteristic.assign(static_cast<std::size_t>(components.Count), 0);
  components.Closed.assign(static_cast<std::size_t>(components.Count), false);
  return components;
}

TetrahedralMesh WithoutTetrahedra(const TetrahedralMesh& mesh, const std::vector<bool>& removed)
{
  TetrahedralMesh rest{ mesh.Points, TetrahedronMatrix(mesh.Tetrahedra.rows(), 4) };
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < mesh.Tetrahedra.rows(); ++t)
  {
    if (!removed[t])
    {
      rest.Tetrahedra.row(count++) = mesh.Tetrahedra.row(t);
    }
  }
  rest.Tetrahedra.conservativeResize(count, 4);
  return rest;
}

std::int64_t RequireValidVolume(
  const TetrahedralMesh& mesh, const std::function<std::int64_t(std::int64_t)>& cellOfTetrahedron)
{
  const auto inCells = [&](DefectCount found) {
    found.First = cellOfTetrahedron && found.Count > 0 ? cellOfTetrahedron(found.First) : found.First;
    return found;
  };
  if (mesh.NumberOfTetrahedra() == 0)
  {
    throw InvalidInput("The volume has no tetrahedra; vtkTetrahedralizeFilter fills a closed surface with them.");
  }
  const auto outOfRange = [&](Index t) {
    return (mesh.Tetrahedra.row(t).array() < 0).any() ||
      (mesh.Tetrahedra.row(t).array() >= mesh.NumberOfPoints()).any();
  };
  RequireNone(inCells(CountTetrahedra(mesh, outOfRange)), "tetrahedra that name a point which does not exist", "cell",
    "write the dataset again with the program that made it.");
  RequireFiniteUsedPoints(mesh);
  const std::string again = "vtkTetrahedralizeFilter fills the surface of the volume (vtkDataSetSurfaceFilter) again.";
  RequireNone(inCells(CountTetrahedra(mesh, [&](Index t) { return RepeatsCorner(mesh, t); })),
    "tetrahedra that use a point twice", "cell", again);
  const auto isFlat = [&](Index t) {
    const double edge = std::sqrt(SquaredLongestEdge(mesh, t));
    const double sixfold = std::abs(SixfoldVolume(mesh, t));
    return !(sixfold > FlatTetrahedronRatio * edge * edge * edge && sixfold > 1e-280);
  };
  RequireNone(inCells(CountTetrahedra(mesh, isFlat)), "degenerate tetrahedra, without volume", "cell", again);
  const TetrahedronFaces faces = FindFaces(mesh);
  RequireNone({ faces.NumberOfShared, faces.FirstShared[0] }, "face(s) with more than two tetrahedra", "point",
    "tetrahedra lie upon each other there; " + again);
  return CountTetrahedra(mesh, [&](Index t) { return SixfoldVolume(mesh, t) < 0.0; }).Count;
}

} // namespace surfsynth
