// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/OneRings.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Pi = 3.14159265358979323846;
/// Least places of a range: each costs three arc tangents, sines and cosines.
constexpr std::int64_t LogarithmGrain = 2048;

MeshRequirements RingRequirements()
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  return requirements;
}

/// Sorts the corners around a vertex counter-clockwise.
class RingOrder
{
public:
  explicit RingOrder(const TriangleMesh& mesh)
    : Mesh(mesh)
  {}

  /// Writes the corners of the triangles [first, last) at vertex @p v to @p out in their order.
  /// @return false when they form no single fan of one winding.
  bool Sort(Index v, const Index* first, const Index* last, Index* out)
  {
    const auto count = static_cast<Index>(last - first);
    this->Collect(v, first, count);
    this->Next.assign(static_cast<std::size_t>(count), -1);
    this->HasPrevious.assign(static_cast<std::size_t>(count), false);
    Index ends = 0;
    for (Index k = 0; k < count; ++k)
    {
      const Index to = this->To[k];
      const auto found = std::lower_bound(
        this->From.begin(), this->From.end(), to, [](const auto& entry, Index id) { return entry.first < id; });
      if (found == this->From.end() || found->first != to)
      {
        ++ends;
        continue;
      }
      this->Next[k] = found->second;
      this->HasPrevious[found->second] = true;
    }
    this->Closed = ends == 0;
    const auto begin = std::find(this->HasPrevious.begin(), this->HasPrevious.end(), false);
    Index at = this->Closed || begin == this->HasPrevious.end() ? 0
                                                                : static_cast<Index>(begin - this->HasPrevious.begin());
    this->Visited.assign(static_cast<std::size_t>(count), false);
    Index visits = 0;
    for (; at >= 0 && !this->Visited[at]; at = this->Next[at])
    {
      this->Visited[at] = true;
      out[visits++] = this->Corners[at];
    }
    return visits == count && ends <= 1;
  }

  /// True when the ring of the last call surrounds its vertex.
  bool IsClosed() const { return this->Closed; }

private:
  void Collect(Index v, const Index* triangles, Index count)
  {
    this->Corners.resize(static_cast<std::size_t>(count));
    this->To.resize(static_cast<std::size_t>(count));
    this->From.resize(static_cast<std::size_t>(count));
    for (Index k = 0; k < count; ++k)
    {
      const auto t = this->Mesh.Triangles.row(triangles[k]);
      const int corner = t(0) == v ? 0 : (t(1) == v ? 1 : 2);
      this->Corners[k] = 3 * triangles[k] + corner;
      this->From[k] = { t((corner + 1) % 3), k };
      this->To[k] = t((corner + 2) % 3);
    }
    std::sort(this->From.begin(), this->From.end());
  }

  const TriangleMesh& Mesh;
  std::vector<Index> Corners;
  std::vector<std::pair<Index, Index>> From; ///< vertex a of each corner, and its place, sorted
  std::vector<Index> To;                     ///< vertex b of each corner
  std::vector<Index> Next;
  std::vector<bool> HasPrevious;
  std::vector<bool> Visited;
  bool Closed = false;
};

/// The edges of one ring: projections to the tangent plane and rescaled angles.
struct ProjectedEdges
{
  std::complex<double> Sum = 0.0; ///< of P(e) exp(-i angle(e))
  double Lengths = 0.0;
  std::complex<double> Longest = 0.0; ///< the longest P(e), times exp(-i angle(e))

  void Add(const std::complex<double>& projection, const std::complex<double>& direction, double length)
  {
    const std::complex<double> turned = projection * std::conj(direction);
    this->Sum += turned;
    this->Lengths += length;
    this->Longest = std::norm(turned) > std::norm(this->Longest) ? turned : this->Longest;
  }
  double Offset() const
  {
    const bool vanishes = std::abs(this->Sum) <= 1e-6 * this->Lengths;
    return std::arg(vanishes ? this->Longest : this->Sum);
  }
};

