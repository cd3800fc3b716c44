// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Geometric texture of one model on one surface, synthesized once and kept.
#pragma once

#include "GeometricTextureAdjustment.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/UsedPoints.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Parameters of a texture, except the model and the surface.
struct GeometricTextureSettings
{
  GeometricTextureRequest Request; ///< without the mask, the blend and the sizes
  int Subdivisions = 0;            ///< number of subdivisions at midpoints before the synthesis
  Eigen::VectorXf Mask;            ///< of the used points of the surface, in [0, 1]; empty for 1
  double MaskFalloff = 0.0;        ///< see SoftenMask()
  Eigen::VectorXf Blend;           ///< of the used points, the share of the second model; empty without one
  Eigen::VectorXf Sizes;           ///< of the used points, see GeometricTextureRequest; empty for equal ones
  std::optional<int> RandomFrom;   ///< the surface is the model's template: see GeometricTextureSampler::Generate()
  bool AllLevels = false;          ///< keep all levels, not only the last
};

/// Levels of a synthesized texture, with the parameters that they depend on.
class GeometricTextureResult
{
public:
  /// Synthesizes the texture on the used points of @p mesh.
  /// @throws the errors of GeometricTextureSampler; InvalidInput before any work when there would be too many
  /// triangles.
  GeometricTextureResult(std::shared_ptr<const GeometricTextureModel> model, const TriangleMesh& mesh,
    const GeometricTextureSettings& settings, const Progress& progress);

  /// Returns true when another synthesis on the same mesh would give this result, with all levels of @p settings.
  bool Is(const GeometricTextureModel& model, const GeometricTextureSettings& settings) const;

  /// Changes the kept levels as @p adjustment says, in place of earlier changes; costs nothing when it says the same.
  /// @param mesh that of the constructor @throws the errors of MakePrintable()
  void Adjust(const TriangleMesh& mesh, const GeometricTextureAdjustment& adjustment, const Progress& progress);

  /// Returns the number of finished levels.
  int NumberOfSteps() const { return static_cast<int>(this->PointsOfStep.size()); }
  /// Returns the surface after @p step + 1 steps; other than the last only with AllLevels.
  const GeometricTextureLevel& Level(int step) const;
  /// Returns what an adjustment to a printable surface has left after @p step + 1 steps; nothing without one.
  std::optional<GeometricTexturePrintability> Printability(int step) const;
  /// Returns the generator level at whose resolution a point of any level appears first.
  int LevelOfPoint(Index point) const;

private:
  /// Returns the place of a step among the kept levels.
  std::size_t PlaceOf(int step) const;
  void Scale(const TriangleMesh& mesh, const GeometricTextureAdjustment& adjustment);
  void Separate(const Progress& progress);
  void ComputeDisplacementsOfLevels();

  std::shared_ptr<const GeometricTextureModel> Model;
  GeometricTextureSettings Settings;
  int FirstLevel = 0;
  std::vector<Index> PointsOfStep;
  std::vector<GeometricTextureLevel> Levels; ///< all, or the last
  GeometricTextureAdjustment Adjustment;
  std::vector<GeometricTextureLevel> AdjustedLevels;        ///< likewise; none without an adjustment
  std::vector<GeometricTexturePrintability> Printabilities; ///< of these; none without Printable
};

} // namespace surfsynth
