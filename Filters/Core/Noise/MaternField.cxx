// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Noise/MaternField.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Common/Text.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/LaplaceEigenpairs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr double LargestResidual = 1e-8;

/// Columns that are solved together, rows in the solver's order.
using Block = Eigen::Map<RowMatrix>;

/// One component of one sample, and where it is to be written.
struct Column
{
  std::uint32_t Sample;
  std::uint32_t Component;
  double* Values; ///< of the first vertex; those of the others follow at a distance of the number of components
};

bool HasTau(NoiseModel model)
{
  return model == NoiseModel::Matern || model == NoiseModel::Spectral;
}

void Require(bool condition, const char* name, double value, const char* expected)
{
  if (!condition)
  {
    throw InvalidInput(
      std::string("MaternField: ") + name + " is " + Text(value) + "; expected " + expected + ".");
  }
}

void Validate(const MaternFieldOptions& options)
{
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  const bool byRange = HasTau(options.Model) && options.Mode == ScaleMode::CorrelationRange;
  if (byRange)
  {
    Require(options.CorrelationRange == 0.0 || positive(options.CorrelationRange), "the correlation range",
      options.CorrelationRange, "a finite number, at least 0 (0: 0.2 times the longest side)");
  }
  if (byRange || options.Model == NoiseModel::PerVertex)
  {
    Require(options.StandardDeviation == 0.0 || positive(options.StandardDeviation), "the standard deviation",
      options.StandardDeviation, "a finite number, at least 0");
  }
  if (HasTau(options.Model) && options.Mode == ScaleMode::Screening)
  {
    Require(positive(options.Screening), "the screening term tau", options.Screening, "a finite number above 0");
  }
  if (HasTau(options.Model) && options.Mode == ScaleMode::NormalizedScreening)
  {
    Require(positive(options.NormalizedScreening), "the normalised screening c", options.NormalizedScreening,
      "a finite number above 0");
  }
}

double FindLongestEdge(const TriangleMesh& mesh)
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

NormalKey Key(const SampleRequest& request, const Column& column)
{
  NormalKey key;
  key.Seed = request.Seed;
  key.Sample = column.Sample;
  key.Component = column.Component;
  key.Stream = request.Stream;
  return key;
}

/// Adds @p diagonal to the diagonal of @p matrix, in which every diagonal entry is present.
void AddToDiagonal(SparseMatrix& matrix, const Eigen::VectorXd& diagonal)
{
  for (Index v = 0; v < matrix.cols(); ++v)
  {
    const Index* first = matrix.innerIndexPtr() + matrix.outerIndexPtr()[v];
    const Index* last = matrix.innerIndexPtr() + matrix.outerIndexPtr()[v + 1];
    matrix.valuePtr()[std::lower_bound(first, last, v) - matrix.innerIndexPtr()] += diagonal[v];
  }
}
}

class MaternField::Internals
{
public:
  Internals(
    TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress);

  /// Samples @p columns of the request. @p scratch grows as needed and is worth keeping from call to call.
  void SampleColumns(
    const SampleRequest& request, const std::vector<Column>& columns, LargeArray<double>& scratch, const Progress& progress);

  TriangleMesh Mesh;
  MaternFieldOptions Options;
  double Tau = 0.0;
  double Gamma = 0.0;
  double LongestEdge = 0.0;

  void ForgetResidual()
  {
    std::lock_guard<std::mutex> lock(this->ResidualMutex);
    this->Residual = 0.0;
  }
  double WorstResidual()
  {
    std::lock_guard<std::mutex> lock(this->ResidualMutex);
    return this->Residual;
  }

private:
  void ChooseScreening(const SparseMatrix& stiffness);
  void ChooseAmplitude();
  void FactorScreened(SparseMatrix matrix, const Progress& progress);
  void FactorUnscreened(SparseMatrix matrix, const Progress& progress);
  void Factor(const SparseMatrix& matrix, const Progress& progress);

