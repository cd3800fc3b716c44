// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentDecoder.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/FieldLatents/FieldLatentKernels.h"
#include "Inference/FieldLatents/FieldLatentWeights.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr std::int64_t TileTexels = 160;
constexpr std::int64_t Corners = 3;

[[noreturn]] void RefuseTexels(const std::string& found, const std::string& expected)
{
  throw InvalidInput("FieldLatentDecoder: " + found + "; expected " + expected + ".");
}

std::string SizeOf(const FieldLatentMatrix& matrix)
{
  return "[" + std::to_string(matrix.rows()) + ", " + std::to_string(matrix.cols()) + "]";
}

void CheckTexels(const FieldLatentOptions& options, const FieldLatentMatrix& latents, const FieldLatentTexels& texels)
{
  const std::int64_t count = texels.Corners.rows();
  const bool logarithmic = options.Coordinates == FieldLatentCoordinates::Logarithmic;
  if (count > 0 && latents.cols() != 2 * options.LatentDimension)
  {
    RefuseTexels("the latent codes are " + SizeOf(latents), "[V, " + std::to_string(2 * options.LatentDimension) + "]");
  }
  if (count > 0 && (texels.Barycentric.rows() != count || texels.Barycentric.cols() != Corners))
  {
    RefuseTexels("the barycentric coordinates are " + SizeOf(texels.Barycentric), "[" + std::to_string(count) + ", 3]");
  }
  if (count > 0 && logarithmic && (texels.Logarithms.rows() != count || texels.Logarithms.cols() != 2 * Corners))
  {
    RefuseTexels("the logarithms are " + SizeOf(texels.Logarithms), "[" + std::to_string(count) + ", 6]");
  }
  if (count > 0 && (texels.Corners.minCoeff() < 0 || texels.Corners.maxCoeff() >= latents.rows()))
  {
    RefuseTexels("corners are vertices " + std::to_string(texels.Corners.minCoeff()) + " to " +
        std::to_string(texels.Corners.maxCoeff()),
      "0 to " + std::to_string(latents.rows() - 1));
  }
  if (!latents.allFinite() || !texels.Barycentric.allFinite() || (logarithmic && !texels.Logarithms.allFinite()))
  {
    RefuseTexels("a latent code or a coordinate is not finite", "finite numbers");
  }
}

} // namespace

class FieldLatentDecoder::Internals
{
public:
  /// Temporaries of one tile.
  struct TexelScratch
  {
    std::vector<std::int32_t> Vertices; ///< those of the tile, in order
    std::vector<std::int32_t> Ids;      ///< [TileTexels, 3], places of the corners among them
    std::vector<float> Inputs;          ///< of the vertices
    LargeArray<float> Shares;           ///< of the vertices in the first layer
    LargeArray<float> Hidden[2];        ///< [rows, width]
    std::vector<float> Colors;          ///< [rows, 3]
  };

  explicit Internals(const FieldLatentModel& model)
    : Options(model.Options)
    , Weights(model)
    , Kernels(BestFieldLatentKernels())
  {}

  void DecodeTile(const FieldLatentMatrix& latents, const FieldLatentTexels& texels, std::int64_t first,
    std::int64_t count, float* out) const;

  FieldLatentOptions Options;

private:
  bool IsLogarithmic() const { return this->Options.Coordinates == FieldLatentCoordinates::Logarithmic; }
  std::int64_t RowsOf(std::int64_t texels) const { return this->IsLogarithmic() ? Corners * texels : texels; }
  void Reserve(TexelScratch& scratch) const;
  static void FindVertices(const std::int32_t* corners, std::int64_t count, TexelScratch& scratch);
  void ShareProducts(const FieldLatentMatrix& latents, TexelScratch& scratch) const;
  void ShareCoordinates(const FieldLatentMatrix& latents, TexelScratch& scratch) const;

  FieldLatentDecoderWeights Weights;
  const FieldLatentKernels& Kernels;
  mutable ScratchPool<TexelScratch> Pool;
};

