// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/FieldLatentEncoder.h"

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
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <utility>

namespace surfsynth
{

namespace
{
/// Tokens of a tile; a ring with more is a tile of its own.
constexpr std::int64_t TileTokens = 512;
/// Queries of a ring whose attention is computed together: bounds the memory of large rings.
constexpr std::int64_t QueriesAtOnce = 128;

[[noreturn]] void RefuseRings(const std::string& found, const std::string& expected)
{
  throw InvalidInput("FieldLatentEncoder: " + found + "; expected " + expected + ".");
}

void CheckRings(const FieldLatentRings& rings)
{
  const std::vector<std::int64_t>& offsets = rings.Offsets;
  const std::string samples = std::to_string(rings.Logarithms.rows());
  if (rings.Logarithms.rows() != rings.Colors.rows() ||
    (rings.Logarithms.rows() > 0 && (rings.Logarithms.cols() != 2 || rings.Colors.cols() != 3)))
  {
    RefuseRings("the logarithms are [" + samples + ", " + std::to_string(rings.Logarithms.cols()) +
        "] and the colors [" + std::to_string(rings.Colors.rows()) + ", " + std::to_string(rings.Colors.cols()) + "]",
      "[S, 2] and [S, 3]");
  }
  if (offsets.empty() || offsets.front() != 0 || offsets.back() != rings.Logarithms.rows() ||
    !std::is_sorted(offsets.begin(), offsets.end()))
  {
    RefuseRings("the " + std::to_string(offsets.size()) + " offsets do not cut " + samples + " samples into rings",
      "offsets from 0 to " + samples + " that never decrease");
  }
  if (!rings.Logarithms.allFinite() || !rings.Colors.allFinite())
  {
    RefuseRings("a logarithm or a color is not finite", "finite numbers");
  }
}

/// First vertices of tiles of at most TileTokens tokens, and the number of vertices at the end.
std::vector<std::int64_t> CutIntoTiles(const std::vector<std::int64_t>& offsets)
{
  std::vector<std::int64_t> tiles = { 0 };
  const auto vertices = static_cast<std::int64_t>(offsets.size()) - 1;
  std::int64_t tokens = 0;
  for (std::int64_t v = 0; v < vertices; ++v)
  {
    const std::int64_t size = offsets[static_cast<std::size_t>(v) + 1] - offsets[static_cast<std::size_t>(v)] + 1;
    if (tokens > 0 && tokens + size > TileTokens)
    {
      tiles.push_back(v);
      tokens = 0;
    }
    tokens += size;
  }
  tiles.push_back(vertices);
  return tiles;
}

/// Reports progress, and sets @p stop when that throws.
void ReportOrStop(const Progress& progress, double fraction, std::atomic<bool>& stop)
{
  try
  {
    Report(progress, fraction);
  }
  catch (...)
  {
    stop = true;
    throw;
  }
}

/// A tile: some rings, the tokens of which follow each other; the token of equation 22 is the last of its ring.
struct Tile
{
  const FieldLatentRings& Rings;
  std::int64_t First; ///< first vertex
  std::int64_t Last;  ///< after the last vertex

  std::int64_t Vertices() const { return this->Last - this->First; }
  std::int64_t FirstSample(std::int64_t v) const { return this->Rings.Offsets[static_cast<std::size_t>(v)]; }
  std::int64_t Samples(std::int64_t v) const { return this->FirstSample(v + 1) - this->FirstSample(v); }
  /// Row of the first token of a vertex in the tile.
  std::int64_t Row(std::int64_t v) const
  {
    return this->FirstSample(v) - this->FirstSample(this->First) + v - this->First;
  }
  std::int64_t Tokens() const { return this->Row(this->Last); }
};
} // namespace

class FieldLatentEncoder::Internals
{
public:
  using Heartbeat = std::function<void()>;

  /// Temporaries of one tile.
  struct TileScratch
  {
    /// Makes room for @p tokens tokens of @p channels channels.
    void Reserve(std::int64_t tokens, std::int64_t channels)
    {
      const auto size = static_cast<std::size_t>(tokens * channels);
      if (this->Wide.size() < 6 * size)
      {
        this->Features = LargeArray<float>(2 * size);
        this->Other = LargeArray<float>(2 * size);
        this->Wide = LargeArray<float>(6 * size);
        this->Scores = LargeArray<float>(static_cast<std::size_t>((tokens + 2) * QueriesAtOnce));
      }
    }