  bool Used(Index v) const { return this->Components.OfVertex[v] >= 0; }
  void SampleBySolve(
    const SampleRequest& request, const std::vector<Column>& columns, LargeArray<double>& scratch, const Progress& progress);
  void SampleByVertex(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;
  void SampleBySpectrum(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const;

  void FillRightHandSides(const SampleRequest& request, const std::vector<Column>& columns, Block& block) const;
  void TakeSolutions(const SampleRequest& request, const std::vector<Column>& columns, const Block& block) const;
  void RemoveMeans(Block& block, const Eigen::VectorXd& weights, const Eigen::VectorXd& shape) const;
  Eigen::VectorXd FirstColumn(const Block& block) const;
  void CheckSolution(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide);

  Eigen::VectorXd Mass;
  Eigen::VectorXd RootMass;
  Eigen::VectorXd Amplitude; ///< what each vertex's value is multiplied by
  MeshComponents Components;
  std::optional<CholeskySolver> Solver;
  std::vector<Index> RowOfVertex; ///< in the solver's order
  Eigenpairs Pairs;

  std::mutex ResidualMutex;
  double Residual = 0.0;
};

MaternField::Internals::Internals(
  TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress)
  : Mesh(std::move(mesh))
  , Options(options)
{
  this->LongestEdge = FindLongestEdge(this->Mesh);
  this->Mass = LumpedMass(this->Mesh, topology);
  this->RootMass = this->Mass.cwiseSqrt();
  this->Components = ComputeComponents(topology, this->Mass);
  Report(progress, 0.05);
  const bool anything = this->Components.Count > 0;
  if (!anything || options.Model == NoiseModel::PerVertex || options.Model == NoiseModel::White)
  {
    this->ChooseAmplitude();
    return;
  }
  SparseMatrix stiffness = CotangentStiffness(this->Mesh, topology);
  this->ChooseScreening(stiffness);
  this->ChooseAmplitude();
  Report(progress, 0.15);
  const Progress rest = SubProgress(progress, 0.15, 1.0);
  switch (options.Model)
  {
    case NoiseModel::Spectral:
      this->Pairs = LowestLaplaceEigenpairs(stiffness, this->Mass, options.NumberOfEigenpairs, rest);
      break;
    case NoiseModel::Unscreened:
      this->FactorUnscreened(std::move(stiffness), rest);
      break;
    default:
      this->FactorScreened(std::move(stiffness), rest);
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
      const double range = asked > 0.0 ? asked : 0.2 * ComputeBoundingBox(this->Mesh).LongestSide();
      this->Tau = 8.0 / (range * range); // kappa^2 with kappa = sqrt(8 nu) / range, nu = 1
      break;
    }
    case ScaleMode::Screening:
      this->Tau = this->Options.Screening;
      break;
    case ScaleMode::NormalizedScreening:
      this->Tau = this->Gamma * this->Options.NormalizedScreening;
      break;
  }
  Require(this->Tau > 0.0 && std::isfinite(this->Tau), "the screening term that follows from the options", this->Tau,
    "a finite number above 0");
}

void MaternField::Internals::ChooseAmplitude()
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
  if (this->Options.Mode == ScaleMode::NormalizedScreening)
  {
    this->Amplitude *= std::sqrt(this->Gamma);
  }
  if (this->Options.Mode == ScaleMode::CorrelationRange)
  {
    std::vector<double> factor;
    for (Index c = 0; c < this->Components.Count; ++c)
    {
      factor.push_back(this->Options.StandardDeviation /
        std::sqrt(MarginalVariance(this->Tau, this->Components.Area[c], this->Components.EulerCharacteristic[c],
          this->Components.Closed[c])));
    }
    for (Index v = 0; v < this->Mass.size(); ++v)
    {
      this->Amplitude[v] = this->Used(v) ? factor[this->Components.OfVertex[v]] : 0.0;
    }
  }
}

void MaternField::Internals::FactorScreened(SparseMatrix matrix, const Progress& progress)
{
  Eigen::VectorXd diagonal = this->Tau * this->Mass;
  for (Index v = 0; v < diagonal.size(); ++v)
  {
    diagonal[v] = this->Used(v) ? diagonal[v] : 1.0;
  }
  AddToDiagonal(matrix, diagonal);
  this->Factor(matrix, progress);
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
  this->Factor(matrix, progress);
}

