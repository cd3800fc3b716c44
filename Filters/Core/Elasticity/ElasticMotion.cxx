// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/ElasticMotion.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Elasticity/IncrementalPotential.h"
#include "Core/Solvers/RepeatedCholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr int MostFallIterations = 8; ///< of Newton's method in a time step of the motion, which ends there unconverged
constexpr int MostCreepIterations = 40; ///< in one of the creep
constexpr double FallTolerance = 2e-3;  ///< norm of what is left of the gradient in motion, as a fraction of the weight
constexpr double CreepTolerance = 0.1;  ///< in the creep, as a fraction of the imbalance that is asked for
constexpr int MostHalvings = 40;        ///< of a move in a line search
constexpr double SufficientDecrease = 1e-4; ///< of Armijo's rule
constexpr double LongestMove = 0.1;         ///< of a node against the mean in an iteration, in diagonals
constexpr double LeastTimeStep = 1e-5;      ///< seconds
constexpr double LongestTimeStep = 2.0;     ///< of the creep, seconds
constexpr double Rounding = 1e-12;          ///< of energies, as a fraction of weight times diagonal
constexpr double StressRounding = 1e-14;    ///< of energies, as a fraction of stress times volume
/// Why steps fail.
constexpr const char* Causes = "The body is too soft for its weight (YoungsModulus, Density, Gravity; LengthUnit where "
                               "it is larger than meant), falls for too long (DropHeight), or has tetrahedra that are "
                               "too flat.";

/// End of Newton's method.
struct Accuracy
{
  double Tolerance; ///< norm of the gradient, as a fraction of weight and loads
  int MostIterations;
};
} // namespace

class ElasticMotion::Internals
{
public:
  Internals(const ElasticBody& body, const ElasticSurroundings& surroundings, const MotionOptions& options)
    : Body(body)
    , Options(options)
    , Potential(body, surroundings)
  {
    const BoundingBox box = ComputeBoundingBox(body.Mesh());
    this->Force = surroundings.Gravity * body.Masses().sum() + surroundings.Loads.norm();
    this->Diagonal = (box.Upper - box.Lower).norm();
    this->Work = this->Force * this->Diagonal;
    this->Volume = body.Masses().sum() / body.Material().Density;
  }

  /// Begins a motion.
  void Begin(PointMatrix points, PointMatrix velocities, const Progress& progress)
  {
    this->Result = {};
    this->Heartbeat = SubProgress(progress, 0.0, 0.0);
    this->Points = std::move(points);
    this->Velocities = std::move(velocities);
    double start = std::numeric_limits<double>::infinity();
    if (this->Points.allFinite() && this->Velocities.allFinite())
    {
      this->Potential.PrepareMove(this->Points, PointMatrix::Zero(this->Points.rows(), 3));
      start = this->Energy(this->Points, this->Velocities);
    }
    if (!std::isfinite(start))
    {
      throw InvalidInput("ElasticMotion: the energy of the start is not finite; expected finite positions above the "
                         "floor and velocities.");
    }
    // Coordinates are rounded by 1e-16 of the size, against stresses of about sqrt(E U / V) in the mean, where U, the energy
    // that is there, is that of the beginning: StressRounding is a hundred times as large.
    const double available = this->Work + std::abs(start);
    const double stress = std::sqrt(this->Body.Material().YoungsModulus * available / this->Volume);
    this->Tolerance = std::max(Rounding * this->Work, StressRounding * (available + stress * this->Volume));
  }

  /// A time step; false when no move lowers the potential or the energy has risen.
  bool Step(double step, const Accuracy& accuracy)
  {
    this->Potential.Begin(this->Points, this->Velocities, step);
    PointMatrix points = this->Points;
    this->Potential.PrepareMove(points, PointMatrix::Zero(points.rows(), 3));
    const double before = this->Energy(points, this->Velocities);
    if (!this->Minimize(points, accuracy))
    {
      return false;
    }
    const PointMatrix velocities = (points - this->Points) / step;
    const double rise = this->Energy(points, velocities) - before;
    if (!(rise <= this->Tolerance))
    {
      return false;
    }
    this->Result.LargestEnergyRise = std::max(this->Result.LargestEnergyRise, rise / this->Work);
    this->Points = points;
    this->Velocities = velocities;
    return true;
  }

