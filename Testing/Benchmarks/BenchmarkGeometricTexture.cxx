// SPDX-License-Identifier: BSD-3-Clause
// Geometric textures: from a coarse mesh through three levels.
#include "BenchmarkMeshes.h"
#include "RandomTexture.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Learning/Samplers/GeometricTextureSampler.h"

#include <chrono>
#include <memory>

namespace surfsynth::bench
{
namespace
{

std::shared_ptr<const GeometricTextureModel> PublishedTexture()
{
  GeometricTextureOptions options;
  options.Levels = 3;
  return std::make_shared<const GeometricTextureModel>(test::RandomTexture(options));
}

/// Floating-point operations of the networks of all levels as their equations stand: for each triangle and each of its
/// three neighbours one affine map of [neighbour, self], two operations for each weight.
double StraightforwardOperations(const GeometricTextureOptions& options, const TriangleMesh& mesh)
{
  double operations = 0.0;
  double triangles = mesh.NumberOfTriangles();
  for (std::int64_t level = 0; level < options.Levels; ++level, triangles *= 4.0)
  {
    const TextureChannels channels = options.GeneratorChannels(level);
    for (std::size_t j = 0; j + 1 < channels.size(); ++j)
    {
      operations += triangles * 3.0 * 2.0 *
        static_cast<double>((j == 0 ? channels[j] : 2 * channels[j]) * channels[j + 1]);
    }
  }
  return operations;
}

/// Three levels, everything included. OfProductRate is the rate of the straightforward operations over what sgemm
/// reaches on one thread in the same run.
void GeometricTexture(benchmark::State& state, const TriangleMesh& mesh)
{
  const std::shared_ptr<const GeometricTextureModel> model = PublishedTexture();
  const GeometricTextureSampler sampler(model);
  PeakMemory memory;
  memory.Restart();
  Index triangles = 0;
  const auto start = std::chrono::steady_clock::now();
  for ([[maybe_unused]] auto step : state)
  {
    triangles = sampler.Grow(mesh, {}).Mesh.NumberOfTriangles();
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const double operations = StraightforwardOperations(model->Options, mesh);
  const double rate = operations * static_cast<double>(state.iterations()) / seconds.count();
  state.counters["TrianglesOut"] = triangles;
  state.counters["GFLOP"] = 1e-9 * operations;
  state.counters["GFLOPperSecond"] = 1e-9 * rate;
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  const Threads single(1);
  state.counters["OfProductRate"] = rate / MeasuredProductRate();
#endif
  state.counters["PeakMiB"] = memory.PeakMiB();
  state.counters["PeakAboveStartMiB"] = memory.AboveStartMiB();
}

/// What is not the network: two subdivisions, and tables and features of the three meshes.
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
      const FaceNeighbours neighbours = ComputeFaceNeighbours(fine);
      benchmark::DoNotOptimize(ComputeEdgeFeatures(fine.Points.cast<float>(), fine.Triangles, neighbours).data());
    }
  }
}

} // namespace

void RegisterGeometricTexture()
{
  // 9,900 triangles become 158,000, and 62,500 a million.
  const std::vector<Index> sizes = Sizes("4952,31252");
  Register("GeometricTexture", GeometricTexture, sizes);
  Register("GeometricTextureTables", GeometricTextureTables, sizes);
}

} // namespace surfsynth::bench
