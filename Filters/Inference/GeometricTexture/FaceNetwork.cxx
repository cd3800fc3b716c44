// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/FaceNetwork.h"

#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Epsilon = 1e-5; // of the instance norm
constexpr std::int64_t EdgeInputs = 4;

/// Calls body(tile, first row, number of rows) for all tiles, in parallel.
template <typename Body>
void ForTiles(std::int64_t faces, std::int64_t tileRows, const Body& body)
{
  ParallelTasks((faces + tileRows - 1) / tileRows,
    [&](std::int64_t tile) { body(tile, tile * tileRows, std::min(tileRows, faces - tile * tileRows)); });
}

/// Scratch of the calling thread, kept from tile to tile.
float* Scratch(std::int64_t size)
{
  thread_local std::vector<float> scratch;
  if (static_cast<std::int64_t>(scratch.size()) < size)
  {
    scratch.resize(static_cast<std::size_t>(size));
  }
  return scratch.data();
}
} // namespace

FaceNetwork::FaceNetwork(const std::map<std::string, ModelTensor>& tensors, std::int64_t level, std::int64_t layers,
  const std::map<std::string, ModelTensor>& statistics, std::int64_t step)
  : Kernels(BestFaceKernels())
{
  for (std::int64_t j = 0; j < layers - 1; ++j)
  {
    const GeometricTextureTensorNames names = NamesOfConvolution(level, j, layers);
    const ModelTensor& weight = tensors.at(names.Weight);
    Layer layer;
    layer.Width = weight.Shape[0];
    layer.Inputs = j == 0 ? EdgeInputs : weight.Shape[1] / 2;
    layer.Bias = tensors.at(names.Bias).Values;
    const std::int64_t inputs = weight.Shape[1];
    const std::int64_t maps = j == 0 ? 1 : 2;
    layer.Matrix.resize(weight.Values.size());
    for (std::int64_t out = 0; out < layer.Width; ++out)
    {
      for (std::int64_t in = 0; in < inputs; ++in)
      {
        // Published columns are [neighbour, self]; here the map of the triangle itself comes first.
        const std::int64_t map = maps == 1 || in >= layer.Inputs ? 0 : 1;
        layer.Matrix[(in % layer.Inputs) * maps * layer.Width + map * layer.Width + out] =
          weight.Values[out * inputs + in];
      }
    }
    this->Layers.push_back(std::move(layer));
  }
  for (std::int64_t j = 0; j < layers - 2 && !statistics.empty(); ++j)
  {
    const GeometricTextureStatisticsNames names = NamesOfStatistics(level, j);
    const std::int64_t width = this->Layers[static_cast<std::size_t>(j)].Width;
    const auto ofStep = [&](const std::string& name) {
      const auto first = statistics.at(name).Values.begin() + step * width;
      return std::vector<double>(first, first + width);
    };
    this->Given.push_back(NormOf({ ofStep(names.Mean), ofStep(names.Variance) }));
  }
}

FaceNetwork::Moments FaceNetwork::FirstMoments(const EdgeFeatureMatrix& features) const
{
  const Layer& layer = this->Layers.front();
  const std::int64_t faces = features.rows();
  Moments moments(static_cast<std::size_t>((faces + TileRows - 1) / TileRows * 2 * layer.Width));
  ForTiles(faces, TileRows, [&](std::int64_t tile, std::int64_t first, std::int64_t rows) {
    float* values = Scratch(TileRows * layer.Width);
    this->Kernels.EdgeMaps(
      features.data() + 12 * first, layer.Matrix.data(), layer.Bias.data(), rows, layer.Width, values);
    double* sums = moments.data() + tile * 2 * layer.Width;
    std::fill_n(sums, 2 * layer.Width, 0.0);
    this->Kernels.AddMoments(values, layer.Width, rows, layer.Width, sums, sums + layer.Width);
  });
  return moments;
}

ChannelStatistics FaceNetwork::Summarise(const Moments& moments, std::int64_t faces, std::int64_t width)
{
  std::vector<double> total(static_cast<std::size_t>(2 * width), 0.0);
  for (std::size_t k = 0; k < moments.size(); ++k)
  {
    total[k % total.size()] += moments[k];
  }
  ChannelStatistics statistics;
  for (std::int64_t c = 0; c < width; ++c)
  {
    const double mean = total[c] / static_cast<double>(faces);
    statistics.Mean.push_back(mean);
    statistics.Variance.push_back(std::max(total[width + c] / static_cast<double>(faces) - mean * mean, 0.0));
  }
  return statistics;
}

FaceNetwork::Norm FaceNetwork::NormOf(const ChannelStatistics& statistics)
{
  Norm norm;
  for (std::size_t c = 0; c < statistics.Mean.size(); ++c)
  {
    norm.Mean.push_back(static_cast<float>(statistics.Mean[c]));
    norm.Scale.push_back(static_cast<float>(1.0 / std::sqrt(statistics.Variance[c] + Epsilon)));
  }
  return norm;
}