void FieldLatentDecoder::Internals::Reserve(TexelScratch& scratch) const
{
  if (scratch.Shares.size() > 0)
  {
    return;
  }
  const auto rows = static_cast<std::size_t>(this->RowsOf(TileTexels));
  const auto width = static_cast<std::size_t>(this->Options.DecoderWidth);
  const std::size_t vertices = TileTexels * Corners;
  scratch.Inputs.resize(
    vertices * static_cast<std::size_t>(std::max(this->Options.NumberOfProducts(), 4 * this->Options.LatentDimension)));
  scratch.Shares = LargeArray<float>(vertices * (this->IsLogarithmic() ? 3 : 1) * width);
  scratch.Hidden[0] = LargeArray<float>(rows * width);
  scratch.Hidden[1] = LargeArray<float>(rows * width);
  scratch.Colors.resize(rows * 3);
}

/// Finds the different vertices of a tile, and the place of each corner among them. Texels of one triangle follow one
/// another: corners that are those of the texel before are not looked up.
void FieldLatentDecoder::Internals::FindVertices(const std::int32_t* corners, std::int64_t count, TexelScratch& scratch)
{
  const auto isRepeated = [corners](std::int64_t k) { return k >= Corners && corners[k] == corners[k - Corners]; };
  scratch.Vertices.clear();
  for (std::int64_t k = 0; k < Corners * count; ++k)
  {
    if (!isRepeated(k))
    {
      scratch.Vertices.push_back(corners[k]);
    }
  }
  std::sort(scratch.Vertices.begin(), scratch.Vertices.end());
  scratch.Vertices.erase(std::unique(scratch.Vertices.begin(), scratch.Vertices.end()), scratch.Vertices.end());
  scratch.Ids.resize(static_cast<std::size_t>(Corners * count));
  for (std::int64_t k = 0; k < Corners * count; ++k)
  {
    const auto id = static_cast<std::size_t>(k);
    if (isRepeated(k))
    {
      scratch.Ids[id] = scratch.Ids[id - Corners];
      continue;
    }
    const auto found = std::lower_bound(scratch.Vertices.begin(), scratch.Vertices.end(), corners[k]);
    scratch.Ids[id] = static_cast<std::int32_t>(found - scratch.Vertices.begin());
  }
}

/// Share of the outer products z z^* in the first layer, with its bias where corners are decoded apart.
void FieldLatentDecoder::Internals::ShareProducts(const FieldLatentMatrix& latents, TexelScratch& scratch) const
{
  const std::int64_t dimension = this->Options.LatentDimension;
  const std::int64_t products = this->Options.NumberOfProducts();
  const std::int64_t width = this->Options.DecoderWidth;
  const std::int64_t stride = this->IsLogarithmic() ? 3 * width : width;
  const auto vertices = static_cast<std::int64_t>(scratch.Vertices.size());
  float* real = scratch.Inputs.data();
  float* share = scratch.Shares.data();
  for (const std::int32_t vertex : scratch.Vertices)
  {
    const float* z = latents.row(vertex).data();
    float* imaginary = real + products / 2;
    for (std::int64_t i = 0; i < dimension; ++i)
    {
      for (std::int64_t j = i; j < dimension; ++j)
      {
        *real++ = z[2 * i] * z[2 * j] + z[2 * i + 1] * z[2 * j + 1];
        *imaginary++ = z[2 * i + 1] * z[2 * j] - z[2 * i] * z[2 * j + 1];
      }
    }
    real = imaginary;
    if (this->IsLogarithmic())
    {
      std::copy(this->Weights.Bias.begin(), this->Weights.Bias.end(), share);
    }
    share += stride;
  }
  MultiplyBlocks({ scratch.Inputs.data(), products }, { this->Weights.Products.data(), width }, scratch.Shares.data(),
    stride, vertices, products, width, this->IsLogarithmic());
}

/// Share of equation 5 in the first layer: with log = x + i y, conj(z) log = x conj(z) + y i conj(z).
void FieldLatentDecoder::Internals::ShareCoordinates(const FieldLatentMatrix& latents, TexelScratch& scratch) const
{
  const std::int64_t dimension = this->Options.LatentDimension;
  const std::int64_t width = this->Options.DecoderWidth;
  const auto vertices = static_cast<std::int64_t>(scratch.Vertices.size());
  float* input = scratch.Inputs.data();
  for (const std::int32_t vertex : scratch.Vertices)
  {
    const float* z = latents.row(vertex).data();
    for (std::int64_t j = 0; j < dimension; ++j, ++input)
    {
      input[0] = z[2 * j];
      input[dimension] = -z[2 * j + 1];
      input[2 * dimension] = z[2 * j + 1];
      input[3 * dimension] = z[2 * j];
    }
    input += 3 * dimension;
  }
  for (std::int64_t part = 0; part < 2; ++part)
  {
    MultiplyBlocks({ scratch.Inputs.data() + part * 2 * dimension, 4 * dimension },
      { this->Weights.Coordinates.data(), width }, scratch.Shares.data() + (1 + part) * width, 3 * width, vertices,
      2 * dimension, width);
  }
}

