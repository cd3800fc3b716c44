// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternEstimation.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Noise/MaternField.h"
#include "Core/Solvers/CholeskySolver.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// eta, the deviation of the errors over that of the field: least and largest.
constexpr double LeastNoise = 1e-3;
constexpr double LargestNoise = 100.0;
/// Longest correlation range over the longest side of the surface.
constexpr double LongestRange = 4.0;
/// Rough number of evaluations, for progress.
constexpr double ExpectedEvaluations = 80.0;
/// Largest size of the last simplex, in the logarithms.
constexpr double SimplexAccuracy = 1e-4;
constexpr int MostEvaluations = 400;
/// LogarithmStep of the differences of the observed information, in the logarithms.
constexpr double LogarithmStep = 0.03;
constexpr double Quantile95 = 1.959963984540054;

/// log range and log eta.
using Parameters = Eigen::Vector2d;

/// Parts of the likelihood, whose logarithm is -(R determinant + 2 N log sigma + square / sigma^2 + N log 2 pi) / 2.
struct Terms
{
  double Determinant = 0.0; ///< log det (H Q^-1 H^T + eta^2 I)
  double Square = 0.0;      ///< sum over fields of y^T (H Q^-1 H^T + eta^2 I)^-1 y
  Eigen::VectorXd Means;    ///< [R]
};

/// The likelihood of observations on a mesh.
class Likelihood
{
public:
  Likelihood(const TriangleMesh& mesh, const MeshTopology& topology, const SparseRowMatrix& matrix,
    const Eigen::MatrixXd& values, const MaternEstimationOptions& options, const Progress& progress)
    : Mass(LumpedMass(mesh, topology))
    , Stiffness(CotangentStiffness(mesh, topology))
    , Components(ComputeComponents(topology, this->Mass))
    , Matrix(matrix)
    , Transpose(matrix.transpose())
    , Normal(this->Transpose * matrix)
    , Values(values)
    , Options(options)
    , Reporting(progress)
  {}

  Terms At(const Parameters& at)
  {
    Report(this->Reporting, std::min(0.99, this->Evaluations++ / ExpectedEvaluations));
    const double range = std::exp(at[0]);
    const double eta2 = std::exp(2.0 * at[1]);
    const int power = this->Options.OperatorPower;
    const double tau = 8.0 * (power - 1) / (range * range);
    SparseMatrix screened = this->Stiffness;
    screened.diagonal() += (this->Mass.array() > 0.0).select(tau * this->Mass, 1.0);
    Eigen::VectorXd roots(this->Mass.size()); // of the inverse mass
    double logarithms = 0.0;
    for (Index v = 0; v < roots.size(); ++v)
    {
      roots[v] = this->Mass[v] > 0.0 ? 1.0 / std::sqrt(this->Mass[v]) : 1.0;
      logarithms += 2.0 * (power - 1) * std::log(roots[v]) + 2.0 * std::log(this->Amplitude(tau, v));
    }
    const Precision precision = this->PrecisionOf(screened, roots, tau);
    SparseMatrix posterior = precision.Product() + this->Normal * (1.0 / eta2);
    posterior = 0.5 * (posterior + SparseMatrix(posterior.transpose())); // symmetric to the last bit
    const CholeskySolver solver(posterior);
    Terms terms;
    terms.Determinant = solver.LogDeterminant() - power * CholeskySolver(screened).LogDeterminant() - logarithms +
      static_cast<double>(this->Values.rows()) * 2.0 * at[1];
    this->AddSquares(precision, solver, eta2, terms);
    return terms;
  }

  /// -2 log likelihood with the best sigma, without constants.
  double Deviance(const Parameters& at)
  {
    const Terms terms = this->At(at);
    return this->Fields() * terms.Determinant + this->Numbers() * std::log(terms.Square / this->Numbers());
  }