void MaternField::Internals::Factor(const SparseMatrix& matrix, const Progress& progress)
{
  this->Solver.emplace(matrix, progress);
  const std::vector<Index>& order = this->Solver->Order();
  this->RowOfVertex.resize(order.size());
  for (Index row = 0; row < this->Solver->Size(); ++row)
  {
    this->RowOfVertex[order[row]] = row;
  }
}

void MaternField::Internals::SampleColumns(
  const SampleRequest& request, const std::vector<Column>& columns, LargeArray<double>& scratch, const Progress& progress)
{
  if (this->Solver)
  {
    this->SampleBySolve(request, columns, scratch, progress);
    return;
  }
  Eigen::VectorXd values(this->Mass.size());
  for (std::size_t k = 0; k < columns.size(); ++k)
  {
    const NormalKey key = Key(request, columns[k]);
    if (this->Pairs.Values.size() > 0)
    {
      this->SampleBySpectrum(key, values);
    }
    else
    {
      this->SampleByVertex(key, values);
    }
    Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<>>(
      columns[k].Values, values.size(), Eigen::InnerStride<>(request.NumberOfComponents)) = request.Scale * values;
    Report(progress, (k + 1.0) / static_cast<double>(columns.size()));
  }
}

void MaternField::Internals::SampleByVertex(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const
{
  FillNormals(key, 0, values.size(), values.data());
  for (Index v = 0; v < values.size(); ++v)
  {
    const double scale =
      this->Options.Model == NoiseModel::White ? this->Amplitude[v] / this->RootMass[v] : this->Amplitude[v];
    values[v] = this->Used(v) ? scale * values[v] : 0.0;
  }
}

void MaternField::Internals::SampleBySpectrum(const NormalKey& key, Eigen::Ref<Eigen::VectorXd> values) const
{
  // chi_i / (lambda_i + tau), then one eigenvector after the other, in a fixed order.
  Eigen::VectorXd coefficients(this->Pairs.Values.size());
  FillNormals(key, 0, coefficients.size(), coefficients.data());
  coefficients.array() /= this->Pairs.Values.array() + this->Tau;
  values.setZero();
  for (Eigen::Index i = 0; i < coefficients.size(); ++i)
  {
    values += coefficients[i] * this->Pairs.Vectors.col(i);
  }
  values.array() *= this->Amplitude.array();
}

void MaternField::Internals::FillRightHandSides(
  const SampleRequest& request, const std::vector<Column>& columns, Block& block) const
{
  constexpr Index Tile = 256; // vertices whose numbers for all columns stay in cache
  std::vector<double> normals(Tile * columns.size());
  for (Index begin = 0; begin < this->Mass.size(); begin += Tile)
  {
    const Index count = std::min<Index>(Tile, static_cast<Index>(this->Mass.size()) - begin);
    for (std::size_t k = 0; k < columns.size(); ++k)
    {
      FillNormals(Key(request, columns[k]), begin, count, normals.data() + k * Tile);
    }
    for (Index v = begin; v < begin + count; ++v)
    {
      double* row = block.data() + this->RowOfVertex[v] * block.cols();
      for (std::size_t k = 0; k < columns.size(); ++k)
      {
        row[k] = this->RootMass[v] * normals[k * Tile + static_cast<std::size_t>(v - begin)];
      }
      std::fill(row + columns.size(), row + block.cols(), 0.0);
    }
  }
}

void MaternField::Internals::RemoveMeans(
  Block& block, const Eigen::VectorXd& weights, const Eigen::VectorXd& shape) const
{
  RowMatrix means = RowMatrix::Zero(this->Components.Count, block.cols());
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Used(v))
    {
      const Index c = this->Components.OfVertex[v];
      means.row(c) += weights[v] / this->Components.Area[c] * block.row(this->RowOfVertex[v]);
    }
  }
  for (Index v = 0; v < this->Mass.size(); ++v)
  {
    if (this->Used(v))
    {
      block.row(this->RowOfVertex[v]) -= shape[v] * means.row(this->Components.OfVertex[v]);
    }
  }
}

Eigen::VectorXd MaternField::Internals::FirstColumn(const Block& block) const
{
  Eigen::VectorXd column(block.rows());
  for (Index v = 0; v < column.size(); ++v)
  {
    column[v] = block(this->RowOfVertex[v], 0);
  }
  return column;
}

