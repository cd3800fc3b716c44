// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Losses/LatentDiffusionLosses.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

torch::Tensor DenoisingTarget(
  DiffusionTarget target, double alpha, const torch::Tensor& data, const torch::Tensor& noise)
{
  switch (target)
  {
    case DiffusionTarget::Noise:
      return noise;
    case DiffusionTarget::Data:
      return data;
    default:
      return std::sqrt(alpha) * noise - std::sqrt(1.0 - alpha) * data;
  }
}

double NoiseErrorFactor(DiffusionTarget target, double alpha)
{
  // For Z_t given: epsilon = (Z_t - sqrt(alpha) Z) / sqrt(1 - alpha) = sqrt(1 - alpha) Z_t + sqrt(alpha) v.
  switch (target)
  {
    case DiffusionTarget::Noise:
      return 1.0;
    case DiffusionTarget::Data:
      return alpha / (1.0 - alpha);
    default:
      return alpha;
  }
}

double DenoisingWeight(DiffusionTarget target, double alpha, double limit)
{
  if (limit == 0.0)
  {
    return 1.0;
  }
  // The squared error of the noise is s times that of the data.
  const double ratio = alpha / (1.0 - alpha);
  return std::min(1.0, limit / ratio) * NoiseErrorFactor(target, alpha);
}

} // namespace surfsynth
