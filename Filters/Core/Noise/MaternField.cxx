// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternField.h"

#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Noise/MaternFieldInternals.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

namespace surfsynth
{

namespace
{
double LongestEdgeOf(const TriangleMesh& mesh)
{
  double longest = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    for (int k = 0; k < 3; ++k)
    {
      longest = std::max(longest, (mesh.Points.row(t(k)) - mesh.Points.row(t((k + 1) % 3))).squaredNorm());
    }
  }
  return std::sqrt(longest);
}
} // namespace

MaternField::Internals::Internals(
  TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress)
  : Mesh(std::move(mesh))
  , Options(options)
{
  RequireArrays(options, this->Mesh.Points.rows(), this->Mesh.Triangles.rows());
  this->LongestEdge = LongestEdgeOf(this->Mesh);
  this->LongestScaledEdge = LongestEdgeForRange(this->Mesh, options);
  this->LongestSide = ComputeBoundingBox(this->Mesh).LongestSide();
  if (options.Model != NoiseModel::Matern || options.Arrays.Barrier.empty())
  {
    this->Assemble(SurfaceDomain(this->Mesh, topology, this->Options), progress);
    return;
  }
  const TriangleMesh open = WithoutTriangles(this->Mesh, options.Arrays.Barrier);
  const MeshTopology openTopology(open);
  this->Assemble(SurfaceDomain(open, openTopology, this->Options), progress);
}

MaternField::Internals::Internals(
  const TetrahedralMesh& mesh, const MaternFieldOptions& options, const Progress& progress)
  : Mesh{ mesh.Points, {} }
  , Dimension(3)
  , Options(options)
{
  RequireArrays(options, mesh.Points.rows(), mesh.Tetrahedra.rows());
  this->LongestEdge = FindLongestEdge(mesh);
  this->LongestScaledEdge = LongestEdgeForRange(mesh, options);
  this->LongestSide = ComputeBoundingBox(mesh).LongestSide();
  if (options.Model != NoiseModel::Matern || options.Arrays.Barrier.empty())
  {
    this->Assemble(VolumeDomain(mesh, this->Options), progress);
    return;
  }
  const TetrahedralMesh open = WithoutTetrahedra(mesh, options.Arrays.Barrier);
  this->Assemble(VolumeDomain(open, this->Options), progress);
}

void MaternField::Internals::Assemble(const FieldDomain& domain, const Progress& progress)
{
  const NoiseModel model = this->Options.Model;
  this->Mass = domain.Mass();
  this->RootMass = this->Mass.cwiseSqrt();
  this->Components = domain.Components(this->Mass);
  Report(progress, 0.05);
  const bool anything = this->Components.Count > 0;
  if (!anything || model == NoiseModel::PerVertex || model == NoiseModel::White)
  {
    this->ChooseAmplitude(domain);
    return;
  }
  SparseMatrix stiffness = domain.Stiffness();
  this->ChooseScreening(stiffness);
  this->ChooseAmplitude(domain);
  const SparseMatrix coupling = domain.Coupling(SubProgress(progress, 0.05, 0.15));
  if (coupling.rows() > 0)
  {
    stiffness += coupling;
  }
  Report(progress, 0.15);
  const Progress rest = SubProgress(progress, 0.15, 1.0);
  switch (model)
  {
    case NoiseModel::Spectral:
      this->Pairs = LowestLaplaceEigenpairs(stiffness, this->Mass, this->Options.NumberOfEigenpairs, rest);
      break;
    case NoiseModel::Unscreened:
      this->FactorUnscreened(std::move(stiffness), rest);
      break;
    default:
      this->Pin(domain.Pinned());
      this->ChooseNoise(domain);
      this->FactorScreened(
        std::move(stiffness), domain.RobinMass(), SubProgress(rest, 0.0, this->Options.VarianceCorrection ? 0.3 : 1.0));
      if (this->Options.VarianceCorrection)
      {
        this->CorrectAmplitude(SubProgress(rest, 0.3, 1.0));
      }
  }
}