  double Numbers() const { return static_cast<double>(this->Values.size()); }
  double Fields() const { return static_cast<double>(this->Values.cols()); }
  int NumberOfEvaluations() const { return this->Evaluations; }

private:
  /// Q = R^T B R: with D the root of the variance, R = M^-1/2 A D for alpha = 2, M^-1 A D for 3, M^-1/2 A M^-1 A D for 4,
  /// and B = A for 3, else the identity.
  struct Precision
  {
    SparseMatrix Root;   ///< R
    SparseMatrix Middle; ///< B; empty for the identity

    SparseMatrix Product() const
    {
      const SparseMatrix transpose = this->Root.transpose();
      return this->Middle.size() > 0 ? SparseMatrix(transpose * SparseMatrix(this->Middle * this->Root))
                                     : SparseMatrix(transpose * this->Root);
    }
    /// Sum of x^T Q x over the columns x.
    double Square(const Eigen::MatrixXd& columns) const
    {
      const Eigen::MatrixXd image = this->Root * columns;
      return this->Middle.size() > 0 ? image.cwiseProduct(this->Middle * image).sum() : image.squaredNorm();
    }
  };

  Precision PrecisionOf(const SparseMatrix& screened, const Eigen::VectorXd& roots, double tau)
  {
    const int power = this->Options.OperatorPower;
    const Eigen::VectorXd inverse = roots.cwiseAbs2();
    Precision precision;
    precision.Root = power == 3 ? SparseMatrix(inverse.asDiagonal() * screened)
                                : SparseMatrix(roots.asDiagonal() * screened);
    if (power == 3)
    {
      precision.Middle = screened;
    }
    if (power == 4)
    {
      precision.Root = precision.Root * SparseMatrix(inverse.asDiagonal() * screened);
    }
    for (Index v = 0; v < roots.size(); ++v)
    {
      precision.Root.col(v) *= this->Amplitude(tau, v);
    }
    return precision;
  }

  /// Square root of the marginal variance of the unscaled field at vertex @p v.
  double Amplitude(double tau, Index v)
  {
    const Index c = this->Components.OfVertex[static_cast<std::size_t>(v)];
    if (c < 0)
    {
      return 1.0;
    }
    if (tau != this->AmplitudesOf)
    {
      this->Amplitudes.clear();
      for (std::size_t k = 0; k < static_cast<std::size_t>(this->Components.Count); ++k)
      {
        this->Amplitudes.push_back(std::sqrt(MarginalVariance(tau, this->Components.Area[k],
          this->Components.EulerCharacteristic[k], this->Components.Closed[k], this->Options.OperatorPower)));
      }
      this->AmplitudesOf = tau;
    }
    return this->Amplitudes[static_cast<std::size_t>(c)];
  }

  /// y^T S^-1 y = || y - H x ||^2 / eta^2 + x^T Q x with x = (Q + H^T H / eta^2)^-1 H^T y / eta^2.
  void AddSquares(const Precision& precision, const CholeskySolver& solver, double eta2, Terms& terms) const
  {
    Eigen::MatrixXd centered = this->Values;
    terms.Means = Eigen::VectorXd::Zero(centered.cols());
    if (this->Options.Mean)
    {
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(centered.rows());
      const Eigen::VectorXd weights = (ones - this->Matrix * Solve(solver, this->Transpose * ones / eta2)) / eta2;
      terms.Means = centered.transpose() * weights / weights.sum();
      centered.rowwise() -= terms.Means.transpose();
    }
    const Eigen::MatrixXd fields = Solve(solver, this->Transpose * centered / eta2);
    terms.Square = (centered - this->Matrix * fields).squaredNorm() / eta2 + precision.Square(fields);
  }

  static Eigen::MatrixXd Solve(const CholeskySolver& solver, const Eigen::MatrixXd& rightHandSides)
  {
    RowMatrix solutions = rightHandSides;
    solver.SolveInPlace(solutions);
    return solutions;
  }

