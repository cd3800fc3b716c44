// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/SelfIntersections.h"

#include "MeshProcessing/Cgal/CgalMesh.h"
#include "MeshProcessing/Repair/SoupRepair.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"

#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <array>

namespace surfsynth
{

namespace
{
namespace Boxes = CGAL::Box_intersection_d;
using TriangleBox = Boxes::Box_with_info_d<double, 3, Index, Boxes::ID_FROM_BOX_ADDRESS>;

/// The test of two triangles.
class IntersectionTest
{
public:
  explicit IntersectionTest(const TriangleMesh& mesh)
    : Mesh(mesh)
    , PointOf(EqualPoints(mesh.Points))
  {}

  bool IsProper(Index f) const
  {
    const auto c = this->Corners(f);
    const auto t = this->Mesh.Triangles.row(f);
    const bool isFinite = this->Mesh.Points.row(t(0)).allFinite() && this->Mesh.Points.row(t(1)).allFinite() &&
      this->Mesh.Points.row(t(2)).allFinite();
    return c[0] != c[1] && c[1] != c[2] && c[2] != c[0] && isFinite && !IsDegenerateTriangle(this->Mesh, f);
  }

  bool Intersect(Index f, Index g) const
  {
    std::array<Index, 3> a = this->Corners(f);
    std::array<Index, 3> b = this->Corners(g);
    // The shared corners come first, in the same order.
    std::size_t shared = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto found = std::find(b.begin() + static_cast<std::ptrdiff_t>(shared), b.end(), a[k]);
      if (found != b.end())
      {
        std::swap(*found, b[shared]);
        std::swap(a[k], a[shared]);
        ++shared;
      }
    }
    const CgalPoint p[] = { this->At(a[0]), this->At(a[1]), this->At(a[2]) };
    const CgalPoint q[] = { this->At(b[0]), this->At(b[1]), this->At(b[2]) };
    const CgalKernel::Triangle_3 first(p[0], p[1], p[2]);
    const CgalKernel::Triangle_3 second(q[0], q[1], q[2]);
    switch (shared)
    {
      case 0:
        return CGAL::do_intersect(first, second);
      case 1: // beyond the shared corner they intersect at the side opposite to it
        return CGAL::do_intersect(CgalKernel::Segment_3(p[1], p[2]), second) ||
          CGAL::do_intersect(CgalKernel::Segment_3(q[1], q[2]), first);
      case 2: // folded onto each other
        return CGAL::coplanar(p[0], p[1], p[2], q[2]) &&
          CGAL::coplanar_orientation(p[0], p[1], p[2], q[2]) == CGAL::POSITIVE;
      default: // duplicates
        return false;
    }
  }

private:
  std::array<Index, 3> Corners(Index f) const
  {
    const auto t = this->Mesh.Triangles.row(f);
    return { this->PointOf[t(0)], this->PointOf[t(1)], this->PointOf[t(2)] };
  }
  CgalPoint At(Index p) const { return ToCgalPoint(this->Mesh.Points.row(p).transpose()); }

