// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rate of the matrix products of the BLAS in use, per second of processor time.
#pragma once

#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <vector>

namespace surfsynth::bench
{

/// Seconds of processor time of all threads of this process.
inline double ProcessorSeconds() { return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC); }

/// Largest rate of sgemm on one thread for 512 rows by matrices of 128, 256 and 512 squared, operations per second.
inline double ProductRate()
{
  const SingleThreadedBlas blas;
  double best = 0.0;
  for (const std::int64_t width : { 128, 256, 512 })
  {
    const std::int64_t rows = 512;
    const std::vector<float> a(static_cast<std::size_t>(rows * width), 1.0F);
    const std::vector<float> b(static_cast<std::size_t>(width * width), 0.5F);
    std::vector<float> c(a.size());
    for (int trial = 0; trial < 5; ++trial)
    {
      const int count = static_cast<int>(200 * 128 * 128 / (width * width));
      const double start = ProcessorSeconds();
      for (int k = 0; k < count; ++k)
      {
        Multiply(a.data(), b.data(), c.data(), rows, width, width);
      }
      const double operations = 2.0 * count * static_cast<double>(rows * width * width);
      best = std::max(best, operations / (ProcessorSeconds() - start));
    }
  }
  return best;
}

} // namespace surfsynth::bench
