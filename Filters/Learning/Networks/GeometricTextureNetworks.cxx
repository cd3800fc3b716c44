// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Networks/GeometricTextureNetworks.h"

#include "Core/Common/Errors.h"
#include "Learning/Layers/FaceConvolution.h"

#include <vector>

namespace surfsynth
{

GeometricTextureLevelNetworkImpl::GeometricTextureLevelNetworkImpl(const GeometricTextureChannels& channels)
{
  this->Layers = this->register_module("layers", torch::nn::ModuleList());
  for (std::size_t k = 0; k + 1 < channels.size(); ++k)
  {
    const FaceConvolutionOptions convolution = FaceConvolutionOptions(channels[k], channels[k + 1]).of_edges(k == 0);
    if (k + 2 < channels.size())
    {
      this->Layers->push_back(FaceBlock(convolution));
    }
    else
    {
      this->Layers->push_back(FaceConvolution(convolution));
    }
  }
}

torch::Tensor GeometricTextureLevelNetworkImpl::forward(const FaceTables& tables, const torch::Tensor& features)
{
  const std::size_t blocks = this->Layers->size() - 1;
  torch::Tensor x = features;
  for (std::size_t k = 0; k < blocks; ++k)
  {
    x = this->Layers[k]->as<FaceBlockImpl>()->forward(tables, x);
  }
  return this->Layers[blocks]->as<FaceConvolutionImpl>()->forward(tables, x);
}

GeometricTextureNetworkImpl::GeometricTextureNetworkImpl(const GeometricTextureOptions& options, bool discriminator)
{
  CheckOptions(options);
  this->Levels = this->register_module("levels", torch::nn::ModuleList());
  for (std::int64_t level = 0; level < options.Levels; ++level)
  {
    this->Levels->push_back(GeometricTextureLevelNetwork(
      discriminator ? options.DiscriminatorChannels(level) : options.GeneratorChannels(level)));
  }
}

torch::Tensor Displaced(GeometricTextureLevelNetworkImpl& level, const FaceTables& tables,
  const torch::Tensor& positions, const torch::Tensor& noise)
{
  const torch::Tensor seen = noise.defined() ? positions + noise : positions;
  const torch::Tensor local = level.forward(tables, EdgeFeatureTensor(tables, seen));
  return positions + CornerDisplacement(tables, positions, local);
}

GeometricTextureNetwork MakeGeometricTextureNetwork(
  const GeometricTextureOptions& options, bool discriminator, const std::map<std::string, ModelTensor>& tensors)
{
  GeometricTextureNetwork network(options, discriminator);
  const torch::NoGradGuard noGradients;
  for (auto& parameter : network->named_parameters())
  {
    const ModelTensor& tensor = tensors.at(parameter.key());
    parameter.value().copy_(torch::from_blob(const_cast<float*>(tensor.Values.data()), tensor.Shape, torch::kFloat32));
  }
  return network;
}

GeometricTextureNetwork MakeGeometricTextureGenerator(const GeometricTextureModel& model)
{
  CheckModel(model);
  return MakeGeometricTextureNetwork(model.Options, false, model.Generator);
}

GeometricTextureNetwork MakeGeometricTextureDiscriminator(const GeometricTextureModel& model)
{
  CheckModel(model);
  if (model.Discriminator.empty())
  {
    throw InvalidInput(
      "MakeGeometricTextureDiscriminator: the model has no discriminator; expected one that was trained here.");
  }
  return MakeGeometricTextureNetwork(model.Options, true, model.Discriminator);
}

std::map<std::string, ModelTensor> GeometricTextureTensorsOf(GeometricTextureNetworkImpl& network)
{
  std::map<std::string, ModelTensor> tensors;
  for (const auto& parameter : network.named_parameters())
  {
    const torch::Tensor values = parameter.value().detach().to(torch::kCPU, torch::kFloat32).contiguous();
    const float* data = values.data_ptr<float>();
    tensors[parameter.key()] = { values.sizes().vec(), std::vector<float>(data, data + values.numel()) };
  }
  return tensors;
}

} // namespace surfsynth
