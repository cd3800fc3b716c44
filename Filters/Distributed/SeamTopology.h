// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Edges and connected components of a distributed mesh. Private to the library.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Distributed/VertexOwners.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// A rank's components as parts of those of the whole.
struct ComponentParts
{
  std::vector<double> Area; ///< [components of the rank], of the whole component, square world units
  std::vector<std::int64_t> EulerCharacteristic; ///< likewise
  std::vector<bool> Closed;                      ///< likewise
};

/// Puts the components of the ranks together where they share vertices. Each rank holds those on seams. Collective.
/// @param topology tables of the rank's mesh
/// @param components of the rank's mesh
/// @throws InvalidInput on all ranks when three or more triangles, of any ranks, share an edge.
ComponentParts JoinComponents(
  const VertexOwners& owners, const MergedPiece& piece, const MeshTopology& topology, const MeshComponents& components);

} // namespace surfsynth
