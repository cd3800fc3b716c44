// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/FieldLatents/FieldLatentKernels.h"
#include "Inference/FieldLatents/FieldPooling.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"
#include "Inference/FieldLatents/LatentDiffusionWeights.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Vertices of a tile.
constexpr std::int64_t TileRows = 256;

[[noreturn]] void Refuse(const std::string& found, const std::string& expected)
{
  throw InvalidInput("LatentDiffusionNetwork: " + found + "; expected " + expected + ".");
}

/// Features of all vertices of a level.
struct Features
{
  Features(std::int64_t rows, std::int64_t channels)
    : Rows(rows)
    , Channels(channels)
    , Values(static_cast<std::size_t>(2 * rows * channels))
    , MeanSquares(static_cast<std::size_t>(channels), 0.0)
  {}

  float* Row(std::int64_t row) { return this->Values.data() + 2 * this->Channels * row; }
  const float* Row(std::int64_t row) const { return this->Values.data() + 2 * this->Channels * row; }

  std::int64_t Rows;
  std::int64_t Channels;
  LargeArray<float> Values;        ///< [rows, 2 C], parts apart
  std::vector<double> MeanSquares; ///< [C], mean of |X|^2
};

/// One level of the surface with what guides the samples.
struct Level
{
  FieldNeighborhoods Neighborhoods;
  std::int64_t Rows;
};

Level MakeLevel(const TangentNeighborhoods& at, const float* directions, const std::int32_t* shares)
{
  // std::complex<float> has the layout of two numbers.
  return { { at.Start.data(), at.Sources.data(), reinterpret_cast<const float*>(at.Logarithms.data()),
             reinterpret_cast<const float*>(at.Transport.data()), at.Weights.data(),
             reinterpret_cast<const float*>(at.Centroids.data()), directions, shares },
    at.NumberOfVertices() };
}

/// y = W x + b. @param matrix [outputs, inputs]
std::vector<float> Affine(const std::vector<float>& matrix, const std::vector<float>& bias, const float* x)
{
  std::vector<float> y = bias;
  const std::size_t inputs = matrix.size() / bias.size();
  for (std::size_t o = 0; o < y.size(); ++o)
  {
    for (std::size_t i = 0; i < inputs; ++i)
    {
      y[o] += matrix[o * inputs + i] * x[i];
    }
  }
  return y;
}

/// A matrix with its columns multiplied by factors.
std::vector<float> ScaledColumns(std::vector<float> matrix, const std::vector<float>& factors)
{
  for (std::size_t k = 0; k < matrix.size(); ++k)
  {
    matrix[k] *= factors[k % factors.size()];
  }
  return matrix;
}

/// A matrix with its rows multiplied by factors.
std::vector<float> ScaledRows(std::vector<float> matrix, const std::vector<float>& factors)
{
  const std::size_t columns = matrix.size() / factors.size();
  for (std::size_t k = 0; k < matrix.size(); ++k)
  {
    matrix[k] *= factors[k / columns];
  }
  return matrix;
}

/// Counts the stages of one evaluation for its progress reports.
struct StageClock
{
  const Progress& Report;
  double Stages;
  double Done = 0.0;
};
} // namespace

class LatentDiffusionNetwork::Internals
{
public:
  Internals(const LatentDiffusionModel& model, std::shared_ptr<const TangentHierarchy> surface)
    : Options(model.Options)
    , Surface(std::move(surface))
    , Weights(model)
    , Kernels(BestLatentDiffusionKernels())
    , Neurons(BestFieldLatentKernels())
  {}

  FieldLatentMatrix Evaluate(const FieldLatentMatrix& state, double time, const LatentDiffusionConditions& conditions,
    const Progress& progress) const;
  void CheckInput(const FieldLatentMatrix& state, double time, const LatentDiffusionConditions& conditions) const;

