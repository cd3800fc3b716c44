// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Generator and discriminator of geometric textures [Hertz2020] with LibTorch: differentiable, for training.
#pragma once

#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Learning/Layers/EdgeFeatureTensors.h"

#include <torch/torch.h>

#include <cstddef>
#include <map>
#include <string>

namespace surfsynth
{

/// Face convolutions of one level: those of blocks with norm and activation, named layers.J.0, and a last one without,
/// named layers.J.
class GeometricTextureLevelNetworkImpl : public torch::nn::Module
{
public:
  /// Initialises the layers.
  /// @param channels numbers of channels of edges, of triangles after each convolution, of the result: at least 3.
  explicit GeometricTextureLevelNetworkImpl(const GeometricTextureChannels& channels);
  /// Evaluates the network, [F, channels.back()].
  /// @param features [F, 12] of EdgeFeatureTensor()
  torch::Tensor forward(const FaceTables& tables, const torch::Tensor& features);

private:
  torch::nn::ModuleList Layers;
};
TORCH_MODULE(GeometricTextureLevelNetwork);

/// A network for each level, named levels.L: names and shapes of the parameters are those of
/// ExpectedGeometricTextureTensors().
class GeometricTextureNetworkImpl : public torch::nn::Module
{
public:
  /// Initialises the networks of all levels of a generator or discriminator.
  /// @throws InvalidInput as CheckOptions().
  GeometricTextureNetworkImpl(const GeometricTextureOptions& options, bool discriminator);

  /// Network of a level, below the number of levels.
  GeometricTextureLevelNetworkImpl& Level(std::size_t level)
  {
    return *this->Levels[level]->as<GeometricTextureLevelNetworkImpl>();
  }

private:
  torch::nn::ModuleList Levels;
};
TORCH_MODULE(GeometricTextureNetwork);

/// Positions after a generator level, [V, 3]: @p positions [V, 3] moved by the displacements that the level computes
/// from the features of @p positions + @p noise. Undefined noise is none.
torch::Tensor Displaced(GeometricTextureLevelNetworkImpl& level, const FaceTables& tables,
  const torch::Tensor& positions, const torch::Tensor& noise = {});

/// Makes the generator of a model, in float32 on the processor.
/// @throws InvalidInput as CheckModel().
GeometricTextureNetwork MakeGeometricTextureGenerator(const GeometricTextureModel& model);
/// Makes the discriminator of a model, in float32 on the processor.
/// @throws InvalidInput as CheckModel(), and when there is no discriminator.
GeometricTextureNetwork MakeGeometricTextureDiscriminator(const GeometricTextureModel& model);

/// Makes a network with the parameters @p tensors, which are those of ExpectedGeometricTextureTensors().
GeometricTextureNetwork MakeGeometricTextureNetwork(
  const GeometricTextureOptions& options, bool discriminator, const std::map<std::string, ModelTensor>& tensors);

/// Copies the parameters of a network to tensors of a model, rounded to float32.
std::map<std::string, ModelTensor> GeometricTextureTensorsOf(GeometricTextureNetworkImpl& network);

} // namespace surfsynth
