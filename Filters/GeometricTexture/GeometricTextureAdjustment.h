// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Changes of a synthesized texture that need no other synthesis.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

#include <cstdint>

namespace surfsynth
{

/// Parameters of the changes; the defaults change nothing.
struct GeometricTextureAdjustment
{
  double Strength = 1.0;           ///< factor of the displacements, at least 0
  Eigen::VectorXf StrengthOfPoint; ///< another factor at the used points of the target, at least 0; empty for 1
  bool Printable = false;          ///< then no triangles intersect, see ReduceDisplacement()

  /// Returns true when displacements are multiplied.
  bool HasStrength() const { return this->Strength != 1.0 || this->StrengthOfPoint.size() > 0; }
  /// Returns true when nothing is changed.
  bool IsNone() const { return !this->HasStrength() && !this->Printable; }
  /// Returns true when both change the same.
  bool operator==(const GeometricTextureAdjustment& other) const;
};

/// Result of MakePrintable().
struct GeometricTexturePrintability
{
  std::int64_t NumberOfPairsLeft = 0; ///< number of pairs of triangles that intersect
  double Height = 0.0;                ///< integral of the absolute height over the bare surface, cubic world units
  double HeightBefore = 0.0;          ///< the same before the change
};

/// Multiplies the displacements of a level. Factors of 1 leave points as they are, and those of 0 put them onto the target, to
/// the last bit. The displacement of the level alone is not changed.
/// @param strength factor at all points @param strengthOfPoint another factor [V]; empty for 1
void ScaleDisplacement(GeometricTextureLevel& level, double strength, const Eigen::VectorXf& strengthOfPoint);

/// Checks that MakePrintable() is possible.
/// @throws InvalidInput when the library was built without CGAL
void RequirePrintability();

/// Reduces the displacements of a level until no triangles intersect. The displacement of the level alone is not changed.
/// Takes 4 to 10 microseconds for a triangle where few intersect, and a search around the moved triangles for each round of
/// ReduceDisplacement().
/// @throws InvalidInput as RequirePrintability(); Cancelled
GeometricTexturePrintability MakePrintable(GeometricTextureLevel& level, const Progress& progress);

} // namespace surfsynth