  LatentDiffusionOptions Options;
  std::shared_ptr<const TangentHierarchy> Surface;

private:
  std::vector<float> Embeddings(double time) const;
  void RunTiles(
    Features& out, StageClock& clock, const std::function<void(std::int64_t first, std::int64_t rows)>& task) const;
  void ApplyMap(
    const float* in, std::int64_t width, const std::vector<float>& matrix, Features& out, StageClock& clock) const;
  void ApplyNeuron(const Features& in, const FieldNeuron& neuron, Features& out, StageClock& clock) const;
  void Convolve(const Level& level, const Features& in, const FieldConvolutionWeights& weights,
    const std::vector<float>& embeddings, const std::vector<float>& matrix, bool accumulate, Features& out,
    StageClock& clock) const;
  std::vector<float> Gains(const std::vector<float>& gains, const std::vector<float>& embeddings) const;
  void ApplyBlock(const Level& level, const FieldBlock& block, const std::vector<float>& embeddings, Features& x,
    StageClock& clock) const;
  FieldLatentMatrix InputOf(const FieldLatentMatrix& state, const FieldLatentMatrix& directions) const;
  Features Pool(const Features& fine, StageClock& clock) const;
  Features Unpool(const Features& coarse, const Features& skipped, StageClock& clock) const;

  LatentDiffusionWeights Weights;
  const LatentDiffusionKernels& Kernels;
  const FieldLatentKernels& Neurons;
  mutable ScratchPool<LargeArray<float>> Scratch;

  LargeArray<float> BorrowScratch(std::int64_t size) const
  {
    LargeArray<float> scratch = this->Scratch.Borrow();
    return scratch.size() < static_cast<std::size_t>(size) ? LargeArray<float>(static_cast<std::size_t>(size))
                                                           : std::move(scratch);
  }
};

/// Embeddings of each label, then that of vertices without one, [L + 1, e].
std::vector<float> LatentDiffusionNetwork::Internals::Embeddings(double time) const
{
  const std::int64_t half = this->Options.EmbeddingDimension / 2;
  std::vector<float> waves(static_cast<std::size_t>(2 * half));
  for (std::int64_t k = 0; k < half; ++k)
  {
    const double angle = time * std::pow(10000.0, -static_cast<double>(k) / static_cast<double>(half));
    waves[static_cast<std::size_t>(k)] = static_cast<float>(std::cos(angle));
    waves[static_cast<std::size_t>(half + k)] = static_cast<float>(std::sin(angle));
  }
  std::vector<float> hidden = Affine(this->Weights.Time0, this->Weights.TimeBias0, waves.data());
  for (float& value : hidden)
  {
    value = value / (1.0F + std::exp(-value));
  }
  const std::vector<float> embedding = Affine(this->Weights.Time2, this->Weights.TimeBias2, hidden.data());
  std::vector<float> all = this->Weights.Labels;
  all.insert(all.end(), embedding.begin(), embedding.end());
  for (std::size_t k = 0; k < this->Weights.Labels.size(); ++k)
  {
    all[k] += embedding[k % embedding.size()];
  }
  return all;
}

/// Runs a task for each tile of the rows of @p out, which it must write, then computes the mean squares.
void LatentDiffusionNetwork::Internals::RunTiles(
  Features& out, StageClock& clock, const std::function<void(std::int64_t first, std::int64_t rows)>& task) const
{
  const std::int64_t tiles = (out.Rows + TileRows - 1) / TileRows;
  std::vector<float> squares(static_cast<std::size_t>(tiles * out.Channels));
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    tiles,
    [&](std::int64_t tile) {
      const std::int64_t first = tile * TileRows;
      const std::int64_t rows = std::min(TileRows, out.Rows - first);
      task(first, rows);
      this->Kernels.Squares(out.Row(first), rows, out.Channels, squares.data() + tile * out.Channels);
      ++done;
    },
    [&] {
      const double share = static_cast<double>(done) / static_cast<double>(tiles);
      Report(clock.Report, std::min(1.0, (clock.Done + share) / clock.Stages));
    });
  clock.Done += 1.0;
  std::fill(out.MeanSquares.begin(), out.MeanSquares.end(), 0.0);
  for (std::size_t k = 0; k < squares.size(); ++k)
  {
    out.MeanSquares[k % out.MeanSquares.size()] += static_cast<double>(squares[k]) / static_cast<double>(out.Rows);
  }
}

