// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FieldLatentLayers.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/FieldLatents/FieldLatentKernels.h"
#include "Learning/Layers/FusedLayers.h"

#include <ATen/Parallel.h>

#include <cmath>
#include <vector>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr double NeuronDelta = 1e-3;
constexpr double InitialLogDelta = -13.8; // of 1e-6

/// Only the computation of second derivatives records a backward pass.
void RequireFirstDerivatives()
{
  if (torch::GradMode::is_enabled())
  {
    throw InvalidInput("FieldLatentLayers: second derivatives of float32 layers on the processor are asked for; "
                       "expected first ones (float64 has both).");
  }
}

/// Calls body(r) for each ring, on torch's threads.
template <typename Body>
void ForRings(std::int64_t rings, const Body& body)
{
  at::parallel_for(0, rings, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r)
    {
      body(r);
    }
  });
}

/// Equation 20 on [R, T, 2 C] with a [2 C] and delta [C].
class RingNormStep : public torch::autograd::Function<RingNormStep>
{
public:
  static torch::Tensor forward(
    AutogradContext* context, const torch::Tensor& x, const torch::Tensor& a, const torch::Tensor& delta)
  {
    const torch::Tensor in = x.contiguous();
    const std::int64_t tokens = in.size(1);
    const std::int64_t channels = delta.size(0);
    const torch::Tensor out = torch::empty_like(in);
    const torch::Tensor scales = torch::empty({ in.size(0), channels }, in.options());
    const float* from[3] = { in.data_ptr<float>(), a.data_ptr<float>(), delta.data_ptr<float>() };
    float* const to[2] = { scales.data_ptr<float>(), out.data_ptr<float>() };
    ForRings(in.size(0), [&](std::int64_t r) {
      const std::int64_t at = r * tokens * 2 * channels;
      BestFieldLatentKernels().Normalize(
        from[0] + at, from[1], from[2], tokens, channels, to[0] + r * channels, to[1] + at);
    });
    context->save_for_backward({ in, a, scales });
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstDerivatives();
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::int64_t rings = gradient.size(0);
    const std::int64_t tokens = gradient.size(1);
    const std::int64_t channels = saved[2].size(1);
    const torch::Tensor dx = torch::empty_like(gradient);
    const torch::Tensor da = torch::zeros({ rings, 2 * channels }, gradient.options());
    const torch::Tensor dDelta = torch::zeros({ rings, channels }, gradient.options());
    const torch::Tensor scratch = torch::empty({ rings, channels }, gradient.options());
    const float* from[4] = { saved[0].data_ptr<float>(), saved[1].data_ptr<float>(), saved[2].data_ptr<float>(),
      gradient.data_ptr<float>() };
    float* const to[4] = { scratch.data_ptr<float>(), dx.data_ptr<float>(), da.data_ptr<float>(),
      dDelta.data_ptr<float>() };
    ForRings(rings, [&](std::int64_t r) {
      const std::int64_t at = r * tokens * 2 * channels;
      BestFieldLatentKernels().NormalizeGradient(from[0] + at, from[1], from[2] + r * channels, from[3] + at, tokens,
        channels, to[0] + r * channels, to[1] + at, to[2] + 2 * r * channels, to[3] + r * channels);
    });
    return { dx, da.sum(0), dDelta.sum(0) };
  }
};

/// Rows that a thread takes at a time.
constexpr std::int64_t NeuronRows = 128;

