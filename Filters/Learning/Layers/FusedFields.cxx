// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FusedFields.h"

#include "Core/Common/Errors.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/FieldLatents/FieldLatentKernels.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"
#include "Learning/Layers/KeptValue.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>

namespace surfsynth
{

// Longer than other files: the steps share their tiles, the places of complex weights and the order of their sums.

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Parts of the rows whose sums are added in order, whatever the number of threads.
constexpr std::int64_t FieldParts = 8;
/// Most rows of a tile.
constexpr std::int64_t FieldTileRows = 256;

/// Calls body(part, begin, end) for each part of the rows, on torch's threads.
template <typename Body>
void ForFieldParts(std::int64_t rows, const Body& body)
{
  at::parallel_for(0, FieldParts, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t part = begin; part < end; ++part)
    {
      body(part, rows * part / FieldParts, rows * (part + 1) / FieldParts);
    }
  });
}

/// Most rows of a tile for products with @p columns numbers in a row: more where a mebibyte holds them, so that matrices
/// are packed less often.
std::int64_t ProductTileRows(std::int64_t columns)
{
  return std::clamp<std::int64_t>((std::int64_t(1) << 18) / columns, FieldTileRows, 2 * FieldTileRows);
}

/// Calls body(first, count) for tiles of about the same number of rows, at most @p most.
template <typename Body>
void ForFieldTiles(std::int64_t begin, std::int64_t end, std::int64_t most, const Body& body)
{
  const std::int64_t tiles = (end - begin + most - 1) / most;
  for (std::int64_t tile = 0; tile < tiles; ++tile)
  {
    const std::int64_t first = begin + (end - begin) * tile / tiles;
    body(first, begin + (end - begin) * (tile + 1) / tiles - first);
  }
}

/// Numbers to keep for the derivatives, [rows, columns]; undefined where @p needed is false or they are too many.
torch::Tensor KeptNumbers(bool needed, std::int64_t rows, std::int64_t columns, const torch::Tensor& like)
{
  const bool fits = rows * columns * static_cast<std::int64_t>(sizeof(float)) <= FieldStepMemory();
  return needed && fits ? torch::empty({ rows, columns }, like.options()) : torch::Tensor();
}

/// True when derivatives by one of @p tensors will be asked for.
bool NeedsDerivatives(const variable_list& tensors)
{
  return torch::GradMode::is_enabled() &&
    std::any_of(tensors.begin(), tensors.end(), [](const torch::Tensor& tensor) { return tensor.requires_grad(); });
}

/// Uninitialized numbers.
std::unique_ptr<float[]> FieldScratch(std::int64_t size)
{
  return std::unique_ptr<float[]>(new float[static_cast<std::size_t>(size)]);
}

/// Real matrix of a complex map, by inputs: real parts of a group of channels, its imaginary parts, the next group; in
/// columns real parts of the outputs, then imaginary parts.
struct ComplexPlaces
{
  std::int64_t Outputs;
  std::int64_t Inputs;
  std::int64_t Group;      ///< input channels of a group
  std::int64_t Stride;     ///< columns of the matrix
  std::int64_t Column = 0; ///< first column

  /// Writes the map. @param weight [2, outputs, inputs]
  void Place(const float* weight, float* matrix) const
  {
    const float* imaginary = weight + this->Outputs * this->Inputs;
    this->ForWeights([&](std::int64_t k, std::int64_t re, std::int64_t im) {
      matrix[re] = weight[k];
      matrix[re + this->Outputs] = imaginary[k];
      matrix[im] = -imaginary[k];
      matrix[im + this->Outputs] = weight[k];
    });
  }

  /// Computes the derivatives by the map from those by the matrix.
  void Gradient(const float* byMatrix, float* byWeight) const
  {
    float* imaginary = byWeight + this->Outputs * this->Inputs;
    this->ForWeights([&](std::int64_t k, std::int64_t re, std::int64_t im) {
      byWeight[k] = byMatrix[re] + byMatrix[im + this->Outputs];
      imaginary[k] = byMatrix[re + this->Outputs] - byMatrix[im];
    });
  }

private:
  /// Calls body with each weight and its places in the rows of both parts of the input.
  template <typename Body>
  void ForWeights(const Body& body) const
  {
    for (std::int64_t o = 0; o < this->Outputs; ++o)
    {
      for (std::int64_t group = 0; group < this->Inputs; group += this->Group)
      {
        for (std::int64_t i = 0; i < this->Group; ++i)
        {
          const std::int64_t re = (2 * group + i) * this->Stride + this->Column + o;
          body(o * this->Inputs + group + i, re, re + this->Group * this->Stride);
        }
      }
    }
  }
};

