// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained geometric texture [Hertz2020], and its file. No torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Channels of the face convolutions of one level, input and output included: {4, 32, 32, 32, 32, 32, 3}.
using GeometricTextureChannels = std::vector<std::int64_t>;

/// Architecture of the networks. The channels of a level follow the published rule: 4, then max(min(start 2^level,
/// maximum) / 2^(i - 1), minimum) for i = 1 .. layers - 2, then 3 channels of a generator or 1 of a discriminator.
/// Divisions are of whole numbers.
struct GeometricTextureOptions
{
  std::int64_t Levels = 5;            ///< number of levels, 1 to 16
  std::int64_t Layers = 7;            ///< entries of the list of channels, 3 to 32: one more than convolutions
  std::int64_t StartChannels = 32;    ///< "start" of the rule, 1 to 4096
  std::int64_t MinimumChannels = 32;  ///< "minimum" of the rule, 1 to 4096
  std::int64_t MaximumChannels = 128; ///< "maximum" of the rule, 1 to 4096
  double NoiseAmplitude = 0.1; ///< standard deviation of each coordinate, in mean edge lengths of the level; >= 0
  /// 0: the network of a level maps a mesh with noise to displacements, as published. Above 0: it is the velocity of a
  /// flow from the noise to the displacements, integrated in so many steps; at most 1000.
  std::int64_t FlowSteps = 0;

  /// Channels of the generator of a level.
  GeometricTextureChannels GeneratorChannels(std::int64_t level) const;
  /// Channels of the discriminator of a level.
  GeometricTextureChannels DiscriminatorChannels(std::int64_t level) const;
};

/// Checks the options.
/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const GeometricTextureOptions& options);

/// Published names of the tensors of one convolution.
struct GeometricTextureTensorNames
{
  std::string Weight; ///< name of the weight
  std::string Bias;   ///< name of the bias
};
/// Names of the tensors of a convolution.
/// @param convolution 0 to layers - 2
GeometricTextureTensorNames NamesOfConvolution(std::int64_t level, std::int64_t convolution, std::int64_t layers);

/// Names of the statistics of the channels after one convolution, which normalize them.
struct GeometricTextureStatisticsNames
{
  std::string Mean;     ///< name of the means
  std::string Variance; ///< name of the variances
};
/// Names of the statistics of the channels after a convolution: levels.L.layers.J.mean and .variance.
/// @param convolution 0 to layers - 3
GeometricTextureStatisticsNames NamesOfStatistics(std::int64_t level, std::int64_t convolution);

/// Shapes of the statistics of all channels of a generator that are normalized, [C'] each, or [FlowSteps, C'] of a flow, by
/// their names.
std::map<std::string, std::vector<std::int64_t>> ExpectedGeometricTextureStatistics(
  const GeometricTextureOptions& options);

/// Shapes of all tensors of a generator or discriminator, by their published names: levels.L.layers.J.0.conv.weight
/// [C', C, 1] and .bias [C'], and levels.L.layers.J.conv.* of the last convolution. Input channels of the first are 4,
/// of the others twice the channels before.
std::map<std::string, std::vector<std::int64_t>> ExpectedGeometricTextureTensors(
  const GeometricTextureOptions& options, bool discriminator);

/// A generator of displacements, level by level, with the template it was trained on.
struct GeometricTextureModel
{
  GeometricTextureOptions Options; ///< architecture
  std::map<std::string, ModelTensor>
    Generator; ///< by published names; exactly those of ExpectedGeometricTextureTensors()
  std::map<std::string, ModelTensor> Discriminator; ///< by published names, or empty: only continued training needs it
  /// Mean and variance of each channel of the generator on surfaces like the reference, by the names of
  /// ExpectedGeometricTextureStatistics(): they normalize the channels on any other surface; of a flow for each of its steps.
  /// Empty in files without them, as published: channels are then normalized by what they are on the surface itself.
  std::map<std::string, ModelTensor> Statistics;
  /// Template of level 0, in units of the mean edge length of the reference mesh; empty in files without one (converted
  /// ones). Meets GeometricTextureSampler::Requirements().
  TriangleMesh Template;
  /// [V of Template, 3], noise that gives the reference, but of a flow, which does not reconstruct; empty without a template
  SinglePoints ReconstructionNoise;
  std::string Name;                            ///< name of the texture, for people
  std::map<std::string, std::string> Metadata; ///< metadata of the file, unchanged

  std::string Description() const; ///< description in one line: name, levels, channels, template
};

/// Reads a model file: safetensors with the metadata `architecture` ("geometric_texture"), `format_version` ("1", or
/// "2" of a flow), `geometric_texture` (a JSON object with the numbers levels, layers, start_channels, least_channels,
/// most_channels, noise_amplitude, in format version 2 flow_steps, and the string name) and the tensors levels.* of the
/// generator under their published names, statistics.levels.*, discriminator.levels.*, template.points [V, 3],
/// template.triangles [F, 3] (integers) and reconstruction_noise [V, 3], of which all but the first may be absent, the
/// three of the template together.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a number is
/// not finite; ModelMismatch when it is another kind of model.
GeometricTextureModel ReadGeometricTexture(const std::string& path);

/// Checks a model.
/// @throws InvalidInput naming the parts that do not fit together.
void CheckModel(const GeometricTextureModel& model);

/// Writes a model file, weights and noise in float32, points in float64.
/// @throws InvalidInput as CheckModel(), and when the file cannot be written.
void WriteGeometricTexture(const std::string& path, const GeometricTextureModel& model);

} // namespace surfsynth
