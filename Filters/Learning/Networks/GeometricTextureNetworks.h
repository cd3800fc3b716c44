// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Generator and discriminator of geometric textures with LibTorch: differentiable, for training. "Deep Geometric Texture
/// Synthesis" (Hertz et al. 2020).
#pragma once

#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

#include <cstddef>
#include <map>
#include <string>

namespace surfsynth
{

/// The face convolutions of one level: those of blocks with norm and activation, named layers.J.0, and a last one without,
/// named layers.J.
class GeometricTextureLevelNetworkImpl : public torch::nn::Module
{
public:
  /// @param channels of edges, of triangles after each convolution, of the result: at least 3.
  explicit GeometricTextureLevelNetworkImpl(const GeometricTextureChannels& channels);
  /// @param features [F, 12] of EdgeFeatureTensor(). @returns [F, channels.back()]
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);

private:
  torch::nn::ModuleList Layers;
};
TORCH_MODULE(GeometricTextureLevelNetwork);

/// A network for each level, named levels.L: names and shapes of the parameters are those of ExpectedGeometricTextureTensors().
class GeometricTextureNetworkImpl : public torch::nn::Module
{
public:
  /// @throws InvalidInput as CheckOptions().
  GeometricTextureNetworkImpl(const GeometricTextureOptions& options, bool discriminator);

  GeometricTextureLevelNetworkImpl& Level(std::size_t level)
  {
    return *this->Levels[level]->as<GeometricTextureLevelNetworkImpl>();
  }

private:
  torch::nn::ModuleList Levels;
};
TORCH_MODULE(GeometricTextureNetwork);

/// Positions after a generator level: @p positions [V, 3] moved by what the level makes of their features, @p noise
/// [V, 3] having been added to the positions that features are computed from. Undefined noise is none.
torch::Tensor Displaced(GeometricTextureLevelNetworkImpl& level, const FaceTables& tables,
  const torch::Tensor& positions, const torch::Tensor& noise = {});

/// The networks of a model, in float32 on the processor. @throws InvalidInput as CheckModel(), and when there is no
/// discriminator.
GeometricTextureNetwork MakeGeometricTextureGenerator(const GeometricTextureModel& model);
GeometricTextureNetwork MakeGeometricTextureDiscriminator(const GeometricTextureModel& model);

/// A network with these parameters, which are those of ExpectedGeometricTextureTensors().
GeometricTextureNetwork MakeGeometricTextureNetwork(
  const GeometricTextureOptions& options, bool discriminator, const std::map<std::string, ModelTensor>& tensors);

/// The parameters of a network as a model holds them, rounded to float32.
std::map<std::string, ModelTensor> GeometricTextureTensorsOf(GeometricTextureNetworkImpl& network);

} // namespace surfsynth