/// Weights of a neuron, with the normalization that its matrix takes in.
class NeuronMatrices
{
public:
  /// @param meanSquares [a], mean of |X|^2 over the vertices, float64
  NeuronMatrices(const torch::Tensor& meanSquares, const torch::Tensor& scale, const torch::Tensor& logDelta,
    const torch::Tensor& key, const torch::Tensor& query)
    : Inputs(key.size(2))
    , Outputs(key.size(1))
    , Scale(scale.data_ptr<float>())
    , Matrix(static_cast<std::size_t>(8 * this->Inputs * this->Outputs))
  {
    this->KeyPlaces().Place(key.data_ptr<float>(), this->Matrix.data());
    this->QueryPlaces().Place(query.data_ptr<float>(), this->Matrix.data());
    for (std::int64_t c = 0; c < this->Inputs; ++c)
    {
      this->Delta.push_back(std::exp(logDelta.data_ptr<float>()[c]));
      this->Inverse.push_back(static_cast<float>(
        1.0 / std::sqrt(meanSquares.data_ptr<double>()[c] + static_cast<double>(this->Delta.back()))));
    }
    this->Normalize();
  }

  ComplexPlaces KeyPlaces() const { return { this->Outputs, this->Inputs, this->Inputs, 4 * this->Outputs }; }
  ComplexPlaces QueryPlaces() const
  {
    return { this->Outputs, this->Inputs, this->Inputs, 4 * this->Outputs, 2 * this->Outputs };
  }
  /// Matrix that reads the features before their normalization, [2 a, 4 b].
  const float* Normalized() const { return this->NormalizedMatrix.data(); }

  /// Turns the derivatives by the normalized matrix, [2 a, 4 b], into those by the matrix, and computes those by scale
  /// [2 a], logarithm of delta [a] and mean squares [a].
  void Gradient(float* byMatrix, float* byScale, float* byLogDelta, float* bySquares) const
  {
    const std::int64_t columns = 4 * this->Outputs;
    for (std::int64_t c = 0; c < this->Inputs; ++c)
    {
      const float* re = this->Matrix.data() + c * columns;
      const float* im = re + this->Inputs * columns;
      float* byRe = byMatrix + c * columns;
      float* byIm = byRe + this->Inputs * columns;
      const float inverse = this->Inverse[static_cast<std::size_t>(c)];
      const float a = inverse * this->Scale[c];
      const float b = inverse * this->Scale[this->Inputs + c];
      float byA = 0.0F;
      float byB = 0.0F;
      for (std::int64_t k = 0; k < columns; ++k)
      {
        byA += byRe[k] * re[k] + byIm[k] * im[k];
        byB += byRe[k] * im[k] - byIm[k] * re[k];
        const float first = byRe[k];
        byRe[k] = a * first - b * byIm[k];
        byIm[k] = b * first + a * byIm[k];
      }
      byScale[c] = inverse * byA;
      byScale[this->Inputs + c] = inverse * byB;
      // a / sqrt(m + delta) by m + delta.
      bySquares[c] = -0.5F * inverse * inverse * (a * byA + b * byB);
      byLogDelta[c] = bySquares[c] * this->Delta[static_cast<std::size_t>(c)];
    }
  }

private:
  void Normalize()
  {
    this->NormalizedMatrix.resize(this->Matrix.size());
    const std::int64_t columns = 4 * this->Outputs;
    for (std::int64_t c = 0; c < this->Inputs; ++c)
    {
      const std::int64_t first = c * columns;
      const std::int64_t second = (this->Inputs + c) * columns;
      const float a = this->Inverse[static_cast<std::size_t>(c)] * this->Scale[c];
      const float b = this->Inverse[static_cast<std::size_t>(c)] * this->Scale[this->Inputs + c];
      const float* from = this->Matrix.data();
      float* to = this->NormalizedMatrix.data();
      for (std::int64_t k = 0; k < columns; ++k)
      {
        to[first + k] = a * from[first + k] + b * from[second + k];
        to[second + k] = a * from[second + k] - b * from[first + k];
      }
    }
  }

