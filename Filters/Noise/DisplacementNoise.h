// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random displacements of surfaces, and the points that they move. Private to the module.
#pragma once

#include "BlockCache.h"
#include "SurfaceBridge.h"

#include "Core/Noise/SurfaceDisplacement.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkDataObject;

namespace surfsynth
{

/// Displacements of the surfaces of the last update, with the normals of each, which are kept while the mesh stays the
/// same.
class DisplacementNoise
{
public:
  /// Begins an update with these directions; none for fields that are no displacements.
  void Begin(std::optional<DisplacementDirections> directions);
  /// Forgets what the update has not used.
  void DropUnused() { this->Blocks.DropUnused(); }
  /// True when the fields are displacements.
  bool IsOn() const { return this->Directions.has_value(); }

  /// Returns the displacement of a surface; null when IsOn() is false.
  /// @throws InvalidInput when the directions need normals and triangles of the surface are not wound alike.
  std::shared_ptr<const SurfaceDisplacement> Of(const Surface& surface);

  /// Replaces fields by displacements, and counts the triangles that they invert.
  /// @param samples 3 V doubles for each sample
  /// @return "", or a warning of inverted triangles
  std::string Finish(
    const Surface& surface, const SurfaceDisplacement& displacement, const std::vector<double*>& samples);

  /// Number of triangles that the samples since Begin() invert, all together.
  std::int64_t NumberOfInvertedTriangles() const { return this->Inverted; }

private:
  std::optional<DisplacementDirections> Directions;
  BlockCache<std::shared_ptr<const SurfaceDisplacement>> Blocks;
  std::int64_t Inverted = 0;
};

/// Moves the points of the surfaces of @p output, a vtkPolyData or a tree of them, by their point array @p name, and
/// drops their normals. Points stay in single or double precision; surfaces without the array stay as they are.
void MovePointsBy(vtkDataObject* output, const std::string& name);

} // namespace surfsynth
