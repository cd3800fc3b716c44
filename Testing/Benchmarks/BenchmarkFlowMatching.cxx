// SPDX-License-Identifier: BSD-3-Clause
// Samples of a flow matching model, beside the evaluations of the network that they need.
#include "BenchmarkMeshes.h"
#include "RandomPoissonNet.h"

#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <chrono>
#include <memory>

namespace surfsynth::bench
{
namespace
{

/// The deformer of appendix B.1 with random weights, and the time and position as condition.
std::shared_ptr<const FlowMatchingModel> Deformer(const TriangleMesh& mesh)
{
  PoissonNetOptions options;
  options.ExtraFeatures = FlowMatchingModel::PlainConditions;
  options.ModulateHead = true;
  auto model = std::make_shared<FlowMatchingModel>();
  model->Velocity = test::RandomModel(options);
  model->SignalMean = Eigen::RowVectorXd::Zero(3);
  model->SignalScale = Eigen::RowVectorXd::Ones(3);
  model->Shape.Mean = SecondMoments(Normalized(mesh, FlowNormalization(mesh)));
  return model;
}

/// Construction of a sampler: operators, factors of the Poisson equation and of the noise.
void FlowMatchingSetUp(benchmark::State& state, const TriangleMesh& mesh)
{
  const auto model = Deformer(mesh);
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(FlowMatchingSampler(model, mesh).Warnings().size());
  }
}

/// One sample, noise included, of two midpoint steps. OverEvaluations is its time over that of as many evaluations of
/// the network by PoissonNetEvaluator on the same mesh, measured right after it.
void FlowMatchingSample(benchmark::State& state, const TriangleMesh& mesh)
{
  using Clock = std::chrono::steady_clock;
  const auto model = Deformer(mesh);
  PeakMemory memory;
  memory.Restart();
  const FlowMatchingSampler sampler(model, mesh);
  FlowSampleRequest request;
  request.Steps = 2;
  const int evaluations = request.Steps * EvaluationsPerStep(request.Integrator);
  std::chrono::duration<double> sampling(0.0);
  for ([[maybe_unused]] auto step : state)
  {
    const auto start = Clock::now();
    benchmark::DoNotOptimize(sampler.Integrate(sampler.InitialNoise(request), request).data());
    sampling += Clock::now() - start;
    ++request.Sample;
  }
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();

  const TriangleMesh normalized = Normalized(mesh, FlowNormalization(mesh));
  const PoissonNetEvaluator evaluator(std::shared_ptr<const PoissonNetModel>(model, &model->Velocity), normalized);
  PoissonNetInput input;
  input.Extra = FeatureMatrix::Constant(mesh.NumberOfPoints(), FlowMatchingModel::PlainConditions, 0.5F);
  benchmark::DoNotOptimize(evaluator.Evaluate(input).Values.data()); // the first one touches fresh memory
  const auto start = Clock::now();
  for (benchmark::IterationCount k = 0; k < state.iterations(); ++k)
  {
    for (int e = 0; e < evaluations; ++e)
    {
      benchmark::DoNotOptimize(evaluator.Evaluate(input).Values.data());
    }
  }
  const std::chrono::duration<double> plain = Clock::now() - start;
  state.counters["OverEvaluations"] = sampling.count() / plain.count();
}

} // namespace

void RegisterFlowMatching()
{
  Register("FlowMatchingSetUp", FlowMatchingSetUp);
  Register("FlowMatchingSample", FlowMatchingSample);
}

} // namespace surfsynth::bench