  /// Kinetic energy over weight times diagonal.
  double Motion() const { return 0.5 * this->Body.Masses().dot(this->Velocities.rowwise().squaredNorm()) / this->Work; }
  /// Norm of the forces left over weight and loads.
  double Imbalance() const { return this->Potential.Imbalance(this->Points).norm() / this->Force; }

  /// Time steps until the body rests, or MaximumTime.
  void Fall(const Progress& progress)
  {
    double step = this->Options.TimeStep;
    double still = 0.0;
    while (this->Result.Time < this->Options.MaximumTime && still < this->Options.RestTime)
    {
      step = this->Advance(step, this->Options.TimeStep, { FallTolerance, MostFallIterations });
      this->Result.Time += this->LastStep;
      still = this->Motion() <= this->Options.RestEnergy ? still + this->LastStep : 0.0;
      this->ReportDone(progress, 0.9 * std::min(this->Result.Time / this->Options.MaximumTime, 1.0));
    }
    this->Result.HasSettled = still >= this->Options.RestTime;
  }

  /// Time steps without velocities, until forces are in balance.
  void Creep(const Progress& progress)
  {
    double step = this->Options.TimeStep;
    do
    {
      this->Velocities.setZero();
      step = this->Advance(step, LongestTimeStep, { CreepTolerance * this->Options.Imbalance, MostCreepIterations });
      this->ReportDone(progress, 0.95);
    } while (this->Imbalance() > this->Options.Imbalance);
  }

  /// Ends a motion: what is known of where it has come to.
  void Measure()
  {
    this->Result.SmallestVolumeRatio = this->Body.SmallestVolumeRatio(this->Points);
    this->Result.Imbalance = this->Imbalance();
  }

  bool MustBalance() const { return this->Options.MustBalance; }

  PointMatrix Points;
  ElasticEquilibrium Result;

private:
  void ReportDone(const Progress& progress, double fraction)
  {
    Report(progress, fraction);
    this->Heartbeat = SubProgress(progress, fraction, fraction);
  }

  /// Does a time step of at most @p step, and returns the length of the next, at most @p longest.
  double Advance(double step, double longest, const Accuracy& accuracy)
  {
    if (++this->Result.NumberOfTimeSteps > this->Options.MaximumSteps)
    {
      throw SolverFailure("ElasticMotion: forces of " + FormatNumber(this->Imbalance()) +
        " of the weight are left after " + std::to_string(this->Options.MaximumSteps) +
        " time steps; expected at most " + FormatNumber(this->Options.Imbalance) + ". " + Causes);
    }
    while (!this->Step(step, accuracy))
    {
      step *= 0.5;
      if (step < LeastTimeStep)
      {
        throw SolverFailure(
          "ElasticMotion: no time step above " + FormatNumber(LeastTimeStep) + " s lowers the energy. " + Causes);
      }
    }
    this->LastStep = step;
    return std::min(1.5 * step, longest);
  }

  double Energy(const PointMatrix& points, const PointMatrix& velocities) const
  {
    return 0.5 * this->Body.Masses().dot(velocities.rowwise().squaredNorm()) + this->Potential.PotentialEnergy(points);
  }

  /// Lowers the potential from @p points, to its minimum where the iterations suffice.
  bool Minimize(PointMatrix& points, const Accuracy& accuracy)
  {
    for (int iteration = 0; iteration < accuracy.MostIterations; ++iteration)
    {
      const PointMatrix gradient = this->Potential.Gradient(points);
      if (gradient.norm() <= accuracy.Tolerance * this->Force)
      {
        return true;
      }
      ++this->Result.NumberOfIterations;
      const PointMatrix move = this->Direction(points, gradient);
      this->Potential.PrepareMove(points, move);
      if (!this->Descend(points, move, gradient.cwiseProduct(move).sum()))
      {
        return iteration > 0;
      }
    }
    return true;
  }