  Eigen::VectorXd Mass;
  SparseMatrix Stiffness;
  MeshComponents Components;
  const SparseRowMatrix& Matrix;
  SparseMatrix Transpose;
  SparseMatrix Normal; ///< H^T H
  const Eigen::MatrixXd& Values;
  MaternEstimationOptions Options;
  const Progress& Reporting;
  int Evaluations = 0;
  std::vector<double> Amplitudes; ///< by component, for the tau below
  double AmplitudesOf = 0.0;
};

/// A point of the simplex.
struct Trial
{
  Parameters At;
  double Deviance;
};

/// Lowest and highest parameters that are looked at.
struct Box
{
  Parameters Lower;
  Parameters Upper;

  Parameters Inside(const Parameters& at) const { return at.cwiseMax(this->Lower).cwiseMin(this->Upper); }
};

/// Finds the minimum by the method of Nelder and Mead within @p box, from the best point of a grid. With the noise
/// fixed, the second parameter has no extent.
class Search
{
public:
  Search(Likelihood& likelihood, const Box& box)
    : Function(likelihood)
    , Limits(box)
  {}

  Trial Run()
  {
    const Trial start = this->BestOfGrid();
    const int dimensions = this->Limits.Upper[1] > this->Limits.Lower[1] ? 2 : 1;
    std::vector<Trial> simplex{ start };
    for (int k = 0; k < dimensions; ++k)
    {
      Parameters at = start.At;
      at[k] += at[k] + 0.4 <= this->Limits.Upper[k] ? 0.4 : -0.4;
      simplex.push_back(this->Try(at));
    }
    while (this->SizeOf(simplex) > SimplexAccuracy)
    {
      if (this->Function.NumberOfEvaluations() > MostEvaluations)
      {
        throw SolverFailure("EstimateMatern: the likelihood has no maximum to 1e-4 after " +
          std::to_string(MostEvaluations) + " evaluations; expected one.");
      }
      this->Improve(simplex);
    }
    return *std::min_element(simplex.begin(), simplex.end(), IsBetter);
  }

private:
  static bool IsBetter(const Trial& a, const Trial& b) { return a.Deviance < b.Deviance; }

  Trial Try(const Parameters& at)
  {
    const Parameters inside = this->Limits.Inside(at);
    // Long ranges of large powers are not positive definite to working precision, and no candidates.
    double deviance = std::numeric_limits<double>::infinity();
    try
    {
      deviance = this->Function.Deviance(inside);
    }
    catch (const SolverFailure&)
    {}
    return { inside, std::isfinite(deviance) ? deviance : std::numeric_limits<double>::infinity() };
  }

  Trial BestOfGrid()
  {
    constexpr int Ranges = 6;
    Trial best{ this->Limits.Lower, std::numeric_limits<double>::infinity() };
    for (int k = 0; k < Ranges; ++k)
    {
      for (const double noise : { -3.5, -1.0 })
      {
        const double fraction = (k + 0.5) / Ranges;
        const Parameters at((1.0 - fraction) * this->Limits.Lower[0] + fraction * this->Limits.Upper[0], noise);
        const Trial trial = this->Try(at);
        best = trial.Deviance < best.Deviance ? trial : best;
      }
    }
    if (!std::isfinite(best.Deviance))
    {
      throw SolverFailure("EstimateMatern: no matrix of the ranges that are looked at is positive definite to working "
                          "precision; expected a mesh without needle triangles, or a smaller operator power.");
    }
    return best;
  }

  static double SizeOf(const std::vector<Trial>& simplex)
  {
    double size = 0.0;
    for (const Trial& trial : simplex)
    {
      size = std::max(size, (trial.At - simplex.front().At).cwiseAbs().maxCoeff());
    }
    return size;
  }

