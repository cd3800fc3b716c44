// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Levels of a surface for the training of diffusion in field latents [Mitchel2024]. No torch.
#pragma once

#include "Core/Tangent/TangentHierarchy.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

struct FieldNeighborhoods;
struct FieldSources;

/// One level of a surface with what guides the features there, and its edges by their sources for derivatives.
struct FieldLevel
{
  /// Builds the tables.
  /// @param rows [V], row of the embeddings of each vertex, or empty
  /// @param directions [V, 2], or empty
  FieldLevel(TangentNeighborhoods neighborhoods, std::vector<std::int32_t> rows, FieldLatentMatrix directions);

  /// Number of vertices, V.
  std::int64_t NumberOfVertices() const { return this->Neighborhoods.NumberOfVertices(); }
  /// Tables as the kernels read them. @param guided false to leave out labels and directions
  FieldNeighborhoods View(bool guided) const;
  /// Edges by their sources.
  FieldSources Sources() const;

  TangentNeighborhoods Neighborhoods;
  std::vector<std::int32_t> Rows; ///< [V], row of the embeddings: 0 without a label, else the label and 1; or empty
  FieldLatentMatrix Directions;   ///< [V, 2], in the frames of the vertices, or empty

private:
  std::vector<std::int32_t> SourceStart;   ///< [V + 1]
  std::vector<std::int32_t> SourceEdges;   ///< [E]
  std::vector<std::int32_t> SourceTargets; ///< [E]
};

/// Both levels of a surface. Coarse vertices have the labels and directions of their centers.
struct DiffusionSurface
{
  /// Builds the tables.
  /// @param conditions labels and directions of the vertices of @p surface, which fit it
  explicit DiffusionSurface(const TangentHierarchy& surface, const LatentDiffusionConditions& conditions = {});

  FieldLevel Fine;
  FieldLevel Coarse;
  std::vector<Index> Clusters;               ///< [V], coarse vertex of each vertex
  std::vector<std::complex<float>> ToCenter; ///< [V], parallel transport to the coarse vertex
  std::vector<Index> MemberStart;            ///< [W + 1], first of the members of each coarse vertex
  std::vector<Index> Members;                ///< [V], vertices by cluster
};

} // namespace surfsynth
