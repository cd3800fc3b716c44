// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Operators/ComponentCoupling.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/SharedProgress.h"
#include "Core/Mesh/TriangleTree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Distance of automatic pairs over the square root of the area.
constexpr double AutomaticDistance = 0.03;
/// Largest distance of a vertex from its place over that of the place from the component of the vertex.
constexpr double LargestRatio = 2.0;
/// Vertices whose places are searched for in one task.
constexpr std::int64_t PlacesOfTask = 256;

/// The place that a vertex is coupled to; no triangle for none.
/// @param own component of the vertex
NearestPlace FacingPlace(const TriangleTree& tree, Index own, const Eigen::Vector3d& vertex, double limit)
{
  NearestPlace nearest;
  nearest.SquaredDistance = limit * limit * (1.0 + 1e-12);
  tree.FindOutside(own, vertex, nearest);
  if (nearest.Place.Triangle >= 0)
  {
    // The way back is at least as long as 1 / LargestRatio of the way, when nothing nearer is found.
    NearestPlace back;
    back.SquaredDistance = nearest.SquaredDistance / (LargestRatio * LargestRatio);
    const double limitOfBack = back.SquaredDistance;
    tree.FindIn(own, nearest.Position, back);
    nearest.Place.Triangle = back.SquaredDistance < limitOfBack ? -1 : nearest.Place.Triangle;
  }
  return nearest;
}

/// Component of each triangle, [F].
std::vector<Index> ComponentsOfTriangles(const TriangleMesh& mesh, const MeshComponents& components)
{
  std::vector<Index> of(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    of[f] = components.OfVertex[mesh.Triangles(f, 0)];
  }
  return of;
}

void RequireOptions(const ComponentCoupling& coupling)
{
  if (!(coupling.Weight > 0.0 && std::isfinite(coupling.Weight)))
  {
    throw InvalidInput("FindCoupledPairs: the weight of the coupling is " + FormatNumber(coupling.Weight) +
      "; expected a finite number above 0.");
  }
  if (!(coupling.Distance >= 0.0 && std::isfinite(coupling.Distance)))
  {
    throw InvalidInput("FindCoupledPairs: the distance of the coupling is " + FormatNumber(coupling.Distance) +
      "; expected a finite number of at least 0.");
  }
}

/// Throws unless pairs join the components.
/// @param distance limit over the square root of the area
void RequireJoined(const std::vector<CoupledPair>& pairs, const MeshComponents& components, double distance)
{
  std::vector<Index> parent(static_cast<std::size_t>(components.Count));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](Index c) {
    while (parent[c] != c)
    {
      c = parent[c] = parent[parent[c]];
    }
    return c;
  };
  for (const CoupledPair& pair : pairs)
  {
    parent[root(components.OfVertex[pair.Vertex])] = root(components.OfVertex[pair.Corners[0]]);
  }
  Index apart = 0;
  Index first = -1;
  for (Index c = 1; c < components.Count; ++c)
  {
    if (root(c) != root(0))
    {
      ++apart;
      first = first < 0 ? c : first;
    }
  }
  if (apart > 0)
  {
    const auto point = std::find(components.OfVertex.begin(), components.OfVertex.end(), first);
    throw InvalidInput("FindCoupledPairs: " + std::to_string(apart) + " of " + std::to_string(components.Count) +
      " connected components lie farther than the coupling distance, " + FormatNumber(distance) +
      " times the square root of the area, from the first one and those that are coupled to it, the first of them at "
      "point " +
      std::to_string(point - components.OfVertex.begin()) +
      "; expected components near each other. Increase the coupling distance, or process the parts one by one "
      "(vtkPolyDataConnectivityFilter).");
  }
}
} // namespace

double LargestDistance(const ComponentCoupling& coupling, double area)
{
  return coupling.Distance > 0.0 ? coupling.Distance : AutomaticDistance * std::sqrt(area);
}

