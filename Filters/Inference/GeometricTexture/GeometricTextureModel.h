// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained geometric texture, and its file: "Deep Geometric Texture Synthesis" (Hertz et al. 2020). No torch.
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

/// The published rule: 4, then max(min(start 2^level, most) / 2^(i - 1), least) for i = 1 .. layers - 2, then 3
/// channels of a generator or 1 of a discriminator. Divisions are of whole numbers.
struct GeometricTextureOptions
{
  std::int64_t Levels = 5;         ///< 1 to 16
  std::int64_t Layers = 7;         ///< entries of the list of channels, 3 to 32: one more than convolutions
  std::int64_t StartChannels = 32; ///< 1 to 4096, as the next two
  std::int64_t MinimumChannels = 32;
  std::int64_t MaximumChannels = 128;
  double NoiseAmplitude = 0.1; ///< standard deviation of each coordinate, in mean edge lengths of the level; >= 0

  GeometricTextureChannels GeneratorChannels(std::int64_t level) const;
  GeometricTextureChannels DiscriminatorChannels(std::int64_t level) const;
};

/// @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const GeometricTextureOptions& options);

/// The published names of the tensors of one convolution.
struct GeometricTextureTensorNames
{
  std::string Weight;
  std::string Bias;
};
/// @param convolution 0 to layers - 2
GeometricTextureTensorNames NamesOfConvolution(std::int64_t level, std::int64_t convolution, std::int64_t layers);

/// Shapes of all tensors of a generator or discriminator, by their published names: levels.L.layers.J.0.conv.weight
/// [C', C, 1] and .bias [C'], and levels.L.layers.J.conv.* of the last convolution. Input channels of the first are 4,
/// of the others twice the channels before.
std::map<std::string, std::vector<std::int64_t>> ExpectedGeometricTextureTensors(
  const GeometricTextureOptions& options, bool discriminator);

/// A generator of displacements, level by level, with the template it was trained on.
struct GeometricTextureModel
{
  GeometricTextureOptions Options;
  std::map<std::string, ModelTensor>
    Generator; ///< by published names; exactly those of ExpectedGeometricTextureTensors()
  std::map<std::string, ModelTensor> Discriminator; ///< the same, or empty: needed to go on training only
  /// Of level 0, in units in which edges of the reference mesh are 1 long in the mean; empty in files without one
  /// (converted ones). Meets GeometricTextureSampler::Requirements().
  TriangleMesh Template;
  SinglePoints ReconstructionNoise; ///< [V of Template, 3], what reconstructs the reference; empty without a template
  std::string Name;                 ///< of the texture, for people
  std::map<std::string, std::string> Metadata; ///< of the file, as it was

  std::string Description() const; ///< one line: name, levels, channels, template
};

/// Reads a model file: safetensors with the metadata `architecture` ("geometric_texture"), `format_version` ("1"),
/// `geometric_texture` (a JSON object with the numbers levels, layers, start_channels, least_channels, most_channels,
/// noise_amplitude and the string name) and the tensors levels.* of the generator under their published names,
/// discriminator.levels.*, template.points [V, 3], template.triangles [F, 3] (integers) and reconstruction_noise [V,
/// 3], of which the last four may be absent, the three of the template together.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a number is
/// not finite; ModelMismatch when it is another kind of model, naming what was found and what was expected.
GeometricTextureModel ReadGeometricTexture(const std::string& path);

/// @throws InvalidInput naming what does not fit together.
void CheckModel(const GeometricTextureModel& model);

/// Writes a model file, weights and noise in float32, points in float64. @throws InvalidInput as CheckModel(), and when
/// the file cannot be written.
void WriteGeometricTexture(const std::string& path, const GeometricTextureModel& model);

} // namespace surfsynth