void MaternField::Internals::ChooseScreening(const SparseMatrix& stiffness)
{
  if (!HasTau(this->Options.Model))
  {
    return;
  }
  this->Gamma = LaplaceBeltramiNorm(stiffness, this->Mass);
  switch (this->Options.Mode)
  {
    case ScaleMode::CorrelationRange:
    {
      const double asked = this->Options.CorrelationRange;
      const double range = asked > 0.0 ? asked : 0.2 * this->LongestSide;
      this->Tau = 8.0 * this->Smoothness() / (range * range); // kappa^2 with kappa = sqrt(8 nu) / range
      break;
    }
    case ScaleMode::Screening:
      this->Tau = this->Options.Screening;
      break;
    case ScaleMode::NormalizedScreening:
      this->Tau = this->Gamma * this->Options.NormalizedScreening;
      break;
  }
  RequireOption(this->Tau > 0.0 && std::isfinite(this->Tau), "the screening term that follows from the options",
    this->Tau, "a finite number above 0");
}

double MaternField::Internals::Power() const { return HasTau(this->Options.Model) ? this->Options.OperatorPower : 2; }

double MaternField::Internals::AmplitudeOfComponent(const FieldDomain& domain, Index component) const
{
  return this->Options.StandardDeviation / std::sqrt(domain.Variance(this->Tau, this->Components, component));
}

void MaternField::Internals::ChooseAmplitude(const FieldDomain& domain)
{
  this->Amplitude = Eigen::VectorXd::Ones(this->Mass.size());
  if (this->Options.Model == NoiseModel::PerVertex)
  {
    this->Amplitude *= this->Options.StandardDeviation;
  }
  if (!(this->Tau > 0.0))
  {
    return;
  }
  const double smoothness = this->Smoothness();
  if (this->Options.Mode == ScaleMode::NormalizedScreening)
  {
    this->Amplitude *= std::pow(std::sqrt(this->Gamma), smoothness);
  }
  if (this->Options.Mode == ScaleMode::CorrelationRange)
  {
    std::vector<double> factor;
    for (Index c = 0; c < this->Components.Count; ++c)
    {
      factor.push_back(this->AmplitudeOfComponent(domain, c));
    }
    for (Index v = 0; v < this->Mass.size(); ++v)
    {
      this->Amplitude[v] = this->Used(v) ? factor[this->Components.OfVertex[v]] : 0.0;
    }
    const Eigen::VectorXd& ranges = this->Options.Arrays.RangeFactors;
    if (this->Options.Model == NoiseModel::Matern && ranges.size() > 0)
    {
      this->Amplitude.array() *= ranges.array().pow(-smoothness);
    }
  }
}

void MaternField::Internals::CorrectAmplitude(const Progress& progress)
{
  this->Amplitude.setOnes();
  const Eigen::VectorXd variances = this->InverseVariances(progress);
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    this->Amplitude[v] = this->Mass[v] > 0.0 ? this->Options.StandardDeviation / std::sqrt(variances[v]) : 0.0;
  }
}

void MaternField::Internals::Pin(const std::vector<bool>& pinned)
{
  for (std::size_t v = 0; v < pinned.size(); ++v)
  {
    if (pinned[v])
    {
      this->Mass[v] = this->RootMass[v] = 0.0;
    }
  }
}

void MaternField::Internals::FactorScreened(
  SparseMatrix matrix, const Eigen::VectorXd& boundary, const Progress& progress)
{
  // Each vertex has its own kappa = sqrt(tau) / factor.
  Eigen::VectorXd kappa = Eigen::VectorXd::Constant(this->Mass.size(), std::sqrt(this->Tau));
  const Eigen::VectorXd& ranges = this->Options.Arrays.RangeFactors;
  Eigen::VectorXd diagonal = this->Tau * this->Mass;
  if (ranges.size() > 0)
  {
    kappa.array() /= ranges.array();
    diagonal.array() /= ranges.array().square();
  }
  if (boundary.size() > 0)
  {
    diagonal += kappa.cwiseProduct(boundary);
  }
  if (this->Options.Boundary == BoundaryCondition::Dirichlet)
  {
    DecoupleRows(matrix, this->Mass);
  }
  for (Index v = 0; v < diagonal.size(); ++v)
  {
    diagonal[v] = this->Mass[v] > 0.0 ? diagonal[v] : 1.0;
  }
  AddToDiagonal(matrix, diagonal);
  this->Factor(std::move(matrix), progress);
}