template <typename Compute>
FaceNetwork::Norm FaceNetwork::NormAfter(
  std::size_t layer, std::int64_t faces, NetworkStatistics* found, const Compute& compute) const
{
  const bool isLast = layer + 1 == this->Layers.size();
  const bool needsMoments = !isLast && (this->Given.empty() || found);
  const Moments moments = compute(needsMoments);
  if (!needsMoments)
  {
    return isLast ? Norm() : this->Given[layer];
  }
  const ChannelStatistics statistics = Summarise(moments, faces, this->Layers[layer].Width);
  if (found)
  {
    found->push_back(statistics);
  }
  return this->Given.empty() ? NormOf(statistics) : this->Given[layer];
}

void FaceNetwork::MultiplyFeatures(const EdgeFeatureMatrix& features, const Norm& norm, float* products) const
{
  const Layer& edges = this->Layers[0];
  const Layer& layer = this->Layers[1];
  ForTiles(features.rows(), TileRows, [&](std::int64_t, std::int64_t first, std::int64_t rows) {
    // Computed again: cheaper than to write and read the widest of all layers.
    float* values = Scratch(TileRows * edges.Width);
    this->Kernels.EdgeMaps(
      features.data() + 12 * first, edges.Matrix.data(), edges.Bias.data(), rows, edges.Width, values);
    this->Kernels.Normalize(values, edges.Width, norm.Mean.data(), norm.Scale.data(), rows, edges.Width, values);
    Multiply(values, layer.Matrix.data(), products + 2 * first * layer.Width, rows, layer.Inputs, 2 * layer.Width);
  });
}

void FaceNetwork::MultiplyCompleted(
  const Layer& layer, const float* completed, std::int64_t faces, const Norm& norm, float* products) const
{
  const std::int64_t stride = 2 * layer.Inputs; // of the products before, the first half of which was completed
  ForTiles(faces, TileRows, [&](std::int64_t, std::int64_t first, std::int64_t rows) {
    float* values = Scratch(TileRows * layer.Inputs);
    this->Kernels.Normalize(
      completed + first * stride, stride, norm.Mean.data(), norm.Scale.data(), rows, layer.Inputs, values);
    Multiply(values, layer.Matrix.data(), products + 2 * first * layer.Width, rows, layer.Inputs, 2 * layer.Width);
  });
}

FaceNetwork::Moments FaceNetwork::Complete(
  const Layer& layer, const TriangleMatrix& neighbors, bool withMoments, float* products) const
{
  const std::int64_t faces = neighbors.rows();
  Moments moments(static_cast<std::size_t>(withMoments ? (faces + TileRows - 1) / TileRows * 2 * layer.Width : 0));
  ForTiles(faces, TileRows, [&](std::int64_t tile, std::int64_t first, std::int64_t rows) {
    this->Kernels.GatherMax(neighbors.data(), layer.Bias.data(), first, rows, layer.Width, products);
    if (!withMoments)
    {
      return;
    }
    double* sums = moments.data() + tile * 2 * layer.Width;
    std::fill_n(sums, 2 * layer.Width, 0.0);
    this->Kernels.AddMoments(
      products + 2 * first * layer.Width, 2 * layer.Width, rows, layer.Width, sums, sums + layer.Width);
  });
  return moments;
}

FaceNetwork::Output FaceNetwork::Run(const EdgeFeatureMatrix& features, const TriangleMatrix& neighbors,
  const Progress& progress, NetworkStatistics* found) const
{
  const std::int64_t faces = features.rows();
  const auto layers = static_cast<double>(this->Layers.size());
  Norm norm = this->NormAfter(
    0, faces, found, [&](bool withMoments) { return withMoments ? this->FirstMoments(features) : Moments(); });
  Report(progress, 1.0 / layers);
  LargeArray<float> products;
  for (std::size_t j = 1; j < this->Layers.size(); ++j)
  {
    const Layer& layer = this->Layers[j];
    LargeArray<float> next(static_cast<std::size_t>(2 * faces * layer.Width));
    if (j == 1)
    {
      this->MultiplyFeatures(features, norm, next.data());
    }
    else
    {
      this->MultiplyCompleted(layer, products.data(), faces, norm, next.data());
    }
    products = std::move(next);
    Report(progress, (static_cast<double>(j) + 0.5) / layers);
    norm = this->NormAfter(j, faces, found,
      [&](bool withMoments) { return this->Complete(layer, neighbors, withMoments, products.data()); });
    Report(progress, (static_cast<double>(j) + 1.0) / layers);
  }
  const std::int64_t outputs = this->Layers.back().Width;
  using Completed = Eigen::Map<const Output, 0, Eigen::OuterStride<>>;
  return Completed(products.data(), faces, outputs, Eigen::OuterStride<>(2 * outputs));
}

} // namespace surfsynth