/// Equation 19 on [..., 4 C], K then Q.
class NeuronStep : public torch::autograd::Function<NeuronStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& keysAndQueries)
  {
    const torch::Tensor in = keysAndQueries.contiguous();
    const std::int64_t channels = in.size(-1) / 4;
    std::vector<std::int64_t> shape = in.sizes().vec();
    shape.back() = 2 * channels;
    const torch::Tensor out = torch::empty(shape, in.options());
    const float* from = in.data_ptr<float>();
    float* to = out.data_ptr<float>();
    at::parallel_for(0, in.numel() / in.size(-1), NeuronRows, [&](std::int64_t begin, std::int64_t end) {
      BestFieldLatentKernels().Neuron(from + 4 * channels * begin, end - begin, channels, to + 2 * channels * begin);
    });
    context->save_for_backward({ in });
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstDerivatives();
    const torch::Tensor in = context->get_saved_variables()[0];
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::int64_t channels = in.size(-1) / 4;
    const torch::Tensor out = torch::empty_like(in);
    const float* from[2] = { in.data_ptr<float>(), gradient.data_ptr<float>() };
    float* to = out.data_ptr<float>();
    at::parallel_for(0, in.numel() / in.size(-1), NeuronRows, [&](std::int64_t begin, std::int64_t end) {
      BestFieldLatentKernels().NeuronGradient(from[0] + 4 * channels * begin, from[1] + 2 * channels * begin,
        end - begin, channels, to + 4 * channels * begin);
    });
    return { out };
  }
};

/// Sizes of an attention over rings.
struct AttentionSizes
{
  std::int64_t Rings;
  std::int64_t Tokens;
  std::int64_t Width; ///< 2 C
  std::int64_t Heads;

  std::int64_t HeadSize() const { return this->Width / this->Heads; }
  float Scale() const { return 1.0F / std::sqrt(static_cast<float>(this->HeadSize())); }
  /// First probability of a head of a ring.
  std::int64_t Probability(std::int64_t ring, std::int64_t head) const
  {
    return (ring * this->Heads + head) * this->Tokens * this->Tokens;
  }
};

AttentionSizes SizesOf(const torch::Tensor& in, std::int64_t heads)
{
  return { in.size(0), in.size(1), in.size(2) / 3, heads };
}

/// Attention of one head in one ring. A column of the probabilities belongs to a query.
void AttendHead(const AttentionSizes& sizes, const float* queries, float* probabilities, float* scratch, float* out)
{
  const std::int64_t stride = 3 * sizes.Width;
  const std::int64_t tokens = sizes.Tokens;
  const std::int64_t size = sizes.HeadSize();
  const float* keys = queries + sizes.Width;
  const float* values = keys + sizes.Width;
  MultiplyBlocks({ keys, stride }, { queries, stride, true }, probabilities, tokens, tokens, size, tokens);
  BestFieldLatentKernels().ColumnSoftmax(probabilities, sizes.Scale(), tokens, tokens, scratch);
  MultiplyBlocks({ probabilities, tokens, true }, { values, stride }, out, sizes.Width, tokens, tokens, size);
}

/// Derivatives of AttendHead(). @param scores scratch, [T, T]
void AttendHeadGradient(const AttentionSizes& sizes, const float* queries, const float* probabilities,
  const float* gradient, float* scores, float* scratch, float* dQueries)
{
  const std::int64_t stride = 3 * sizes.Width;
  const std::int64_t tokens = sizes.Tokens;
  const std::int64_t size = sizes.HeadSize();
  const float* keys = queries + sizes.Width;
  const float* values = keys + sizes.Width;
  float* dKeys = dQueries + sizes.Width;
  float* dValues = dKeys + sizes.Width;
  MultiplyBlocks({ probabilities, tokens }, { gradient, sizes.Width }, dValues, stride, tokens, tokens, size);
  MultiplyBlocks({ values, stride }, { gradient, sizes.Width, true }, scores, tokens, tokens, size, tokens);
  BestFieldLatentKernels().ColumnSoftmaxGradient(probabilities, sizes.Scale(), tokens, tokens, scratch, scores);
  MultiplyBlocks({ scores, tokens, true }, { keys, stride }, dQueries, stride, tokens, tokens, size);
  MultiplyBlocks({ scores, tokens }, { queries, stride }, dKeys, stride, tokens, tokens, size);
}

