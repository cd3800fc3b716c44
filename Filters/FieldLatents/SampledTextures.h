// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Parts of a block that the sampling of textures keeps from one update to the next. Private to the module.
#pragma once

#include "AtlasPlaces.h"
#include "LatentSamples.h"
#include "LatentTriangulation.h"
#include "SurfaceBridge.h"

#include "Core/Common/Progress.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

class vtkPolyData;

namespace surfsynth
{

struct SurfaceAtlas;

/// Atlas of a surface without texture coordinates, as vtkTextureAtlasFilter makes it.
class MadeAtlas
{
public:
  /// @param size width and height of the texture, texels
  /// @throws InvalidInput when the surface does not meet the requirements of an atlas or the library was built without
  /// CGAL; the errors of MakeSurfaceAtlas()
  MadeAtlas(vtkPolyData* input, const Surface& surface, const int size[2], const Progress& progress);

  /// True when it was made for a texture of this size.
  bool Is(const int size[2]) const { return this->Size[0] == size[0] && this->Size[1] == size[1]; }
  /// Fills @p output with the surface, its current arrays and the texture coordinates.
  void Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const;

private:
  std::array<int, 2> Size;
  std::shared_ptr<const SurfaceAtlas> Atlas;
};

/// Triangulation of a surface, and what was made of it.
struct PreparedTextures
{
  std::int64_t NumberOfPoints = 0; ///< asked for; 0 for the triangles of the surface
  std::unique_ptr<const LatentTriangulation> Triangulation;
  std::optional<AtlasPlaces> Atlas; ///< places of texels and points of the surface on Triangulation
  std::unique_ptr<LatentSamples> Samples;
};

} // namespace surfsynth