  std::int64_t Inputs;
  std::int64_t Outputs;
  const float* Scale;                  ///< [2 a]
  std::vector<float> Matrix;           ///< [2 a, 4 b]
  std::vector<float> NormalizedMatrix; ///< [2 a, 4 b]
  std::vector<float> Delta;            ///< [a]
  std::vector<float> Inverse;          ///< [a], 1 / sqrt(mean square + delta)
};

/// Mean of |X|^2 over the vertices, [C] in float64.
torch::Tensor MeanSquares(const torch::Tensor& x)
{
  const std::int64_t channels = x.size(1) / 2;
  const torch::Tensor parts = torch::zeros({ FieldParts, channels }, torch::kFloat64);
  const float* from = x.data_ptr<float>();
  double* to = parts.data_ptr<double>();
  ForFieldParts(x.size(0), [&](std::int64_t part, std::int64_t begin, std::int64_t end) {
    std::vector<float> squares(static_cast<std::size_t>(channels));
    ForFieldTiles(begin, end, FieldTileRows, [&](std::int64_t first, std::int64_t rows) {
      BestLatentDiffusionKernels().Squares(from + 2 * channels * first, rows, channels, squares.data());
      std::transform(squares.begin(), squares.end(), to + part * channels, to + part * channels,
        [](float square, double sum) { return sum + static_cast<double>(square); });
    });
  });
  return parts.sum(0).div_(static_cast<double>(std::max<std::int64_t>(x.size(0), 1)));
}

/// Equations 20 and 19 on [V, 2 a].
class FieldNeuronStep : public torch::autograd::Function<FieldNeuronStep>
{
public:
  /// @param keep true to keep keys and queries for the derivatives, where they fit
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& x, const torch::Tensor& scale,
    const torch::Tensor& logDelta, const torch::Tensor& key, const torch::Tensor& query, bool keep)
  {
    const torch::Tensor in = x.contiguous();
    const torch::Tensor meanSquares = MeanSquares(in);
    const NeuronMatrices matrices(meanSquares, scale, logDelta, key, query);
    const std::int64_t width = in.size(1);
    const std::int64_t outputs = key.size(1);
    const torch::Tensor out = torch::empty({ in.size(0), 2 * outputs }, in.options());
    const torch::Tensor kept = KeptNumbers(keep, in.size(0), 4 * outputs, in);
    const float* from = in.data_ptr<float>();
    float* to = out.data_ptr<float>();
    float* all = kept.defined() ? kept.data_ptr<float>() : nullptr;
    const std::int64_t most = ProductTileRows(4 * outputs);
    const SingleThreadedBlas blas;
    ForFieldParts(in.size(0), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
      const auto scratch = FieldScratch(all ? 0 : most * 4 * outputs);
      ForFieldTiles(begin, end, most, [&](std::int64_t first, std::int64_t rows) {
        float* wide = all ? all + first * 4 * outputs : scratch.get();
        Multiply(from + first * width, matrices.Normalized(), wide, rows, width, 4 * outputs);
        BestFieldLatentKernels().Neuron(wide, rows, outputs, to + 2 * first * outputs);
      });
    });
    context->save_for_backward({ in, scale, logDelta, key, query, meanSquares, kept });
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor& in = saved[0];
    const torch::Tensor gradient = gradients[0].contiguous();
    const NeuronMatrices matrices(saved[5], saved[1], saved[2], saved[3], saved[4]);
    const torch::Tensor dx = torch::empty_like(in);
    const torch::Tensor byMatrix = MatrixGradient(in, gradient, matrices.Normalized(), saved[6], dx);

    const torch::Tensor byScale = torch::empty_like(saved[1]);
    const torch::Tensor byLogDelta = torch::empty_like(saved[2]);
    std::vector<float> bySquares(static_cast<std::size_t>(in.size(1) / 2));
    matrices.Gradient(
      byMatrix.data_ptr<float>(), byScale.data_ptr<float>(), byLogDelta.data_ptr<float>(), bySquares.data());
    AddSquares(in, bySquares, dx);
    const torch::Tensor byKey = torch::empty_like(saved[3]);
    const torch::Tensor byQuery = torch::empty_like(saved[4]);
    matrices.KeyPlaces().Gradient(byMatrix.data_ptr<float>(), byKey.data_ptr<float>());
    matrices.QueryPlaces().Gradient(byMatrix.data_ptr<float>(), byQuery.data_ptr<float>());
    return { dx, byScale, byLogDelta, byKey, byQuery, torch::Tensor() };
  }