/// Attention over [R, T, 6 C]: queries, keys and values by head, to [R, T, 2 C] by head.
class AttentionStep : public torch::autograd::Function<AttentionStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& queriesKeysValues, std::int64_t heads)
  {
    const torch::Tensor in = queriesKeysValues.contiguous();
    const AttentionSizes sizes = SizesOf(in, heads);
    const torch::Tensor probabilities = torch::empty({ sizes.Rings, heads, sizes.Tokens, sizes.Tokens }, in.options());
    const torch::Tensor out = torch::empty({ sizes.Rings, sizes.Tokens, sizes.Width }, in.options());
    const float* from = in.data_ptr<float>();
    float* const to[2] = { probabilities.data_ptr<float>(), out.data_ptr<float>() };
    const SingleThreadedBlas blas;
    ForRings(sizes.Rings, [&](std::int64_t r) {
      std::vector<float> scratch(static_cast<std::size_t>(2 * sizes.Tokens));
      const std::int64_t row = r * sizes.Tokens * sizes.Width;
      for (std::int64_t head = 0; head < heads; ++head)
      {
        const std::int64_t column = head * sizes.HeadSize();
        AttendHead(
          sizes, from + 3 * row + column, to[0] + sizes.Probability(r, head), scratch.data(), to[1] + row + column);
      }
    });
    context->save_for_backward({ in, probabilities });
    context->saved_data["heads"] = heads;
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstDerivatives();
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor gradient = gradients[0].contiguous();
    const AttentionSizes sizes = SizesOf(saved[0], context->saved_data["heads"].toInt());
    const torch::Tensor out = torch::empty_like(saved[0]);
    const float* from[3] = { saved[0].data_ptr<float>(), saved[1].data_ptr<float>(), gradient.data_ptr<float>() };
    float* to = out.data_ptr<float>();
    const SingleThreadedBlas blas;
    ForRings(sizes.Rings, [&](std::int64_t r) {
      std::vector<float> scores(static_cast<std::size_t>((sizes.Tokens + 1) * sizes.Tokens));
      float* scratch = scores.data() + sizes.Tokens * sizes.Tokens;
      const std::int64_t row = r * sizes.Tokens * sizes.Width;
      for (std::int64_t head = 0; head < sizes.Heads; ++head)
      {
        const std::int64_t column = head * sizes.HeadSize();
        AttendHeadGradient(sizes, from[0] + 3 * row + column, from[1] + sizes.Probability(r, head),
          from[2] + row + column, scores.data(), scratch, to + 3 * row + column);
      }
    });
    return { out, torch::Tensor() };
  }
};

torch::Tensor PlainRingNorm(const torch::Tensor& x, const torch::Tensor& a, const torch::Tensor& delta)
{
  const std::vector<torch::Tensor> parts = x.chunk(2, -1);
  const torch::Tensor square = (parts[0].square() + parts[1].square()).mean(1, true);
  const torch::Tensor scale = torch::rsqrt(square + delta);
  const torch::Tensor re = parts[0] * scale;
  const torch::Tensor im = parts[1] * scale;
  return torch::cat({ re * a[0] - im * a[1], re * a[1] + im * a[0] }, -1);
}

torch::Tensor PlainNeuron(const torch::Tensor& keysAndQueries)
{
  const std::vector<torch::Tensor> parts = keysAndQueries.chunk(4, -1);
  const torch::Tensor dot = parts[0] * parts[2] + parts[1] * parts[3];
  const torch::Tensor factor = torch::relu(-dot) / (parts[0].square() + parts[1].square() + NeuronDelta);
  return torch::cat({ parts[2] + factor * parts[0], parts[3] + factor * parts[1] }, -1);
}

torch::Tensor PlainAttention(const torch::Tensor& queriesKeysValues, std::int64_t heads)
{
  const AttentionSizes sizes = SizesOf(queriesKeysValues, heads);
  const std::vector<torch::Tensor> parts = queriesKeysValues
                                             .view({ sizes.Rings, sizes.Tokens, 3, heads, sizes.HeadSize() })
                                             .permute({ 2, 0, 3, 1, 4 })
                                             .unbind();
  const torch::Tensor scores = torch::matmul(parts[0], parts[1].transpose(-1, -2)) * sizes.Scale();
  return torch::matmul(torch::softmax(scores, -1), parts[2])
    .transpose(1, 2)
    .reshape({ sizes.Rings, sizes.Tokens, sizes.Width });
}

