// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/RationalPower.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace surfsynth
{

namespace
{
using Real = long double;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

constexpr int MaximumTerms = 32;
constexpr Real Pi = 3.14159265358979323846264338327950288L;

/// r(x) on [1, condition], by the logarithms of shifts and weights: both stay positive.
struct Approximation
{
  Real Power;
  Vector Parameters; ///< logarithms of the K shifts, then of the K weights

  Eigen::Index Terms() const { return this->Parameters.size() / 2; }
  Real Shift(Eigen::Index k) const { return std::exp(this->Parameters[k]); }
  Real Weight(Eigen::Index k) const { return std::exp(this->Parameters[this->Terms() + k]); }

  /// x^power r(x) - 1.
  Real Error(Real x) const
  {
    Real sum = 0.0L;
    for (Eigen::Index k = 0; k < this->Terms(); ++k)
    {
      sum += this->Weight(k) / (x + this->Shift(k));
    }
    return std::pow(x, this->Power) * sum - 1.0L;
  }

  /// Derivatives of Error() in the parameters.
  Vector Gradient(Real x) const
  {
    Vector gradient(this->Parameters.size());
    const Real scale = std::pow(x, this->Power);
    for (Eigen::Index k = 0; k < this->Terms(); ++k)
    {
      const Real shift = this->Shift(k);
      const Real term = scale * this->Weight(k) / (x + shift);
      gradient[k] = -term * shift / (x + shift);
      gradient[this->Terms() + k] = term;
    }
    return gradient;
  }
};

/// Amplitudes of the elliptic functions, am(i K / count) for i = 1 ... count - 1, for the complementary modulus @p
/// complement, by the arithmetic-geometric mean.
Vector Amplitudes(Real complement, int count)
{
  std::vector<Real> means{ 1.0L };
  std::vector<Real> ratios{ 0.0L };
  Real geometric = complement;
  while (std::abs(means.back() - geometric) > 1e-18L * means.back() && means.size() < 40)
  {
    const Real arithmetic = 0.5L * (means.back() + geometric);
    const Real difference = 0.5L * (means.back() - geometric);
    geometric = std::sqrt(means.back() * geometric);
    means.push_back(arithmetic);
    ratios.push_back(difference / arithmetic);
  }
  Vector amplitudes(count - 1);
  for (int i = 1; i < count; ++i)
  {
    Real angle = std::ldexp(
      0.5L * Pi * i / count, static_cast<int>(means.size()) - 1); // 2^n a_n u with K = pi / (2 a_n)
    for (std::size_t n = means.size() - 1; n > 0; --n)
    {
      angle = 0.5L * (angle + std::asin(ratios[n] * std::sin(angle)));
    }
    amplitudes[i - 1] = angle;
  }
  return amplitudes;
}

/// Abscissas of [1, condition] that are dense enough for the extrema of the error, denser at the ends.
Vector Grid(Real condition, Eigen::Index terms)
{
  const Eigen::Index count = 60 * terms + 60;
  Vector grid(count + 1);
  for (Eigen::Index i = 0; i <= count; ++i)
  {
    grid[i] = std::pow(condition, 0.5L * (1.0L - std::cos(Pi * static_cast<Real>(i) / static_cast<Real>(count))));
  }
  return grid;
}

/// The approximation of x^-1/2: poles and zeros by elliptic functions, centered about 1.
Approximation Zolotarev(Real condition, int terms)
{
  const Vector angles = Amplitudes(1.0L / std::sqrt(condition), 2 * terms);
  const auto root = [&](Eigen::Index i) { return std::pow(std::tan(angles[i]), 2); };
  Approximation result{ 0.5L, Vector(2 * terms) };
  for (Eigen::Index k = 0; k < terms; ++k)
  {
    Real logarithm = 0.0L; // of the residue: all factors are positive but for signs that cancel
    for (Eigen::Index j = 0; j < terms; ++j)
    {
      logarithm += j + 1 < terms ? std::log(std::abs(root(2 * j + 1) - root(2 * k))) : 0.0L;
      logarithm -= j != k ? std::log(std::abs(root(2 * j) - root(2 * k))) : 0.0L;
    }
    result.Parameters[k] = std::log(root(2 * k));
    result.Parameters[terms + k] = logarithm;
  }
  Real least = std::numeric_limits<Real>::infinity();
  Real largest = 0.0L;
  for (const Real x : Grid(condition, terms))
  {
    const Real value = result.Error(x) + 1.0L;
    least = std::min(least, value);
    largest = std::max(largest, value);
  }
  result.Parameters.tail(terms).array() -= std::log(0.5L * (least + largest));
  return result;
}

/// Zeros of the error.
Vector Zeros(const Approximation& r, const Vector& grid)
{
  std::vector<Real> zeros;
  for (Eigen::Index i = 0; i + 1 < grid.size(); ++i)
  {
    Real low = grid[i];
    Real high = grid[i + 1];
    const bool rises = r.Error(low) < 0.0L;
    if (rises == (r.Error(high) < 0.0L))
    {
      continue;
    }
    for (int step = 0; step < 70; ++step)
    {
      const Real middle = 0.5L * (low + high);
      ((r.Error(middle) < 0.0L) == rises ? low : high) = middle;
    }
    zeros.push_back(low);
  }
  return Eigen::Map<Vector>(zeros.data(), static_cast<Eigen::Index>(zeros.size()));
}

/// Largest deviation of each stretch of one sign: abscissas, errors alternate.
Vector Extrema(const Approximation& r, const Vector& grid)
{
  std::vector<Real> places;
  std::vector<Real> errors;
  for (const Real x : grid)
  {
    const Real error = r.Error(x);
    if (errors.empty() || (error < 0.0L) != (errors.back() < 0.0L))
    {
      places.push_back(x);
      errors.push_back(error);
    }
    else if (std::abs(error) > std::abs(errors.back()))
    {
      places.back() = x;
      errors.back() = error;
    }
  }
  return Eigen::Map<Vector>(places.data(), static_cast<Eigen::Index>(places.size()));
}

/// Errors at @p nodes.
Vector ErrorsAt(const Approximation& r, const Vector& nodes)
{
  Vector errors(nodes.size());
  for (Eigen::Index i = 0; i < nodes.size(); ++i)
  {
    errors[i] = r.Error(nodes[i]);
  }
  return errors;
}

/// Derivatives of the errors at @p nodes in the parameters.
Matrix Jacobian(const Approximation& r, const Vector& nodes)
{
  Matrix jacobian(nodes.size(), r.Parameters.size());
  for (Eigen::Index i = 0; i < nodes.size(); ++i)
  {
    jacobian.row(i) = r.Gradient(nodes[i]).transpose();
  }
  return jacobian;
}

/// Moves @p r to the interpolant of x^-power at the nodes, by Newton's method; false when that does not converge.
bool Interpolate(Approximation& r, const Vector& nodes, Real power)
{
  Approximation next = r;
  next.Power = power;
  for (int iteration = 0; iteration < 20; ++iteration)
  {
    const Vector step = Jacobian(next, nodes).fullPivLu().solve(ErrorsAt(next, nodes));
    const Real size = step.cwiseAbs().maxCoeff();
    if (!(size < 3.0L))
    {
      return false;
    }
    next.Parameters -= step;
    if (size < 1e-6L)
    {
      r = next;
      return true;
    }
  }
  return false;
}

/// Continuation from the power of @p r to @p power, interpolating at the nodes.
void Continue(Approximation& r, const Vector& nodes, Real power)
{
  Real fraction = 0.3L;
  while (r.Power != power)
  {
    // Steps are shorter towards 0 and 1, where a shift goes to infinity or 0.
    const Real step = fraction * std::min(r.Power, 1.0L - r.Power);
    const Real next = std::abs(power - r.Power) <= step ? power : r.Power + std::copysign(step, power - r.Power);
    if (!Interpolate(r, nodes, next))
    {
      fraction *= 0.5L;
      if (fraction < 1e-3L)
      {
        throw SolverFailure("ApproximateInversePower: the interpolation of x^-" +
          FormatNumber(static_cast<double>(power)) + " does not converge; expected it to.");
      }
    }
  }
}

/// Levels the extrema of the error by Newton steps of Remez' exchange; keeps the best.
Real Level(Approximation& best, const Vector& grid)
{
  Approximation r = best;
  Real least = ErrorsAt(best, grid).cwiseAbs().maxCoeff();
  const Eigen::Index count = r.Parameters.size() + 1;
  for (int iteration = 0; iteration < 12; ++iteration)
  {
    const Vector places = Extrema(r, grid);
    if (places.size() != count)
    {
      break;
    }
    const Vector errors = ErrorsAt(r, places);
    if (errors.cwiseAbs().maxCoeff() < 1.005L * errors.cwiseAbs().minCoeff())
    {
      break;
    }
    Matrix system(count, count);
    system.leftCols(count - 1) = Jacobian(r, places);
    for (Eigen::Index i = 0; i < count; ++i)
    {
      system(i, count - 1) = (i % 2 == 0) == (errors[0] > 0.0L) ? -1.0L : 1.0L;
    }
    const Vector step = system.fullPivLu().solve(errors).head(count - 1);
    r.Parameters -= step / std::max(1.0L, 2.0L * step.cwiseAbs().maxCoeff());
    const Real largest = ErrorsAt(r, grid).cwiseAbs().maxCoeff();
    if (largest < least)
    {
      least = largest;
      best = r;
    }
  }
  return least;
}

void RequireArgument(bool condition, const char* name, double value, const char* expected)
{
  if (!condition)
  {
    throw InvalidInput(
      std::string("ApproximateInversePower: ") + name + " is " + FormatNumber(value) + "; expected " + expected + ".");
  }
}
} // namespace

double RationalPower::operator()(double x) const
{
  double sum = 0.0;
  for (std::size_t k = 0; k < this->Weights.size(); ++k)
  {
    sum += this->Weights[k] / (x + this->Shifts[k]);
  }
  return sum;
}

RationalPower ApproximateInversePower(double power, double lower, double upper, int terms)
{
  RequireArgument(power > 0.0 && power < 1.0, "the power", power, "a number between 0 and 1");
  RequireArgument(lower > 0.0 && std::isfinite(lower), "the lower end", lower, "a finite number above 0");
  RequireArgument(upper > lower && std::isfinite(upper), "the upper end", upper, "a finite number above the lower end");
  RequireArgument(terms >= 1 && terms <= MaximumTerms, "the number of terms", terms, "1 to 32");
  const Real condition = static_cast<Real>(upper) / static_cast<Real>(lower);
  const Vector grid = Grid(condition, terms);
  Approximation r = Zolotarev(condition, terms);
  const Vector nodes = Zeros(r, grid);
  if (power != 0.5 && nodes.size() != r.Parameters.size())
  {
    throw SolverFailure("ApproximateInversePower: the error has " + std::to_string(nodes.size()) + " zeros; expected " +
      std::to_string(r.Parameters.size()) + ". The interval is too short for so many terms.");
  }
  Continue(r, nodes, power);
  RationalPower result;
  result.Power = power;
  result.RelativeError = static_cast<double>(Level(r, grid));
  for (Eigen::Index k = 0; k < terms; ++k)
  {
    // x = lower y: (lower y)^-s = lower^-s sum w / (y + c).
    result.Weights.push_back(static_cast<double>(r.Weight(k) * std::pow(static_cast<Real>(lower), 1.0L - r.Power)));
    result.Shifts.push_back(static_cast<double>(r.Shift(k) * lower));
  }
  return result;
}

RationalPower ApproximateInversePowerTo(double tolerance, double power, double lower, double upper)
{
  RequireArgument(tolerance >= 1e-9 && tolerance <= 0.1, "the tolerance", tolerance, "1e-9 to 0.1");
  for (int terms = 1; terms <= MaximumTerms; ++terms)
  {
    RationalPower result = ApproximateInversePower(power, lower, upper, terms);
    if (result.RelativeError <= tolerance)
    {
      return result;
    }
  }
  throw SolverFailure("ApproximateInversePower: 32 terms do not reach the tolerance " + FormatNumber(tolerance) +
    " on an interval of ratio " + FormatNumber(upper / lower) + "; expected them to.");
}

} // namespace surfsynth
