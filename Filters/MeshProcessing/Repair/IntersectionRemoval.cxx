// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/IntersectionRemoval.h"

#include "MeshProcessing/Repair/SelfIntersections.h"
#include "MeshProcessing/Repair/SurfaceExtent.h"

#include "Core/Mesh/MeshStatistics.h"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
using ComponentMap = CgalMesh::Property_map<CgalFace, std::size_t>;
constexpr std::size_t NoComponent = std::numeric_limits<std::size_t>::max();

/// Local removal works on small parts of a surface. With a larger fraction of intersecting triangles, such as two sheets
/// in one place, it takes very long and leaves little.
constexpr double LargestIntersectingFraction = 0.5;

/// A mesh after an attempt of the removal.
struct Attempt
{
  CgalMesh Mesh;
  std::int64_t Left = 0;
  std::int64_t Fragments = 0;
  double Loss = 0.0;
};

SurfaceExtent ExtentOf(const CgalMesh& mesh) { return MeasureExtent(FromCgalMesh(mesh), CGAL::is_closed(mesh)); }

/// The components that are the largest rest of one of the components before.
std::vector<bool> Successors(
  const CgalMesh& mesh, const ComponentMap& before, const ComponentMap& after, const std::vector<double>& area)
{
  std::map<std::size_t, std::size_t> successor;
  for (const CgalFace f : mesh.faces())
  {
    if (before[f] != NoComponent)
    {
      const auto place = successor.emplace(before[f], after[f]).first;
      place->second = area[after[f]] > area[place->second] ? after[f] : place->second;
    }
  }
  std::vector<bool> isSuccessor(area.size(), false);
  for (const auto& entry : successor)
  {
    isSuccessor[entry.second] = true;
  }
  return isSuccessor;
}

/// Removes the pieces that were cut off, when together they have at most @p largest of the area.
/// @return number of pieces removed
std::int64_t RemoveFragments(CgalMesh& mesh, const ComponentMap& before, double largest)
{
  namespace PMP = CGAL::Polygon_mesh_processing;
  auto after = mesh.add_property_map<CgalFace, std::size_t>("f:after", 0).first;
  std::vector<double> area(PMP::connected_components(mesh, after), 0.0);
  double total = 0.0;
  for (const CgalFace f : mesh.faces())
  {
    const double part = PMP::face_area(f, mesh);
    area[after[f]] += part;
    total += part;
  }
  const std::vector<bool> isSuccessor = Successors(mesh, before, after, area);
  std::vector<std::size_t> kept;
  double lost = 0.0;
  for (std::size_t c = 0; c < area.size(); ++c)
  {
    isSuccessor[c] ? kept.push_back(c) : static_cast<void>(lost += area[c]);
  }
  const bool isSmall = !kept.empty() && kept.size() < area.size() && lost <= largest * total;
  if (isSmall)
  {
    PMP::keep_connected_components(mesh, kept, after);
  }
  mesh.remove_property_map(after);
  return isSmall ? static_cast<std::int64_t>(area.size() - kept.size()) : 0;
}

Attempt TryRemoval(const CgalMesh& mesh, const SurfaceExtent& extent, bool preserveGenus, double maximumLoss,
  const std::atomic<bool>* stop)
{
  namespace PMP = CGAL::Polygon_mesh_processing;
  Attempt attempt;
  attempt.Mesh = mesh;
  auto before = attempt.Mesh.add_property_map<CgalFace, std::size_t>("f:before", NoComponent).first;
  PMP::connected_components(attempt.Mesh, before);
  try
  {
    PMP::experimental::remove_self_intersections(attempt.Mesh, CGAL::parameters::preserve_genus(preserveGenus));
  }
  catch (const CGAL::Failure_exception&)
  {
    attempt.Loss = std::numeric_limits<double>::infinity(); // a mesh in between two steps
    return attempt;
  }
  attempt.Fragments = RemoveFragments(attempt.Mesh, before, maximumLoss);
  attempt.Mesh.remove_property_map(before);
  attempt.Mesh.collect_garbage();
  attempt.Left = static_cast<std::int64_t>(FindIntersectingTriangles(FromCgalMesh(attempt.Mesh), stop).size());
  attempt.Loss = attempt.Mesh.number_of_faces() > 0 ? LargestLoss(extent, ExtentOf(attempt.Mesh)) : 1.0;
  return attempt;
}
} // namespace

IntersectionRemoval RemoveIntersections(CgalMesh& mesh, double maximumLoss, const std::atomic<bool>* stop)
{
  IntersectionRemoval removal;
  const std::vector<Index> intersecting = FindIntersectingTriangles(FromCgalMesh(mesh), stop);
  removal.Before = static_cast<std::int64_t>(intersecting.size());
  removal.Left = removal.Before;
  const double limit = LargestIntersectingFraction * static_cast<double>(mesh.number_of_faces());
  if (removal.Before == 0 || static_cast<double>(removal.Before) > limit)
  {
    return removal;
  }
  const TriangleMesh whole = FromCgalMesh(mesh);
  SurfaceExtent extent = MeasureExtent(whole, CGAL::is_closed(mesh));
  extent.Area -= SurfaceArea({ whole.Points, whole.Triangles(intersecting, Eigen::all) });
  CgalMesh best;
  for (const bool preserveGenus : { false, true })
  {
    Attempt attempt = TryRemoval(mesh, extent, preserveGenus, maximumLoss, stop);
    if (attempt.Loss > maximumLoss)
    {
      const double refused = std::min(attempt.Loss, 1.0);
      removal.RefusedLoss = removal.RefusedLoss > 0.0 ? std::min(removal.RefusedLoss, refused) : refused;
    }
    else if (attempt.Left < removal.Left)
    {
      removal.Left = attempt.Left;
      removal.Fragments = attempt.Fragments;
      best = std::move(attempt.Mesh);
    }
    if (removal.Left == 0)
    {
      break;
    }
  }
  if (removal.Left < removal.Before)
  {
    mesh = std::move(best);
  }
  return removal;
}

} // namespace surfsynth
