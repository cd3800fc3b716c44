// SPDX-License-Identifier: BSD-3-Clause
// Ensembles compared by the core, and by the expression that one writes down.
#include "BenchmarkMeshes.h"
#include "ExampleMeshes.h"

#include "Core/Statistics/EnsembleMetrics.h"

#include <algorithm>
#include <limits>

namespace surfsynth::bench
{
namespace
{

constexpr int NumberOfSamples = 32; // generated and references together
constexpr double Pairs = NumberOfSamples * (NumberOfSamples - 1) / 2.0;

/// Shapes near that of the mesh.
std::vector<PointMatrix> ShapesOf(const TriangleMesh& mesh)
{
  std::vector<PointMatrix> shapes(NumberOfSamples, mesh.Points);
  for (std::size_t k = 0; k < shapes.size(); ++k)
  {
    for (Eigen::Index i = 0; i < shapes[k].size(); ++i)
    {
      shapes[k].data()[i] += 0.01 * test::Uniform(k, static_cast<std::uint64_t>(i));
    }
  }
  return shapes;
}

/// Counts the points of a pair of samples that were compared in a second.
void CountPoints(benchmark::State& state, const TriangleMesh& mesh)
{
  state.counters["Points"] = benchmark::Counter(
    Pairs * mesh.NumberOfPoints(), benchmark::Counter::kIsIterationInvariantRate);
}

void CompareEnsembles(benchmark::State& state, const TriangleMesh& mesh)
{
  const std::vector<PointMatrix> shapes = ShapesOf(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  EnsemblePair ensembles;
  for (const PointMatrix& shape : shapes)
  {
    (ensembles.Generated.size() < shapes.size() / 2 ? ensembles.Generated : ensembles.Reference)
      .emplace_back(shape.data());
  }
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(ComputeEnsembleMetrics(ensembles, mass).MMD);
  }
  CountPoints(state, mesh);
}

/// The nearest neighbours alone, one pair after the other.
void PlainNeighbors(benchmark::State& state, const TriangleMesh& mesh)
{
  const std::vector<PointMatrix> shapes = ShapesOf(mesh);
  const Eigen::VectorXd mass = LumpedMass(mesh);
  for ([[maybe_unused]] auto step : state)
  {
    std::vector<double> nearest(shapes.size(), std::numeric_limits<double>::infinity());
    for (std::size_t a = 0; a < shapes.size(); ++a)
    {
      for (std::size_t b = a + 1; b < shapes.size(); ++b)
      {
        const double distance = (shapes[a] - shapes[b]).rowwise().norm().dot(mass) / mass.sum();
        nearest[a] = std::min(nearest[a], distance);
        nearest[b] = std::min(nearest[b], distance);
      }
    }
    benchmark::DoNotOptimize(nearest.data());
  }
  CountPoints(state, mesh);
}

} // namespace

void RegisterStatistics()
{
  Register("EnsembleMetrics", CompareEnsembles);
  Register("ReferenceEnsembleNeighbors", PlainNeighbors);
}

} // namespace surfsynth::bench
