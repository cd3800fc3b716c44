// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentOptions.h"

#include "Core/Common/Errors.h"

#include <tuple>

namespace surfsynth
{

namespace
{
constexpr std::int64_t Colors = 3;

auto AsTuple(const FieldLatentOptions& o)
{
  return std::tie(o.LatentDimension, o.Channels, o.EncoderLayers, o.Heads, o.SamplesPerRing, o.DecoderLayers,
    o.DecoderWidth, o.Coordinates);
}

using Shapes = std::map<std::string, std::vector<std::int64_t>>;

void AddAffineMap(Shapes& shapes, const std::string& name, std::int64_t outputs, std::int64_t inputs)
{
  shapes[name + ".weight"] = { outputs, inputs };
  shapes[name + ".bias"] = { outputs };
}

void AddTransformerLayer(Shapes& shapes, const std::string& name, std::int64_t channels)
{
  for (const char* norm : { ".norm1", ".norm2" })
  {
    shapes[name + norm + ".scale"] = { 2, channels };
    shapes[name + norm + ".log_delta"] = { channels };
  }
  for (const char* map : { ".attention.query", ".attention.key", ".attention.value", ".attention.out", ".neuron1.key",
         ".neuron1.query", ".neuron2.key", ".neuron2.query" })
  {
    shapes[name + map + ".weight"] = { 2, channels, channels };
  }
}
} // namespace

FieldLatentOptions FieldLatentOptions::Paper() { return {}; }

FieldLatentOptions FieldLatentOptions::Small()
{
  FieldLatentOptions options;
  options.Channels = 32;
  options.EncoderLayers = 4;
  options.Heads = 4;
  options.SamplesPerRing = 32;
  options.DecoderLayers = 4;
  options.DecoderWidth = 128;
  return options;
}

std::int64_t FieldLatentOptions::DecoderInputs() const
{
  return this->NumberOfProducts() +
    (this->Coordinates == FieldLatentCoordinates::Logarithmic ? 2 * this->LatentDimension : 0);
}

bool operator==(const FieldLatentOptions& a, const FieldLatentOptions& b) { return AsTuple(a) == AsTuple(b); }

std::string NameOf(FieldLatentCoordinates coordinates)
{
  return coordinates == FieldLatentCoordinates::Logarithmic ? "logarithmic" : "barycentric";
}

void CheckOptions(const FieldLatentOptions& options)
{
  const struct
  {
    const char* Name;
    std::int64_t Value;
    std::int64_t Maximum;
  } ranges[] = { { "LatentDimension", options.LatentDimension, 256 }, { "Channels", options.Channels, 4096 },
    { "EncoderLayers", options.EncoderLayers, 256 }, { "Heads", options.Heads, 4096 },
    { "SamplesPerRing", options.SamplesPerRing, 65536 }, { "DecoderLayers", options.DecoderLayers, 256 },
    { "DecoderWidth", options.DecoderWidth, 65536 } };
  for (const auto& range : ranges)
  {
    if (range.Value < 1 || range.Value > range.Maximum)
    {
      throw InvalidInput(std::string("FieldLatentOptions: ") + range.Name + " is " + std::to_string(range.Value) +
        "; expected 1 to " + std::to_string(range.Maximum) + ".");
    }
  }
  if (options.Channels % options.Heads != 0)
  {
    throw InvalidInput("FieldLatentOptions: Heads is " + std::to_string(options.Heads) +
      "; expected a divisor of the " + std::to_string(options.Channels) + " channels.");
  }
}

Shapes ExpectedFieldLatentTensors(const FieldLatentOptions& options)
{
  const std::int64_t channels = options.Channels;
  Shapes shapes;
  AddAffineMap(shapes, "encoder.lift", 2 * channels, Colors);
  AddAffineMap(shapes, "encoder.gather", 2 * channels, Colors);
  AddAffineMap(shapes, "encoder.filter.0", channels, 1);
  AddAffineMap(shapes, "encoder.filter.2", 2 * channels, channels);
  for (std::int64_t layer = 0; layer < options.EncoderLayers; ++layer)
  {
    AddTransformerLayer(shapes, "encoder.layers." + std::to_string(layer), channels);
  }
  shapes["encoder.mean.neuron.key.weight"] = shapes["encoder.mean.neuron.query.weight"] = { 2, channels, channels };
  shapes["encoder.mean.out.weight"] = { 2, options.LatentDimension, channels };
  shapes["encoder.deviation.product.weight"] = { 2, channels, channels };
  AddAffineMap(shapes, "encoder.deviation.0", channels, 2 * channels);
  AddAffineMap(shapes, "encoder.deviation.2", options.LatentDimension, channels);
  for (std::int64_t layer = 0; layer <= options.DecoderLayers; ++layer)
  {
    AddAffineMap(shapes, "decoder.layers." + std::to_string(layer),
      layer == options.DecoderLayers ? Colors : options.DecoderWidth,
      layer == 0 ? options.DecoderInputs() : options.DecoderWidth);
  }
  return shapes;
}

} // namespace surfsynth