private:
  /// Derivatives by the normalized matrix, and by x for constant mean squares.
  /// @param kept keys and queries, or undefined to compute them again
  static torch::Tensor MatrixGradient(const torch::Tensor& in, const torch::Tensor& gradient, const float* matrix,
    const torch::Tensor& kept, const torch::Tensor& dx)
  {
    const std::int64_t width = in.size(1);
    const std::int64_t outputs = gradient.size(1) / 2;
    const std::int64_t columns = 4 * outputs;
    const torch::Tensor parts = torch::empty({ FieldParts, width, columns }, in.options());
    const float* from[2] = { in.data_ptr<float>(), gradient.data_ptr<float>() };
    const float* all = kept.defined() ? kept.data_ptr<float>() : nullptr;
    float* const to[2] = { dx.data_ptr<float>(), parts.data_ptr<float>() };
    const std::int64_t most = ProductTileRows(columns);
    const SingleThreadedBlas blas;
    ForFieldParts(in.size(0), [&](std::int64_t part, std::int64_t begin, std::int64_t end) {
      const auto byWide = FieldScratch(most * columns);
      const auto scratch = FieldScratch(all ? 0 : most * columns);
      float* byMatrix = to[1] + part * width * columns;
      std::fill_n(byMatrix, begin == end ? width * columns : 0, 0.0F);
      ForFieldTiles(begin, end, most, [&](std::int64_t first, std::int64_t rows) {
        const float* x = from[0] + first * width;
        const float* wide = all ? all + first * columns : scratch.get();
        if (!all)
        {
          Multiply(x, matrix, scratch.get(), rows, width, columns);
        }
        BestFieldLatentKernels().NeuronGradient(wide, from[1] + 2 * first * outputs, rows, outputs, byWide.get());
        MultiplyBlocks(
          { byWide.get(), columns }, { matrix, columns, true }, to[0] + first * width, width, rows, columns, width);
        MultiplyBlocks(
          { x, width, true }, { byWide.get(), columns }, byMatrix, columns, width, rows, columns, first > begin);
      });
    });
    return parts.sum(0);
  }

  /// Adds the derivatives that come through the mean squares.
  static void AddSquares(const torch::Tensor& in, const std::vector<float>& bySquares, const torch::Tensor& dx)
  {
    const std::int64_t width = in.size(1);
    std::vector<float> factors = bySquares;
    for (float& factor : factors)
    {
      factor *= 2.0F / static_cast<float>(in.size(0));
    }
    factors.insert(factors.end(), factors.begin(), factors.begin() + width / 2);
    const float* from = in.data_ptr<float>();
    float* to = dx.data_ptr<float>();
    ForFieldParts(in.size(0), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
      for (std::int64_t row = begin; row < end; ++row)
      {
        for (std::int64_t c = 0; c < width; ++c)
        {
          to[row * width + c] += factors[static_cast<std::size_t>(c)] * from[row * width + c];
        }
      }
    });
  }
};

FieldFilter FilterOf(const variable_list& in)
{
  return { in[InputShares].data_ptr<float>(), in[InputRadius].data_ptr<float>(), in[InputAligned].data_ptr<float>(),
    in[InputCentroids].data_ptr<float>(), in[InputDirected].data_ptr<float>(), in[InputHidden].data_ptr<float>(),
    in[InputHiddenBias].data_ptr<float>() };
}

/// Places of the weights [2, out, 8, in] of a convolution.
ComplexPlaces ConvolutionPlaces(std::int64_t channels)
{
  return { channels, FilterChannels * channels, channels, 2 * channels };
}