/// Decodes texels @p first to @p first + @p count to @p out, [count, 3].
void FieldLatentDecoder::Internals::DecodeTile(const FieldLatentMatrix& latents, const FieldLatentTexels& texels,
  std::int64_t first, std::int64_t count, float* out) const
{
  TexelScratch scratch = this->Pool.Borrow();
  this->Reserve(scratch);
  FindVertices(texels.Corners.data() + Corners * first, count, scratch);
  this->ShareProducts(latents, scratch);
  const std::int64_t rows = this->RowsOf(count);
  const std::int64_t width = this->Options.DecoderWidth;
  const float* barycentric = texels.Barycentric.data() + Corners * first;
  float* hidden = scratch.Hidden[0].data();
  float* next = scratch.Hidden[1].data();
  if (this->IsLogarithmic())
  {
    this->ShareCoordinates(latents, scratch);
    this->Kernels.LogarithmicTexels(
      scratch.Shares.data(), scratch.Ids.data(), texels.Logarithms.data() + 2 * Corners * first, rows, width, hidden);
  }
  else
  {
    this->Kernels.BarycentricTexels(
      scratch.Shares.data(), scratch.Ids.data(), barycentric, this->Weights.Bias.data(), rows, width, hidden);
  }
  for (std::size_t layer = 0; layer + 1 < this->Weights.Layers.size(); ++layer)
  {
    Multiply(hidden, this->Weights.Layers[layer].Matrix.data(), next, rows, width, width);
    this->Kernels.BiasSilu(next, this->Weights.Layers[layer].Bias.data(), rows, width);
    std::swap(hidden, next);
  }
  const FieldLatentAffine& last = this->Weights.Layers.back();
  float* colors = scratch.Colors.data();
  Multiply(hidden, last.Matrix.data(), colors, rows, width, 3);
  for (std::int64_t texel = 0; texel < count; ++texel)
  {
    for (std::int64_t c = 0; c < 3; ++c)
    {
      const float* b = barycentric + 3 * texel;
      const float* of = colors + 9 * texel + c;
      const float bias = last.Bias[static_cast<std::size_t>(c)];
      out[3 * texel + c] = this->IsLogarithmic() ? b[0] * (of[0] + bias) + b[1] * (of[3] + bias) + b[2] * (of[6] + bias)
                                                 : colors[3 * texel + c] + bias;
    }
  }
  this->Pool.Return(std::move(scratch));
}

FieldLatentDecoder::FieldLatentDecoder(const FieldLatentModel& model)
{
  CheckModel(model);
  this->Impl = std::make_unique<Internals>(model);
}

FieldLatentDecoder::~FieldLatentDecoder() = default;
FieldLatentDecoder::FieldLatentDecoder(FieldLatentDecoder&&) noexcept = default;
FieldLatentDecoder& FieldLatentDecoder::operator=(FieldLatentDecoder&&) noexcept = default;

const FieldLatentOptions& FieldLatentDecoder::Options() const { return this->Impl->Options; }

FieldLatentMatrix FieldLatentDecoder::Decode(
  const FieldLatentMatrix& latents, const FieldLatentTexels& texels, const Progress& progress) const
{
  CheckTexels(this->Options(), latents, texels);
  const std::int64_t count = texels.Corners.rows();
  const std::int64_t tiles = (count + TileTexels - 1) / TileTexels;
  FieldLatentMatrix colors(count, 3);
  const SingleThreadedBlas blas;
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    tiles,
    [&](std::int64_t tile) {
      const std::int64_t first = tile * TileTexels;
      this->Impl->DecodeTile(latents, texels, first, std::min(TileTexels, count - first), colors.data() + 3 * first);
      ++done;
    },
    [&] { Report(progress, static_cast<double>(done) / static_cast<double>(tiles)); });
  if (!colors.allFinite())
  {
    RefuseTexels("a color is not finite", "latent codes and weights that single precision can hold");
  }
  Report(progress, 1.0);
  return colors;
}

} // namespace surfsynth
