// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/LatentDiffusionLayers.h"

#include "Inference/FieldLatents/LatentDiffusionKernels.h"
#include "Learning/Layers/FusedFields.h"
#include "Learning/Layers/FusedLayers.h"
#include "Learning/Layers/KeptValue.h"

#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

torch::Tensor PlainFieldNeuron(const torch::Tensor& x, const torch::Tensor& scale, const torch::Tensor& logDelta,
  const torch::Tensor& key, const torch::Tensor& query)
{
  const std::vector<torch::Tensor> parts = x.chunk(2, -1);
  const torch::Tensor factor = torch::rsqrt((parts[0].square() + parts[1].square()).mean(0, true) + logDelta.exp());
  const torch::Tensor re = factor * (parts[0] * scale[0] - parts[1] * scale[1]);
  const torch::Tensor im = factor * (parts[0] * scale[1] + parts[1] * scale[0]);
  const auto mapped = [&](const torch::Tensor& map) {
    return std::pair<torch::Tensor, torch::Tensor>(
      torch::linear(re, map[0]) - torch::linear(im, map[1]), torch::linear(re, map[1]) + torch::linear(im, map[0]));
  };
  const auto [kr, ki] = mapped(key);
  const auto [qr, qi] = mapped(query);
  constexpr double delta = 1e-3;
  const torch::Tensor along = torch::relu(-(kr * qr + ki * qi)) / (kr.square() + ki.square() + delta);
  return torch::cat({ qr + along * kr, qi + along * ki }, -1);
}

/// Hidden outputs of the filters of a convolution, [E, C, 8].
torch::Tensor PlainFilters(const FieldLevelTensors& level, const variable_list& in)
{
  const torch::Tensor& x = in[InputX];
  const std::vector<torch::Tensor> parts = x.chunk(2, -1);
  const torch::Tensor inverse = torch::rsqrt(parts[0].square() + parts[1].square() + 1e-6);
  const torch::Tensor ur = (parts[0] * inverse).index_select(0, level.Sources);
  const torch::Tensor ui = (parts[1] * inverse).index_select(0, level.Sources);
  const auto angles = [&](const torch::Tensor& vectors, const torch::Tensor& weights) {
    const torch::Tensor vx = vectors.narrow(1, 0, 1);
    const torch::Tensor vy = vectors.narrow(1, 1, 1);
    return (ur * vx + ui * vy).unsqueeze(-1) * weights[0] + (ur * vy - ui * vx).unsqueeze(-1) * weights[1];
  };
  const torch::Tensor constant = in[InputShares].index_select(0, level.Rows) + level.Radii * in[InputRadius];
  torch::Tensor first = constant.unsqueeze(1) + angles(level.Logarithms, in[InputAligned]);
  if (level.Centroids.defined())
  {
    first = first + angles(level.Centroids, in[InputCentroids]);
  }
  if (level.Directions.defined())
  {
    first = first + angles(level.Directions, in[InputDirected]);
  }
  return torch::relu(torch::linear(torch::relu(first), in[InputHidden], in[InputHiddenBias]));
}

torch::Tensor PlainFieldConvolution(const FieldLevelTensors& level, const variable_list& in)
{
  const torch::Tensor filters = PlainFilters(level, in);
  const std::vector<torch::Tensor> parts = in[InputX].chunk(2, -1);
  const torch::Tensor re = parts[0].index_select(0, level.Sources);
  const torch::Tensor im = parts[1].index_select(0, level.Sources);
  const torch::Tensor tr = level.Transport.narrow(1, 0, 1);
  const torch::Tensor ti = level.Transport.narrow(1, 1, 1);
  const std::int64_t vertices = in[InputX].size(0);
  const auto sums = [&](const torch::Tensor& carried) {
    const torch::Tensor each = filters * carried.unsqueeze(-1);
    return torch::zeros({ vertices, each.size(1), each.size(2) }, each.options())
      .index_add(0, level.Targets, each)
      .transpose(1, 2)
      .reshape({ vertices, -1 });
  };
  const torch::Tensor sr = sums(tr * re - ti * im);
  const torch::Tensor si = sums(tr * im + ti * re);
  const torch::Tensor& weight = in[InputWeight];
  const torch::Tensor matrix = weight.reshape({ 2, weight.size(1), -1 });
  return torch::cat({ torch::linear(sr, matrix[0]) - torch::linear(si, matrix[1]),
                      torch::linear(sr, matrix[1]) + torch::linear(si, matrix[0]) },
    -1);
}