std::vector<float> ConvolutionMatrix(const torch::Tensor& weight)
{
  const std::int64_t channels = weight.size(1);
  std::vector<float> matrix(static_cast<std::size_t>(4 * FilterChannels * channels * channels));
  ConvolutionPlaces(channels).Place(weight.data_ptr<float>(), matrix.data());
  return matrix;
}

torch::Tensor UnitFields(const torch::Tensor& x)
{
  const torch::Tensor units = torch::empty_like(x);
  const std::int64_t width = x.size(1);
  const float* from = x.data_ptr<float>();
  float* to = units.data_ptr<float>();
  ForFieldParts(x.size(0), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
    BestLatentDiffusionKernels().Units(from + begin * width, end - begin, width / 2, to + begin * width);
  });
  return units;
}

/// Equation 35 on [V, 2 C]; the inputs are those of ConvolutionInput.
class FieldConvolutionStep : public torch::autograd::Function<FieldConvolutionStep>
{
public:
  /// @param keep true to keep the sums of neighborhoods for the derivatives, where they fit
  static torch::Tensor forward(AutogradContext* context, const std::shared_ptr<const FieldLevel>& level, bool guided,
    const torch::Tensor& x, const torch::Tensor& shares, const torch::Tensor& radius, const torch::Tensor& aligned,
    const torch::Tensor& centroids, const torch::Tensor& directed, const torch::Tensor& hidden,
    const torch::Tensor& hiddenBias, const torch::Tensor& weight, bool keep)
  {
    variable_list in = { x.contiguous(), shares.contiguous(), radius, aligned, centroids, directed, hidden, hiddenBias,
      weight };
    const std::int64_t channels = weight.size(1);
    const std::int64_t width = FilterChannels * 2 * channels;
    const std::vector<float> matrix = ConvolutionMatrix(weight);
    const torch::Tensor units = UnitFields(in[InputX]);
    const torch::Tensor out = torch::empty_like(in[InputX]);
    const torch::Tensor kept = KeptNumbers(keep, out.size(0), width, out);
    float* all = kept.defined() ? kept.data_ptr<float>() : nullptr;
    const FieldNeighborhoods at = level->View(guided);
    const FieldFilter filter = FilterOf(in);
    const float* from[2] = { in[InputX].data_ptr<float>(), units.data_ptr<float>() };
    float* to = out.data_ptr<float>();
    const std::int64_t most = ProductTileRows(width);
    const SingleThreadedBlas blas;
    ForFieldParts(out.size(0), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
      const auto scratch = FieldScratch(all ? 0 : most * width);
      ForFieldTiles(begin, end, most, [&](std::int64_t first, std::int64_t rows) {
        float* sums = all ? all + first * width : scratch.get();
        BestLatentDiffusionKernels().GatherFields(at, filter, from[0], from[1], first, rows, channels, sums);
        Multiply(sums, matrix.data(), to + 2 * first * channels, rows, width, 2 * channels);
      });
    });
    in.push_back(kept);
    context->save_for_backward(in);
    KeepValue(context, level);
    context->saved_data["guided"] = guided;
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const variable_list in = context->get_saved_variables();
    const auto level = KeptValue<std::shared_ptr<const FieldLevel>>(context);
    const bool guided = context->saved_data["guided"].toBool();
    const torch::Tensor gradient = gradients[0].contiguous();
    const torch::Tensor units = UnitFields(in[InputX]);
    const std::int64_t channels = in[InputWeight].size(1);
    const torch::Tensor dSums = torch::empty({ gradient.size(0), FilterChannels * 2 * channels }, gradient.options());
    const torch::Tensor byMatrix = ProductGradient(*level, guided, in, units, gradient, dSums);
    variable_list derivatives = FilterGradient(*level, guided, in, units, dSums);
    const torch::Tensor byWeight = torch::empty_like(in[InputWeight]);
    ConvolutionPlaces(channels).Gradient(byMatrix.data_ptr<float>(), byWeight.data_ptr<float>());
    derivatives.push_back(byWeight);
    derivatives.insert(derivatives.begin(), 2, torch::Tensor()); // of level and guidance
    derivatives.emplace_back();                                  // of the choice to keep sums
    return derivatives;
  }

