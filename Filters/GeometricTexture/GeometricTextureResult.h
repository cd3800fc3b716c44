// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The texture of one model on one surface, grown once and kept.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/UsedPoints.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <vector>

namespace surfsynth
{

/// All that a texture depends on, but for the model and the surface.
struct GeometricTextureSettings
{
  GeometricTextureRequest Request; ///< but for the mask
  int Subdivisions = 0;            ///< how often the surface is cut at midpoints first
  Eigen::VectorXf Mask;            ///< of the used points of the surface, in [0, 1]; empty for 1
  double MaskFalloff = 0.0;        ///< see SoftenMask()
  std::optional<int> RandomFrom;   ///< the surface is the model's template: see GeometricTextureSampler::Generate()
  bool AllLevels = false;          ///< whether all levels are to be kept, or only the last
};

class GeometricTextureResult
{
public:
  /// Grows the texture on the used points of @p mesh.
  /// @throws what GeometricTextureSampler throws; InvalidInput before any work when there would be too many triangles.
  GeometricTextureResult(std::shared_ptr<const GeometricTextureModel> model, const TriangleMesh& mesh,
    const GeometricTextureSettings& settings, const Progress& progress);

  /// Whether this is what another growth with the same mesh would give, with all levels that @p settings wants.
  bool Is(const GeometricTextureModel& model, const GeometricTextureSettings& settings) const;

  /// Number of levels that have grown.
  int NumberOfSteps() const { return static_cast<int>(this->PointsOfStep.size()); }
  /// The surface after so many steps and one more; other than the last only with AllLevels.
  const GeometricTextureLevel& Level(int step) const;
  /// Generator level at whose resolution each point of any level appears first.
  int LevelOfPoint(Index point) const;

private:
  std::shared_ptr<const GeometricTextureModel> Model;
  GeometricTextureSettings Settings;
  int FirstLevel = 0;
  std::vector<Index> PointsOfStep;
  std::vector<GeometricTextureLevel> Levels; ///< all, or the last
};

} // namespace surfsynth
