// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A surface without the points that no triangle uses.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <vector>

namespace surfsynth
{

/// The points that triangles use: what a network is to see of a mesh, since a stray point, which may even be NaN, would
/// take part in norms and in the extent of the mesh.
class UsedPoints
{
public:
  explicit UsedPoints(const TriangleMesh& mesh);

  bool All() const { return this->Ids.empty(); }
  Index Count() const { return this->Number; }
  /// Id in the whole mesh of used point @p k.
  Index Id(Index k) const { return this->Ids.empty() ? k : this->Ids[static_cast<std::size_t>(k)]; }
  /// @p mesh with the used points only, in their order.
  TriangleMesh Compact(const TriangleMesh& mesh) const;

private:
  Index Number = 0;
  std::vector<Index> Ids; ///< ascending; empty when all points are used
};

} // namespace surfsynth
