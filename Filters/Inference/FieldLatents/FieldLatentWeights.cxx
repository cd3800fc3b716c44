// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentWeights.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace surfsynth
{

namespace
{
/// Place of the real (part 0) or imaginary (1) part of a channel in a row.
using Place = std::function<std::int64_t(std::int64_t channel, std::int64_t part)>;

Place PartsApart(std::int64_t channels)
{
  return [channels](std::int64_t channel, std::int64_t part) { return part * channels + channel; };
}

Place PartsInTurn()
{
  return [](std::int64_t channel, std::int64_t part) { return 2 * channel + part; };
}

/// Heads one after the other, the parts of each apart.
Place ByHead(std::int64_t size)
{
  return [size](std::int64_t channel, std::int64_t part) {
    return channel / size * 2 * size + part * size + channel % size;
  };
}

/// Writes the real matrix of a complex map, [2, out, in], into columns of @p matrix from @p column on: rows of inputs,
/// @p stride numbers each.
void PlaceComplex(const ModelTensor& weight, const Place& input, const Place& output, std::int64_t column,
  std::int64_t stride, std::vector<float>& matrix)
{
  const std::int64_t outputs = weight.Shape[1];
  const std::int64_t inputs = weight.Shape[2];
  for (std::int64_t o = 0; o < outputs; ++o)
  {
    for (std::int64_t i = 0; i < inputs; ++i)
    {
      const float re = weight.Values[static_cast<std::size_t>(o * inputs + i)];
      const float im = weight.Values[static_cast<std::size_t>((outputs + o) * inputs + i)];
      const auto at = [&](std::int64_t from, std::int64_t to) -> float& {
        return matrix[static_cast<std::size_t>(input(i, from) * stride + column + output(o, to))];
      };
      at(0, 0) = re;
      at(0, 1) = im;
      at(1, 0) = -im;
      at(1, 1) = re;
    }
  }
}

std::vector<float> Zeros(std::int64_t rows, std::int64_t columns)
{
  return std::vector<float>(static_cast<std::size_t>(rows * columns), 0.0F);
}

class WeightReader
{
public:
  explicit WeightReader(const FieldLatentModel& model)
    : Model(model)
    , Channels(model.Options.Channels)
    , HeadSize(model.Options.Channels / model.Options.Heads)
  {}

  const ModelTensor& Tensor(const std::string& name) const { return this->Model.Tensors.at(name); }

  FieldLatentAffine Affine(const std::string& name) const
  {
    const ModelTensor& weight = this->Tensor(name + ".weight");
    FieldLatentAffine affine = { Zeros(weight.Shape[1], weight.Shape[0]), this->Tensor(name + ".bias").Values };
    for (std::int64_t o = 0; o < weight.Shape[0]; ++o)
    {
      for (std::int64_t i = 0; i < weight.Shape[1]; ++i)
      {
        affine.Matrix[static_cast<std::size_t>(i * weight.Shape[0] + o)] =
          weight.Values[static_cast<std::size_t>(o * weight.Shape[1] + i)];
      }
    }
    return affine;
  }

  FieldLatentNorm Norm(const std::string& name) const
  {
    FieldLatentNorm norm = { this->Tensor(name + ".scale").Values, this->Tensor(name + ".log_delta").Values };
    std::transform(
      norm.Delta.begin(), norm.Delta.end(), norm.Delta.begin(), [](float value) { return std::exp(value); });
    return norm;
  }

  std::vector<float> Complex(const std::string& name, const Place& output) const
  {
    const ModelTensor& weight = this->Tensor(name + ".weight");
    std::vector<float> matrix = Zeros(2 * this->Channels, 2 * weight.Shape[1]);
    PlaceComplex(weight, PartsApart(this->Channels), output, 0, 2 * weight.Shape[1], matrix);
    return matrix;
  }

  std::vector<float> Neuron(const std::string& name) const
  {
    const std::int64_t width = 2 * this->Channels;
    std::vector<float> matrix = Zeros(width, 2 * width);
    const Place apart = PartsApart(this->Channels);
    PlaceComplex(this->Tensor(name + ".key.weight"), apart, apart, 0, 2 * width, matrix);
    PlaceComplex(this->Tensor(name + ".query.weight"), apart, apart, width, 2 * width, matrix);
    return matrix;
  }

  FieldLatentLayer Layer(const std::string& name) const
  {
    const std::int64_t width = 2 * this->Channels;
    const Place apart = PartsApart(this->Channels);
    const Place byHead = ByHead(this->HeadSize);
    FieldLatentLayer layer;
    layer.Norm1 = this->Norm(name + ".norm1");
    layer.Norm2 = this->Norm(name + ".norm2");
    layer.QueryKeyValue = Zeros(width, 3 * width);
    std::int64_t column = 0;
    for (const char* map : { "query", "key", "value" })
    {
      PlaceComplex(
        this->Tensor(name + ".attention." + map + ".weight"), apart, byHead, column, 3 * width, layer.QueryKeyValue);
      column += width;
    }
    layer.Out = Zeros(width, width);
    PlaceComplex(this->Tensor(name + ".attention.out.weight"), byHead, apart, 0, width, layer.Out);
    layer.Neuron1 = this->Neuron(name + ".neuron1");
    layer.Neuron2 = this->Neuron(name + ".neuron2");
    return layer;
  }

private:
  const FieldLatentModel& Model;
  std::int64_t Channels;
  std::int64_t HeadSize;
};
} // namespace

FieldLatentEncoderWeights::FieldLatentEncoderWeights(const FieldLatentModel& model)
{
  const WeightReader reader(model);
  this->Lift = reader.Affine("encoder.lift");
  this->GatherColors = reader.Affine("encoder.gather");
  this->FilterIn = reader.Affine("encoder.filter.0");
  this->FilterOut = reader.Affine("encoder.filter.2");
  for (std::int64_t layer = 0; layer < model.Options.EncoderLayers; ++layer)
  {
    this->Layers.push_back(reader.Layer("encoder.layers." + std::to_string(layer)));
  }
  this->MeanNeuron = reader.Neuron("encoder.mean.neuron");
  this->MeanOut = reader.Complex("encoder.mean.out", PartsInTurn());
  this->Product = reader.Complex("encoder.deviation.product", PartsApart(model.Options.Channels));
  this->DeviationIn = reader.Affine("encoder.deviation.0");
  this->DeviationOut = reader.Affine("encoder.deviation.2");
}

FieldLatentDecoderWeights::FieldLatentDecoderWeights(const FieldLatentModel& model)
{
  const WeightReader reader(model);
  const FieldLatentAffine first = reader.Affine("decoder.layers.0");
  const std::int64_t coordinates = model.Options.DecoderInputs() - model.Options.NumberOfProducts();
  const auto split = first.Matrix.begin() + coordinates * model.Options.DecoderWidth;
  this->Coordinates.assign(first.Matrix.begin(), split);
  this->Products.assign(split, first.Matrix.end());
  this->Bias = first.Bias;
  for (std::int64_t layer = 1; layer <= model.Options.DecoderLayers; ++layer)
  {
    this->Layers.push_back(reader.Affine("decoder.layers." + std::to_string(layer)));
  }
}

} // namespace surfsynth