/// PlainFieldConvolution() that keeps its inputs only and is computed again for the derivatives.
class RecomputedConvolutionStep : public torch::autograd::Function<RecomputedConvolutionStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const FieldLevelTensors& level, const torch::Tensor& x,
    const torch::Tensor& shares, const torch::Tensor& radius, const torch::Tensor& aligned,
    const torch::Tensor& centroids, const torch::Tensor& directed, const torch::Tensor& hidden,
    const torch::Tensor& hiddenBias, const torch::Tensor& weight)
  {
    const variable_list in = { x, shares, radius, aligned, centroids, directed, hidden, hiddenBias, weight };
    context->save_for_backward(in);
    KeepValue(context, level);
    return PlainFieldConvolution(level, in);
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const FieldLevelTensors level = KeptValue<FieldLevelTensors>(context);
    variable_list in;
    for (const torch::Tensor& tensor : context->get_saved_variables())
    {
      in.push_back(tensor.detach().requires_grad_(true));
    }
    const torch::AutoGradMode record(true);
    variable_list derivatives = torch::autograd::grad(
      { PlainFieldConvolution(level, in) }, in, { gradients[0] }, false, false, true);
    derivatives.insert(derivatives.begin(), torch::Tensor());
    return derivatives;
  }
};

/// Ids of a table as a tensor where @p like is.
torch::Tensor FieldIds(const std::vector<std::int32_t>& ids, const torch::Tensor& like)
{
  return torch::from_blob(
    const_cast<std::int32_t*>(ids.data()), { static_cast<std::int64_t>(ids.size()) }, torch::kInt32)
    .to(like.device(), torch::kInt64);
}

/// Products of complex numbers [V, 2] with features [V, 2 C].
torch::Tensor TurnedFields(const torch::Tensor& turns, const torch::Tensor& x)
{
  const std::vector<torch::Tensor> parts = x.chunk(2, -1);
  const torch::Tensor re = turns.narrow(1, 0, 1);
  const torch::Tensor im = turns.narrow(1, 1, 1);
  return torch::cat({ re * parts[0] - im * parts[1], re * parts[1] + im * parts[0] }, -1);
}

void FillModules(torch::nn::ModuleList& list, std::int64_t inputs, std::int64_t outputs)
{
  for (int layer = 0; layer < 3; ++layer)
  {
    list->push_back(NormalizedFieldNeuron(layer == 0 ? inputs : outputs, outputs));
  }
}

torch::Tensor ThroughNeurons(torch::nn::ModuleList& list, torch::Tensor x)
{
  for (const auto& layer : *list)
  {
    x = layer->as<NormalizedFieldNeuron>()->forward(x);
  }
  return x;
}
} // namespace

torch::Tensor TangentPairs(const float* pairs, std::int64_t rows, const torch::Tensor& like)
{
  return torch::from_blob(const_cast<float*>(pairs), { rows, 2 }, torch::kFloat32)
    .to(like.device(), like.scalar_type(), false, true);
}

torch::Tensor TangentPairs(const std::vector<std::complex<float>>& vectors, const torch::Tensor& like)
{
  return TangentPairs(reinterpret_cast<const float*>(vectors.data()), static_cast<std::int64_t>(vectors.size()), like);
}