/// Order of the numbers of complex channels: real parts of a group of @p Size channels, its imaginary parts, the next
/// group.
struct ChannelOrder
{
  std::int64_t Size;

  std::int64_t Place(std::int64_t channel, std::int64_t part) const
  {
    return (2 * (channel / this->Size) + part) * this->Size + channel % this->Size;
  }
};

/// Real matrices [n 2 out, 2 in] of complex maps [n, 2, out, in], one after the other.
class RealMatricesStep : public torch::autograd::Function<RealMatricesStep>
{
public:
  static torch::Tensor forward(
    AutogradContext* context, const torch::Tensor& maps, std::int64_t rowGroup, std::int64_t columnGroup)
  {
    const torch::Tensor in = maps.contiguous();
    const torch::Tensor out = torch::empty({ in.size(0) * 2 * in.size(2), 2 * in.size(3) }, in.options());
    const float* from = in.data_ptr<float>();
    float* to = out.data_ptr<float>();
    ForWeights(in.sizes(), { rowGroup }, { columnGroup },
      [&](std::int64_t re, std::int64_t im, const std::int64_t* rows, const std::int64_t* columns) {
        to[rows[0] + columns[0]] = from[re];
        to[rows[0] + columns[1]] = -from[im];
        to[rows[1] + columns[0]] = from[im];
        to[rows[1] + columns[1]] = from[re];
      });
    context->saved_data["shape"] = in.sizes().vec();
    context->saved_data["row_group"] = rowGroup;
    context->saved_data["column_group"] = columnGroup;
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstDerivatives();
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::vector<std::int64_t> shape = context->saved_data["shape"].toIntVector();
    const torch::Tensor out = torch::empty(shape, gradient.options());
    const float* from = gradient.data_ptr<float>();
    float* to = out.data_ptr<float>();
    ForWeights(shape, { context->saved_data["row_group"].toInt() }, { context->saved_data["column_group"].toInt() },
      [&](std::int64_t re, std::int64_t im, const std::int64_t* rows, const std::int64_t* columns) {
        to[re] = from[rows[0] + columns[0]] + from[rows[1] + columns[1]];
        to[im] = from[rows[1] + columns[0]] - from[rows[0] + columns[1]];
      });
    return { out, torch::Tensor(), torch::Tensor() };
  }

private:
  /// Calls body for each complex weight with the places of its parts, the places of its two rows and of its two columns.
  template <typename Body>
  static void ForWeights(at::IntArrayRef shape, ChannelOrder rowOrder, ChannelOrder columnOrder, const Body& body)
  {
    const std::int64_t outputs = shape[2];
    const std::int64_t inputs = shape[3];
    for (std::int64_t map = 0; map < shape[0]; ++map)
    {
      for (std::int64_t o = 0; o < outputs; ++o)
      {
        const std::int64_t first = 2 * map * outputs;
        const std::int64_t rows[2] = { (first + rowOrder.Place(o, 0)) * 2 * inputs,
          (first + rowOrder.Place(o, 1)) * 2 * inputs };
        for (std::int64_t group = 0; group < inputs; group += columnOrder.Size)
        {
          for (std::int64_t i = group; i < group + columnOrder.Size; ++i)
          {
            const std::int64_t columns[2] = { group + i, group + i + columnOrder.Size };
            body((first + o) * inputs + i, (first + outputs + o) * inputs + i, rows, columns);
          }
        }
      }
    }
  }
};

/// Orders the rows of a real matrix [2 C, ...] as ChannelOrder.
torch::Tensor RowsByGroup(const torch::Tensor& matrix, std::int64_t group)
{
  const std::int64_t rows = matrix.size(0);
  return matrix.view({ 2, rows / 2 / group, group, matrix.size(1) }).transpose(0, 1).reshape({ rows, matrix.size(1) });
}

