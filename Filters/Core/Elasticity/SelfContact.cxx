// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/SelfContact.h"

#include "Core/Mesh/NearestWeights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
/// Part of their distance by which a point and a triangle may approach in one move.
constexpr double Approach = 0.8;
/// Largest number of grid cells along an axis.
constexpr double MostCells = 48.0;
/// Pairs nearer than this many distances of the barrier at rest never touch.
constexpr double RestDistances = 2.0;

/// Largest length by which @p move can bring a point and a triangle nearer to each other.
double ApproachOf(const PointMatrix& move, Index point, const TriangleMatrix& triangles, Index f)
{
  double largest = 0.0;
  for (int corner = 0; corner < 3; ++corner)
  {
    largest = std::max(largest, (move.row(point) - move.row(triangles(f, corner))).squaredNorm());
  }
  return std::sqrt(largest);
}

/// Ball around a triangle.
struct TriangleBall
{
  Eigen::Vector3d Center;
  double Radius = 0.0;
  double Move = 0.0; ///< largest move of a corner
};

/// Balls around the triangles, whose points move by at most @p lengths [V].
std::vector<TriangleBall> BallsAround(
  const PointMatrix& points, const TriangleMatrix& triangles, const Eigen::VectorXd& lengths)
{
  std::vector<TriangleBall> balls(static_cast<std::size_t>(triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
  {
    TriangleBall& ball = balls[static_cast<std::size_t>(f)];
    ball.Center = (points.row(triangles(f, 0)) + points.row(triangles(f, 1)) + points.row(triangles(f, 2))) / 3.0;
    for (int corner = 0; corner < 3; ++corner)
    {
      ball.Radius = std::max(ball.Radius, (points.row(triangles(f, corner)).transpose() - ball.Center).norm());
      ball.Move = std::max(ball.Move, lengths[triangles(f, corner)]);
    }
  }
  return balls;
}

/// Cells of a box, and the triangles whose boxes, made larger by a radius, meet each.
class TriangleGrid
{
public:
  TriangleGrid(const PointMatrix& points, const TriangleMatrix& triangles, double radius)
    : Lower(points.colwise().minCoeff().transpose())
  {
    const Eigen::Vector3d extent = points.colwise().maxCoeff().transpose() - this->Lower;
    double edges = 0.0;
    for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    {
      edges += (points.row(triangles(f, 1)) - points.row(triangles(f, 0))).norm();
    }
    const double mean = edges / static_cast<double>(std::max<Eigen::Index>(triangles.rows(), 1));
    this->Cell = std::max(std::max(mean, 2.0 * radius), extent.maxCoeff() / MostCells);
    this->Size = (extent / this->Cell).array().floor().cast<int>() + 1;
    this->Start.assign(static_cast<std::size_t>(this->Size.prod()) + 1, 0);
    const auto each = [&](const auto& visit) {
      for (Index f = 0; f < triangles.rows(); ++f)
      {
        this->VisitBox(points, triangles, f, radius, visit);
      }
    };
    each([this](std::size_t cell, Index) { ++this->Start[cell + 1]; });
    for (std::size_t cell = 1; cell < this->Start.size(); ++cell)
    {
      this->Start[cell] += this->Start[cell - 1];
    }
    this->Triangles.resize(static_cast<std::size_t>(this->Start.back()));
    std::vector<Index> next(this->Start.begin(), this->Start.end() - 1);
    each([&](std::size_t cell, Index f) { this->Triangles[next[cell]++] = f; });
  }

  /// Calls visit(f) for the triangles at a point inside the box.
  template <typename Visit>
  void ForEachAt(const Eigen::Vector3d& point, const Visit& visit) const
  {
    const Eigen::Array3i place = this->PlaceOf(point);
    const std::size_t cell = this->CellAt(place);
    for (Index k = this->Start[cell]; k < this->Start[cell + 1]; ++k)
    {
      visit(this->Triangles[k]);
    }
  }

private:
  Eigen::Array3i PlaceOf(const Eigen::Vector3d& point) const
  {
    const Eigen::Array3d place = ((point - this->Lower) / this->Cell).array().floor();
    return place.max(0.0).min((this->Size - 1).cast<double>()).cast<int>();
  }
  std::size_t CellAt(const Eigen::Array3i& place) const
  {
    return (static_cast<std::size_t>(place[2]) * this->Size[1] + place[1]) * this->Size[0] + place[0];
  }
  template <typename Visit>
  void VisitBox(
    const PointMatrix& points, const TriangleMatrix& triangles, Index f, double radius, const Visit& visit) const
  {
    const Eigen::Vector3d a = points.row(triangles(f, 0)).transpose();
    const Eigen::Vector3d b = points.row(triangles(f, 1)).transpose();
    const Eigen::Vector3d c = points.row(triangles(f, 2)).transpose();
    const Eigen::Array3i first = this->PlaceOf((a.cwiseMin(b).cwiseMin(c).array() - radius).matrix());
    const Eigen::Array3i last = this->PlaceOf((a.cwiseMax(b).cwiseMax(c).array() + radius).matrix());
    for (int z = first[2]; z <= last[2]; ++z)
    {
      for (int y = first[1]; y <= last[1]; ++y)
      {
        for (int x = first[0]; x <= last[0]; ++x)
        {
          visit(this->CellAt({ x, y, z }), f);
        }
      }
    }
  }

  Eigen::Vector3d Lower;
  double Cell = 0.0;
  Eigen::Array3i Size;
  std::vector<Index> Start;
  std::vector<Index> Triangles;
};
} // namespace

SelfContact::SelfContact(
  const Barrier& barrier, TriangleMatrix boundary, Eigen::VectorXd areas, const PointMatrix& rest)
  : Surface(barrier)
  , Boundary(std::move(boundary))
  , Areas(std::move(areas))
{
  for (Index v = 0; v < this->Areas.size(); ++v)
  {
    if (this->Areas[v] > 0.0)
    {
      this->BoundaryPoints.push_back(v);
    }
  }
  this->NearAtRest = this->Near(rest, PointMatrix::Zero(rest.rows(), 3), RestDistances * barrier.Distance());
}

std::vector<SelfContact::Pair> SelfContact::Near(
  const PointMatrix& points, const PointMatrix& move, double distance) const
{
  const Eigen::VectorXd lengths = (move.rowwise() - move.colwise().mean()).rowwise().norm();
  const TriangleGrid grid(points, this->Boundary, distance + 2.0 * lengths.maxCoeff());
  const std::vector<TriangleBall> balls = BallsAround(points, this->Boundary, lengths);
  std::vector<Pair> pairs;
  for (const Index p : this->BoundaryPoints)
  {
    const Eigen::Vector3d place = points.row(p).transpose();
    grid.ForEachAt(place, [&](Index f) {
      const TriangleBall& ball = balls[static_cast<std::size_t>(f)];
      const double reach = ball.Radius + ball.Move + lengths[p] + distance;
      if ((place - ball.Center).squaredNorm() > reach * reach)
      {
        return;
      }
      const bool isCorner = p == this->Boundary(f, 0) || p == this->Boundary(f, 1) || p == this->Boundary(f, 2);
      if (!isCorner && this->PlaceOf(points, { p, f }).Distance < distance + ApproachOf(move, p, this->Boundary, f) &&
        !std::binary_search(this->NearAtRest.begin(), this->NearAtRest.end(), Pair(p, f)))
      {
        pairs.emplace_back(p, f);
      }
    });
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void SelfContact::Find(const PointMatrix& points, const PointMatrix& move)
{
  this->Pairs = this->Near(points, move, this->Surface.Distance());
}

ContactPlace SelfContact::PlaceOf(const PointMatrix& points, const Pair& pair) const
{
  ContactPlace place;
  const auto corners = this->Boundary.row(pair.second);
  place.Nodes = { pair.first, corners[0], corners[1], corners[2] };
  const Eigen::Vector3d p = points.row(pair.first).transpose();
  const std::array<Eigen::Vector3d, 3> triangle{ points.row(corners[0]).transpose(), points.row(corners[1]).transpose(),
    points.row(corners[2]).transpose() };
  const Eigen::Vector3d weights = NearestWeights(triangle, p);
  const Eigen::Vector3d difference = p - weights[0] * triangle[0] - weights[1] * triangle[1] - weights[2] * triangle[2];
  place.Distance = difference.norm();
  const Eigen::Vector3d direction = place.Distance > 0.0 ? Eigen::Vector3d(difference / place.Distance)
                                                         : Eigen::Vector3d::Zero();
  place.Derivative = { direction, -weights[0] * direction, -weights[1] * direction, -weights[2] * direction };
  return place;
}

std::vector<NodePair> SelfContact::Coupled(const PointMatrix& points) const
{
  std::vector<NodePair> coupled;
  for (const Pair& pair : this->Pairs)
  {
    const ContactPlace place = this->PlaceOf(points, pair);
    if (place.Distance < this->Surface.Distance())
    {
      for (int corner = 1; corner < 4; ++corner)
      {
        coupled.emplace_back(place.Nodes[0], place.Nodes[corner]);
      }
    }
  }
  return coupled;
}

double SelfContact::Energy(const PointMatrix& points) const
{
  double energy = 0.0;
  for (const Pair& pair : this->Pairs)
  {
    energy += this->Areas[pair.first] * this->Surface.Energy(this->PlaceOf(points, pair).Distance);
  }
  return energy;
}

void SelfContact::AddGradient(const PointMatrix& points, PointMatrix& gradient) const
{
  for (const Pair& pair : this->Pairs)
  {
    const ContactPlace place = this->PlaceOf(points, pair);
    const double force = this->Areas[pair.first] * this->Surface.Pressure(place.Distance);
    for (int k = 0; k < 4 && force > 0.0; ++k)
    {
      gradient.row(place.Nodes[k]) -= force * place.Derivative[k].transpose();
    }
  }
}

void SelfContact::AddStiffness(const PointMatrix& points, NodeMatrix& stiffness) const
{
  for (const Pair& pair : this->Pairs)
  {
    const ContactPlace place = this->PlaceOf(points, pair);
    const double factor = this->Areas[pair.first] * this->Surface.Curvature(place.Distance);
    for (int a = 0; a < 4 && factor > 0.0; ++a)
    {
      for (int b = 0; b < 4; ++b)
      {
        stiffness.Add(place.Nodes[a], place.Nodes[b], factor * place.Derivative[a] * place.Derivative[b].transpose());
      }
    }
  }
}

double SelfContact::LargestStep(const PointMatrix& points, const PointMatrix& move) const
{
  double part = 1.0;
  for (const Pair& pair : this->Pairs)
  {
    const ContactPlace place = this->PlaceOf(points, pair);
    const double speed = ApproachOf(move, pair.first, this->Boundary, pair.second);
    part = speed > 0.0 ? std::min(part, Approach * place.Distance / speed) : part;
  }
  return part;
}

} // namespace surfsynth
