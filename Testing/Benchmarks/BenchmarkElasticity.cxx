// SPDX-License-Identifier: BSD-3-Clause
//
// Soft bodies: whole drops to their rest states, and a solve of Newton's method beside Eigen's on the same matrix.
#include "BenchmarkMeshes.h"

#include "Core/Elasticity/ElasticBody.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/NodeMatrix.h"
#include "Core/Solvers/RepeatedCholesky.h"

#include <Eigen/SparseCholesky>

#include <benchmark/benchmark.h>

#include <cmath>

namespace
{
using namespace surfsynth;

/// A block of 10 x 6 x 6 cells of six tetrahedra, half a meter from corner to corner: 539 nodes, 2,160 tetrahedra.
TetrahedralMesh Block()
{
  constexpr int X = 10;
  constexpr int Y = 6;
  constexpr int Z = 6;
  const auto id = [](int i, int j, int k) { return static_cast<Index>((k * (Y + 1) + j) * (X + 1) + i); };
  TetrahedralMesh mesh{ PointMatrix((X + 1) * (Y + 1) * (Z + 1), 3), TetrahedronMatrix(X * Y * Z * 6, 4) };
  for (int point = 0; point < mesh.NumberOfPoints(); ++point)
  {
    mesh.Points.row(point) << point % (X + 1), point / (X + 1) % (Y + 1), point / ((X + 1) * (Y + 1));
  }
  mesh.Points *= 0.5 / std::sqrt(X * X + Y * Y + Z * Z);
  const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
  for (int t = 0; t < mesh.NumberOfTetrahedra(); ++t)
  {
    const int cell = t / 6;
    int corner[3] = { cell % X, cell / X % Y, cell / (X * Y) };
    mesh.Tetrahedra(t, 0) = id(corner[0], corner[1], corner[2]);
    for (int step = 0; step < 3; ++step)
    {
      ++corner[orders[t % 6][step]];
      mesh.Tetrahedra(t, step + 1) = id(corner[0], corner[1], corner[2]);
    }
  }
  return mesh;
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
  add("ElasticStiffness", Stiffness);
  add("ElasticSolve", Solve);
  add("ReferenceElasticSolve", PlainSolve);
}
} // namespace surfsynth::bench
