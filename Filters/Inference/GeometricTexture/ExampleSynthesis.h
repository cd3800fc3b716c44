// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Synthesis of the geometric texture of an example on a mesh, without a training.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Texture to synthesize from an example.
struct ExampleSynthesisRequest
{
  /// Size of the texture on the target over that on the example, both in world units; 0: the mean edge length of the target,
  /// once subdivided, over that of the example.
  double Scale = 0.0;
  /// Number of subdivisions of the target, 0 to 8; -1: 2 where Scale is 0, else as many as make the edges nearly as long as
  /// those of the example at that scale.
  int Subdivisions = -1;
  std::uint64_t Seed = 0;   ///< of the random numbers
  std::uint32_t Stream = 0; ///< see NormalKey::Stream
  Eigen::VectorXf Sizes;    ///< [V] of the target, factors of Scale, above 0; interpolated linearly; empty: 1
  /// [V, 3] of the target, directions along which those of the example come to lie; empty for textures without direction.
  PointMatrix Directions;
  /// Second example, of as many scales; null for one alone. Must outlive the synthesis.
  const GeometricTextureExample* Second = nullptr;
  /// [V] of the target, 0 to 1, the share of the area that looks like the second example; empty without one.
  Eigen::VectorXf Blend;
};

/// Ends of the edges whose midpoints each subdivision of a mesh adds, in the order of the new points.
using SubdivisionParents = std::vector<std::vector<std::array<Index, 2>>>;

/// Result of SynthesizeFromExample().
struct ExampleSynthesis
{
  SubdivisionParents Parents;  ///< of the subdivisions of the target
  GeometricTextureLevel Level; ///< the target, subdivided and displaced; Level::Level is the number of subdivisions
  double Scale = 0.0;          ///< that was used, for the first example
  double Mismatch = 0.0;       ///< see MatchNearest(), at the finest scale
};

/// Synthesizes a texture from coarse scales to fine ones. At each scale patches of the target begin with the displacement of
/// the coarser one, or with random numbers; at the two coarsest ones the sliced Wasserstein distance of the patches from those
/// of the example is descended [Elnekave2022]; then each patch is replaced by the nearest one of the example, and the
/// displacement by the best fit to all patches [Kwatra2005], [Granot2022], several times, and stretched until the patches vary
/// as widely as those of the example.
///
/// With a second example the features of both are mixed, not their heights: each patch looks like one of one of them, in islands
/// about as wide as a feature of mean size, and overlapping patches agree on what lies between. Where the share of the second is
/// 0 everywhere, the texture is that of the first alone, to the last bit where both have the same spacing on the target.
///
/// Linear in the area over the square of the finest spacing; the same bits for every number
/// of threads.
/// @param mesh target; its triangles need not be even, but small enough once subdivided
/// @throws InvalidInput when the mesh has no triangle or does not meet GeometricTextureExample::Requirements(), a value of the
/// request is out of its range or of a wrong size, directions are given for an example without them or the other way round, the
/// examples have other numbers of scales, the scale does not fit the mesh, the finest mesh would have too many triangles, or the result is not finite; Cancelled
ExampleSynthesis SynthesizeFromExample(const GeometricTextureExample& example, const TriangleMesh& mesh,
  const ExampleSynthesisRequest& request, const Progress& progress = {});

} // namespace surfsynth
