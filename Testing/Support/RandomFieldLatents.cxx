// SPDX-License-Identifier: BSD-3-Clause
#include "RandomFieldLatents.h"

#include "ExampleMeshes.h"

#include <cmath>

namespace surfsynth::test
{

namespace
{
bool EndsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

FieldLatentMatrix RandomMatrix(std::int64_t rows, std::int64_t columns, std::uint64_t seed)
{
  FieldLatentMatrix matrix(rows, columns);
  for (Eigen::Index k = 0; k < matrix.size(); ++k)
  {
    matrix.data()[k] = static_cast<float>(Uniform(seed, static_cast<std::uint64_t>(k)));
  }
  return matrix;
}
} // namespace

FieldLatentOptions TinyFieldLatents()
{
  FieldLatentOptions options;
  options.LatentDimension = 3;
  options.Channels = 12;
  options.EncoderLayers = 2;
  options.Heads = 3;
  options.SamplesPerRing = 6;
  options.DecoderLayers = 2;
  options.DecoderWidth = 10;
  return options;
}

FieldLatentModel RandomFieldLatents(const FieldLatentOptions& options, std::uint64_t seed)
{
  FieldLatentModel model;
  model.Options = options;
  model.Iterations = 7;
  seed *= 1000;
  for (const auto& [name, shape] : ExpectedFieldLatentTensors(options))
  {
    ModelTensor& tensor = model.Tensors[name];
    tensor.Shape = shape;
    std::int64_t count = 1;
    for (const std::int64_t extent : shape)
    {
      count *= extent;
    }
    const bool scale = EndsWith(name, ".scale");
    const double factor = scale ? 0.3 : EndsWith(name, ".log_delta") ? 1.0 : 1.0 / std::sqrt(double(shape.back()));
    ++seed;
    for (std::int64_t k = 0; k < count; ++k)
    {
      const double shift = scale && k < count / 2 ? 1.0 : 0.0;
      tensor.Values.push_back(static_cast<float>(shift + factor * Uniform(seed, static_cast<std::uint64_t>(k))));
    }
  }
  return model;
}

FieldLatentRings RandomRings(std::int64_t vertices, std::int64_t samples, std::int64_t more)
{
  FieldLatentRings rings;
  for (std::int64_t v = 0; v < vertices; ++v)
  {
    rings.Offsets.push_back(rings.Offsets.back() + samples + v % more);
  }
  rings.Logarithms = RandomMatrix(rings.Offsets.back(), 2, 17);
  rings.Colors = RandomMatrix(rings.Offsets.back(), 3, 18);
  return rings;
}

FieldLatentMatrix RandomLatents(std::int64_t vertices, std::int64_t dimension)
{
  return RandomMatrix(vertices, 2 * dimension, 19);
}

FieldLatentTexels RandomTexels(std::int64_t count, std::int64_t vertices)
{
  FieldLatentTexels texels;
  texels.Logarithms = RandomMatrix(count, 6, 20);
  texels.Barycentric = RandomMatrix(count, 3, 21).cwiseAbs().array() + 0.01F;
  texels.Corners.resize(count, 3);
  for (Eigen::Index q = 0; q < count; ++q)
  {
    texels.Barycentric.row(q) /= texels.Barycentric.row(q).sum();
    const auto first = static_cast<Index>(q * vertices / count);
    texels.Corners.row(q) << first, static_cast<Index>((first + 1) % vertices),
      static_cast<Index>((first + 5) % vertices);
  }
  return texels;
}

} // namespace surfsynth::test
