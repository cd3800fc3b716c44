// SPDX-License-Identifier: BSD-3-Clause
// Geometric textures: from a coarse mesh through three levels, by a model and from an example.
#include "BenchmarkMeshes.h"
#include "ExampleMeshes.h"
#include "RandomGeometricTexture.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/ExampleSynthesis.h"
#include "Inference/GeometricTexture/FaceNetwork.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Inference/GeometricTexture/NearestPatches.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

namespace surfsynth::bench
{
namespace
{

std::shared_ptr<const GeometricTextureModel> PublishedGeometricTexture()
{
  GeometricTextureOptions options;
  options.Levels = 3;
  return std::make_shared<const GeometricTextureModel>(test::RandomGeometricTexture(options));
}

/// Floating-point operations of the networks of all levels as their equations stand: for each triangle and each of its
/// three neighbours one affine map of [neighbour, self], two operations for each weight.
double StraightforwardOperations(const GeometricTextureOptions& options, const TriangleMesh& mesh)
{
  double operations = 0.0;
  double triangles = mesh.NumberOfTriangles();
  for (std::int64_t level = 0; level < options.Levels; ++level, triangles *= 4.0)
  {
    const GeometricTextureChannels channels = options.GeneratorChannels(level);
    for (std::size_t j = 0; j + 1 < channels.size(); ++j)
    {
      operations += triangles * 3.0 * 2.0 *
        static_cast<double>((j == 0 ? channels[j] : 2 * channels[j]) * channels[j + 1]);
    }
  }
  return operations;
}

/// The rate of the straightforward operations, and that over what sgemm reaches on one thread in the same run.
void CountOperations(benchmark::State& state, const TriangleMesh& mesh, double seconds)
{
  const double operations = StraightforwardOperations(PublishedGeometricTexture()->Options, mesh);
  const double rate = operations * static_cast<double>(state.iterations()) / seconds;
  state.counters["GFLOP"] = 1e-9 * operations;
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  const Threads single(1);
  state.counters["OfProductRate"] = rate / MeasuredProductRate();
#endif
}

/// Three levels, everything included.
void GeometricTexture(benchmark::State& state, const TriangleMesh& mesh)
{
  const GeometricTextureSampler sampler(PublishedGeometricTexture());
  PeakMemory memory;
  memory.Restart();
  Index triangles = 0;
  const auto start = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    triangles = sampler.Synthesize(mesh, {}).Mesh.NumberOfTriangles();
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  state.counters["TrianglesOut"] = triangles;
  state.counters["NanosecondsPerTriangle"] = 1e9 * seconds.count() /
    (static_cast<double>(state.iterations()) * triangles);
  state.counters["PeakMiB"] = memory.PeakMiB();
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
  CountOperations(state, mesh, seconds.count());
}

/// The networks of the three levels on what they see, which is there.
void GeometricTextureNetwork(benchmark::State& state, const TriangleMesh& mesh)
{
  struct Level
  {
    FaceNetwork Network;
    EdgeFeatureMatrix Features;
    TriangleMatrix Neighbors;
  };
  const std::shared_ptr<const GeometricTextureModel> model = PublishedGeometricTexture();
  std::vector<Level> levels;
  TriangleMesh fine = mesh;
  for (std::int64_t level = 0; level < model->Options.Levels; ++level)
  {
    if (level > 0)
    {
      fine = SubdivideAtMidpoints(fine).Mesh;
    }
    const FaceNeighbors neighbors = ComputeFaceNeighbors(fine);
    levels.push_back({ FaceNetwork(model->Generator, level, model->Options.Layers),
      ComputeEdgeFeatures(fine.Points.cast<float>(), fine.Triangles, neighbors), neighbors.Faces });
  }
  const SingleThreadedBlas blas;
  const auto start = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    for (const Level& level : levels)
    {
      benchmark::DoNotOptimize(level.Network.Run(level.Features, level.Neighbors).data());
    }
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  CountOperations(state, mesh, seconds.count());
}

/// Work beside the network: two subdivisions, and tables and features of the three meshes.
void GeometricTextureTables(benchmark::State& state, const TriangleMesh& mesh)
{
  for ([[maybe_unused]] auto step : state)
  {
    TriangleMesh fine = mesh;
    for (int level = 0; level < 3; ++level)
    {
      if (level > 0)
      {
        fine = SubdivideAtMidpoints(fine).Mesh;
      }
      const FaceNeighbors neighbors = ComputeFaceNeighbors(fine);
      benchmark::DoNotOptimize(ComputeEdgeFeatures(fine.Points.cast<float>(), fine.Triangles, neighbors).data());
    }
  }
}

/// A ball of 20,480 triangles with waves, as an example of three scales.
const GeometricTextureExample& WavesOfBall()
{
  static const GeometricTextureExample example = [] {
    const TriangleMesh plain = test::Icosphere(5);
    TriangleMesh waves = plain;
    for (Index v = 0; v < waves.NumberOfPoints(); ++v)
    {
      const auto x = plain.Points.row(v).array();
      waves.Points.row(v) *= 1.0 + 0.05 * (14.0 * x).sin().prod();
    }
    GeometricTextureExampleOptions options;
    options.Scales = 3;
    return GeometricTextureExample(waves, plain, options);
  }();
  return example;
}

/// A texture from an example on the mesh, divided twice.
void GeometricTextureFromExample(benchmark::State& state, const TriangleMesh& mesh)
{
  const GeometricTextureExample& example = WavesOfBall();
  ExampleSynthesisRequest request;
  request.Subdivisions = 2;
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(SynthesizeFromExample(example, mesh, request).Mismatch);
  }
  state.counters["microsecondsPerTriangle"] = benchmark::Counter(16e-6 * static_cast<double>(mesh.NumberOfTriangles()),
    benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// The search for the nearest of up to 131,072 patches, for as many patches as the mesh has points.
void NearestPatchesOfExample(benchmark::State& state, const TriangleMesh& mesh)
{
  const ExamplePatches& scale = WavesOfBall().Scales().front();
  const Eigen::Index rows = std::min<Eigen::Index>(mesh.NumberOfPoints(), scale.Coordinates.cols());
  const Eigen::Index stride = scale.Coordinates.cols() / rows; // patches are sorted by cluster
  const ExamplePatches::Rows coordinates = scale.Coordinates(Eigen::all, Eigen::seqN(0, rows, stride)).transpose();
  const SingleThreadedBlas blas;
  const NearestPatches search(scale);
  const auto start = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(search.Find(coordinates).data());
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const double pairs = static_cast<double>(coordinates.rows()) * static_cast<double>(scale.Count());
  state.counters["nanosecondsPerPair"] = 1e9 * seconds.count() / (pairs * static_cast<double>(state.iterations()));
}

} // namespace

void RegisterGeometricTexture()
{
  // 9,900 triangles become 158,000, 25,000 become 400,000, and 62,500 a million.
  const std::vector<Index> sizes = Sizes("4952,12502,31252");
  Register("GeometricTexture", GeometricTexture, sizes);
  Register("GeometricTextureNetwork", GeometricTextureNetwork, sizes);
  Register("GeometricTextureTables", GeometricTextureTables, sizes);
  Register("GeometricTextureFromExample", GeometricTextureFromExample, sizes);
  Register("NearestPatchesOfExample", NearestPatchesOfExample, sizes);
}

} // namespace surfsynth::bench
