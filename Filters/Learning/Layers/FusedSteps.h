// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Tasks, scratch memory and sums of derivatives of the steps of FusedPoisson.h. Private to these steps.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <ATen/Parallel.h>
#include <torch/torch.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Parts of the work whose sums of derivatives are added in order, whatever the number of threads.
constexpr std::int64_t StepParts = 8;
/// Most rows of a tile.
constexpr std::int64_t StepTileRows = 128;

/// Calls body(part, task) for tasks 0 to @p tasks in parts, on as many threads as torch may use. (at::parallel_for() is
/// serial in code that is compiled without OpenMP.)
template <typename Body>
void ForStepTasks(std::int64_t tasks, const Body& body)
{
  const SingleThreadedBlas blas;
  const ThreadScope threads(at::get_num_threads());
  ParallelTasks(StepParts, [&](std::int64_t part) {
    for (std::int64_t task = tasks * part / StepParts; task < tasks * (part + 1) / StepParts; ++task)
    {
      body(part, task);
    }
  });
}

/// Calls body(first, rows) for tiles of @p rows rows, of about the same size.
template <typename Body>
void ForStepTiles(std::int64_t rows, const Body& body)
{
  const std::int64_t tiles = (rows + StepTileRows - 1) / StepTileRows;
  for (std::int64_t tile = 0; tile < tiles; ++tile)
  {
    const std::int64_t first = rows * tile / tiles;
    body(first, rows * (tile + 1) / tiles - first);
  }
}

/// Uninitialized numbers of memory that later tasks use again.
class TileScratch
{
public:
  /// Borrows memory for @p size numbers.
  explicit TileScratch(std::int64_t size);
  ~TileScratch();
  TileScratch(const TileScratch&) = delete;
  TileScratch& operator=(const TileScratch&) = delete;

  /// Takes the next @p size numbers.
  float* Take(std::int64_t size)
  {
    float* taken = this->Values.data() + this->Used;
    this->Used += size;
    return taken;
  }

private:
  LargeArray<float> Values;
  std::int64_t Used = 0;
};

/// Derivatives by the weights of a step: one array for each part, which are added in order.
class PartSums
{
public:
  /// Zeros. @param weights absent ones are empty or undefined
  explicit PartSums(const std::vector<torch::Tensor>& weights);
  /// Array of weight @p number in a part, or null.
  float* Of(std::size_t number, std::int64_t part) const;
  /// Sum over the parts; undefined for an absent weight.
  torch::Tensor Total(std::size_t number) const;

private:
  std::vector<torch::Tensor> Sums;
};

/// Differentiable steps take no undefined tensors: an empty one stands for what is absent.
inline torch::Tensor OrEmpty(const torch::Tensor& tensor) { return tensor.defined() ? tensor : torch::empty({ 0 }); }

/// False for an undefined or empty tensor.
inline bool IsPresent(const torch::Tensor& tensor) { return tensor.defined() && tensor.numel() > 0; }

/// Numbers of a contiguous tensor, or null.
inline const float* DataOf(const torch::Tensor& tensor)
{
  return IsPresent(tensor) ? tensor.data_ptr<float>() : nullptr;
}

/// Number of signals of a tensor [..., rows, channels].
inline std::int64_t BatchOf(const torch::Tensor& tensor)
{
  return tensor.numel() / std::max<std::int64_t>(tensor.size(-1) * tensor.size(-2), 1);
}

/// Numbers of signal @p b of a contiguous tensor [..., rows, channels], or null.
inline const float* SignalOf(const torch::Tensor& tensor, std::int64_t b)
{
  return IsPresent(tensor) ? tensor.data_ptr<float>() + b * tensor.size(-1) * tensor.size(-2) : nullptr;
}

/// The same for writing.
inline float* WritableSignal(const torch::Tensor& tensor, std::int64_t b)
{
  return tensor.data_ptr<float>() + b * tensor.size(-1) * tensor.size(-2);
}

} // namespace surfsynth
