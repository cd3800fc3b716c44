// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Synthesis of geometric textures on a mesh [Hertz2020]. No torch.
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

/// Statistics that normalize the channels of the networks.
enum class NormStatistics
{
  Target,   ///< those of the channels on the target, as published
  Reference ///< those of the model, GeometricTextureModel::Statistics
};

/// Texture to synthesize: levels, noise and mask.
struct GeometricTextureRequest
{
  int StartLevel = 0;           ///< first generator level, for the mesh itself, from 0 to the last
  int EndLevel = -1;            ///< last generator level; below 0 or too large: the model's last
  std::uint64_t Seed = 0;       ///< seed of the noise
  std::uint64_t SecondSeed = 0; ///< noise = cos(a) first + sin(a) second with a = Interpolation pi / 2: same variance
  double Interpolation = 0.0;   ///< in [0, 1]; 0 and 1 are the noise of the first and of the second seed, bit for bit
  std::uint32_t Stream = 0;     ///< see NormalKey::Stream
  NormStatistics Statistics = NormStatistics::Target; ///< statistics of the norms
  /// Standard deviation, in mean edge lengths; below 0: the model's. A flow has learned from that alone, and where it
  /// begins with less or more noise, or none, it makes less or more of the texture.
  double NoiseAmplitude = -1.0;
  std::vector<bool> LevelsWithoutNoise; ///< by step, true for a level without noise; missing steps have noise
  /// Restarts of a flow at each level with noise, 0 to 20; below 0: 3. At the end of the flow the displacements are mixed
  /// with fresh noise as at half of its time, and go on from there to the end again: errors of the first part, as features
  /// that are too close to each other, are mended [Xu2023]. Not used by models that are no flows.
  int Restarts = -1;
  /// [V] of the mesh, in [0, 1]: factor of the displacements, interpolated linearly on finer levels; empty: 1. Vertices
  /// with 0 keep their place to the last bit. With NormStatistics::Target the networks of finer levels see the masked mesh,
  /// as published; with NormStatistics::Reference the mesh without a mask, so that where it is 1 nothing changes by it.
  Eigen::VectorXf Mask;
  /// Another model with as many levels, for a mixture of two textures on a mesh; null for none. At each level both
  /// networks take the same mesh and the same noise, each with the standard deviation of its training, and their
  /// displacements are added with the weights 1 - Blend and Blend.
  std::shared_ptr<const GeometricTextureModel> SecondModel;
  /// [V] of the mesh, in [0, 1]: share of the second model, interpolated linearly on finer levels. Where it is 0
  /// everywhere, or 1 everywhere, the result is that of one model to the last bit.
  Eigen::VectorXf Blend;
  /// [V] of the mesh, above 0, in proportion to the length of the edges around each vertex: the networks see each place
  /// in a unit of its own, so that a texture is as large as the edges there; interpolated linearly on finer levels;
  /// empty: edges are equally long.
  Eigen::VectorXf Sizes;
};

/// The generator levels that work on a mesh, one after the other.
struct GeometricTextureLevelRange
{
  int First = 0; ///< first generator level
  int Last = 0;  ///< last generator level

  /// Number of levels.
  int Count() const { return this->Last - this->First + 1; }
};

/// Finds the levels of a request in a model of @p levelsOfModel levels.
/// @throws InvalidInput when the first level is below 0 or above the last.
GeometricTextureLevelRange LevelsToSynthesize(const GeometricTextureRequest& request, std::int64_t levelsOfModel);

/// The mesh after one generator level.
struct GeometricTextureLevel
{
  TriangleMesh Mesh;        ///< in the caller's units
  int Level = 0;            ///< generator level that made it
  PointMatrix Displacement; ///< [V, 3], displacement of this level alone, the caller's units
  PointMatrix Base;         ///< [V, 3], positions without any displacement, the caller's units
};

/// Synthesizer of the texture of one model on meshes [Hertz2020]. A mesh is moved to the mean of its vertices and
/// scaled to a mean edge length of 1. At each level the network gets the mesh plus noise (normal numbers, a function of
/// seed, stream, level, component and vertex) and displaces the mesh without the noise. Then, except after the last
/// level, triangles are cut into four and all is doubled, so that edges stay about 1 long. The network of a flow
/// (GeometricTextureOptions::FlowSteps) is the velocity of the displacements, which begin as the noise: each of the steps
/// evaluates it on the mesh with the displacements so far. Linear in the number of faces, and of steps; results have the
/// same bits for every number of threads.
class GeometricTextureSampler
{
public:
  /// Keeps @p model.
  /// @throws InvalidInput as CheckModel().
  explicit GeometricTextureSampler(std::shared_ptr<const GeometricTextureModel> model);

  /// Receives each level in turn, coarse to fine; the reference is only valid during the call.
  using Observer = std::function<void(const GeometricTextureLevel& level)>;

  /// Synthesizes the texture on a mesh. Each level but the last is subdivided at midpoints.
  /// @param mesh target; its edges should have about the same length everywhere. The mean edge length sets the scale of
  /// the texture.
  /// @return the last level.
  /// @throws InvalidInput when the mesh has no triangle or does not meet Requirements(), the first level is below 0 or
  /// above the last, a model lacks the statistics that are asked for, both models have other numbers of levels, the
  /// mask or the blend has the wrong size, a size is not above 0, or they or the interpolation a value outside [0, 1],
  /// the finest mesh would have too many triangles, or the result is not finite; Cancelled.
  GeometricTextureLevel Synthesize(const TriangleMesh& mesh, const GeometricTextureRequest& request,
    const Observer& observe = {}, const Progress& progress = {}) const;

  /// Synthesizes the texture on the model's template, in its own units. Generator levels below @p randomFrom have the
  /// noise of the reconstruction (the stored one at level 0, none above), the others random noise. 0: a random sample;
  /// the number of levels: the reconstruction of the reference.
  /// @throws InvalidInput as Synthesize(), when the model has no template, and when @p randomFrom is not between 0 and
  /// its levels, or not 0 of a flow, which does not reconstruct.
  GeometricTextureLevel Generate(int randomFrom, const GeometricTextureRequest& request, const Observer& observe = {},
    const Progress& progress = {}) const;

  /// Requirements on a mesh: finite, non-degenerate triangles, manifold edges, consistent winding. Any genus, open or
  /// closed, several components.
  static MeshRequirements Requirements();

private:
  std::shared_ptr<const GeometricTextureModel> Model;
};

/// Measures the statistics of the channels of a generator on random samples of the reference: means over the triangles
/// of @p samples samples with the seeds 0, 1, ..., each normalized by itself.
/// @return GeometricTextureModel::Statistics
/// @throws InvalidInput as GeometricTextureSampler::Generate(), and for less than one sample; Cancelled.
std::map<std::string, ModelTensor> MeasureStatistics(
  const GeometricTextureModel& model, int samples = 8, const Progress& progress = {});
/// Measures them on as many samples of each of several references, given by their templates, level 0: means over all.
/// @throws InvalidInput as above, and without templates.
std::map<std::string, ModelTensor> MeasureStatistics(const GeometricTextureModel& model,
  const std::vector<TriangleMesh>& templates, int samples = 8, const Progress& progress = {});

} // namespace surfsynth