void MaternField::Internals::FactorUnscreened(SparseMatrix matrix, const Progress& progress)
{
  // L is singular on each component. With anything added to the diagonal at one vertex, right-hand sides that are
  // orthogonal to constants have the solution that is 0 there: summing the equations shows it.
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(this->Mass.size());
  const Eigen::VectorXd stiffnessDiagonal = matrix.diagonal();
  std::vector<bool> pinned(static_cast<std::size_t>(this->Components.Count), false);
  for (Index v = 0; v < diagonal.size(); ++v)
  {
    if (!this->Used(v))
    {
      diagonal[v] = 1.0;
    }
    else if (!pinned[this->Components.OfVertex[v]])
    {
      pinned[this->Components.OfVertex[v]] = true;
      diagonal[v] = stiffnessDiagonal[v];
    }
  }
  AddToDiagonal(matrix, diagonal);
  this->Factor(std::move(matrix), progress);
}

std::uint64_t MaternField::Internals::FactorLimit() const
{
  return this->Options.FactorMemoryLimit > 0 ? this->Options.FactorMemoryLimit : AvailableMemory() / 4 * 3;
}

void MaternField::Internals::ChooseRationalPower(const SparseMatrix& matrix)
{
  // The standard deviation of every mode to 1e-4: each term more divides the error by 5 to 10.
  constexpr double Tolerance = 1e-4;
  const Eigen::VectorXd& ranges = this->Options.Arrays.RangeFactors;
  const double longest = ranges.size() > 0 ? ranges.maxCoeff() : 1.0;
  const double lower = this->Tau / (longest * longest);
  const double upper = LargestEigenvalueBound(matrix, this->Mass, lower);
  try
  {
    this->Rational = ApproximateInversePowerTo(Tolerance, std::fmod(this->Power(), 2.0) / 2.0, lower, upper);
  }
  catch (const SolverFailure& error)
  {
    throw SolverFailure("MaternField: the operator power " + FormatNumber(this->Power()) +
      " has no approximation on eigenvalues from " + FormatNumber(lower) + " to " + FormatNumber(upper) + " (" +
      error.what() + ") Use a smaller correlation range, in the units of the mesh, or a whole operator power.");
  }
}

std::uint64_t MaternField::Internals::NumberOfFactors() const
{
  return this->Rational ? static_cast<std::uint64_t>(this->Rational->NumberOfTerms() + (this->Power() > 2.0 ? 1 : 0))
                        : 1U;
}

int MaternField::Internals::Iterations() const
{
  return std::max(
    this->Iterative ? this->Iterative->Iterations() : 0, this->Fraction ? this->Fraction->Iterations() : 0);
}

bool MaternField::Internals::FactorFits(const SparseMatrix& matrix) const
{
  const std::uint64_t limit = this->FactorLimit();
  const bool isCorrected = this->Options.Model == NoiseModel::Matern && this->Options.VarianceCorrection;
  // Selected inversion holds two more factors for each power.
  const std::uint64_t powers = this->Rational ? 2U : static_cast<std::uint64_t>(this->WholePower());
  const std::uint64_t factors = this->NumberOfFactors() + (isCorrected ? 2U * powers : 0U);
  const std::uint64_t needed = factors * CholeskySolver::EstimateMemory(matrix.rows(), matrix.nonZeros());
  const bool fits = needed <= limit;
  if (!fits && (std::fmod(this->Power(), 2.0) == 1.0 || isCorrected))
  {
    constexpr std::uint64_t MiB = 1U << 20U;
    throw InvalidInput(
      "MaternField: the Cholesky factor, with variance correction that of its inverse too, takes about " +
      std::to_string(needed / MiB + 1) + " MiB; expected at most " + std::to_string(limit / MiB) +
      " MiB, or an operator power 2 or 4, or one that is no integer, without variance correction, which need no "
      "factor.");
  }
  return fits;
}