void MaternField::Internals::CheckSolution(const Eigen::VectorXd& solution, const Eigen::VectorXd& rightHandSide)
{
  const double residual = this->Solver->RelativeResidual(solution, rightHandSide);
  if (!(residual <= LargestResidual))
  {
    throw SolverFailure("MaternField: the relative residual of the solve is " + Text(residual) +
      "; expected at most 1e-8. Needle triangles, or a screening term that is tiny for the size of the mesh, make the "
      "system ill-conditioned: remesh, or use a smaller correlation range.");
  }
  std::lock_guard<std::mutex> lock(this->ResidualMutex);
  this->Residual = std::max(this->Residual, residual);
}

void MaternField::Internals::TakeSolutions(
  const SampleRequest& request, const std::vector<Column>& columns, const Block& block) const
{
  constexpr Index Tile = 64; // vertices whose rows stay in cache while they are turned into columns
  const auto stride = static_cast<std::ptrdiff_t>(request.NumberOfComponents);
  const auto points = static_cast<Index>(block.rows());
  bool finite = true;
  for (Index begin = 0; begin < points; begin += Tile)
  {
    const Index end = std::min<Index>(begin + Tile, points);
    for (std::size_t k = 0; k < columns.size(); ++k)
    {
      const double* solution = block.data() + k;
      double sum = 0.0;
      for (Index v = begin; v < end; ++v)
      {
        const double value = request.Scale * this->Amplitude[v] * solution[this->RowOfVertex[v] * block.cols()];
        columns[k].Values[v * stride] = value;
        sum += value;
      }
      finite = finite && std::isfinite(sum);
    }
  }
  if (!finite)
  {
    throw SolverFailure("MaternField: a sample is not finite.");
  }
}

void MaternField::Internals::SampleBySolve(
  const SampleRequest& request, const std::vector<Column>& columns, LargeArray<double>& scratch, const Progress& progress)
{
  constexpr Eigen::Index Granularity = CholeskySolver::ColumnGranularity;
  const auto count = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index padded = (count + Granularity - 1) / Granularity * Granularity;
  const Eigen::Index points = this->Mass.size();
  const auto size = static_cast<std::size_t>(points * padded);
  if (scratch.size() < size)
  {
    scratch = LargeArray<double>(size);
  }
  Block block(scratch.data(), points, padded);
  this->FillRightHandSides(request, columns, block);
  const bool unscreened = this->Options.Model == NoiseModel::Unscreened;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(unscreened ? points : 0);
  if (unscreened)
  {
    this->RemoveMeans(block, ones, this->Mass); // now orthogonal to constants
  }
  const Eigen::VectorXd rightHandSide = this->FirstColumn(block);
  this->Solver->SolveOrderedInPlace(block, progress);
  this->CheckSolution(this->FirstColumn(block), rightHandSide);
  if (unscreened)
  {
    this->RemoveMeans(block, this->Mass, ones);
  }
  this->TakeSolutions(request, columns, block);
}

MaternField::MaternField(TriangleMesh mesh, const MaternFieldOptions& options, const Progress& progress)
{
  Validate(options);
  const MeshTopology topology = RequireSoundMesh(mesh);
  this->Impl = std::make_unique<Internals>(std::move(mesh), topology, options, progress);
}

MaternField::MaternField(
  TriangleMesh mesh, const MeshTopology& topology, const MaternFieldOptions& options, const Progress& progress)
{
  Validate(options);
  this->Impl = std::make_unique<Internals>(std::move(mesh), topology, options, progress);
}

MaternField::~MaternField() = default;
MaternField::MaternField(MaternField&&) noexcept = default;
MaternField& MaternField::operator=(MaternField&&) noexcept = default;

