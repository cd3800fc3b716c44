// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Logarithmic barrier [Li2020] of contact and of volumes. Private to the library.
#pragma once

#include <cmath>

namespace surfsynth
{

/// b(d) = -(d - D)^2 log(d / D) below the distance D at which contact begins, 0 above it, infinite at 0; with two
/// continuous derivatives.
class Barrier
{
public:
  /// @param begin D, meters
  /// @param stiffness factor of b, pascals per meter
  Barrier(double begin, double stiffness)
    : Begin(begin)
    , Stiffness(stiffness)
  {}

  /// Barrier whose pressure at half of the distance @p begin is @p pressure, pascals.
  static Barrier OfPressure(double begin, double pressure)
  {
    return { begin, pressure / ((std::log(2.0) + 0.5) * begin) };
  }

  /// Distance at which contact begins, meters.
  double Distance() const { return this->Begin; }
  /// Energy on an area, joules per square meter.
  double Energy(double d) const
  {
    const double gap = d - this->Begin;
    return d >= this->Begin ? 0.0 : -this->Stiffness * gap * gap * std::log(d / this->Begin);
  }
  /// Pressure, -dE/dd, pascals, at least 0.
  double Pressure(double d) const
  {
    const double gap = d - this->Begin;
    return d >= this->Begin ? 0.0 : this->Stiffness * gap * (2.0 * std::log(d / this->Begin) + gap / d);
  }
  /// Second derivative of the energy, pascals per meter, at least 0.
  double Curvature(double d) const
  {
    const double gap = (d - this->Begin) / d;
    return d >= this->Begin ? 0.0 : this->Stiffness * (gap * gap - 4.0 * gap - 2.0 * std::log(d / this->Begin));
  }

private:
  double Begin;
  double Stiffness;
};

} // namespace surfsynth
