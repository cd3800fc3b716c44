// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Geometric textures grown on a mesh. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace surfsynth
{

/// What to grow.
struct GeometricTextureRequest
{
  int StartLevel = 0; ///< generator level that works on the mesh as it is, >= 0; above EndLevel: EndLevel
  int EndLevel = -1;  ///< last generator level; below 0 or too large: the model's last
  std::uint64_t Seed = 0;
  std::uint64_t SecondSeed = 0; ///< noise = cos(a) first + sin(a) second with a = Interpolation pi / 2: same variance
  double Interpolation = 0.0;   ///< in [0, 1]; 0 and 1 are the noise of the first and of the second seed, bit for bit
  std::uint32_t Stream = 0;     ///< see NormalKey::Stream
  double NoiseAmplitude = -1.0; ///< in mean edge lengths; below 0: the model's
  std::vector<bool> LevelsWithoutNoise; ///< by step, true for a level whose noise is 0; levels beyond have noise
  /// [V] of the mesh, in [0, 1]: displacements are multiplied by it, interpolated linearly on finer levels; empty: 1.
  /// Where it is 0 the mesh stays as it is, to the last bit.
  Eigen::VectorXf Mask;
};

/// The generator levels that work on a mesh, one after the other.
struct GeometricTextureLevelRange
{
  int First = 0;
  int Last = 0;

  int Count() const { return this->Last - this->First + 1; }
};

/// Those that a request wants of a model with so many levels. @throws InvalidInput when the first is below 0.
GeometricTextureLevelRange LevelsToSynthesize(const GeometricTextureRequest& request, std::int64_t levelsOfModel);

/// The mesh after one generator level.
struct GeometricTextureLevel
{
  TriangleMesh Mesh;        ///< in the caller's units
  int Level = 0;            ///< generator level that made it
  PointMatrix Displacement; ///< [V, 3], of this level alone, the caller's units
  PointMatrix Base;         ///< [V, 3], where the point would be without any displacement, the caller's units
};

/// Grows the texture of one model on meshes. A mesh is moved to the mean of its vertices and scaled to a mean edge
/// length of 1. At each level the network sees the mesh with noise, normals that are a function of (seed, stream,
/// level, component, vertex), and displaces the mesh without it; then, but for the last level, triangles are cut into
/// four and all is doubled, so that edges stay about 1 long. Tables are built once for each level; face convolutions
/// are two linear maps for each face, computed once and gathered: W [neighbour, self] + b = (W_n neighbour) + (W_s self
/// + b). Linear in the number of faces; results have the same bits for every number of threads.
class GeometricTextureSampler
{
public:
  /// @throws InvalidInput as CheckModel().
  explicit GeometricTextureSampler(std::shared_ptr<const GeometricTextureModel> model);

  /// Receives each level in turn, coarse to fine; the reference is only valid during the call.
  using Observer = std::function<void(const GeometricTextureLevel& level)>;

  /// @param mesh what the texture is grown on; its edges should be about as long everywhere. The mean edge length sets
  /// the scale of the texture. Each level but the last is subdivided at midpoints.
  /// @returns the last level.
  /// @throws InvalidInput when the mesh has no triangle or does not meet Requirements(), the first level is below 0,
  /// the mask has the wrong size or it or the interpolation a value outside [0, 1], the finest mesh would have too many
  /// triangles, or the result is not finite; Cancelled.
  GeometricTextureLevel Synthesize(const TriangleMesh& mesh, const GeometricTextureRequest& request,
    const Observer& observe = {}, const Progress& progress = {}) const;

  /// Unconditional: grows from the model's template in its own units, below generator level @p randomFrom with the
  /// noise of the reconstruction (the stored one at level 0, none above), from it on with random noise; 0: random
  /// everywhere; the number of levels: the reconstruction of the reference.
  /// @throws InvalidInput as Synthesize(), when the model has no template, and when @p randomFrom is not between 0 and its
  /// levels.
  GeometricTextureLevel Generate(int randomFrom, const GeometricTextureRequest& request, const Observer& observe = {},
    const Progress& progress = {}) const;

  /// Finite, non-degenerate triangles, manifold edges, consistent winding. Any genus, open or closed, several
  /// components.
  static MeshRequirements Requirements();

private:
  std::shared_ptr<const GeometricTextureModel> Model;
};

} // namespace surfsynth