    LargeArray<float> Features; ///< [tokens, 2 C]
    LargeArray<float> Other;    ///< [tokens, 2 C]
    LargeArray<float> Wide;     ///< [tokens, 6 C]
    LargeArray<float> Scores;   ///< [tokens + 2, QueriesAtOnce]
  };

  explicit Internals(const FieldLatentModel& model)
    : Options(model.Options)
    , Weights(model)
    , Kernels(BestFieldLatentKernels())
  {}

  /// @param beat is called now and then; it may throw
  void EncodeTile(const Tile& tile, const Heartbeat& beat, FieldLatentCodes& codes) const;

  FieldLatentOptions Options;

private:
  void Lift(const Tile& tile, TileScratch& scratch) const;
  void NormalizeRings(const Tile& tile, const FieldLatentNorm& norm, const float* in, float* out) const;
  void Attend(const Tile& tile, const Heartbeat& beat, TileScratch& scratch) const;
  void AttendRing(std::int64_t tokens, const Heartbeat& beat, const float* in, float* scores, float* out) const;
  void ApplyLayer(
    const Tile& tile, const FieldLatentLayer& layer, bool last, const Heartbeat& beat, TileScratch& scratch) const;
  void KeepTokens(const Tile& tile, float* rows) const;
  void PredictMean(const Tile& tile, TileScratch& scratch, FieldLatentCodes& codes) const;
  void PredictDeviation(const Tile& tile, TileScratch& scratch, FieldLatentCodes& codes) const;