/// out = in M. @param in [V, width] @param matrix [width, 2 C]
void LatentDiffusionNetwork::Internals::ApplyMap(
  const float* in, std::int64_t width, const std::vector<float>& matrix, Features& out, StageClock& clock) const
{
  this->RunTiles(out, clock, [&](std::int64_t first, std::int64_t rows) {
    Multiply(in + first * width, matrix.data(), out.Row(first), rows, width, 2 * out.Channels);
  });
}

/// Equations 20 and 19; @p out may be @p in.
void LatentDiffusionNetwork::Internals::ApplyNeuron(
  const Features& in, const FieldNeuron& neuron, Features& out, StageClock& clock) const
{
  const std::vector<float> matrix = neuron.Normalized(in.MeanSquares);
  this->RunTiles(out, clock, [&](std::int64_t first, std::int64_t rows) {
    LargeArray<float> wide = this->BorrowScratch(TileRows * 4 * out.Channels);
    Multiply(in.Row(first), matrix.data(), wide.data(), rows, 2 * in.Channels, 4 * out.Channels);
    this->Neurons.Neuron(wide.data(), rows, out.Channels, out.Row(first));
    this->Scratch.Return(std::move(wide));
  });
}

/// Factors 1 + G e of complex channels at one time, [2 C]: those of real parts, then the same of imaginary ones.
/// @param gains G, [C, e] @param embeddings the last is that of vertices without a label, which counts
std::vector<float> LatentDiffusionNetwork::Internals::Gains(
  const std::vector<float>& gains, const std::vector<float>& embeddings) const
{
  const auto dimension = static_cast<std::size_t>(this->Options.EmbeddingDimension);
  const std::vector<float> ones(gains.size() / dimension, 1.0F);
  const std::vector<float> factors = Affine(gains, ones, embeddings.data() + embeddings.size() - dimension);
  std::vector<float> both = factors;
  both.insert(both.end(), factors.begin(), factors.end());
  return both;
}

/// Equation 35; @p out is not @p in. @param matrix that of the weights, with gains
void LatentDiffusionNetwork::Internals::Convolve(const Level& level, const Features& in,
  const FieldConvolutionWeights& weights, const std::vector<float>& embeddings, const std::vector<float>& matrix,
  bool accumulate, Features& out, StageClock& clock) const
{
  const std::int64_t channels = weights.Channels;
  FieldNeighborhoods neighborhoods = level.Neighborhoods;
  std::vector<float> shares = weights.Bias;
  if (weights.Embedding.empty())
  {
    neighborhoods.Shares = nullptr;
    neighborhoods.Centroids = nullptr;
    neighborhoods.Directions = nullptr;
  }
  else
  {
    const auto dimension = static_cast<std::size_t>(this->Options.EmbeddingDimension);
    shares.clear();
    for (std::size_t row = 0; row < embeddings.size() / dimension; ++row)
    {
      const std::vector<float> share = Affine(weights.Embedding, weights.Bias, embeddings.data() + row * dimension);
      shares.insert(shares.end(), share.begin(), share.end());
    }
  }
  const FieldFilter filter = { shares.data(), weights.Radius.data(), weights.Aligned.data(), weights.Centroids.data(),
    weights.Directed.data(), weights.Hidden.data(), weights.HiddenBias.data() };
  Features units(in.Rows, channels);
  ParallelFor(in.Rows, TileRows, [&](std::int64_t begin, std::int64_t end) {
    this->Kernels.Units(in.Row(begin), end - begin, channels, units.Row(begin));
  });
  const std::int64_t width = FilterChannels * 2 * channels;
  this->RunTiles(out, clock, [&](std::int64_t first, std::int64_t rows) {
    LargeArray<float> sums = this->BorrowScratch(TileRows * width);
    this->Kernels.GatherFields(
      neighborhoods, filter, in.Values.data(), units.Values.data(), first, rows, channels, sums.data());
    Multiply(sums.data(), matrix.data(), out.Row(first), rows, width, 2 * channels, accumulate);
    this->Scratch.Return(std::move(sums));
  });
}

