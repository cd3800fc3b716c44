// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/UsedPoints.h"

#include <algorithm>

namespace surfsynth
{

UsedPoints::UsedPoints(const TriangleMesh& mesh)
{
  std::vector<char> used(static_cast<std::size_t>(mesh.NumberOfPoints()), 0);
  for (Eigen::Index k = 0; k < mesh.Triangles.size(); ++k)
  {
    used[static_cast<std::size_t>(mesh.Triangles.data()[k])] = 1;
  }
  this->Number = static_cast<Index>(std::count(used.begin(), used.end(), 1));
  if (this->Number == mesh.NumberOfPoints())
  {
    return;
  }
  this->Ids.reserve(static_cast<std::size_t>(this->Number));
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    if (used[static_cast<std::size_t>(v)])
    {
      this->Ids.push_back(v);
    }
  }
}

TriangleMesh UsedPoints::Compact(const TriangleMesh& mesh) const
{
  if (this->All())
  {
    return mesh;
  }
  std::vector<Index> place(static_cast<std::size_t>(mesh.NumberOfPoints()), -1);
  TriangleMesh compact;
  compact.Points.resize(this->Number, 3);
  for (Index k = 0; k < this->Number; ++k)
  {
    place[static_cast<std::size_t>(this->Id(k))] = k;
    compact.Points.row(k) = mesh.Points.row(this->Id(k));
  }
  compact.Triangles = mesh.Triangles.unaryExpr([&](Index v) { return place[static_cast<std::size_t>(v)]; });
  return compact;
}

} // namespace surfsynth
