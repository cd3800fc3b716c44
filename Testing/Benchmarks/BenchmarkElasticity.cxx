// SPDX-License-Identifier: BSD-3-Clause
//
// Soft bodies: whole drops to their rest states, a shape that settles, and a solve of Newton's method beside Eigen's on the same matrix.
#include "BenchmarkMeshes.h"
#include "ExampleVolumes.h"

#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/ElasticSettling.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Solvers/RepeatedCholesky.h"

#include <Eigen/SparseCholesky>

#include <benchmark/benchmark.h>

#include <vector>

namespace
{
using namespace surfsynth;

/// A block of 10 x 6 x 6 cells of six tetrahedra, half a meter from corner to corner: 539 nodes, 2,160 tetrahedra.
TetrahedralMesh Block()
{
  const Eigen::Vector3d cells(10.0, 6.0, 6.0);
  return test::BoxOfTetrahedra({ 10, 6, 6 }, 0.5 * cells.normalized());
}

/// The matrix of a time step of 0.04 s at rest.
NodeMatrix StepMatrix(const ElasticBody& body)
{
  NodeMatrix matrix(body.Mesh(), {});
  body.AddStiffness(body.Mesh().Points, matrix);
  for (Index v = 0; v < body.Mesh().NumberOfPoints(); ++v)
  {
    matrix.Add(v, v, body.Masses()[v] / (0.04 * 0.04) * Eigen::Matrix3d::Identity());
  }
  return matrix;
}

void Drop(benchmark::State& state)
{
  const ElasticDrops drops(Block(), {});
  NormalKey key;
  double iterations = 0.0;
  for (auto _ : state)
  {
    iterations += drops.Drop(key).NumberOfIterations;
    ++key.Sample;
  }
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

/// Next to a rest state after a drop, as drawn into it from the undeformed block.
void Settle(benchmark::State& state)
{
  const TetrahedralMesh block = Block();
  const PointMatrix shape = ElasticDrops(block, {}).Drop({}).Points;
  std::vector<VolumePlace> places(static_cast<std::size_t>(block.NumberOfPoints()));
  for (Index t = 0; t < block.NumberOfTetrahedra(); ++t)
  {
    for (int corner = 0; corner < 4; ++corner)
    {
      places[static_cast<std::size_t>(block.Tetrahedra(t, corner))] = { t, Eigen::Vector4d::Unit(corner) };
    }
  }
  const ElasticSettling settling(
    block, places, PointMatrix::Zero(shape.rows(), 3), Eigen::VectorXd::Ones(shape.rows()), {});
  double iterations = 0.0;
  for (auto _ : state)
  {
    iterations += settling.Settle(shape).NumberOfIterations;
  }
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

void Stiffness(benchmark::State& state)
{
  const ElasticBody body(Block(), {});
  NodeMatrix matrix(body.Mesh(), {});
  for (auto _ : state)
  {
    matrix.SetZero();
    body.AddStiffness(body.Mesh().Points, matrix);
    benchmark::ClobberMemory();
  }
}

void Solve(benchmark::State& state)
{
  const ElasticBody body(Block(), {});
  const NodeMatrix matrix = StepMatrix(body);
  RepeatedCholesky solver(matrix.Matrix());
  const Eigen::VectorXd rightHandSide = Eigen::VectorXd::Ones(matrix.Matrix().rows());
  for (auto _ : state)
  {
    benchmark::DoNotOptimize(solver.Solve(matrix.Matrix(), rightHandSide));
  }
}

void PlainSolve(benchmark::State& state)
{
  const ElasticBody body(Block(), {});
  const NodeMatrix matrix = StepMatrix(body);
  Eigen::SimplicialLLT<SparseMatrix> solver;
  solver.analyzePattern(matrix.Matrix());
  const Eigen::VectorXd rightHandSide = Eigen::VectorXd::Ones(matrix.Matrix().rows());
  for (auto _ : state)
  {
    solver.factorize(matrix.Matrix());
    benchmark::DoNotOptimize(solver.solve(rightHandSide).eval());
  }
}

} // namespace

namespace surfsynth::bench
{
void RegisterElasticity()
{
  const auto add = [](const char* name, void (*body)(benchmark::State&)) {
    benchmark::RegisterBenchmark(name, body)->Unit(benchmark::kMillisecond);
  };
  add("ElasticDrop", Drop);
  add("ElasticSettle", Settle);
  add("ElasticStiffness", Stiffness);
  add("ElasticSolve", Solve);
  add("ReferenceElasticSolve", PlainSolve);
}
} // namespace surfsynth::bench