void MaternField::Internals::Factor(SparseMatrix matrix, const Progress& progress)
{
  if (this->IsFractional())
  {
    this->ChooseRationalPower(matrix);
  }
  const bool fits = this->FactorFits(matrix);
  const bool hasWhole = this->Power() >= 2.0 || !this->Rational;
  const double shifted = this->Rational && hasWhole ? 0.9 : this->Rational ? 1.0 : 0.0;
  if (this->Rational)
  {
    this->Fraction.emplace(matrix, this->Mass, *this->Rational, !fits, SubProgress(progress, 0.0, shifted));
  }
  const Progress rest = SubProgress(progress, shifted, 1.0);
  if (hasWhole && fits)
  {
    this->Solver.emplace(matrix, rest);
  }
  else if (hasWhole)
  {
    this->Iterative.emplace(std::move(matrix), MultigridOptions(), rest);
  }
  const std::vector<Index>& order = this->InUse()->Order();
  this->RowOfVertex.resize(order.size());
  for (Index row = 0; row < this->InUse()->Size(); ++row)
  {
    this->RowOfVertex[order[row]] = row;
  }
}

MaternField::MaternField(TriangleMesh mesh, const MaternFieldOptions& options, const Progress& progress)
{
  RequireOptions(options, 2);
  const MeshTopology topology = RequireValidMesh(mesh);
  this->Impl = std::make_unique<Internals>(std::move(mesh), topology, options, progress);
}

MaternField::MaternField(
  TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress)
{
  RequireOptions(options, 2);
  this->Impl = std::make_unique<Internals>(std::move(mesh), topology, options, progress);
}

MaternField::MaternField(const TetrahedralMesh& mesh, const MaternFieldOptions& options, const Progress& progress)
{
  RequireOptions(options, 3);
  this->Impl = std::make_unique<Internals>(mesh, options, progress);
}

MaternField::~MaternField() = default;
MaternField::MaternField(MaternField&&) noexcept = default;
MaternField& MaternField::operator=(MaternField&&) noexcept = default;

void MaternField::SampleInto(
  const SampleRequest& request, const Destination& destination, const Progress& progress) const
{
  ScratchPool<LargeArray<double>> scratch;
  this->Impl->SampleInto(request, destination, scratch, progress);
}

void MaternField::Internals::SampleInto(const SampleRequest& request, const Destination& destination,
  ScratchPool<LargeArray<double>>& scratch, const Progress& progress)
{
  if (request.NumberOfComponents < 1)
  {
    throw InvalidInput("MaternField: 0 components asked for; expected at least 1.");
  }
  if (request.FirstSample + std::uint64_t(request.NumberOfSamples) * request.SampleStep > 0x100000000ULL)
  {
    throw InvalidInput("MaternField: samples beyond number 4294967295 asked for.");
  }
  std::vector<MaternColumn> columns;
  for (std::uint32_t k = 0; k < request.NumberOfSamples; ++k)
  {
    const std::uint32_t sample = request.FirstSample + k * request.SampleStep;
    double* values = destination(sample);
    for (std::uint32_t component = 0; component < request.NumberOfComponents; ++component)
    {
      columns.push_back({ sample, component, values + component });
    }
  }
  // Blocks of equal size, at least one for each thread, over each of which the factor is read once. Conjugate gradients
  // share the rows of one block after the other among the threads.
  const auto count = static_cast<std::int64_t>(columns.size());
  const std::int64_t fewest = (count + CholeskySolver::BlockColumns - 1) / CholeskySolver::BlockColumns;
  const std::int64_t granules = (count + CholeskySolver::ColumnGranularity - 1) / CholeskySolver::ColumnGranularity;
  const std::int64_t threads = MaximumThreads();
  const bool together = this->IsIterative();
  const std::int64_t blocks = together ? granules : std::min((fewest + threads - 1) / threads * threads, granules);
  const auto firstOf = [&](std::int64_t block) {
    return std::min(count, granules * block / std::max<std::int64_t>(blocks, 1) * CholeskySolver::ColumnGranularity);
  };

  this->ResetResidual();
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<std::int64_t> done{ 0 };
  const auto sampleBlock = [&](std::int64_t k) {
    Progress blockProgress;
    if (progress && std::this_thread::get_id() == caller)
    {
      blockProgress = [&](double fraction) {
        return progress((static_cast<double>(done) + fraction) / static_cast<double>(blocks));
      };
    }
    LargeArray<double> memory = scratch.Borrow();
    this->SampleColumns(
      request, { columns.begin() + firstOf(k), columns.begin() + firstOf(k + 1) }, memory, blockProgress);
    scratch.Return(std::move(memory));
    ++done;
  };
  for (std::int64_t k = 0; together && k < blocks; ++k)
  {
    sampleBlock(k);
  }
  ParallelTasks(together ? 0 : blocks, sampleBlock);
  Report(progress, 1.0);
}