private:
  /// Derivatives by the matrix, from the sums that were kept or are computed again, and by the sums.
  static torch::Tensor ProductGradient(const FieldLevel& level, bool guided, const variable_list& in,
    const torch::Tensor& units, const torch::Tensor& gradient, const torch::Tensor& dSums)
  {
    const std::int64_t channels = in[InputWeight].size(1);
    const std::int64_t outputs = 2 * channels;
    const std::int64_t width = FilterChannels * outputs;
    const std::vector<float> matrix = ConvolutionMatrix(in[InputWeight]);
    const torch::Tensor parts = torch::empty({ FieldParts, width, outputs }, gradient.options());
    const FieldNeighborhoods at = level.View(guided);
    const FieldFilter filter = FilterOf(in);
    const float* from[3] = { in[InputX].data_ptr<float>(), units.data_ptr<float>(), gradient.data_ptr<float>() };
    const float* all = in[ConvolutionInputs].defined() ? in[ConvolutionInputs].data_ptr<float>() : nullptr;
    float* const to[2] = { parts.data_ptr<float>(), dSums.data_ptr<float>() };
    const std::int64_t most = ProductTileRows(width);
    const SingleThreadedBlas blas;
    ForFieldParts(gradient.size(0), [&](std::int64_t part, std::int64_t begin, std::int64_t end) {
      const auto scratch = FieldScratch(all ? 0 : most * width);
      float* byMatrix = to[0] + part * width * outputs;
      std::fill_n(byMatrix, begin == end ? width * outputs : 0, 0.0F);
      ForFieldTiles(begin, end, most, [&](std::int64_t first, std::int64_t rows) {
        const float* byOut = from[2] + first * outputs;
        const float* sums = all ? all + first * width : scratch.get();
        if (!all)
        {
          BestLatentDiffusionKernels().GatherFields(at, filter, from[0], from[1], first, rows, channels, scratch.get());
        }
        MultiplyBlocks(
          { sums, width, true }, { byOut, outputs }, byMatrix, outputs, width, rows, outputs, first > begin);
        MultiplyBlocks(
          { byOut, outputs }, { matrix.data(), outputs, true }, to[1] + first * width, width, rows, outputs, width);
      });
    });
    return parts.sum(0);
  }

  /// Derivatives by x, shares, radius, aligned, centroids, directed, hidden weight and bias.
  static variable_list FilterGradient(const FieldLevel& level, bool guided, const variable_list& in,
    const torch::Tensor& units, const torch::Tensor& dSums)
  {
    const std::int64_t channels = in[InputWeight].size(1);
    variable_list parts = { torch::empty_like(in[InputX]) };
    std::vector<float*> to = { parts.front().data_ptr<float>() };
    std::vector<std::int64_t> sizes = { 0 };
    for (int k = InputShares; k < InputWeight; ++k)
    {
      std::vector<std::int64_t> shape = in[k].sizes().vec();
      shape.insert(shape.begin(), FieldParts);
      parts.push_back(torch::zeros(shape, dSums.options()));
      to.push_back(parts.back().data_ptr<float>());
      sizes.push_back(in[k].numel());
    }
    const FieldNeighborhoods at = level.View(guided);
    const FieldSources sources = level.Sources();
    const FieldFilter filter = FilterOf(in);
    const float* from[3] = { in[InputX].data_ptr<float>(), units.data_ptr<float>(), dSums.data_ptr<float>() };
    ForFieldParts(dSums.size(0), [&](std::int64_t part, std::int64_t begin, std::int64_t end) {
      const auto place = [&](int k) {
        return to[static_cast<std::size_t>(k)] + part * sizes[static_cast<std::size_t>(k)];
      };
      const FieldFilterGradient gradient = { place(InputShares), place(InputRadius), place(InputAligned),
        place(InputCentroids), place(InputDirected), place(InputHidden), place(InputHiddenBias) };
      ForFieldTiles(begin, end, FieldTileRows, [&](std::int64_t first, std::int64_t rows) {
        BestLatentDiffusionKernels().GatherFieldsGradient(at, sources, filter, from[0], from[1], from[2], first, rows,
          channels, to[0] + 2 * first * channels, gradient);
      });
    });
    for (std::size_t k = InputShares; k < parts.size(); ++k)
    {
      parts[k] = parts[k].sum(0);
    }
    return parts;
  }
};

