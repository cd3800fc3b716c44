// SPDX-License-Identifier: BSD-3-Clause
// The steps from a mesh in memory to samples of a Matern field.
#include "BenchmarkMeshes.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Noise/MaternField.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/MultigridSolver.h"

#include <algorithm>

namespace surfsynth::bench
{
namespace
{

void MeshCheck(benchmark::State& state, const TriangleMesh& mesh)
{
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(CheckMesh(mesh).size());
  }
}

void Assembly(benchmark::State& state, const TriangleMesh& mesh)
{
  for ([[maybe_unused]] auto step : state)
  {
    const MeshTopology topology(mesh);
    benchmark::DoNotOptimize(LumpedMass(mesh, topology).data());
    benchmark::DoNotOptimize(CotangentStiffness(mesh, topology).valuePtr());
  }
}

void FactorizationOf(benchmark::State& state, const SparseMatrix& matrix)
{
  std::int64_t entries = 0;
  for ([[maybe_unused]] auto step : state)
  {
    entries = CholeskySolver(matrix).FactorEntries();
  }
  state.counters["FactorEntries"] = static_cast<double>(entries);
}

void Factorization(benchmark::State& state, const TriangleMesh& mesh)
{
  FactorizationOf(state, ScreenedLaplacian(mesh));
}

/// Solves for Columns right-hand sides of a volume, in the order of rows.
template <int Columns>
void VolumeSolve(benchmark::State& state, const SparseMatrix& matrix)
{
  const CholeskySolver solver(matrix);
  const RowMatrix sides = RowMatrix::Ones(matrix.rows(), Columns);
  for ([[maybe_unused]] auto step : state)
  {
    RowMatrix solutions = sides;
    solver.SolveInPlace(solutions);
    benchmark::DoNotOptimize(solutions.data());
  }
}

/// Set-up of what stands in for the factor where that is too large.
void MultigridSetUp(benchmark::State& state, const TriangleMesh& mesh)
{
  const SparseMatrix matrix = ScreenedLaplacian(mesh);
  for ([[maybe_unused]] auto step : state)
  {
    const MultigridSolver solver(matrix);
    state.counters["BytesOfVertex"] = static_cast<double>(solver.MemoryInUse()) / solver.Size();
    state.counters["OperatorComplexity"] = solver.OperatorComplexity();
  }
}

/// Solves by conjugate gradients with a multigrid preconditioner, to a relative residual of 1e-10.
template <int Columns>
void MultigridSolve(benchmark::State& state, const TriangleMesh& mesh)
{
  const MultigridSolver solver(ScreenedLaplacian(mesh));
  const Eigen::VectorXd mass = LumpedMass(mesh);
  const RowMatrix sides = mass.cwiseSqrt().asDiagonal() * RowMatrix::Random(mass.size(), Columns);
  for ([[maybe_unused]] auto step : state)
  {
    RowMatrix solutions = sides;
    solver.SolveInPlace(solutions);
    benchmark::DoNotOptimize(solutions.data());
  }
  state.counters["Iterations"] = solver.Iterations();
}

/// Options of the default range, with the operator power @p Halves / 2.
template <int Halves>
MaternFieldOptions OfPower()
{
  MaternFieldOptions options;
  options.OperatorPower = 0.5 * Halves;
  return options;
}

/// From a mesh in memory to the first sample.
template <int Halves>
void ColdStart(benchmark::State& state, const TriangleMesh& mesh)
{
  PeakMemory memory;
  double peak = 0.0;
  double above = 0.0;
  for ([[maybe_unused]] auto step : state)
  {
    state.PauseTiming();
    memory.Restart();
    TriangleMesh own = mesh;
    state.ResumeTiming();
    {
      const MaternField field(std::move(own), OfPower<Halves>());
      benchmark::DoNotOptimize(field.Sample().data());
      state.PauseTiming();
      peak = std::max(peak, memory.PeakMiB());
      above = std::max(above, memory.AboveStartMiB());
    }
    state.ResumeTiming();
  }
  state.counters["PeakMiB"] = peak;
  state.counters["PeakAboveStartMiB"] = above;
}

template <int Halves>
void NextSample(benchmark::State& state, const TriangleMesh& mesh)
{
  const MaternField field(mesh, OfPower<Halves>());
  SampleRequest request;
  for ([[maybe_unused]] auto step : state)
  {
    ++request.Seed;
    benchmark::DoNotOptimize(field.Sample(request).data());
  }
}

void HundredSamples(benchmark::State& state, const TriangleMesh& mesh)
{
  const MaternField field(mesh, {});
  SampleRequest request;
  request.NumberOfSamples = 100;
  for ([[maybe_unused]] auto step : state)
  {
    ++request.Seed;
    field.Sample(request,
      [](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) { benchmark::DoNotOptimize(values.data()); });
  }
}

} // namespace

void RegisterCore()
{
  Register("MeshCheck", MeshCheck);
  Register("Assembly", Assembly);
  Register("Factorization", Factorization);
  RegisterVolume("VolumeFactorization", FactorizationOf);
  RegisterVolume("VolumeSolve100", VolumeSolve<100>);
  Register("MultigridSetUp", MultigridSetUp);
  Register("MultigridSolve1", MultigridSolve<1>);
  Register("MultigridSolve8", MultigridSolve<8>);
  Register("ColdStart", ColdStart<4>);
  Register("NextSample", NextSample<4>);
  Register("FractionalColdStart", ColdStart<5>);
  Register("FractionalNextSample", NextSample<5>);
  Register("HundredSamples", HundredSamples);
}

} // namespace surfsynth::bench