  /// Newton's direction, shortened where the body would be torn about.
  PointMatrix Direction(const PointMatrix& points, const PointMatrix& gradient)
  {
    this->Couple(this->Potential.Coupled(points));
    this->Potential.FillStiffness(points, *this->Stiffness);
    const Eigen::Map<const Eigen::VectorXd> rightHandSide(gradient.data(), gradient.size());
    const Eigen::VectorXd solution = this->Solver->Solve(this->Stiffness->Matrix(), -rightHandSide, this->Heartbeat);
    PointMatrix move = Eigen::Map<const PointMatrix>(solution.data(), gradient.rows(), 3);
    const double longest = (move.rowwise() - move.colwise().mean()).rowwise().norm().maxCoeff();
    if (longest > LongestMove * this->Diagonal)
    {
      move *= LongestMove * this->Diagonal / longest;
    }
    return move;
  }

  /// Makes sure that the pattern has these pairs.
  void Couple(const std::vector<NodePair>& pairs)
  {
    const auto isHeld = [this](const NodePair& pair) { return this->Stiffness->Has(pair.first, pair.second); };
    if (!this->Stiffness || !std::all_of(pairs.begin(), pairs.end(), isHeld))
    {
      this->Stiffness.emplace(this->Body.Mesh(), pairs);
      this->Solver.emplace(this->Stiffness->Matrix());
    }
  }

  /// Line search along @p move, whose slope is @p slope.
  bool Descend(PointMatrix& points, const PointMatrix& move, double slope) const
  {
    const double before = this->Potential.Value(points);
    double part = this->Potential.LargestStep(points, move);
    for (int halving = 0; halving < MostHalvings; ++halving, part *= 0.5)
    {
      const PointMatrix moved = points + part * move;
      const double allowed = before + SufficientDecrease * part * slope + this->Tolerance;
      if (this->Potential.Value(moved) <= allowed) // infinite where a tetrahedron has turned over
      {
        points = moved;
        return true;
      }
    }
    return false;
  }

  const ElasticBody& Body;
  MotionOptions Options;
  IncrementalPotential Potential;
  double Force = 0.0;     ///< weight and loads, newtons
  double Diagonal = 0.0;  ///< of the box at rest, meters
  double Work = 0.0;      ///< weight times diagonal, joules
  double Volume = 0.0;    ///< cubic meters
  double Tolerance = 0.0; ///< rounding of energies, joules
  double LastStep = 0.0;
  PointMatrix Velocities;
  Progress Heartbeat; ///< repeats the last report in a factorization, which may take seconds
  std::optional<NodeMatrix> Stiffness;
  std::optional<RepeatedCholesky> Solver;
};

ElasticMotion::ElasticMotion(
  const ElasticBody& body, const ElasticSurroundings& surroundings, const MotionOptions& options)
  : Impl(std::make_unique<Internals>(body, surroundings, options))
{}

ElasticMotion::~ElasticMotion() = default;

ElasticEquilibrium ElasticMotion::Settle(PointMatrix points, PointMatrix velocities, const Progress& progress)
{
  this->Impl->Begin(std::move(points), std::move(velocities), progress);
  try
  {
    this->Impl->Fall(progress);
    this->Impl->Creep(progress);
  }
  catch (const SolverFailure&)
  {
    if (this->Impl->MustBalance())
    {
      throw;
    }
  }
  this->Impl->Measure();
  ElasticEquilibrium result = this->Impl->Result;
  result.Points = this->Impl->Points;
  Report(progress, 1.0);
  return result;
}

} // namespace surfsynth
