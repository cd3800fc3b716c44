// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternField.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

double MarginalVariance(double tau, double area, std::int64_t eulerCharacteristic, bool closed)
{
  const double constantMode = 1.0 / (area * tau * tau);
  if (!closed)
  {
    return std::max(1.0 / (4.0 * M_PI * tau), constantMode);
  }
  const double mu = 4.0 * M_PI / area * (1.0 - static_cast<double>(eulerCharacteristic) / 6.0);
  return constantMode + 1.0 / (4.0 * M_PI * (tau + mu));
}

} // namespace surfsynth