FieldLevelTensors::FieldLevelTensors(std::shared_ptr<const FieldLevel> level, bool guided, const torch::Tensor& like)
  : Level(std::move(level))
  , Guided(guided)
{
  if (IsFused(like))
  {
    return;
  }
  const TangentNeighborhoods& at = this->Level->Neighborhoods;
  std::vector<std::int32_t> targets;
  for (Index p = 0; p < at.NumberOfVertices(); ++p)
  {
    targets.resize(static_cast<std::size_t>(at.Start[static_cast<std::size_t>(p) + 1]), p);
  }
  this->Sources = FieldIds(at.Sources, like);
  this->Targets = FieldIds(targets, like);
  const FieldNeighborhoods view = this->Level->View(guided);
  this->Rows = view.Shares ? FieldIds(this->Level->Rows, like).index_select(0, this->Sources)
                           : torch::zeros_like(this->Sources);
  const torch::Tensor logarithms = TangentPairs(at.Logarithms, like);
  const torch::Tensor transport = TangentPairs(at.Transport, like);
  this->Radii = logarithms.square().sum(1, true).sqrt();
  const torch::Tensor back = torch::stack({ transport.select(1, 0), -transport.select(1, 1) }, 1);
  this->Logarithms = TurnedFields(back, logarithms) / this->Radii.clamp_min(1e-30);
  this->Centroids = TangentPairs(at.Centroids, like).index_select(0, this->Sources);
  const torch::Tensor weights = torch::from_blob(
    const_cast<float*>(at.Weights.data()), { transport.size(0), 1 }, torch::kFloat32)
                                  .to(like.device(), like.scalar_type());
  this->Transport = weights * transport;
  if (view.Directions)
  {
    const torch::Tensor directions = TangentPairs(view.Directions, this->Level->NumberOfVertices(), like);
    this->Directions = directions.index_select(0, this->Sources);
  }
}

NormalizedFieldNeuronImpl::NormalizedFieldNeuronImpl(std::int64_t inputs, std::int64_t outputs)
{
  const auto norm = this->register_module("norm", std::make_shared<torch::nn::Module>());
  this->Scale = norm->register_parameter("scale", torch::zeros({ 2, inputs }));
  this->LogDelta = norm->register_parameter("log_delta", torch::zeros({ inputs }));
  const auto key = this->register_module("key", std::make_shared<torch::nn::Module>());
  this->Key = key->register_parameter("weight", torch::zeros({ 2, outputs, inputs }));
  const auto query = this->register_module("query", std::make_shared<torch::nn::Module>());
  this->Query = query->register_parameter("weight", torch::zeros({ 2, outputs, inputs }));
}

torch::Tensor NormalizedFieldNeuronImpl::forward(const torch::Tensor& x)
{
  return IsFused(x) ? FusedFieldNeuron(x, this->Scale, this->LogDelta, this->Key, this->Query)
                    : PlainFieldNeuron(x, this->Scale, this->LogDelta, this->Key, this->Query);
}

FieldConvolutionImpl::FieldConvolutionImpl(std::int64_t channels, std::int64_t embedding, bool directed)
{
  const auto filter = this->register_module("filter", std::make_shared<torch::nn::Module>());
  this->Radius = filter->register_parameter("radius", torch::zeros({ FilterChannels }));
  this->Aligned = filter->register_parameter("aligned", torch::zeros({ 2, FilterChannels }));
  this->Bias = filter->register_parameter("bias", torch::zeros({ FilterChannels }));
  if (embedding > 0)
  {
    this->Embedding = filter->register_parameter("embedding", torch::zeros({ FilterChannels, embedding }));
    this->Centroids = filter->register_parameter("centroids", torch::zeros({ 2, FilterChannels }));
    if (directed)
    {
      this->Directed = filter->register_parameter("directed", torch::zeros({ 2, FilterChannels }));
    }
  }
  const auto hidden = filter->register_module("hidden", std::make_shared<torch::nn::Module>());
  this->HiddenWeight = hidden->register_parameter("weight", torch::zeros({ FilterChannels, FilterChannels }));
  this->HiddenBias = hidden->register_parameter("bias", torch::zeros({ FilterChannels }));
  this->Weight = this->register_parameter("weight", torch::zeros({ 2, channels, FilterChannels, channels }));
}