  void Improve(std::vector<Trial>& simplex)
  {
    std::sort(simplex.begin(), simplex.end(), IsBetter);
    Parameters center = Parameters::Zero();
    for (std::size_t k = 0; k + 1 < simplex.size(); ++k)
    {
      center += simplex[k].At / static_cast<double>(simplex.size() - 1);
    }
    Trial& worst = simplex.back();
    const Trial reflected = this->Try(2.0 * center - worst.At);
    if (reflected.Deviance < simplex.front().Deviance)
    {
      const Trial expanded = this->Try(3.0 * center - 2.0 * worst.At);
      worst = IsBetter(expanded, reflected) ? expanded : reflected;
      return;
    }
    if (reflected.Deviance < simplex[simplex.size() - 2].Deviance)
    {
      worst = reflected;
      return;
    }
    const Parameters& outer = IsBetter(reflected, worst) ? reflected.At : worst.At;
    const Trial contracted = this->Try(0.5 * (center + outer));
    if (contracted.Deviance < std::min(reflected.Deviance, worst.Deviance))
    {
      worst = contracted;
      return;
    }
    for (std::size_t k = 1; k < simplex.size(); ++k)
    {
      simplex[k] = this->Try(0.5 * (simplex[0].At + simplex[k].At));
    }
  }

  Likelihood& Function;
  Box Limits;
};

/// Observed information in log range, log sigma, log eta at the maximum, by differences of second order.
Eigen::Matrix3d ObservedInformation(Likelihood& likelihood, const Parameters& at, const Terms& center)
{
  const double variance = center.Square / likelihood.Numbers();
  std::array<std::array<Terms, 3>, 3> around;
  for (int i = 0; i < 3; ++i)
  {
    for (int j = 0; j < 3; ++j)
    {
      around[i][j] = i == 1 && j == 1 ? center : likelihood.At(at + LogarithmStep * Parameters(i - 1, j - 1));
    }
  }
  const auto half = [&](int i, int j) {
    return 0.5 * (likelihood.Fields() * around[i][j].Determinant + around[i][j].Square / variance);
  };
  const double squareByRange = (around[2][1].Square - around[0][1].Square) / (2.0 * LogarithmStep);
  const double squareByNoise = (around[1][2].Square - around[1][0].Square) / (2.0 * LogarithmStep);
  Eigen::Matrix3d information;
  information(0, 0) = (half(2, 1) - 2.0 * half(1, 1) + half(0, 1)) / (LogarithmStep * LogarithmStep);
  information(2, 2) = (half(1, 2) - 2.0 * half(1, 1) + half(1, 0)) / (LogarithmStep * LogarithmStep);
  information(0, 2) = (half(2, 2) - half(2, 0) - half(0, 2) + half(0, 0)) / (4.0 * LogarithmStep * LogarithmStep);
  information(1, 1) = 2.0 * likelihood.Numbers();
  information(0, 1) = -squareByRange / variance;
  information(1, 2) = -squareByNoise / variance;
  information(1, 0) = information(0, 1);
  information(2, 0) = information(0, 2);
  information(2, 1) = information(1, 2);
  return information;
}

EstimatedParameter WithInterval(double value, double variance)
{
  if (!(variance > 0.0) || !std::isfinite(variance))
  {
    throw SolverFailure("EstimateMatern: the observed information is not positive definite; expected more observations "
                        "or fields, for a maximum that is determined by them.");
  }
  const double error = std::sqrt(variance);
  return { value, error, value * std::exp(-Quantile95 * error), value * std::exp(Quantile95 * error) };
}

void RequireObservations(const SparseRowMatrix& matrix, const Eigen::MatrixXd& values, Index vertices)
{
  const auto require = [](bool condition, const std::string& text) {
    if (!condition)
    {
      throw InvalidInput("EstimateMatern: " + text);
    }
  };
  require(matrix.cols() == vertices && matrix.rows() == values.rows(),
    std::to_string(values.rows()) + " values of a field for " + std::to_string(matrix.rows()) + " places on " +
      std::to_string(matrix.cols()) + " vertices; expected as many values as places, on " + std::to_string(vertices) +
      " vertices.");
  require(values.allFinite(), "a value is not finite; expected finite numbers.");
  require(values.size() >= 4, std::to_string(values.size()) + " values; expected at least 4.");
  require(values.maxCoeff() > values.minCoeff(),
    "all values are " + FormatNumber(values(0, 0)) + "; expected a field that varies.");
}