void LatentDiffusionNetwork::Internals::ApplyBlock(const Level& level, const FieldBlock& block,
  const std::vector<float>& embeddings, Features& x, StageClock& clock) const
{
  Features y(x.Rows, block.Convolution1.Channels);
  Features z(x.Rows, block.Convolution1.Channels);
  this->ApplyNeuron(x, block.Mlp1[0], y, clock);
  this->ApplyNeuron(y, block.Mlp1[1], y, clock);
  this->ApplyNeuron(y, block.Mlp1[2], y, clock);
  this->Convolve(level, y, block.Convolution1, embeddings, block.Convolution1.Matrix, false, z, clock);
  for (const FieldNeuron& neuron : block.Mlp2)
  {
    this->ApplyNeuron(z, neuron, z, clock);
  }
  if (!block.Residual.empty())
  {
    this->ApplyMap(x.Values.data(), 2 * x.Channels, block.Residual, y, clock);
    x = std::move(y);
  }
  const std::vector<float> matrix = ScaledColumns(block.Convolution2.Matrix, this->Gains(block.Gains, embeddings));
  this->Convolve(level, z, block.Convolution2, embeddings, matrix, true, x, clock);
}

/// Mean over the members of each cluster, in the frame of its center.
Features LatentDiffusionNetwork::Internals::Pool(const Features& fine, StageClock& clock) const
{
  Features coarse(this->Surface->Coarse.NumberOfVertices(), fine.Channels);
  this->RunTiles(coarse, clock, [&](std::int64_t first, std::int64_t rows) {
    PoolFieldRows(*this->Surface, fine.Row(0), fine.Channels, first, rows, coarse.Row(first));
  });
  return coarse;
}

/// Features of the center of each vertex in the frame of the vertex, then those of @p skipped.
Features LatentDiffusionNetwork::Internals::Unpool(
  const Features& coarse, const Features& skipped, StageClock& clock) const
{
  Features fine(skipped.Rows, coarse.Channels + skipped.Channels);
  this->RunTiles(fine, clock, [&](std::int64_t first, std::int64_t rows) {
    Features turned(rows, coarse.Channels);
    UnpoolFieldRows(*this->Surface, coarse.Row(0), coarse.Channels, first, rows, turned.Row(0));
    for (std::int64_t row = 0; row < rows; ++row)
    {
      for (std::int64_t part = 0; part < 2; ++part)
      {
        float* out = fine.Row(first + row) + part * fine.Channels;
        std::copy_n(turned.Row(row) + part * coarse.Channels, coarse.Channels, out);
        std::copy_n(skipped.Row(first + row) + part * skipped.Channels, skipped.Channels, out + coarse.Channels);
      }
    }
  });
  return fine;
}

