// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/EdgeDistances.h"

#include "Core/Common/Errors.h"

#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <utility>

namespace surfsynth
{

Eigen::VectorXd EdgeDistances(const TriangleMesh& mesh, const MeshTopology& topology, const std::vector<Index>& sources)
{
  Eigen::VectorXd distances = Eigen::VectorXd::Constant(mesh.NumberOfPoints(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, Index>; // nearest first, then the lowest vertex: the order is always the same
  std::priority_queue<Reached, std::vector<Reached>, std::greater<Reached>> front;
  for (const Index source : sources)
  {
    if (source < 0 || source >= mesh.NumberOfPoints())
    {
      throw InvalidInput("EdgeDistances: source " + std::to_string(source) + " is no vertex; expected 0 to " +
        std::to_string(mesh.NumberOfPoints() - 1) + ".");
    }
    distances[source] = 0.0;
    front.emplace(0.0, source);
  }
  while (!front.empty())
  {
    const auto [distance, vertex] = front.top();
    front.pop();
    if (distance > distances[vertex])
    {
      continue; // was reached on a shorter path since
    }
    for (Index k = topology.NeighborStart[vertex]; k < topology.NeighborStart[vertex + 1]; ++k)
    {
      const Index other = topology.Neighbors[k];
      const double through = distance + (mesh.Points.row(other) - mesh.Points.row(vertex)).stableNorm();
      if (through < distances[other])
      {
        distances[other] = through;
        front.emplace(through, other);
      }
    }
  }
  return distances;
}

double MeanEdgeLength(const TriangleMesh& mesh, const MeshTopology& topology)
{
  double sum = 0.0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    for (Index k = topology.NeighborStart[v]; k < topology.NeighborStart[v + 1]; ++k)
    {
      const Index w = topology.Neighbors[k];
      sum += v < w ? (mesh.Points.row(v) - mesh.Points.row(w)).stableNorm() : 0.0;
    }
  }
  return sum / static_cast<double>(topology.NumberOfEdges());
}

} // namespace surfsynth
