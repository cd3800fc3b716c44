// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Restriction of a mesh to the points that triangles use.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// The points that triangles use. A network gets only these: a stray point, which may even be NaN, would take part in
/// norms and in the extent of the mesh.
class UsedPoints
{
public:
  /// Finds the used points of @p mesh, whose ids are in range.
  explicit UsedPoints(const TriangleMesh& mesh);

  /// True when triangles use all points.
  bool All() const { return this->Ids.empty(); }
  /// Number of used points.
  Index Count() const { return this->Number; }
  /// Id in the whole mesh of used point @p k, which is in [0, Count()).
  Index Id(Index k) const { return this->Ids.empty() ? k : this->Ids[static_cast<std::size_t>(k)]; }
  /// Returns @p mesh with the used points only, in their order.
  TriangleMesh Compact(const TriangleMesh& mesh) const;

private:
  Index Number = 0;
  std::vector<Index> Ids; ///< ascending; empty when all points are used
};

} // namespace surfsynth
