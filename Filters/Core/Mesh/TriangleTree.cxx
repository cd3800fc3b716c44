// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/TriangleTree.h"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Part of the length of a side by which an intersection may lie outside of its triangle, so that none is lost between two.
constexpr double Overhang = 1e-9;

/// Intersects a line with triangle @p f [Moller1997]; only when the triangle faces along the direction.
void Intersect(
  const TriangleMesh& mesh, Index f, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, LineHit& hit)
{
  const Eigen::Vector3d corner = mesh.Points.row(mesh.Triangles(f, 0)).transpose();
  const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(f, 1)).transpose() - corner;
  const Eigen::Vector3d b = mesh.Points.row(mesh.Triangles(f, 2)).transpose() - corner;
  const Eigen::Vector3d normal = a.cross(b);
  const double facing = normal.dot(direction);
  const Eigen::Vector3d offset = origin - corner;
  const double way = -normal.dot(offset);
  if (!(facing > 0.0) || !(std::abs(way) < std::abs(hit.Way) * facing))
  {
    return;
  }
  const Eigen::Vector3d turned = direction.cross(offset);
  const double weightA = b.dot(turned);
  const double weightB = -a.dot(turned);
  const double least = -Overhang * facing;
  if (weightA < least || weightB < least || facing - weightA - weightB < least)
  {
    return;
  }
  Eigen::Vector3d weights(facing - weightA - weightB, weightA, weightB);
  weights = weights.cwiseMax(0.0);
  hit = { { f, weights / weights.sum() }, way / facing };
}
} // namespace

/// A line, and what its intersections with boxes need.
struct TriangleTree::Line
{
  Eigen::Vector3d Origin;
  Eigen::Vector3d Direction;
  Eigen::Vector3d Inverse; ///< 1 / Direction, infinite where that is 0

  /// Least distance from the origin at which the line runs in @p box, in lengths of the direction; infinite outside.
  double WayTo(const Eigen::AlignedBox3d& box) const
  {
    double begin = -std::numeric_limits<double>::infinity();
    double end = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c)
    {
      // fmin and fmax leave out the NaN of a line within a side.
      const double lower = (box.min()[c] - this->Origin[c]) * this->Inverse[c];
      const double upper = (box.max()[c] - this->Origin[c]) * this->Inverse[c];
      begin = std::fmax(begin, std::fmin(lower, upper));
      end = std::fmin(end, std::fmax(lower, upper));
    }
    const double slack = std::isfinite(begin) && std::isfinite(end) ? 1e-9 * (std::abs(begin) + std::abs(end)) : 0.0;
    return begin > end + slack ? std::numeric_limits<double>::infinity()
                               : std::max({ 0.0, begin - slack, -end - slack });
  }
};

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

void TriangleTree::FindOnLine(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, LineHit& hit) const
{
  const Line line{ origin, direction, direction.cwiseInverse() };
  if (line.WayTo(this->Nodes.front().Box) <= std::abs(hit.Way))
  {
    this->FindOnLine(0, line, hit);
  }
}

void TriangleTree::FindOnLine(int id, const Line& line, LineHit& hit) const
{
  const Node& node = this->Nodes[static_cast<std::size_t>(id)];
  if (node.Right < 0)
  {
    for (std::size_t k = node.Begin; k < node.End; ++k)
    {
      Intersect(this->Mesh, this->Triangles[k], line.Origin, line.Direction, hit);
    }
    return;
  }
  std::array<std::pair<double, int>, 2> children{ { { 0.0, id + 1 }, { 0.0, node.Right } } };
  for (auto& child : children)
  {
    child.first = line.WayTo(this->Nodes[static_cast<std::size_t>(child.second)].Box);
  }
  std::sort(children.begin(), children.end());
  for (const auto& child : children)
  {
    if (child.first <= std::abs(hit.Way) && child.first < std::numeric_limits<double>::infinity())
    {
      this->FindOnLine(child.second, line, hit);
    }
  }
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
