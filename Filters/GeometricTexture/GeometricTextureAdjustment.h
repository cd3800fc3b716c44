// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Changes of a synthesized texture that need no other synthesis.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <cstdint>

namespace surfsynth
{

/// Parameters of the changes; the defaults change nothing.
struct GeometricTextureAdjustment
{
  bool Printable = false; ///< no triangles intersect, see ReduceDisplacement()

  /// Returns true when nothing is changed.
  bool IsNone() const { return !this->Printable; }
  bool operator==(const GeometricTextureAdjustment& other) const { return this->Printable == other.Printable; }
};

/// What the change of a level to a printable surface has left.
struct GeometricTexturePrintability
{
  std::int64_t NumberOfPairsLeft = 0; ///< number of pairs of triangles that intersect
  double Height = 0.0;                ///< integral of the absolute height over the bare surface, cubic world units
  double HeightBefore = 0.0;          ///< the same before the change
};

/// Reduces the displacements of a level until no triangles intersect. The displacement of the level alone is not changed.
/// @throws InvalidInput when the library was built without CGAL; Cancelled
GeometricTexturePrintability MakePrintable(GeometricTextureLevel& level, const Progress& progress);

} // namespace surfsynth