  const TriangleMesh& Mesh;
  std::vector<Index> PointOf; ///< lowest point of the same coordinates
};

constexpr std::ptrdiff_t BoxCutoff = 2000; ///< CGAL's own for meshes

/// Boxes of the proper ones of @p count triangles, the k-th of which is @p triangle(k).
template <typename Triangle>
std::vector<TriangleBox> BoxesOf(
  const TriangleMesh& mesh, const IntersectionTest& test, std::size_t count, const Triangle& triangle)
{
  std::vector<TriangleBox> boxes;
  boxes.reserve(count);
  for (std::size_t k = 0; k < count; ++k)
  {
    const Index f = triangle(k);
    if (test.IsProper(f))
    {
      const auto t = mesh.Triangles.row(f);
      const auto corner = [&](int c) { return ToCgalPoint(mesh.Points.row(t(c)).transpose()).bbox(); };
      boxes.emplace_back(corner(0) + corner(1) + corner(2), f);
    }
  }
  return boxes;
}

std::vector<TriangleBox> BoxesOf(const TriangleMesh& mesh, const IntersectionTest& test)
{
  return BoxesOf(mesh, test, static_cast<std::size_t>(mesh.NumberOfTriangles()),
    [](std::size_t k) { return static_cast<Index>(k); });
}

std::vector<const TriangleBox*> PointersTo(const std::vector<TriangleBox>& boxes)
{
  std::vector<const TriangleBox*> pointers;
  pointers.reserve(boxes.size());
  for (const TriangleBox& box : boxes)
  {
    pointers.push_back(&box);
  }
  return pointers;
}

void ThrowOnStop(const std::atomic<bool>* stop)
{
  if (stop && stop->load(std::memory_order_relaxed))
  {
    throw Cancelled("Stopped on request.");
  }
}

/// Calls @p visit for each pair of proper triangles whose boxes overlap, once.
/// @throws Cancelled
template <typename Visit>
void VisitOverlappingBoxes(
  const TriangleMesh& mesh, const IntersectionTest& test, const std::atomic<bool>* stop, const Visit& visit)
{
  const std::vector<TriangleBox> boxes = BoxesOf(mesh, test);
  std::vector<const TriangleBox*> pointers = PointersTo(boxes);
  const auto visitBoxes = [&](const TriangleBox* first, const TriangleBox* second) {
    ThrowOnStop(stop);
    visit(first->info(), second->info());
  };
  CGAL::box_self_intersection_d(pointers.begin(), pointers.end(), visitBoxes, BoxCutoff);
}
} // namespace

std::vector<Index> FindIntersectingTriangles(const TriangleMesh& mesh, const std::atomic<bool>* stop)
{
  const IntersectionTest test(mesh);
  std::vector<bool> isMarked(static_cast<std::size_t>(mesh.NumberOfTriangles()), false);
  VisitOverlappingBoxes(mesh, test, stop, [&](Index f, Index g) {
    if (!(isMarked[f] && isMarked[g]) && test.Intersect(f, g))
    {
      isMarked[f] = true;
      isMarked[g] = true;
    }
  });
  std::vector<Index> marked;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (isMarked[f])
    {
      marked.push_back(f);
    }
  }
  return marked;
}

std::vector<std::array<Index, 2>> FindIntersectingPairs(const TriangleMesh& mesh, const std::atomic<bool>* stop)
{
  const IntersectionTest test(mesh);
  std::vector<std::array<Index, 2>> pairs;
  VisitOverlappingBoxes(mesh, test, stop, [&](Index f, Index g) {
    if (test.Intersect(f, g))
    {
      pairs.push_back({ std::min(f, g), std::max(f, g) });
    }
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<std::array<Index, 2>> FindIntersectingPairsOf(
  const TriangleMesh& mesh, const std::vector<Index>& subset, const std::atomic<bool>* stop)
{
  const IntersectionTest test(mesh);
  std::vector<bool> isOfSubset(static_cast<std::size_t>(mesh.NumberOfTriangles()), false);
  for (const Index f : subset)
  {
    isOfSubset[f] = true;
  }
  const std::vector<TriangleBox> all = BoxesOf(mesh, test);
  const std::vector<TriangleBox> some = BoxesOf(mesh, test, subset.size(), [&](std::size_t k) { return subset[k]; });
  std::vector<const TriangleBox*> pointersToAll = PointersTo(all);
  std::vector<const TriangleBox*> pointersToSome = PointersTo(some);
  std::vector<std::array<Index, 2>> pairs;
  const auto visitBoxes = [&](const TriangleBox* first, const TriangleBox* second) {
    ThrowOnStop(stop);
    const Index f = first->info();
    const Index g = second->info();
    const bool isFirstVisit = f != g && (!isOfSubset[g] || f < g);
    if (isFirstVisit && test.Intersect(f, g))
    {
      pairs.push_back({ std::min(f, g), std::max(f, g) });
    }
  };
  CGAL::box_intersection_d(
    pointersToSome.begin(), pointersToSome.end(), pointersToAll.begin(), pointersToAll.end(), visitBoxes, BoxCutoff);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

} // namespace surfsynth
