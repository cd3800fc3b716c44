// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternField.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
/// Variance on the plane: 1 / (4 pi nu tau^nu).
double VarianceOnPlane(double tau, int smoothness)
{
  double power = tau;
  for (int k = 1; k < smoothness; ++k)
  {
    power *= tau;
  }
  return 1.0 / (4.0 * M_PI * smoothness * power);
}
} // namespace

double MarginalVariance(double tau, double area, std::int64_t eulerCharacteristic, bool closed, int operatorPower)
{
  double constantMode = 1.0 / (area * tau * tau);
  for (int k = 2; k < operatorPower; ++k)
  {
    constantMode /= tau;
  }
  const int smoothness = operatorPower - 1;
  if (!closed)
  {
    return std::max(VarianceOnPlane(tau, smoothness), constantMode);
  }
  const double mu = 4.0 * M_PI / area * (1.0 - static_cast<double>(eulerCharacteristic) / 6.0);
  return constantMode + VarianceOnPlane(tau + mu, smoothness);
}

double MarginalVarianceInVolume(double tau, double volume, int operatorPower)
{
  // Gamma(nu) / (Gamma(alpha) (4 pi)^(3/2) kappa^(2 nu)) with nu = alpha - 3/2.
  const double smoothness = operatorPower - 1.5;
  const double inSpace = operatorPower > 1 ? std::tgamma(smoothness) /
      (std::tgamma(static_cast<double>(operatorPower)) * std::pow(4.0 * M_PI, 1.5) * std::pow(tau, smoothness))
                                           : 0.0;
  return std::max(inSpace, 1.0 / (volume * std::pow(tau, operatorPower)));
}

} // namespace surfsynth