/// Unfolds the triangle of corner @p c and returns its true angle there. Angle and Scale are set later.
double UnfoldCorner(const TriangleMesh& mesh, Index c, RingCorner& corner, double& area)
{
  const auto t = mesh.Triangles.row(c / 3);
  const auto edge = [&](int k) -> Eigen::Vector3d {
    return (mesh.Points.row(t((c % 3 + k) % 3)) - mesh.Points.row(t(c % 3))).transpose();
  };
  const Eigen::Vector3d a = edge(1);
  const Eigen::Vector3d b = edge(2);
  const double across = a.cross(b).norm();
  corner.Length = a.norm();
  corner.OtherX = a.dot(b) / corner.Length;
  corner.OtherY = across / corner.Length;
  area = 0.5 * across;
  return std::atan2(corner.OtherY, corner.OtherX);
}

std::complex<double> Projection(const TriangleMesh& mesh, const VertexFrames& frames, Index v, Index other)
{
  const Eigen::RowVector3d edge = mesh.Points.row(other) - mesh.Points.row(v);
  return { edge.dot(frames.X.row(v)), edge.dot(frames.Y.row(v)) };
}

/// Vertex of the triangle of corner @p c that lies @p steps corners further.
Index CornerVertex(const TriangleMesh& mesh, Index c, int steps) { return mesh.Triangles(c / 3, (c % 3 + steps) % 3); }

double Rescaling(double total, bool closed) { return closed || total > 2.0 * Pi ? 2.0 * Pi / total : 1.0; }
} // namespace

OneRings::OneRings(const TriangleMesh& mesh)
{
  const MeshTopology topology = RequireValidMesh(mesh, RingRequirements());
  this->Frames = TangentFrames(mesh, topology);
  this->Unfold(mesh, topology);
  this->ConnectNeighbors();
}

OneRings::OneRings(const TriangleMesh& mesh, const MeshTopology& topology, VertexFrames frames)
  : Frames(std::move(frames))
{
  if (this->Frames.X.rows() != mesh.NumberOfPoints() || this->Frames.Y.rows() != mesh.NumberOfPoints())
  {
    throw InvalidInput("OneRings: " + std::to_string(this->Frames.X.rows()) + " frames; expected " +
      std::to_string(mesh.NumberOfPoints()) + ", one for each vertex.");
  }
  this->Unfold(mesh, topology);
  this->ConnectNeighbors();
}

void OneRings::Unfold(const TriangleMesh& mesh, const MeshTopology& topology)
{
  const Index points = mesh.NumberOfPoints();
  this->RingStart = topology.VertexTriangleStart;
  this->NeighborStart = topology.NeighborStart;
  this->Neighbors = topology.Neighbors;
  this->RingCorners.resize(topology.VertexTriangles.size());
  this->Corners.resize(topology.VertexTriangles.size());
  this->OnBoundary.assign(static_cast<std::size_t>(points), 0);
  this->TotalAngles = Eigen::VectorXd::Zero(points);
  this->Areas = Eigen::VectorXd::Zero(points);
  this->NeighborLogarithms.resize(static_cast<Eigen::Index>(this->Neighbors.size()));
  ParallelFor(points, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    RingOrder order(mesh);
    std::vector<RingEdge> edges;
    for (auto v = static_cast<Index>(begin); v < end; ++v)
    {
      const Index first = this->RingStart[v];
      const Index last = this->RingStart[v + 1];
      if (first == last)
      {
        continue;
      }
      const Index* triangles = topology.VertexTriangles.data();
      if (!order.Sort(v, triangles + first, triangles + last, this->RingCorners.data() + first))
      {
        throw InvalidInput("OneRings: the triangles around vertex " + std::to_string(v) +
          " form several fans or are wound in opposite senses; expected one fan or ring of one winding.");
      }
      this->OnBoundary[v] = order.IsClosed() ? 0 : 1;
      this->UnfoldRing(mesh, v, edges);
    }
  });
}

