// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Fixtures as tensors, for the tests that include torch anyway.
#pragma once

#include "Fixtures.h"

#include <torch/torch.h>

namespace surfsynth::test
{

inline torch::Tensor ToTensor(const SafetensorsFile& file, const std::string& name, torch::ScalarType type)
{
  std::vector<double> values = file.Float64(name);
  return torch::from_blob(values.data(), file.Entry(name).Shape, torch::kFloat64).to(type, false, true);
}

inline FixtureMatrix ToMatrix(const torch::Tensor& tensor)
{
  const torch::Tensor rows = tensor.detach().to(torch::kFloat64).contiguous();
  const std::int64_t count = rows.dim() == 0 ? 1 : rows.size(0);
  return Eigen::Map<const FixtureMatrix>(rows.data_ptr<double>(), count, rows.numel() / count);
}

} // namespace surfsynth::test