/// Real matrices of complex maps of the same size, one after the other: [n 2 out, 2 in].
/// @param rowGroup, columnGroup channels of a group, see ChannelOrder; 0: all in one
torch::Tensor RealMatrices(
  const std::vector<torch::Tensor>& maps, std::int64_t rowGroup = 0, std::int64_t columnGroup = 0)
{
  const std::int64_t rows = rowGroup > 0 ? rowGroup : maps.front().size(1);
  const std::int64_t columns = columnGroup > 0 ? columnGroup : maps.front().size(2);
  if (IsFused(maps.front()))
  {
    return RealMatricesStep::apply(maps.size() == 1 ? maps.front().unsqueeze(0) : torch::stack(maps), rows, columns);
  }
  std::vector<torch::Tensor> matrices;
  for (const torch::Tensor& map : maps)
  {
    const torch::Tensor matrix = torch::cat(
      { torch::cat({ map[0], -map[1] }, 1), torch::cat({ map[1], map[0] }, 1) }, 0);
    matrices.push_back(RowsByGroup(RowsByGroup(matrix, rows).t().contiguous(), columns).t());
  }
  return torch::cat(matrices);
}
} // namespace

ComplexMapImpl::ComplexMapImpl(std::int64_t in, std::int64_t out)
{
  const double bound = 1.0 / std::sqrt(static_cast<double>(in));
  this->Weight = this->register_parameter("weight", torch::empty({ 2, out, in }).uniform_(-bound, bound));
}

torch::Tensor ComplexMapImpl::forward(const torch::Tensor& x)
{
  return torch::linear(x, RealMatrices({ this->Weight }));
}

RingNormImpl::RingNormImpl(std::int64_t channels)
{
  this->Scale = this->register_parameter(
    "scale", torch::stack({ torch::ones({ channels }), torch::zeros({ channels }) }));
  this->LogDelta = this->register_parameter("log_delta", torch::full({ channels }, InitialLogDelta));
}

torch::Tensor RingNormImpl::forward(const torch::Tensor& x)
{
  const torch::Tensor delta = this->LogDelta.exp();
  return IsFused(x) ? RingNormStep::apply(x, this->Scale.view({ -1 }), delta) : PlainRingNorm(x, this->Scale, delta);
}

VectorNeuronImpl::VectorNeuronImpl(std::int64_t channels)
{
  this->Key = this->register_module("key", ComplexMap(channels, channels));
  this->Query = this->register_module("query", ComplexMap(channels, channels));
}

torch::Tensor VectorNeuronImpl::forward(const torch::Tensor& x)
{
  const torch::Tensor keysAndQueries = torch::linear(x, RealMatrices({ this->Key->Weight, this->Query->Weight }));
  return IsFused(x) ? NeuronStep::apply(keysAndQueries) : PlainNeuron(keysAndQueries);
}

RingAttentionImpl::RingAttentionImpl(std::int64_t channels, std::int64_t heads)
  : Heads(heads)
{
  this->Query = this->register_module("query", ComplexMap(channels, channels));
  this->Key = this->register_module("key", ComplexMap(channels, channels));
  this->Value = this->register_module("value", ComplexMap(channels, channels));
  this->Out = this->register_module("out", ComplexMap(channels, channels));
}

torch::Tensor RingAttentionImpl::forward(const torch::Tensor& x)
{
  const std::int64_t group = this->Query->Weight.size(1) / this->Heads;
  const torch::Tensor queriesKeysValues = torch::linear(
    x, RealMatrices({ this->Query->Weight, this->Key->Weight, this->Value->Weight }, group));
  const torch::Tensor attended = IsFused(x) ? AttentionStep::apply(queriesKeysValues, this->Heads)
                                            : PlainAttention(queriesKeysValues, this->Heads);
  return torch::linear(attended, RealMatrices({ this->Out->Weight }, 0, group));
}

} // namespace surfsynth