void LatentDiffusionNetwork::Internals::CheckInput(
  const FieldLatentMatrix& state, double time, const LatentDiffusionConditions& conditions) const
{
  const Index vertices = this->Surface->Fine.NumberOfVertices();
  const std::int64_t width = 2 * this->Options.LatentDimension;
  if (state.rows() != vertices || state.cols() != width)
  {
    Refuse("the state is [" + std::to_string(state.rows()) + ", " + std::to_string(state.cols()) + "]",
      "[" + std::to_string(vertices) + ", " + std::to_string(width) + "]");
  }
  if (!state.allFinite() || !conditions.Directions.allFinite())
  {
    Refuse("the state or a direction is not finite", "finite numbers");
  }
  if (!(time >= 0.0 && time <= static_cast<double>(this->Options.TimeSteps)))
  {
    Refuse("the time is " + std::to_string(time), "0 to " + std::to_string(this->Options.TimeSteps));
  }
  const std::int64_t labels = this->Options.NumberOfLabels;
  if (!conditions.Labels.empty() && (labels == 0 || static_cast<Index>(conditions.Labels.size()) != vertices))
  {
    Refuse("there are " + std::to_string(conditions.Labels.size()) + " labels of vertices",
      labels == 0 ? "none: the model was trained without labels" : std::to_string(vertices) + " or none");
  }
  for (const std::int32_t label : conditions.Labels)
  {
    if (label < -1 || label >= labels)
    {
      Refuse("label " + std::to_string(label), "-1 (none) to " + std::to_string(labels - 1));
    }
  }
  const bool directed = conditions.Directions.size() > 0;
  if (directed &&
    (!this->Options.Directed || conditions.Directions.rows() != vertices || conditions.Directions.cols() != 2))
  {
    Refuse("the directions are [" + std::to_string(conditions.Directions.rows()) + ", " +
        std::to_string(conditions.Directions.cols()) + "]",
      this->Options.Directed ? "[" + std::to_string(vertices) + ", 2] or none"
                             : "none: the model was trained without directions");
  }
}

/// State, directions of the centroids of the rings and, in directed models, those of the guidance.
FieldLatentMatrix LatentDiffusionNetwork::Internals::InputOf(
  const FieldLatentMatrix& state, const FieldLatentMatrix& directions) const
{
  FieldLatentMatrix seen = FieldLatentMatrix::Zero(state.rows(), 2 * InputVectors(this->Options));
  seen.leftCols(state.cols()) = state;
  for (Eigen::Index v = 0; v < state.rows(); ++v)
  {
    const std::complex<float> centroid = this->Surface->Fine.Centroids[static_cast<std::size_t>(v)];
    seen(v, state.cols()) = centroid.real();
    seen(v, state.cols() + 1) = centroid.imag();
  }
  if (directions.size() > 0)
  {
    seen.rightCols(2) = directions;
  }
  return seen;
}

FieldLatentMatrix LatentDiffusionNetwork::Internals::Evaluate(const FieldLatentMatrix& state, double time,
  const LatentDiffusionConditions& conditions, const Progress& progress) const
{
  const TangentHierarchy& surface = *this->Surface;
  // Rows of the embeddings: the labels, then none. Coarse vertices have those of their centers.
  const auto none = static_cast<std::int32_t>(this->Options.NumberOfLabels);
  std::vector<std::int32_t> shares(static_cast<std::size_t>(state.rows()), none);
  std::transform(conditions.Labels.begin(), conditions.Labels.end(), shares.begin(),
    [none](std::int32_t label) { return label < 0 ? none : label; });
  std::vector<std::int32_t> coarseShares;
  FieldLatentMatrix coarseDirections(conditions.Directions.size() > 0 ? surface.Centers.size() : 0, 2);
  for (std::size_t a = 0; a < surface.Centers.size(); ++a)
  {
    coarseShares.push_back(shares[static_cast<std::size_t>(surface.Centers[a])]);
    if (coarseDirections.size() > 0)
    {
      coarseDirections.row(static_cast<Eigen::Index>(a)) = conditions.Directions.row(surface.Centers[a]);
    }
  }
  const bool directed = conditions.Directions.size() > 0;
  const Level fine = MakeLevel(surface.Fine, directed ? conditions.Directions.data() : nullptr, shares.data());
  const Level coarse = MakeLevel(surface.Coarse, directed ? coarseDirections.data() : nullptr, coarseShares.data());

  const SingleThreadedBlas blas;
  const std::vector<float> embeddings = this->Embeddings(time);
  const LatentDiffusionWeights& weights = this->Weights;
  const auto blocks = weights.InputBlocks.size() + weights.CoarseBlocks.size() + weights.OutputBlocks.size();
  StageClock clock = { progress, 8.0 * static_cast<double>(blocks) + 6.0 };
  Features x(state.rows(), this->Options.Channels);
  const std::vector<float> entrance = ScaledColumns(weights.Input, this->Gains(weights.InputGains, embeddings));
  const FieldLatentMatrix seen = this->InputOf(state, conditions.Directions);
  this->ApplyMap(seen.data(), seen.cols(), entrance, x, clock);
  for (const FieldBlock& block : weights.InputBlocks)
  {
    this->ApplyBlock(fine, block, embeddings, x, clock);
  }
  Features y = this->Pool(x, clock);
  for (const FieldBlock& block : weights.CoarseBlocks)
  {
    this->ApplyBlock(coarse, block, embeddings, y, clock);
  }
  x = this->Unpool(y, x, clock);
  for (const FieldBlock& block : weights.OutputBlocks)
  {
    this->ApplyBlock(fine, block, embeddings, x, clock);
  }
  const std::vector<float> exit = ScaledRows(weights.Output, this->Gains(weights.OutputGains, embeddings));
  FieldLatentMatrix out(state.rows(), state.cols());
  ParallelTasks((state.rows() + TileRows - 1) / TileRows, [&](std::int64_t tile) {
    const std::int64_t first = tile * TileRows;
    Multiply(x.Row(first), exit.data(), out.row(first).data(), std::min(TileRows, state.rows() - first), 2 * x.Channels,
      out.cols());
  });
  return out;
}