  FieldLatentEncoderWeights Weights;
  const FieldLatentKernels& Kernels;
  mutable ScratchPool<TileScratch> Pool;
};

/// Equations 21 and 22 for all rings: the features of all tokens.
void FieldLatentEncoder::Internals::Lift(const Tile& tile, TileScratch& scratch) const
{
  const std::int64_t channels = this->Options.Channels;
  const std::int64_t first = tile.FirstSample(tile.First);
  const std::int64_t samples = tile.FirstSample(tile.Last) - first;
  const float* logarithms = tile.Rings.Logarithms.data() + 2 * first;
  const float* colors = tile.Rings.Colors.data() + 3 * first;
  float* filter = scratch.Wide.data();
  this->Kernels.Radii(logarithms, this->Weights.FilterIn.Matrix.data(), this->Weights.FilterIn.Bias.data(), samples,
    channels, scratch.Other.data());
  Multiply(scratch.Other.data(), this->Weights.FilterOut.Matrix.data(), filter, samples, channels, 2 * channels);
  for (std::int64_t v = tile.First; v < tile.Last; ++v)
  {
    const std::int64_t sample = tile.FirstSample(v) - first;
    const std::int64_t size = tile.Samples(v);
    float* features = scratch.Features.data() + 2 * channels * tile.Row(v);
    this->Kernels.Lift(colors + 3 * sample, logarithms + 2 * sample, this->Weights.Lift.Matrix.data(),
      this->Weights.Lift.Bias.data(), size, channels, features);
    this->Kernels.Gather(colors + 3 * sample, logarithms + 2 * sample, this->Weights.GatherColors.Matrix.data(),
      this->Weights.GatherColors.Bias.data(), filter + 2 * channels * sample, this->Weights.FilterOut.Bias.data(), size,
      channels, features + 2 * channels * size);
  }
}

void FieldLatentEncoder::Internals::NormalizeRings(
  const Tile& tile, const FieldLatentNorm& norm, const float* in, float* out) const
{
  const std::int64_t channels = this->Options.Channels;
  std::vector<float> scale(static_cast<std::size_t>(channels));
  for (std::int64_t v = tile.First; v < tile.Last; ++v)
  {
    const std::int64_t at = 2 * channels * tile.Row(v);
    this->Kernels.Normalize(
      in + at, norm.Scale.data(), norm.Delta.data(), tile.Samples(v) + 1, channels, scale.data(), out + at);
  }
}

/// Attention within one ring, quadratic in its tokens: @p beat is called for each block of queries of a ring that is a
/// tile of its own. @param in [tokens, 6 C]: queries, keys and values. @param out [tokens, 2 C]
void FieldLatentEncoder::Internals::AttendRing(
  std::int64_t tokens, const Heartbeat& beat, const float* in, float* scores, float* out) const
{
  const std::int64_t width = 2 * this->Options.Channels;
  const std::int64_t size = width / this->Options.Heads;
  const float scale = 1.0F / std::sqrt(static_cast<float>(size));
  float* sums = scores + tokens * QueriesAtOnce;
  for (std::int64_t head = 0; head < this->Options.Heads; ++head)
  {
    const float* queries = in + head * size;
    const float* keys = queries + width;
    const float* values = keys + width;
    for (std::int64_t query = 0; query < tokens; query += QueriesAtOnce)
    {
      const std::int64_t count = std::min(QueriesAtOnce, tokens - query);
      if (tokens > TileTokens)
      {
        beat();
      }
      // A column for each query, so that the loops of the softmax run along rows.
      MultiplyBlocks(
        { keys, 3 * width }, { queries + query * 3 * width, 3 * width, true }, scores, count, tokens, size, count);
      this->Kernels.ColumnSoftmax(scores, scale, tokens, count, sums);
      MultiplyBlocks(
        { scores, count, true }, { values, 3 * width }, out + query * width + head * size, width, count, tokens, size);
    }
  }
}

/// Attention within each ring, from Wide to Other.
void FieldLatentEncoder::Internals::Attend(const Tile& tile, const Heartbeat& beat, TileScratch& scratch) const
{
  const std::int64_t width = 2 * this->Options.Channels;
  for (std::int64_t v = tile.First; v < tile.Last; ++v)
  {
    const std::int64_t row = tile.Row(v);
    this->AttendRing(tile.Samples(v) + 1, beat, scratch.Wide.data() + 3 * width * row, scratch.Scores.data(),
      scratch.Other.data() + width * row);
  }
}

/// Moves the rows of the rings' tokens to the front.
void FieldLatentEncoder::Internals::KeepTokens(const Tile& tile, float* rows) const
{
  const std::int64_t width = 2 * this->Options.Channels;
  for (std::int64_t v = tile.First; v < tile.Last; ++v)
  {
    const float* token = rows + width * (tile.Row(v) + tile.Samples(v));
    std::copy(token, token + width, rows + width * (v - tile.First));
  }
}

/// One VN-transformer layer; the last one leaves only the tokens, in the first rows, for nothing else is read.
void FieldLatentEncoder::Internals::ApplyLayer(
  const Tile& tile, const FieldLatentLayer& layer, bool last, const Heartbeat& beat, TileScratch& scratch) const
{
  const std::int64_t channels = this->Options.Channels;
  const std::int64_t width = 2 * channels;
  const std::int64_t tokens = tile.Tokens();
  float* features = scratch.Features.data();
  float* other = scratch.Other.data();
  float* wide = scratch.Wide.data();
  this->NormalizeRings(tile, layer.Norm1, features, other);
  Multiply(other, layer.QueryKeyValue.data(), wide, tokens, width, 3 * width);
  this->Attend(tile, beat, scratch);
  Multiply(other, layer.Out.data(), features, tokens, width, width, true);
  this->NormalizeRings(tile, layer.Norm2, features, other);
  if (last)
  {
    this->KeepTokens(tile, features);
    this->KeepTokens(tile, other);
  }
  const std::int64_t rows = last ? tile.Vertices() : tokens;
  Multiply(other, layer.Neuron1.data(), wide, rows, width, 2 * width);
  this->Kernels.Neuron(wide, rows, channels, other);
  Multiply(other, layer.Neuron2.data(), wide, rows, width, 2 * width);
  this->Kernels.AddNeuron(wide, rows, channels, features);
}

/// Equation 24, from the tokens in the first rows of Features.
void FieldLatentEncoder::Internals::PredictMean(const Tile& tile, TileScratch& scratch, FieldLatentCodes& codes) const
{
  const std::int64_t channels = this->Options.Channels;
  Multiply(scratch.Features.data(), this->Weights.MeanNeuron.data(), scratch.Wide.data(), tile.Vertices(), 2 * channels,
    4 * channels);
  this->Kernels.Neuron(scratch.Wide.data(), tile.Vertices(), channels, scratch.Other.data());
  Multiply(scratch.Other.data(), this->Weights.MeanOut.data(), codes.Mean.row(tile.First).data(), tile.Vertices(),
    2 * channels, codes.Mean.cols());
}

/// Equation 25, from the tokens in the first rows of Features.
void FieldLatentEncoder::Internals::PredictDeviation(
  const Tile& tile, TileScratch& scratch, FieldLatentCodes& codes) const
{
  const std::int64_t channels = this->Options.Channels;
  const std::int64_t vertices = tile.Vertices();
  float* token = scratch.Features.data();
  float* product = scratch.Other.data();
  Multiply(token, this->Weights.Product.data(), product, vertices, 2 * channels, 2 * channels);
  for (std::int64_t row = 0; row < vertices; ++row)
  {
    float* x = token + row * 2 * channels;
    const float* y = product + row * 2 * channels;
    for (std::int64_t c = 0; c < channels; ++c)
    {
      const float re = x[c];
      const float im = x[channels + c];
      x[c] = re * y[c] + im * y[channels + c];
      x[channels + c] = im * y[c] - re * y[channels + c];
    }
  }
  Multiply(token, this->Weights.DeviationIn.Matrix.data(), product, vertices, 2 * channels, channels);
  this->Kernels.BiasSilu(product, this->Weights.DeviationIn.Bias.data(), vertices, channels);
  const auto dimension = codes.LogDeviation.cols();
  auto out = codes.LogDeviation.middleRows(tile.First, vertices);
  out.rowwise() = Eigen::Map<const Eigen::RowVectorXf>(this->Weights.DeviationOut.Bias.data(), dimension);
  Multiply(product, this->Weights.DeviationOut.Matrix.data(), codes.LogDeviation.row(tile.First).data(), vertices,
    channels, dimension, true);
}

void FieldLatentEncoder::Internals::EncodeTile(const Tile& tile, const Heartbeat& beat, FieldLatentCodes& codes) const
{
  TileScratch scratch = this->Pool.Borrow();
  scratch.Reserve(std::max(tile.Tokens(), TileTokens), this->Options.Channels);
  this->Lift(tile, scratch);
  for (std::size_t layer = 0; layer < this->Weights.Layers.size(); ++layer)
  {
    this->ApplyLayer(tile, this->Weights.Layers[layer], layer + 1 == this->Weights.Layers.size(), beat, scratch);
  }
  this->PredictMean(tile, scratch, codes);
  this->PredictDeviation(tile, scratch, codes);
  this->Pool.Return(std::move(scratch));
}

FieldLatentEncoder::FieldLatentEncoder(const FieldLatentModel& model)
{
  CheckModel(model);
  this->Impl = std::make_unique<Internals>(model);
}

FieldLatentEncoder::~FieldLatentEncoder() = default;
FieldLatentEncoder::FieldLatentEncoder(FieldLatentEncoder&&) noexcept = default;
FieldLatentEncoder& FieldLatentEncoder::operator=(FieldLatentEncoder&&) noexcept = default;

const FieldLatentOptions& FieldLatentEncoder::Options() const { return this->Impl->Options; }

FieldLatentCodes FieldLatentEncoder::Encode(const FieldLatentRings& rings, const Progress& progress) const
{
  CheckRings(rings);
  const std::int64_t vertices = rings.NumberOfVertices();
  const std::int64_t dimension = this->Options().LatentDimension;
  FieldLatentCodes codes = { FieldLatentMatrix(vertices, 2 * dimension), FieldLatentMatrix(vertices, dimension) };
  const std::vector<std::int64_t> tiles = CutIntoTiles(rings.Offsets);
  const auto count = static_cast<std::int64_t>(vertices > 0 ? tiles.size() - 1 : 0);
  const SingleThreadedBlas blas;
  std::atomic<std::int64_t> done{ 0 };
  std::atomic<bool> stop{ false };
  const auto report = [&] { ReportOrStop(progress, static_cast<double>(done) / static_cast<double>(count), stop); };
  const std::thread::id caller = std::this_thread::get_id();
  // Within a tile, which may be one ring of very many triangles: progress on the calling thread, the end on all.
  const auto beat = [&] {
    if (std::this_thread::get_id() == caller)
    {
      report();
    }
    else if (stop)
    {
      throw Cancelled("Stopped on request.");
    }
  };
  ParallelTasks(
    count,
    [&](std::int64_t tile) {
      const auto k = static_cast<std::size_t>(tile);
      this->Impl->EncodeTile({ rings, tiles[k], tiles[k + 1] }, beat, codes);
      ++done;
    },
    report);
  if (!codes.Mean.allFinite() || !codes.LogDeviation.allFinite())
  {
    RefuseRings("a latent code is not finite", "samples and weights that single precision can hold");
  }
  Report(progress, 1.0);
  return codes;
}

} // namespace surfsynth