Box Limits(const TriangleMesh& mesh, bool noise)
{
  double longest = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      longest = std::max(
        longest, (mesh.Points.row(mesh.Triangles(f, k)) - mesh.Points.row(mesh.Triangles(f, (k + 1) % 3))).norm());
    }
  }
  const double side = ComputeBoundingBox(mesh).LongestSide();
  const double least = std::log(LeastNoise);
  return { { std::log(std::min(longest, side)), least },
    { std::log(LongestRange * side), noise ? std::log(LargestNoise) : least } };
}

void RequireInside(const Box& box, const Trial& best)
{
  for (const bool upper : { false, true })
  {
    const double limit = upper ? box.Upper[0] : box.Lower[0];
    if (std::abs(best.At[0] - limit) < 2.0 * LogarithmStep)
    {
      throw InvalidInput("EstimateMatern: the likelihood increases " + std::string(upper ? "up" : "down") +
        " to a correlation range of " + FormatNumber(std::exp(limit)) + ", the " +
        (upper ? "longest that is looked at; expected observations that vary on the surface (or a mean that is "
                 "estimated)."
               : "length of the longest edge; expected a field that is smooth over several edges, or a finer mesh."));
    }
  }
  if (std::abs(best.At[1] - std::log(LargestNoise)) < 2.0 * LogarithmStep)
  {
    throw InvalidInput("EstimateMatern: the likelihood increases up to errors of " + FormatNumber(LargestNoise) +
      " times the deviation of the field; expected observations with a spatial correlation.");
  }
}
} // namespace

MaternEstimate EstimateMatern(const TriangleMesh& mesh, const MeshTopology& topology, const SparseRowMatrix& matrix,
  const Eigen::MatrixXd& values, const MaternEstimationOptions& options, const Progress& progress)
{
  RequireObservations(matrix, values, mesh.NumberOfPoints());
  if (options.OperatorPower < 2 || options.OperatorPower > 4)
  {
    throw InvalidInput("EstimateMatern: the operator power is " + std::to_string(options.OperatorPower) +
      "; expected 2, 3 or 4 (1 has no correlation range).");
  }
  Likelihood likelihood(mesh, topology, matrix, values, options, progress);
  const Box box = Limits(mesh, options.Noise);
  const Trial best = Search(likelihood, box).Run();
  RequireInside(box, best);
  const Terms terms = likelihood.At(best.At);
  const Eigen::Matrix3d information = ObservedInformation(likelihood, best.At, terms);
  const bool hasNoise = options.Noise && best.At[1] > box.Lower[1] + 2.0 * LogarithmStep;
  // Without noise the information of the others; log noise = log sigma + log eta.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (hasNoise)
  {
    covariance = information.inverse();
  }
  else
  {
    covariance.topLeftCorner<2, 2>() = information.topLeftCorner<2, 2>().inverse();
  }
  const double deviation = std::sqrt(terms.Square / likelihood.Numbers());
  MaternEstimate estimate;
  estimate.CorrelationRange = WithInterval(std::exp(best.At[0]), covariance(0, 0));
  estimate.StandardDeviation = WithInterval(deviation, covariance(1, 1));
  if (hasNoise)
  {
    estimate.NoiseDeviation = WithInterval(
      deviation * std::exp(best.At[1]), covariance(1, 1) + 2.0 * covariance(1, 2) + covariance(2, 2));
  }
  else if (options.Noise)
  {
    estimate.NoiseDeviation.Upper = deviation * LeastNoise;
  }
  estimate.Means = terms.Means;
  estimate.LogLikelihood = -0.5 *
    (likelihood.Fields() * terms.Determinant +
      likelihood.Numbers() * (2.0 * std::log(deviation) + 1.0 + std::log(2.0 * M_PI)));
  estimate.Observations = matrix.rows();
  estimate.Fields = values.cols();
  estimate.Evaluations = likelihood.NumberOfEvaluations();
  Report(progress, 1.0);
  return estimate;
}

} // namespace surfsynth
