// SPDX-License-Identifier: BSD-3-Clause
// PoissonNet's evaluation and its Poisson solves.
#include "BenchmarkMeshes.h"
#include "RandomPoissonNet.h"

#include "Core/Solvers/CholeskySolver.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <chrono>
#include <memory>

namespace surfsynth::bench
{
namespace
{

/// The deformer of appendix B.1 with one extra feature and random weights.
std::shared_ptr<const PoissonNetModel> Deformer()
{
  PoissonNetOptions options;
  options.ExtraFeatures = 1;
  options.ModulateHead = true;
  auto model = std::make_shared<PoissonNetModel>(test::RandomModel(options));
  model->Normalization = InputNormalization::SurfaceArea;
  return model;
}

/// Floating-point operations of the network evaluated as its equations stand: every map where it is written, a complex
/// product as four real ones, two operations for each weight. Solves and elementary functions are not counted.
double StraightforwardOperations(const PoissonNetOptions& options, const TriangleMesh& mesh)
{
  const double square = 2.0 * static_cast<double>(options.Width * options.Width);
  const double modulator = 3.0 * square;
  const double complexLayers = 4.0 * static_cast<double>(options.ComplexLayers) * square;
  const double vertexMlp = (2.0 + (options.ExtraFeatures > 0 ? 1.0 : 0.0) + 3.0) * square;
  const auto blocks = static_cast<double>(options.Blocks);
  const double head = modulator + 4.0 * static_cast<double>(options.ComplexLayers - 1) * square;
  return mesh.NumberOfTriangles() * (blocks * (modulator + complexLayers) + head) +
    mesh.NumberOfPoints() * blocks * vertexMlp;
}

void PoissonNetSetUp(benchmark::State& state, const TriangleMesh& mesh)
{
  const std::shared_ptr<const PoissonNetModel> model = Deformer();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(PoissonNetEvaluator(model, mesh).Warnings().size());
  }
}

/// One evaluation. OfProductRate is the rate of the straightforward operations over what sgemm reaches on one thread in
/// the same run.
void PoissonNetEvaluation(benchmark::State& state, const TriangleMesh& mesh)
{
  const std::shared_ptr<const PoissonNetModel> model = Deformer();
  const PoissonNetEvaluator evaluator(model, mesh);
  PoissonNetInput input;
  input.Extra = FeatureMatrix::Constant(1, 1, 0.5F);
  PeakMemory memory;
  memory.Restart();
  const auto start = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(evaluator.Evaluate(input).Values.data());
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const double rate = StraightforwardOperations(model->Options, mesh) * static_cast<double>(state.iterations()) /
    seconds.count();
  state.counters["GFLOP"] = 1e-9 * StraightforwardOperations(model->Options, mesh);
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  const Threads single(1);
  state.counters["OfProductRate"] = rate / MeasuredProductRate();
#endif
  state.counters["PeakMiB"] = memory.PeakMiB();
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
}

/// 128 right-hand sides of the Poisson equation, in the solver's order.
void PoissonSolve128(benchmark::State& state, const TriangleMesh& mesh)
{
  SparseMatrix matrix = CotangentStiffness(mesh);
  matrix.diagonal().array() += 1e-6;
  const CholeskySolver solver(matrix);
  RowMatrix sides[4];
  for ([[maybe_unused]] auto step : state)
  {
    state.PauseTiming();
    for (RowMatrix& block : sides)
    {
      block.setOnes(mesh.NumberOfPoints(), CholeskySolver::BlockColumns);
    }
    state.ResumeTiming();
    ParallelTasks(4, [&](std::int64_t k) { solver.SolveOrderedInPlace(sides[k]); });
  }
}

} // namespace

void RegisterPoissonNet()
{
  Register("PoissonNetSetUp", PoissonNetSetUp);
  Register("PoissonNetEvaluation", PoissonNetEvaluation);
  Register("PoissonSolve128", PoissonSolve128);
}

} // namespace surfsynth::bench
