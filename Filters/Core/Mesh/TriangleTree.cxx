// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TriangleTree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr std::size_t LeafSize = 8;

bool IsBefore(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}
} // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh, std::vector<Index> groups)
  : Mesh(mesh)
  , Groups(std::move(groups))
  , Triangles(this->Groups.size())
{
  std::iota(this->Triangles.begin(), this->Triangles.end(), 0);
  this->Build(0, this->Triangles.size());
}

int TriangleTree::Build(std::size_t begin, std::size_t end)
{
  const auto center = [this](Index f) {
    const auto corners = this->Mesh.Triangles.row(f);
    return Eigen::Vector3d(
      (this->Mesh.Points.row(corners(0)) + this->Mesh.Points.row(corners(1)) + this->Mesh.Points.row(corners(2)))
        .transpose() /
      3.0);
  };
  Node node{ Eigen::AlignedBox3d(), begin, end };
  node.Group = this->Groups[this->Triangles[begin]];
  for (std::size_t k = begin; k < end; ++k)
  {
    node.Group = this->Groups[this->Triangles[k]] == node.Group ? node.Group : Several;
    for (int c = 0; c < 3; ++c)
    {
      node.Box.extend(Eigen::Vector3d(this->Mesh.Points.row(this->Mesh.Triangles(this->Triangles[k], c)).transpose()));
    }
  }
  const auto id = static_cast<int>(this->Nodes.size());
  this->Nodes.push_back(node);
  if (end - begin > LeafSize)
  {
    Eigen::Index axis = 0;
    node.Box.sizes().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto first = this->Triangles.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
      first + static_cast<std::ptrdiff_t>(end),
      [&](Index a, Index b) { return std::make_pair(center(a)[axis], a) < std::make_pair(center(b)[axis], b); });
    this->Build(begin, middle);
    const int right = this->Build(middle, end);
    this->Nodes[static_cast<std::size_t>(id)].Right = right;
  }
  return id;
}

void TriangleTree::FindOutside(Index group, const Eigen::Vector3d& point, NearestPlace& nearest) const
{
  this->Find(
    0, point, [group](Index found) { return found != group; }, nearest);
}

void TriangleTree::FindIn(Index group, const Eigen::Vector3d& point, NearestPlace& nearest) const
{
  this->Find(
    0, point, [group](Index found) { return found == group || found == Several; }, nearest);
}

template <typename Wanted>
void TriangleTree::Find(int id, const Eigen::Vector3d& point, const Wanted& isWanted, NearestPlace& nearest) const
{
  const Node& node = this->Nodes[static_cast<std::size_t>(id)];
  if (!isWanted(node.Group) || node.Box.squaredExteriorDistance(point) > nearest.SquaredDistance)
  {
    return;
  }
  if (node.Right >= 0)
  {
    const auto distance = [&](int child) {
      return this->Nodes[static_cast<std::size_t>(child)].Box.squaredExteriorDistance(point);
    };
    const bool isLeftNearer = distance(id + 1) <= distance(node.Right);
    this->Find(isLeftNearer ? id + 1 : node.Right, point, isWanted, nearest);
    this->Find(isLeftNearer ? node.Right : id + 1, point, isWanted, nearest);
    return;
  }
  for (std::size_t k = node.Begin; k < node.End; ++k)
  {
    if (!isWanted(this->Groups[this->Triangles[k]]))
    {
      continue;
    }
    const SurfacePlace place = NearestOnTriangle(this->Mesh, this->Triangles[k], point);
    const Eigen::Vector3d position = PositionOf(this->Mesh, place);
    const double distance = (position - point).squaredNorm();
    if (distance < nearest.SquaredDistance ||
      (distance == nearest.SquaredDistance && IsBefore(position, nearest.Position)))
    {
      nearest = { place, position, distance };
    }
  }
}

} // namespace surfsynth