std::vector<CoupledPair> FindCoupledPairs(const TriangleMesh& mesh, const MeshComponents& components,
  const ComponentCoupling& coupling, const Progress& progress)
{
  RequireOptions(coupling);
  if (components.Count < 2)
  {
    return {};
  }
  const double area = std::accumulate(components.Area.begin(), components.Area.end(), 0.0);
  const double limit = LargestDistance(coupling, area);
  const TriangleTree tree(mesh, ComponentsOfTriangles(mesh, components));
  std::vector<NearestPlace> places(components.OfVertex.size());
  SharedProgress shared(progress, mesh.NumberOfPoints());
  const auto findPlaces = [&](std::int64_t task) {
    const std::int64_t begin = task * PlacesOfTask;
    const std::int64_t end = std::min<std::int64_t>(begin + PlacesOfTask, mesh.NumberOfPoints());
    for (std::int64_t v = begin; v < end; ++v)
    {
      const Index own = components.OfVertex[v];
      if (own >= 0)
      {
        places[v] = FacingPlace(tree, own, mesh.Points.row(v).transpose(), limit);
      }
    }
    shared.Advance(end - begin);
  };
  const std::int64_t tasks = (mesh.NumberOfPoints() + PlacesOfTask - 1) / PlacesOfTask;
  ParallelTasks(tasks, findPlaces, [&shared] { shared.Advance(0); });
  Report(progress, 1.0);
  std::vector<CoupledPair> pairs;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const SurfacePlace& place = places[v].Place;
    if (place.Triangle >= 0)
    {
      const auto corners = mesh.Triangles.row(place.Triangle);
      pairs.push_back({ v, { corners(0), corners(1), corners(2) }, place.Weights });
    }
  }
  RequireJoined(pairs, components, limit / std::sqrt(area));
  return pairs;
}

SparseMatrix CouplingMatrix(
  const TriangleMesh& mesh, const MeshTopology& topology, const ComponentCoupling& coupling, const Progress& progress)
{
  if (!coupling.IsOn)
  {
    return {};
  }
  const Eigen::VectorXd mass = LumpedMass(mesh, topology);
  const MeshComponents components = ComputeComponents(topology, mass);
  const std::vector<CoupledPair> pairs = FindCoupledPairs(mesh, components, coupling, progress);
  if (components.Count < 2)
  {
    return {};
  }
  const double total = mass.sum();
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (const CoupledPair& pair : pairs)
  {
    const Index vertices[4] = { pair.Vertex, pair.Corners[0], pair.Corners[1], pair.Corners[2] };
    const double values[4] = { 1.0, -pair.Weights[0], -pair.Weights[1], -pair.Weights[2] };
    const double weight = coupling.Weight * mass[pair.Vertex] / total;
    for (int i = 0; i < 4; ++i)
    {
      for (int j = 0; j < 4; ++j)
      {
        entries.emplace_back(vertices[i], vertices[j], weight * values[i] * values[j]);
      }
    }
  }
  SparseMatrix matrix(mesh.NumberOfPoints(), mesh.NumberOfPoints());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

MeshComponents CoupledAsOne(const MeshComponents& components)
{
  if (components.Count < 2)
  {
    return components;
  }
  MeshComponents one;
  one.Count = 1;
  for (const Index c : components.OfVertex)
  {
    one.OfVertex.push_back(c < 0 ? -1 : 0);
  }
  one.Area.push_back(std::accumulate(components.Area.begin(), components.Area.end(), 0.0));
  std::pair<double, std::int64_t> largest{ components.Area[0], components.EulerCharacteristic[0] };
  for (Index c = 1; c < components.Count; ++c)
  {
    largest = std::max(largest, { components.Area[c], components.EulerCharacteristic[c] });
  }
  one.EulerCharacteristic.push_back(largest.second);
  one.Closed.push_back(std::find(components.Closed.begin(), components.Closed.end(), false) == components.Closed.end());
  return one;
}

} // namespace surfsynth