void MaternField::SampleInto(
  const SampleRequest& request, const Destination& destination, const Progress& progress) const
{
  if (request.NumberOfComponents < 1)
  {
    throw InvalidInput("MaternField: 0 components asked for; expected at least 1.");
  }
  if (request.FirstSample + std::uint64_t(request.NumberOfSamples) * request.SampleStep > 0x100000000ULL)
  {
    throw InvalidInput("MaternField: samples beyond number 4294967295 asked for.");
  }
  std::vector<Column> columns;
  for (std::uint32_t k = 0; k < request.NumberOfSamples; ++k)
  {
    const std::uint32_t sample = request.FirstSample + k * request.SampleStep;
    double* values = destination(sample);
    for (std::uint32_t component = 0; component < request.NumberOfComponents; ++component)
    {
      columns.push_back({ sample, component, values + component });
    }
  }
  // Blocks of equal size, at least one for each thread, over each of which the factor is read once.
  const auto count = static_cast<std::int64_t>(columns.size());
  const std::int64_t fewest = (count + CholeskySolver::BlockColumns - 1) / CholeskySolver::BlockColumns;
  const std::int64_t granules = (count + CholeskySolver::ColumnGranularity - 1) / CholeskySolver::ColumnGranularity;
  const std::int64_t threads = MaximumThreads();
  const std::int64_t blocks = std::min((fewest + threads - 1) / threads * threads, granules);
  const auto firstOf = [&](std::int64_t block)
  { return std::min(count, granules * block / std::max<std::int64_t>(blocks, 1) * CholeskySolver::ColumnGranularity); };

  this->Impl->ForgetResidual();
  // Large arrays are made once for each thread: the system hands out fresh pages slowly.
  ScratchPool<LargeArray<double>> scratch;
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(blocks,
    [&](std::int64_t k)
    {
      Progress blockProgress;
      if (progress && std::this_thread::get_id() == caller)
      {
        blockProgress = [&](double fraction)
        { return progress((static_cast<double>(done) + fraction) / static_cast<double>(blocks)); };
      }
      LargeArray<double> memory = scratch.Borrow();
      this->Impl->SampleColumns(
        request, { columns.begin() + firstOf(k), columns.begin() + firstOf(k + 1) }, memory, blockProgress);
      scratch.Return(std::move(memory));
      ++done;
    });
  Report(progress, 1.0);
}

void MaternField::Sample(const SampleRequest& request, const Consumer& consume, const Progress& progress) const
{
  const std::int64_t components = std::max<std::int64_t>(request.NumberOfComponents, 1);
  const std::int64_t samples = request.NumberOfSamples;
  const std::int64_t together = std::clamp<std::int64_t>(
    CholeskySolver::BlockColumns * MaximumThreads() / components, 1, std::max<std::int64_t>(samples, 1));
  const Eigen::Index points = this->Impl->Mesh.Points.rows();
  LargeArray<double> group(static_cast<std::size_t>(points * together * components));
  for (std::int64_t begin = 0; begin < samples; begin += together)
  {
    SampleRequest part = request;
    part.FirstSample = request.FirstSample + static_cast<std::uint32_t>(begin) * request.SampleStep;
    part.NumberOfSamples = static_cast<std::uint32_t>(std::min(together, samples - begin));
    double* next = group.data();
    this->SampleInto(
      part, [&](std::uint32_t) { return std::exchange(next, next + points * components); },
      SubProgress(progress, static_cast<double>(begin) / static_cast<double>(samples),
        static_cast<double>(begin + part.NumberOfSamples) / static_cast<double>(samples)));
    for (std::uint32_t k = 0; k < part.NumberOfSamples; ++k)
    {
      const double* values = group.data() + std::int64_t(k) * points * components;
      consume(part.FirstSample + k * request.SampleStep,
        Eigen::MatrixXd(Eigen::Map<const RowMatrix>(values, points, components)));
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

double MaternField::EffectiveScreening() const
{
  return this->Impl->Tau;
}

double MaternField::EffectiveCorrelationRange() const
{
  return this->Impl->Tau > 0.0 ? std::sqrt(8.0 / this->Impl->Tau) : 0.0;
}

double MaternField::Gamma() const
{
  return this->Impl->Gamma;
}

double MaternField::RelativeResidual() const
{
  return this->Impl->WorstResidual();
}

double MaternField::LongestEdge() const
{
  return this->Impl->LongestEdge;
}

const TriangleMesh& MaternField::Mesh() const
{
  return this->Impl->Mesh;
}

} // namespace surfsynth
