// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/VertexStage.h"

#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
void FillRows(float* values, std::int64_t rows, const std::vector<float>& row)
{
  for (std::int64_t k = 0; k < rows; ++k)
  {
    std::copy(row.begin(), row.end(), values + k * static_cast<std::int64_t>(row.size()));
  }
}

void AddRows(float* values, std::int64_t rows, const std::vector<float>& row)
{
  for (std::int64_t k = 0; k < rows; ++k, values += row.size())
  {
    std::transform(row.begin(), row.end(), values, values, std::plus<float>());
  }
}
} // namespace

VertexStage::VertexStage(std::int64_t vertices, std::int64_t width)
  : Vertices(vertices)
  , Width(width)
  , Kernels(BestActivationKernels())
  , Zeros(static_cast<std::size_t>(width), 0.0F)
{}

template <typename Body>
void VertexStage::ForTiles(const Body& body) const
{
  ParallelTasks((this->Vertices + TileRows - 1) / TileRows,
    [&](std::int64_t tile) { body(tile * TileRows, std::min(TileRows, this->Vertices - tile * TileRows)); });
}

void VertexStage::Affine(
  const AffineWeights& weights, const float* in, std::int64_t inputs, float* out, std::int64_t outputs) const
{
  this->ForTiles([&](std::int64_t first, std::int64_t rows) {
    FillRows(out + first * outputs, rows, weights.Bias);
    Multiply(in + first * inputs, weights.Matrix.data(), out + first * outputs, rows, inputs, outputs, true);
  });
}

void VertexStage::Gelu(float* values) const
{
  this->ForTiles([&](std::int64_t first, std::int64_t rows) {
    this->Kernels.BiasGelu(values + first * this->Width, this->Zeros.data(), rows, this->Width);
  });
}

void VertexStage::Run(const BlockWeights& weights, const Inputs& inputs, float* features) const
{
  const std::int64_t width = this->Width;
  this->ForTiles([&](std::int64_t first, std::int64_t rows) {
    LargeArray<float> scratch = this->Pool.Borrow();
    if (scratch.size() == 0)
    {
      scratch = LargeArray<float>(static_cast<std::size_t>(2 * TileRows * width));
    }
    float* solution = scratch.data();
    float* hidden = solution + TileRows * width;
    float* x = features + first * width;
    for (std::int64_t row = 0; row < rows; ++row)
    {
      inputs.Solution->Get(static_cast<Index>(first + row), inputs.SolutionChannels, solution + row * width);
    }
    Multiply(x, weights.FromFeatures.data(), hidden, rows, width, width);
    Multiply(solution, weights.FromSolution.data(), hidden, rows, width, width, true);
    if (inputs.Extra)
    {
      Multiply(inputs.Extra + first * width, weights.FromExtra.data(), hidden, rows, width, width, true);
    }
    if (inputs.Products)
    {
      Multiply(inputs.Products + first * width, weights.FromProducts.data(), hidden, rows, width, width, true);
    }
    this->Kernels.BiasGelu(hidden, inputs.Bias1.data(), rows, width);
    AddRows(x, rows, weights.Out1.Bias);
    Multiply(hidden, weights.Out1.Matrix.data(), x, rows, width, width, true);
    Multiply(x, weights.In2.Matrix.data(), hidden, rows, width, width);
    this->Kernels.BiasGelu(hidden, weights.In2.Bias.data(), rows, width);
    AddRows(x, rows, weights.Out2.Bias);
    Multiply(hidden, weights.Out2.Matrix.data(), x, rows, width, width, true);
    this->Pool.Return(std::move(scratch));
  });
}

} // namespace surfsynth
