// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Places of a mesh on its subdivision at midpoints, whose points have moved since.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <optional>
#include <vector>

namespace surfsynth
{

/// Map of the places of a mesh to a mesh that SubdivideAtMidpoints() has made of it, zero times or more often, and whose
/// points may then have moved anywhere. Seams of either mesh, where points are doubled, do not matter.
class SubdivisionPlaces
{
public:
  /// Recognizes a subdivision by the order of its triangles and the points that they share.
  /// @param classes of the points of @p mesh that lie at one place: see WeldPoints()
  /// @return nothing when @p subdivided is no subdivision of @p mesh.
  static std::optional<SubdivisionPlaces> Find(
    const TriangleMesh& mesh, const std::vector<Index>& classes, const TriangleMesh& subdivided);

  /// Number of subdivisions, at least 0.
  int NumberOfLevels() const { return this->Levels; }

  /// Returns the same place on the subdivided mesh.
  SurfacePlace OnSubdivision(const SurfacePlace& place) const;

private:
  SubdivisionPlaces(Index triangles, int levels)
    : Triangles(triangles)
    , Levels(levels)
  {}

  Index Triangles;
  int Levels;
};

} // namespace surfsynth