LatentDiffusionNetwork::LatentDiffusionNetwork(
  const LatentDiffusionModel& model, std::shared_ptr<const TangentHierarchy> surface)
{
  CheckModel(model);
  if (!surface)
  {
    Refuse("no surface", "the levels of a surface");
  }
  this->Impl = std::make_unique<Internals>(model, std::move(surface));
}

LatentDiffusionNetwork::~LatentDiffusionNetwork() = default;
LatentDiffusionNetwork::LatentDiffusionNetwork(LatentDiffusionNetwork&&) noexcept = default;
LatentDiffusionNetwork& LatentDiffusionNetwork::operator=(LatentDiffusionNetwork&&) noexcept = default;

const LatentDiffusionOptions& LatentDiffusionNetwork::Options() const { return this->Impl->Options; }

const TangentHierarchy& LatentDiffusionNetwork::Surface() const { return *this->Impl->Surface; }

FieldLatentMatrix LatentDiffusionNetwork::Evaluate(const FieldLatentMatrix& state, double time,
  const LatentDiffusionConditions& conditions, const Progress& progress) const
{
  this->Impl->CheckInput(state, time, conditions);
  if (state.rows() == 0)
  {
    return state;
  }
  FieldLatentMatrix result = this->Impl->Evaluate(state, time, conditions, progress);
  if (!result.allFinite())
  {
    Refuse("a result is not finite", "a state and weights that single precision can hold");
  }
  Report(progress, 1.0);
  return result;
}

double LatentDiffusionOperations(const LatentDiffusionOptions& options, std::int64_t vertices, std::int64_t coarse)
{
  const auto c = static_cast<double>(options.Channels);
  const auto w = static_cast<double>(options.CoarseChannels);
  // A block: two convolutions, six neurons; the first neuron of a block has other inputs.
  const auto block = [](double inputs, double outputs) {
    const double residual = inputs == outputs ? 0.0 : 8.0 * inputs * outputs;
    return residual + 16.0 * inputs * outputs + (5.0 * 16.0 + 2.0 * 8.0 * FilterChannels) * outputs * outputs;
  };
  const double fine = 2.0 * 8.0 * c * static_cast<double>(options.LatentDimension) +
    static_cast<double>(options.InputBlocks + options.OutputBlocks - 1) * block(c, c) + block(c + w, c);
  const double below = block(c, w) + static_cast<double>(options.CoarseBlocks - 1) * block(w, w);
  return fine * static_cast<double>(vertices) + below * static_cast<double>(coarse);
}

} // namespace surfsynth
