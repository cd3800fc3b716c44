// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rational approximation of fractional powers.
#pragma once

#include <vector>

namespace surfsynth
{

/// r(x) = sum_k Weights[k] / (x + Shifts[k]), an approximation of x^-power: with a symmetric positive definite matrix in
/// place of x each term is a solve.
struct RationalPower
{
  double Power = 0.5;          ///< the power s of x^-s
  double RelativeError = 0.0;  ///< largest | x^s r(x) - 1 | on the interval
  std::vector<double> Weights; ///< [K], > 0
  std::vector<double> Shifts;  ///< [K], > 0, ascending

  /// Number of terms, K.
  int NumberOfTerms() const { return static_cast<int>(this->Weights.size()); }
  /// r(x).
  double operator()(double x) const;
};

/// Best approximation of x^-power on [@p lower, @p upper] by @p terms terms, in the largest relative error, leveled to
/// 2 %. With one half for the power it is that of Zolotarev [Eshof2002]; others follow from it by continuation of the
/// power and Newton's method in long double. The error falls like exp(-2 pi^2 terms / log(16 upper / lower)).
/// @param power larger than 0, less than 1
/// @param lower, upper ends of the interval, 0 < lower < upper
/// @param terms 1 to 32
/// @throws InvalidInput when an argument is out of range
/// @throws SolverFailure when the iteration does not converge
RationalPower ApproximateInversePower(double power, double lower, double upper, int terms);

/// Same with the smallest number of terms of relative error at most @p tolerance, 1e-9 to 0.1.
RationalPower ApproximateInversePowerTo(double tolerance, double power, double lower, double upper);

} // namespace surfsynth