/// Members of each cluster to its center, or centers to the members. @param mean true to divide by the members
torch::Tensor CarriedFields(const DiffusionSurface& surface, const torch::Tensor& in, bool toCoarse, bool mean)
{
  const std::int64_t rows = toCoarse ? static_cast<std::int64_t>(surface.MemberStart.size()) - 1
                                     : static_cast<std::int64_t>(surface.Clusters.size());
  const std::int64_t channels = in.size(1) / 2;
  const torch::Tensor out = torch::zeros({ rows, in.size(1) }, in.options());
  const float* from = in.data_ptr<float>();
  float* to = out.data_ptr<float>();
  const auto add = [&](Index source, std::int64_t row, std::complex<float> turn) {
    const float* x = from + 2 * channels * source;
    float* y = to + 2 * channels * row;
    for (std::int64_t c = 0; c < channels; ++c)
    {
      y[c] += turn.real() * x[c] - turn.imag() * x[channels + c];
      y[channels + c] += turn.real() * x[channels + c] + turn.imag() * x[c];
    }
  };
  const auto share = [&](std::size_t a) {
    return mean ? 1.0F / static_cast<float>(surface.MemberStart[a + 1] - surface.MemberStart[a]) : 1.0F;
  };
  ForFieldParts(rows, [&](std::int64_t, std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row)
    {
      const auto k = static_cast<std::size_t>(row);
      if (!toCoarse)
      {
        const Index center = surface.Clusters[k];
        add(center, row, share(static_cast<std::size_t>(center)) * std::conj(surface.ToCenter[k]));
        continue;
      }
      for (Index m = surface.MemberStart[k]; m < surface.MemberStart[k + 1]; ++m)
      {
        const Index v = surface.Members[static_cast<std::size_t>(m)];
        add(v, row, share(k) * surface.ToCenter[static_cast<std::size_t>(v)]);
      }
    }
  });
  return out;
}

/// Pooling and its transpose.
class ClusterStep : public torch::autograd::Function<ClusterStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const std::shared_ptr<const DiffusionSurface>& surface,
    const torch::Tensor& x, bool toCoarse, bool mean)
  {
    KeepValue(context, surface);
    context->saved_data["to_coarse"] = toCoarse;
    context->saved_data["mean"] = mean;
    return CarriedFields(*surface, x.contiguous(), toCoarse, mean);
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const auto surface = KeptValue<std::shared_ptr<const DiffusionSurface>>(context);
    const torch::Tensor by = CarriedFields(*surface, gradients[0].contiguous(),
      !context->saved_data["to_coarse"].toBool(), context->saved_data["mean"].toBool());
    return { torch::Tensor(), by, torch::Tensor(), torch::Tensor() };
  }
};
} // namespace

torch::Tensor FusedFieldNeuron(const torch::Tensor& x, const torch::Tensor& scale, const torch::Tensor& logDelta,
  const torch::Tensor& key, const torch::Tensor& query)
{
  return FieldNeuronStep::apply(x, scale, logDelta, key, query, NeedsDerivatives({ x, scale, logDelta, key, query }));
}

torch::Tensor FusedFieldConvolution(
  const std::shared_ptr<const FieldLevel>& level, bool guided, const std::vector<torch::Tensor>& in)
{
  return FieldConvolutionStep::apply(level, guided, in[InputX], in[InputShares], in[InputRadius], in[InputAligned],
    in[InputCentroids], in[InputDirected], in[InputHidden], in[InputHiddenBias], in[InputWeight], NeedsDerivatives(in));
}

torch::Tensor FusedClusterCarry(
  const std::shared_ptr<const DiffusionSurface>& surface, const torch::Tensor& x, bool toCoarse, bool mean)
{
  return ClusterStep::apply(surface, x, toCoarse, mean);
}

std::atomic<std::int64_t>& FieldStepMemory()
{
  static std::atomic<std::int64_t> bytes{ 32 << 20 };
  return bytes;
}

void RequireFirstFieldDerivatives()
{
  if (torch::GradMode::is_enabled())
  {
    throw InvalidInput("A fused layer: second derivatives are asked for; expected first ones.");
  }
}

} // namespace surfsynth
