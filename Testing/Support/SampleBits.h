// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Bits of samples of random fields.
#pragma once

#include "Core/Common/Parallel.h"
#include "Core/Noise/MaternField.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace surfsynth::test
{

/// Expects 40 samples to have the same bits for 1, 2, ... @p threads threads, and one of them the same alone.
inline void ExpectSameBitsAloneAndInABatch(const TriangleMesh& mesh, const MaternFieldOptions& options, int threads)
{
  SampleRequest request;
  request.NumberOfSamples = 40;
  std::vector<Eigen::MatrixXd> reference;
  for (int number = 1; number <= threads; ++number)
  {
    const ThreadScope scope(number);
    const MaternField field(mesh, options);
    std::size_t k = 0;
    field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& z) {
      if (number == 1)
      {
        reference.emplace_back(z);
      }
      EXPECT_EQ(std::memcmp(reference[k++].data(), z.data(), static_cast<std::size_t>(z.size()) * sizeof(double)), 0);
    });
    EXPECT_EQ(k, 40U);
    SampleRequest one = request;
    one.FirstSample = 17;
    EXPECT_EQ((field.Sample(one) - reference[17]).cwiseAbs().maxCoeff(), 0.0);
  }
}

} // namespace surfsynth::test
