// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionWeights.h"

#include "Inference/FieldLatents/LatentDiffusionKernels.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace surfsynth
{

namespace
{
/// Column of the real (part 0) or imaginary (1) part of a channel.
using Place = std::function<std::int64_t(std::int64_t channel, std::int64_t part)>;

Place SeparateParts(std::int64_t channels)
{
  return [channels](std::int64_t channel, std::int64_t part) { return part * channels + channel; };
}

Place AlternatingParts()
{
  return [](std::int64_t channel, std::int64_t part) { return 2 * channel + part; };
}

/// Writes the real matrix of a complex map with real parts at @p re and imaginary parts at @p im, [outputs, inputs],
/// into @p matrix: rows of inputs, @p stride numbers each.
void PlaceComplex(const float* re, const float* im, std::int64_t outputs, std::int64_t inputs, const Place& input,
  const Place& output, std::int64_t stride, std::vector<float>& matrix)
{
  for (std::int64_t o = 0; o < outputs; ++o)
  {
    for (std::int64_t i = 0; i < inputs; ++i)
    {
      const auto at = [&](std::int64_t from, std::int64_t to) -> float& {
        return matrix[static_cast<std::size_t>(input(i, from) * stride + output(o, to))];
      };
      at(0, 0) = at(1, 1) = re[o * inputs + i];
      at(0, 1) = im[o * inputs + i];
      at(1, 0) = -im[o * inputs + i];
    }
  }
}

class DiffusionReader
{
public:
  explicit DiffusionReader(const LatentDiffusionModel& model)
    : Model(model)
  {}

  const std::vector<float>& Values(const std::string& name) const { return this->Model.Tensors.at(name).Values; }
  const std::vector<std::int64_t>& Shape(const std::string& name) const { return this->Model.Tensors.at(name).Shape; }

  std::vector<float> Complex(const std::string& name, const Place& input, const Place& output) const
  {
    const std::int64_t outputs = this->Shape(name)[1];
    const std::int64_t inputs = this->Shape(name)[2];
    std::vector<float> matrix(static_cast<std::size_t>(4 * outputs * inputs));
    const float* re = this->Values(name).data();
    PlaceComplex(re, re + outputs * inputs, outputs, inputs, input, output, 2 * outputs, matrix);
    return matrix;
  }

  FieldNeuron Neuron(const std::string& name) const
  {
    FieldNeuron neuron;
    neuron.Outputs = this->Shape(name + ".key.weight")[1];
    neuron.Inputs = this->Shape(name + ".key.weight")[2];
    neuron.Scale = this->Values(name + ".norm.scale");
    neuron.Delta = this->Values(name + ".norm.log_delta");
    std::transform(
      neuron.Delta.begin(), neuron.Delta.end(), neuron.Delta.begin(), [](float value) { return std::exp(value); });
    neuron.Matrix.resize(static_cast<std::size_t>(8 * neuron.Inputs * neuron.Outputs));
    const std::int64_t size = neuron.Inputs * neuron.Outputs;
    for (std::int64_t part = 0; part < 2; ++part)
    {
      const float* re = this->Values(name + (part == 0 ? ".key.weight" : ".query.weight")).data();
      const Place apart = SeparateParts(neuron.Outputs);
      const std::int64_t shift = part * 2 * neuron.Outputs;
      PlaceComplex(
        re, re + size, neuron.Outputs, neuron.Inputs, SeparateParts(neuron.Inputs),
        [&](std::int64_t channel, std::int64_t k) { return shift + apart(channel, k); }, 4 * neuron.Outputs,
        neuron.Matrix);
    }
    return neuron;
  }

  FieldConvolutionWeights Convolution(const std::string& name, bool embedded) const
  {
    FieldConvolutionWeights weights;
    const std::int64_t channels = this->Shape(name + ".weight")[1];
    weights.Channels = channels;
    weights.Radius = this->Values(name + ".filter.radius");
    weights.Aligned = this->Values(name + ".filter.aligned");
    weights.Bias = this->Values(name + ".filter.bias");
    weights.Hidden = this->Values(name + ".filter.hidden.weight");
    weights.HiddenBias = this->Values(name + ".filter.hidden.bias");
    weights.Centroids.assign(2 * FilterChannels, 0.0F);
    weights.Directed.assign(2 * FilterChannels, 0.0F);
    if (embedded)
    {
      weights.Embedding = this->Values(name + ".filter.embedding");
      weights.Centroids = this->Values(name + ".filter.centroids");
      if (this->Model.Options.Directed)
      {
        weights.Directed = this->Values(name + ".filter.directed");
      }
    }
    const std::int64_t inputs = FilterChannels * channels;
    weights.Matrix.resize(static_cast<std::size_t>(4 * inputs * channels));
    const float* re = this->Values(name + ".weight").data();
    PlaceComplex(
      re, re + channels * inputs, channels, inputs,
      [channels](
        std::int64_t input, std::int64_t part) { return (input / channels * 2 + part) * channels + input % channels; },
      SeparateParts(channels), 2 * channels, weights.Matrix);
    return weights;
  }

  FieldBlock Block(const std::string& name) const
  {
    FieldBlock block;
    if (this->Model.Tensors.count(name + ".residual.weight") > 0)
    {
      const std::vector<std::int64_t>& shape = this->Shape(name + ".residual.weight");
      block.Residual = this->Complex(name + ".residual.weight", SeparateParts(shape[2]), SeparateParts(shape[1]));
    }
    for (int layer = 0; layer < 3; ++layer)
    {
      block.Mlp1[layer] = this->Neuron(name + ".mlp1." + std::to_string(layer));
      block.Mlp2[layer] = this->Neuron(name + ".mlp2." + std::to_string(layer));
    }
    block.Convolution1 = this->Convolution(name + ".convolution1", false);
    block.Convolution2 = this->Convolution(name + ".convolution2", true);
    block.Gains = this->Values(name + ".gains.weight");
    return block;
  }

  std::vector<FieldBlock> Blocks(const std::string& part, std::int64_t count) const
  {
    std::vector<FieldBlock> blocks;
    for (std::int64_t block = 0; block < count; ++block)
    {
      blocks.push_back(this->Block(part + "." + std::to_string(block)));
    }
    return blocks;
  }

private:
  const LatentDiffusionModel& Model;
};
} // namespace

std::vector<float> FieldNeuron::Normalized(const std::vector<double>& meanSquares) const
{
  std::vector<float> matrix(this->Matrix.size());
  const auto inputs = static_cast<std::size_t>(this->Inputs);
  const auto columns = static_cast<std::size_t>(4 * this->Outputs);
  for (std::size_t c = 0; c < inputs; ++c)
  {
    const auto inverse = static_cast<float>(1.0 / std::sqrt(meanSquares[c] + static_cast<double>(this->Delta[c])));
    const float re = inverse * this->Scale[c];
    const float im = inverse * this->Scale[inputs + c];
    const float* first = this->Matrix.data() + c * columns;
    const float* second = this->Matrix.data() + (inputs + c) * columns;
    for (std::size_t k = 0; k < columns; ++k)
    {
      matrix[c * columns + k] = re * first[k] + im * second[k];
      matrix[(inputs + c) * columns + k] = re * second[k] - im * first[k];
    }
  }
  return matrix;
}

LatentDiffusionWeights::LatentDiffusionWeights(const LatentDiffusionModel& model)
{
  const DiffusionReader reader(model);
  const LatentDiffusionOptions& options = model.Options;
  this->Input = reader.Complex("input.weight", AlternatingParts(), SeparateParts(options.Channels));
  this->Output = reader.Complex("output.weight", SeparateParts(options.Channels), AlternatingParts());
  this->InputGains = reader.Values("input.gains.weight");
  this->OutputGains = reader.Values("output.gains.weight");
  this->InputBlocks = reader.Blocks("input", options.InputBlocks);
  this->CoarseBlocks = reader.Blocks("coarse", options.CoarseBlocks);
  this->OutputBlocks = reader.Blocks("output", options.OutputBlocks);
  this->Time0 = reader.Values("time.0.weight");
  this->TimeBias0 = reader.Values("time.0.bias");
  this->Time2 = reader.Values("time.2.weight");
  this->TimeBias2 = reader.Values("time.2.bias");
  if (options.NumberOfLabels > 0)
  {
    this->Labels = reader.Values("labels.weight");
  }
}

} // namespace surfsynth