void MaternField::Sample(const SampleRequest& request, const Consumer& consume, const Progress& progress) const
{
  const std::int64_t components = std::max<std::int64_t>(request.NumberOfComponents, 1);
  const std::int64_t samples = request.NumberOfSamples;
  const std::int64_t together = std::clamp<std::int64_t>(
    (this->Impl->IsIterative() ? CholeskySolver::ColumnGranularity : CholeskySolver::BlockColumns * MaximumThreads()) /
      components,
    1, std::max<std::int64_t>(samples, 1));
  const Eigen::Index points = this->Impl->Mesh.Points.rows();
  LargeArray<double> group(static_cast<std::size_t>(points * together * components));
  // Large arrays are made once for each thread, not for each group: the system hands out fresh pages slowly.
  ScratchPool<LargeArray<double>> scratch;
  for (std::int64_t begin = 0; begin < samples; begin += together)
  {
    SampleRequest part = request;
    part.FirstSample = request.FirstSample + static_cast<std::uint32_t>(begin) * request.SampleStep;
    part.NumberOfSamples = static_cast<std::uint32_t>(std::min(together, samples - begin));
    double* next = group.data();
    this->Impl->SampleInto(
      part, [&](std::uint32_t) { return std::exchange(next, next + points * components); }, scratch,
      SubProgress(progress, static_cast<double>(begin) / static_cast<double>(samples),
        static_cast<double>(begin + part.NumberOfSamples) / static_cast<double>(samples)));
    for (std::uint32_t k = 0; k < part.NumberOfSamples; ++k)
    {
      const double* values = group.data() + std::int64_t(k) * points * components;
      const std::uint32_t sample = part.FirstSample + k * request.SampleStep;
      if (components == 1)
      {
        consume(sample, Eigen::Map<const Eigen::MatrixXd>(values, points, 1));
      }
      else
      {
        consume(sample, Eigen::MatrixXd(Eigen::Map<const RowMatrix>(values, points, components)));
      }
    }
  }
  Report(progress, 1.0);
}

Eigen::MatrixXd MaternField::Sample(const SampleRequest& request) const
{
  SampleRequest one = request;
  one.NumberOfSamples = 1;
  Eigen::MatrixXd values;
  this->Sample(one, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& sample) { values = sample; });
  return values;
}

double MaternField::EffectiveScreening() const { return this->Impl->Tau; }

double MaternField::EffectiveCorrelationRange() const
{
  const bool hasRange = this->Impl->Tau > 0.0 && this->Smoothness() > 0.0;
  return hasRange ? std::sqrt(8.0 * this->Smoothness() / this->Impl->Tau) : 0.0;
}

double MaternField::Smoothness() const { return this->Impl->Smoothness(); }

double MaternField::Gamma() const { return this->Impl->Gamma; }

double MaternField::RelativeResidual() const { return this->Impl->MaximumResidual(); }

const char* MaternField::SolverName() const
{
  return this->Impl->IsIterative() ? "Multigrid" : this->Impl->InUse() ? "Cholesky" : "None";
}

int MaternField::Iterations() const { return this->Impl->Iterations(); }

double MaternField::LongestEdge() const { return this->Impl->LongestEdge; }

double MaternField::LongestEdgeOverRange() const
{
  const double range = this->EffectiveCorrelationRange();
  return range > 0.0 ? this->Impl->LongestScaledEdge / range : 0.0;
}

const TriangleMesh& MaternField::Mesh() const { return this->Impl->Mesh; }

} // namespace surfsynth
