// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Networks/LatentDiffusionNetworks.h"

#include <cmath>
#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
/// Adds blocks named 0, 1, ... to a module.
std::vector<FieldResidualBlock> AddFieldBlocks(torch::nn::Module& module, std::int64_t count, std::int64_t inputs,
  std::int64_t outputs, const LatentDiffusionOptions& options)
{
  std::vector<FieldResidualBlock> blocks;
  for (std::int64_t block = 0; block < count; ++block)
  {
    blocks.push_back(module.register_module(std::to_string(block),
      FieldResidualBlock(block == 0 ? inputs : outputs, outputs, options.EmbeddingDimension, options.Directed)));
  }
  return blocks;
}

/// Tangent vectors [V, 2 d] with parts in turn to parts apart, or back.
torch::Tensor PartsApart(const torch::Tensor& x)
{
  return x.view({ x.size(0), -1, 2 }).transpose(1, 2).reshape({ x.size(0), -1 });
}

torch::Tensor PartsInTurn(const torch::Tensor& x)
{
  return x.view({ x.size(0), 2, -1 }).transpose(1, 2).reshape({ x.size(0), -1 });
}

torch::Tensor ThroughBlocks(std::vector<FieldResidualBlock>& blocks, torch::Tensor x, const torch::Tensor& embeddings,
  const FieldLevelTensors& level)
{
  for (FieldResidualBlock& block : blocks)
  {
    x = block(x, embeddings, level);
  }
  return x;
}
} // namespace

LatentDenoisingNetworkImpl::LatentDenoisingNetworkImpl(const LatentDiffusionOptions& options)
  : Options(options)
{
  CheckOptions(options);
  const std::int64_t embedding = options.EmbeddingDimension;
  this->Time = this->register_module("time",
    torch::nn::Sequential(
      torch::nn::Linear(embedding, embedding), torch::nn::SiLU(), torch::nn::Linear(embedding, embedding)));
  if (options.NumberOfLabels > 0)
  {
    const auto labels = this->register_module("labels", std::make_shared<torch::nn::Module>());
    this->Labels = labels->register_parameter("weight", torch::zeros({ options.NumberOfLabels, embedding }));
  }
  this->Input = this->register_module("input", ComplexMap(InputVectors(options), options.Channels));
  this->InputBlocks = AddFieldBlocks(*this->Input, options.InputBlocks, options.Channels, options.Channels, options);
  const auto coarse = this->register_module("coarse", std::make_shared<torch::nn::Module>());
  this->CoarseBlocks = AddFieldBlocks(*coarse, options.CoarseBlocks, options.Channels, options.CoarseChannels, options);
  this->Output = this->register_module("output", ComplexMap(options.Channels, options.LatentDimension));
  this->OutputBlocks = AddFieldBlocks(
    *this->Output, options.OutputBlocks, options.CoarseChannels + options.Channels, options.Channels, options);
  this->InputGains = this->Input->register_module("gains", TimeGains(options.Channels, embedding));
  this->OutputGains = this->Output->register_module("gains", TimeGains(options.Channels, embedding));
}

/// Embeddings of vertices without a label, then of each label, [L + 1, e].
torch::Tensor LatentDenoisingNetworkImpl::Embeddings(double time, const torch::Tensor& like)
{
  const std::int64_t half = this->Options.EmbeddingDimension / 2;
  const torch::Tensor waves = torch::empty({ 1, 2 * half }, torch::kFloat64);
  double* to = waves.data_ptr<double>();
  for (std::int64_t k = 0; k < half; ++k)
  {
    const double angle = time * std::pow(10000.0, -static_cast<double>(k) / static_cast<double>(half));
    to[k] = std::cos(angle);
    to[half + k] = std::sin(angle);
  }
  const torch::Tensor embedding = this->Time->forward(waves.to(like.device(), like.scalar_type()));
  return this->Labels.defined() ? torch::cat({ embedding, embedding + this->Labels }) : embedding;
}

torch::Tensor LatentDenoisingNetworkImpl::forward(
  const torch::Tensor& state, double time, const std::shared_ptr<const DiffusionSurface>& surface, bool guided)
{
  const FieldLevelTensors fine(std::shared_ptr<const FieldLevel>(surface, &surface->Fine), guided, state);
  const FieldLevelTensors coarse(std::shared_ptr<const FieldLevel>(surface, &surface->Coarse), guided, state);
  const torch::Tensor embeddings = this->Embeddings(time, state);
  std::vector<torch::Tensor> seen = { state, TangentPairs(surface->Fine.Neighborhoods.Centroids, state) };
  if (this->Options.Directed)
  {
    const FieldLatentMatrix& directions = surface->Fine.Directions;
    seen.push_back(guided && directions.size() > 0 ? TangentPairs(directions.data(), directions.rows(), state)
                                                   : torch::zeros_like(seen[1]));
  }
  const torch::Tensor entered = this->Input(PartsApart(torch::cat(seen, 1))) *
    this->InputGains(embeddings).repeat({ 2 });
  const torch::Tensor x = ThroughBlocks(this->InputBlocks, entered, embeddings, fine);
  const torch::Tensor y = ThroughBlocks(this->CoarseBlocks, PoolFields(surface, x), embeddings, coarse);
  const std::vector<torch::Tensor> own = x.chunk(2, -1);
  const std::vector<torch::Tensor> below = UnpoolFields(surface, y).chunk(2, -1);
  const torch::Tensor both = torch::cat({ below[0], own[0], below[1], own[1] }, -1);
  const torch::Tensor left = ThroughBlocks(this->OutputBlocks, both, embeddings, fine);
  return PartsInTurn(this->Output(left * this->OutputGains(embeddings).repeat({ 2 })));
}

LatentDenoisingNetwork MakeLatentDenoisingNetwork(const LatentDiffusionModel& model)
{
  CheckModel(model);
  LatentDenoisingNetwork network(model.Options);
  const torch::NoGradGuard noGradients;
  for (auto& parameter : network->named_parameters())
  {
    const ModelTensor& tensor = model.Tensors.at(parameter.key());
    parameter.value().copy_(torch::from_blob(const_cast<float*>(tensor.Values.data()), tensor.Shape, torch::kFloat32));
  }
  return network;
}

} // namespace surfsynth