void OneRings::UnfoldRing(const TriangleMesh& mesh, Index v, std::vector<RingEdge>& edges)
{
  const Index first = this->RingStart[v];
  const Index last = this->RingStart[v + 1];
  const bool closed = this->OnBoundary[v] == 0;
  double total = 0.0;
  edges.clear();
  for (Index k = first; k < last; ++k)
  {
    const Index c = this->RingCorners[k];
    double area = 0.0;
    const double angle = UnfoldCorner(mesh, c, this->Corners[c], area);
    edges.push_back({ CornerVertex(mesh, c, 1), total, this->Corners[c].Length, 1.0 });
    total += angle;
    this->Areas[v] += area;
  }
  if (!closed)
  {
    const Index c = this->RingCorners[last - 1];
    const double length = std::hypot(this->Corners[c].OtherX, this->Corners[c].OtherY);
    edges.push_back({ CornerVertex(mesh, c, 2), total, length, 1.0 });
  }
  this->TotalAngles[v] = total;
  const double scale = Rescaling(total, closed);
  ProjectedEdges projected;
  for (RingEdge& edge : edges)
  {
    edge.Angle *= scale;
    edge.Direction = std::polar(1.0, edge.Angle);
    projected.Add(Projection(mesh, this->Frames, v, edge.Vertex), edge.Direction, edge.Length);
  }
  const double offset = projected.Offset();
  const std::complex<double> turn = std::polar(1.0, offset);
  const auto neighbors = this->Neighbors.begin();
  for (std::size_t k = 0; k < edges.size(); ++k)
  {
    const auto place = std::lower_bound(
      neighbors + this->NeighborStart[v], neighbors + this->NeighborStart[v + 1], edges[k].Vertex);
    this->NeighborLogarithms[place - neighbors] = edges[k].Length * (turn * edges[k].Direction);
    if (first + static_cast<Index>(k) < last)
    {
      RingCorner& corner = this->Corners[this->RingCorners[first + static_cast<Index>(k)]];
      corner.Angle = offset + edges[k].Angle;
      corner.Scale = scale;
    }
  }
}

void OneRings::ConnectNeighbors()
{
  const auto unit = [](const std::complex<double>& z) { return z / std::abs(z); };
  this->Transport.resize(this->NeighborLogarithms.size());
  ParallelFor(this->NumberOfPoints(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<Index>(begin); v < end; ++v)
    {
      for (Index k = this->NeighborStart[v]; k < this->NeighborStart[v + 1]; ++k)
      {
        const Index w = this->Neighbors[k];
        const auto row = this->Neighbors.begin();
        const auto back = std::lower_bound(row + this->NeighborStart[w], row + this->NeighborStart[w + 1], v) - row;
        this->Transport[k] = -unit(this->NeighborLogarithms[back]) * std::conj(unit(this->NeighborLogarithms[k]));
      }
    }
  });
}

void OneRings::CornerLogarithms(const SurfacePlace* places, std::int64_t count, std::complex<double>* out) const
{
  const auto triangles = static_cast<Index>(this->Corners.size() / 3);
  ParallelFor(count, LogarithmGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t q = begin; q < end; ++q)
    {
      const Index f = places[q].Triangle;
      if (f < -1 || f >= triangles)
      {
        throw InvalidInput("OneRings::CornerLogarithms: place " + std::to_string(q) + " lies in triangle " +
          std::to_string(f) + "; expected an id in [0, " + std::to_string(triangles) + "), or -1 for no place.");
      }
      for (int k = 0; k < 3; ++k)
      {
        out[3 * q + k] = f < 0
          ? 0.0
          : this->Corners[3 * f + k].Logarithm(places[q].Weights[(k + 1) % 3], places[q].Weights[(k + 2) % 3]);
      }
    }
  });
}

double OneRings::RingRadius(Index v) const { return std::sqrt(this->Areas[v] / Pi); }

double MeanRingRadius(const OneRings& rings)
{
  Index used = 0;
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    used += rings.RingStart[v + 1] > rings.RingStart[v] ? 1 : 0;
  }
  return used > 0 ? std::sqrt(rings.Areas.sum() / 3.0 / (Pi * used)) : 0.0;
}

} // namespace surfsynth