torch::Tensor FieldConvolutionImpl::forward(
  const torch::Tensor& x, const torch::Tensor& embeddings, const FieldLevelTensors& level, const torch::Tensor& gains)
{
  // A convolution without embedding sees neither labels nor directions.
  FieldLevelTensors seen = level;
  torch::Tensor shares;
  if (this->Embedding.defined())
  {
    shares = torch::linear(embeddings, this->Embedding, this->Bias);
  }
  else
  {
    shares = this->Bias.unsqueeze(0);
    seen.Guided = false;
    seen.Rows = seen.Rows.defined() ? torch::zeros_like(seen.Rows) : seen.Rows;
    seen.Centroids = torch::Tensor();
    seen.Directions = torch::Tensor();
  }
  const torch::Tensor centroids = this->Centroids.defined() ? this->Centroids : torch::zeros_like(this->Aligned);
  const torch::Tensor directed = this->Directed.defined() ? this->Directed : torch::zeros_like(this->Aligned);
  const torch::Tensor weight = gains.defined() ? this->Weight * gains.view({ 1, -1, 1, 1 }) : this->Weight;
  return IsFused(x)
    ? FusedFieldConvolution(seen.Level, seen.Guided,
        { x, shares, this->Radius, this->Aligned, centroids, directed, this->HiddenWeight, this->HiddenBias, weight })
    : RecomputedConvolutionStep::apply(seen, x, shares, this->Radius, this->Aligned, centroids, directed,
        this->HiddenWeight, this->HiddenBias, weight);
}

TimeGainsImpl::TimeGainsImpl(std::int64_t channels, std::int64_t embedding)
  : Weight(this->register_parameter("weight", torch::zeros({ channels, embedding })))
{}

torch::Tensor TimeGainsImpl::forward(const torch::Tensor& embeddings)
{
  return 1.0 + torch::mv(this->Weight, embeddings.select(0, 0));
}

FieldResidualBlockImpl::FieldResidualBlockImpl(
  std::int64_t inputs, std::int64_t outputs, std::int64_t embedding, bool directed)
{
  if (inputs != outputs)
  {
    this->Residual = this->register_module("residual", ComplexMap(inputs, outputs));
  }
  this->Mlp1 = this->register_module("mlp1", torch::nn::ModuleList());
  FillModules(this->Mlp1, inputs, outputs);
  this->Convolution1 = this->register_module("convolution1", FieldConvolution(outputs, 0, false));
  this->Mlp2 = this->register_module("mlp2", torch::nn::ModuleList());
  FillModules(this->Mlp2, outputs, outputs);
  this->Convolution2 = this->register_module("convolution2", FieldConvolution(outputs, embedding, directed));
  this->Gains = this->register_module("gains", TimeGains(outputs, embedding));
}

torch::Tensor FieldResidualBlockImpl::forward(
  const torch::Tensor& x, const torch::Tensor& embeddings, const FieldLevelTensors& level)
{
  const torch::Tensor y = this->Convolution1(ThroughNeurons(this->Mlp1, x), embeddings, level);
  const torch::Tensor z = this->Convolution2(ThroughNeurons(this->Mlp2, y), embeddings, level, this->Gains(embeddings));
  return (this->Residual ? this->Residual(x) : x) + z;
}

torch::Tensor PoolFields(const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& fine)
{
  if (IsFused(fine))
  {
    return FusedClusterCarry(surface, fine, true, true);
  }
  const torch::Tensor clusters = FieldIds(surface->Clusters, fine);
  const auto coarse = static_cast<std::int64_t>(surface->MemberStart.size()) - 1;
  const torch::Tensor sums = torch::zeros({ coarse, fine.size(1) }, fine.options())
                               .index_add(0, clusters, TurnedFields(TangentPairs(surface->ToCenter, fine), fine));
  const torch::Tensor members = torch::bincount(clusters, {}, coarse).to(fine.scalar_type());
  return sums / members.unsqueeze(1);
}

torch::Tensor UnpoolFields(const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& coarse)
{
  if (IsFused(coarse))
  {
    return FusedClusterCarry(surface, coarse, false, false);
  }
  const torch::Tensor turns = TangentPairs(surface->ToCenter, coarse);
  const torch::Tensor back = torch::stack({ turns.select(1, 0), -turns.select(1, 1) }, 1);
  return TurnedFields(back, coarse.index_select(0, FieldIds(surface->Clusters, coarse)));
}

} // namespace surfsynth
