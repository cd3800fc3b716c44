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
/// 1 %. With one half for the power it is that of Zolotarev [Eshof2002]; others follow from it by continuation of the
/// power and Newton's method in long double. The error is about 4 sin(pi power) exp(-2 pi^2 terms / log(16 ratio)) with
/// ratio = upper / lower; for the powers 1/4 and 3/4:
///
/// | ratio | 2 terms | 4      | 6      | 8      | 10      |
/// |-------|---------|--------|--------|--------|---------|
/// | 3e2   | 2.8e-2  | 2.6e-4 | 2.4e-6 | 2.4e-8 | 2.3e-10 |
/// | 3e4   | 1.4e-1  | 6.9e-3 | 3.3e-4 | 1.6e-5 | 8.0e-7  |
/// | 3e6   | 3.1e-1  | 3.3e-2 | 3.5e-3 | 3.8e-4 | 4.0e-5  |
///
/// @param power larger than 0, less than 1
/// @param lower,upper ends of the interval, 0 < lower < upper
/// @param terms 1 to 32
/// @throws InvalidInput when an argument is out of range
/// @throws SolverFailure when rounding does not let the iteration converge: for errors below about 1e-12
RationalPower ApproximateInversePower(double power, double lower, double upper, int terms);

/// Approximation with the smallest number of terms whose relative error is at most @p tolerance, 1e-9 to 0.1. Same
/// errors.
RationalPower ApproximateInversePowerTo(double tolerance, double power, double lower, double upper);

} // namespace surfsynth
