// SPDX-License-Identifier: BSD-3-Clause
#include "PolygonTriangulation.h"

#include <vtkPoints.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>

namespace surfsynth
{

namespace
{
void WriteTriangle(Index a, Index b, Index c, Index* out)
{
  out[0] = a;
  out[1] = b;
  out[2] = c;
}

void WriteFan(const Index* ids, Index count, Index* triangles)
{
  for (Index k = 0; k + 2 < count; ++k)
  {
    WriteTriangle(ids[0], ids[k + 1], ids[k + 2], triangles + 3 * k);
  }
}

/// True when the triangles (a, b, c) and (a, c, d) have area and face the same way: the diagonal a - c lies inside.
bool DiagonalIsInside(
  const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d)
{
  const Eigen::Vector3d first = (b - a).cross(c - a);
  const Eigen::Vector3d second = (c - a).cross(d - a);
  const double scale = std::max({ (b - a).squaredNorm(), (c - a).squaredNorm(), (d - a).squaredNorm() });
  return std::min(first.norm(), second.norm()) > 1e-12 * scale && first.dot(second) > 0.0;
}

bool CutQuadrilateral(const PointMatrix& points, const Index* ids, Index* triangles)
{
  std::array<Eigen::Vector3d, 4> p;
  double extent = 0.0;
  for (int k = 0; k < 4; ++k)
  {
    p[k] = (points.row(ids[k]) - points.row(ids[0])).transpose();
    extent = std::max(extent, p[k].cwiseAbs().maxCoeff());
  }
  if (!(extent > 0.0) || !(extent < 1e300))
  {
    return false;
  }
  for (Eigen::Vector3d& q : p)
  {
    q /= extent;
  }
  const bool inside02 = DiagonalIsInside(p[0], p[1], p[2], p[3]);
  const bool inside13 = DiagonalIsInside(p[1], p[2], p[3], p[0]);
  const bool longer02 = (p[2] - p[0]).squaredNorm() > (p[3] - p[1]).squaredNorm();
  if (inside02 && !(inside13 && longer02))
  {
    WriteTriangle(ids[0], ids[1], ids[2], triangles);
    WriteTriangle(ids[0], ids[2], ids[3], triangles + 3);
    return true;
  }
  if (inside13)
  {
    WriteTriangle(ids[1], ids[2], ids[3], triangles);
    WriteTriangle(ids[1], ids[3], ids[0], triangles + 3);
    return true;
  }
  return false;
}
} // namespace

bool PolygonTriangulator::Triangulate(const PointMatrix& points, const Index* ids, Index count, Index* triangles)
{
  const bool finite = std::all_of(ids, ids + count, [&](Index id) { return points.row(id).allFinite(); });
  if (count == 3 || !finite)
  {
    WriteFan(ids, count, triangles);
    return true;
  }
  return count == 4 ? CutQuadrilateral(points, ids, triangles) : this->CutEars(points, ids, count, triangles);
}

bool PolygonTriangulator::CutEars(const PointMatrix& points, const Index* ids, Index count, Index* triangles)
{
  const Eigen::RowVector3d origin = points.row(ids[0]);
  double extent = 0.0;
  for (Index k = 0; k < count; ++k)
  {
    extent = std::max(extent, (points.row(ids[k]) - origin).cwiseAbs().maxCoeff());
  }
  if (!(extent > 0.0) || !(extent < 1e300))
  {
    return false;
  }
  this->Polygon->PointIds->SetNumberOfIds(count);
  this->Polygon->Points->SetDataTypeToDouble();
  this->Polygon->Points->SetNumberOfPoints(count);
  for (Index k = 0; k < count; ++k)
  {
    const Eigen::RowVector3d x = (points.row(ids[k]) - origin) / extent;
    this->Polygon->PointIds->SetId(k, k);
    this->Polygon->Points->SetPoint(k, x.data());
  }
  this->Corners->Reset();
  const bool cut = this->Polygon->Triangulate(this->Corners) != 0;
  if (!cut || this->Corners->GetNumberOfIds() != 3 * (static_cast<vtkIdType>(count) - 2))
  {
    return false;
  }
  for (vtkIdType k = 0; k < this->Corners->GetNumberOfIds(); ++k)
  {
    triangles[k] = ids[this->Corners->GetId(k)];
  }
  return true;
}

} // namespace surfsynth
