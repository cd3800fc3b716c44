// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternField.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
/// Variance on the plane: 1 / (4 pi nu tau^nu).
double VarianceOnPlane(double tau, double smoothness)
{
  if (smoothness != std::floor(smoothness)) // integers are multiplied, which is exact to a rounding for each factor
  {
    return 1.0 / (4.0 * M_PI * smoothness * std::pow(tau, smoothness));
  }
  double power = tau;
  for (int k = 1; k < smoothness; ++k)
  {
    power *= tau;
  }
  return 1.0 / (4.0 * M_PI * smoothness * power);
}
} // namespace

double MarginalVariance(double tau, double area, std::int64_t eulerCharacteristic, bool closed, double operatorPower)
{
  const bool isWhole = operatorPower == std::floor(operatorPower);
  double constantMode = isWhole ? 1.0 / (area * tau * tau) : 1.0 / (area * std::pow(tau, operatorPower));
  for (int k = 2; isWhole && k < operatorPower; ++k)
  {
    constantMode /= tau;
  }
  const double smoothness = operatorPower - 1.0;
  if (!closed)
  {
    return std::max(VarianceOnPlane(tau, smoothness), constantMode);
  }
  const double mu = 4.0 * M_PI / area * (1.0 - static_cast<double>(eulerCharacteristic) / 6.0);
  return constantMode + VarianceOnPlane(tau + mu, smoothness);
}

double MarginalVarianceInVolume(double tau, double volume, double operatorPower)
{
  // Gamma(nu) / (Gamma(alpha) (4 pi)^(3/2) kappa^(2 nu)) with nu = alpha - 3/2.
  const double smoothness = operatorPower - 1.5;
  const double inSpace = smoothness > 0.0
    ? std::tgamma(smoothness) / (std::tgamma(operatorPower) * std::pow(4.0 * M_PI, 1.5) * std::pow(tau, smoothness))
    : 0.0;
  return std::max(inSpace, 1.0 / (volume * std::pow(tau, operatorPower)));
}

} // namespace surfsynth
