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

/// The test of two triangles, and the marks of those that intersect.
class IntersectionMarker
{
public:
  IntersectionMarker(const TriangleMesh& mesh, const std::atomic<bool>* stop)
    : Mesh(mesh)
    , PointOf(EqualPoints(mesh.Points))
    , Stop(stop)
    , IsMarked(static_cast<std::size_t>(mesh.NumberOfTriangles()), false)
  {}

  bool IsProper(Index f) const
  {
    const auto c = this->Corners(f);
    const auto t = this->Mesh.Triangles.row(f);
    const bool isFinite = this->Mesh.Points.row(t(0)).allFinite() && this->Mesh.Points.row(t(1)).allFinite() &&
      this->Mesh.Points.row(t(2)).allFinite();
    return c[0] != c[1] && c[1] != c[2] && c[2] != c[0] && isFinite && !IsDegenerateTriangle(this->Mesh, f);
  }

  void operator()(const TriangleBox* first, const TriangleBox* second)
  {
    if (this->Stop && this->Stop->load(std::memory_order_relaxed))
    {
      throw Cancelled("Stopped on request.");
    }
    const Index f = first->info();
    const Index g = second->info();
    if (!(this->IsMarked[f] && this->IsMarked[g]) && this->Intersect(f, g))
    {
      this->IsMarked[f] = true;
      this->IsMarked[g] = true;
    }
  }

  std::vector<Index> Marked() const
  {
    std::vector<Index> marked;
    for (Index f = 0; f < static_cast<Index>(this->IsMarked.size()); ++f)
    {
      if (this->IsMarked[f])
      {
        marked.push_back(f);
      }
    }
    return marked;
  }

private:
  std::array<Index, 3> Corners(Index f) const
  {
    const auto t = this->Mesh.Triangles.row(f);
    return { this->PointOf[t(0)], this->PointOf[t(1)], this->PointOf[t(2)] };
  }
  CgalPoint At(Index p) const { return ToCgalPoint(this->Mesh.Points.row(p).transpose()); }

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

  const TriangleMesh& Mesh;
  std::vector<Index> PointOf; ///< lowest point of the same coordinates
  const std::atomic<bool>* Stop;
  std::vector<bool> IsMarked;
};
} // namespace

std::vector<Index> FindIntersectingTriangles(const TriangleMesh& mesh, const std::atomic<bool>* stop)
{
  IntersectionMarker marker(mesh, stop);
  std::vector<TriangleBox> boxes;
  boxes.reserve(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    if (marker.IsProper(f))
    {
      const auto t = mesh.Triangles.row(f);
      const auto corner = [&](int k) { return ToCgalPoint(mesh.Points.row(t(k)).transpose()).bbox(); };
      boxes.emplace_back(corner(0) + corner(1) + corner(2), f);
    }
  }
  std::vector<const TriangleBox*> pointers;
  pointers.reserve(boxes.size());
  for (const TriangleBox& box : boxes)
  {
    pointers.push_back(&box);
  }
  const std::ptrdiff_t cutoff = 2000; // CGAL's own for meshes
  CGAL::box_self_intersection_d(pointers.begin(), pointers.end(), std::ref(marker), cutoff);
  return marker.Marked();
}

} // namespace surfsynth
