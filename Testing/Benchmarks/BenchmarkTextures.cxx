// SPDX-License-Identifier: BSD-3-Clause
// Tangent spaces of vertices, and atlases: from a mesh in memory to the numbers that field latents take.
#include "BenchmarkMeshes.h"
#include "ExampleMeshes.h"

#include "Core/Atlas/AtlasRaster.h"
#include "Core/Atlas/DisplacementMap.h"
#include "Core/Atlas/TextureSampling.h"
#include "Core/Tangent/OneRings.h"
#include "Core/Tangent/RingSamples.h"
#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Atlas/SurfaceAtlas.h"
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace surfsynth::bench
{
namespace
{

/// Texels along a side of the atlas; fewer in a run on a tiny mesh.
int AtlasSize(const TriangleMesh& mesh) { return mesh.NumberOfPoints() < 5000 ? 128 : 2048; }
/// Places of a look-up.
std::int64_t NumberOfPlaces(const TriangleMesh& mesh) { return mesh.NumberOfPoints() < 5000 ? 1000 : 1000000; }

double SecondsOf(const std::function<void()>& work)
{
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Runs @p work in the steps of @p state, and counts its mean time over the least of three runs of @p reference.
void Compare(benchmark::State& state, const std::string& name, const std::function<void()>& work,
  const std::function<void()>& reference)
{
  double least = SecondsOf(reference);
  least = std::min(least, SecondsOf(reference));
  least = std::min(least, SecondsOf(reference));
  double total = 0.0;
  for ([[maybe_unused]] auto step : state)
  {
    total += SecondsOf(work);
  }
  state.counters[name] = total / static_cast<double>(state.iterations()) / least;
}

void CountPerSecond(benchmark::State& state, const std::string& name, double number)
{
  state.counters[name] = benchmark::Counter(number, benchmark::Counter::kIsIterationInvariantRate);
}

std::vector<SurfacePlace> RandomPlaces(const TriangleMesh& mesh)
{
  std::vector<SurfacePlace> places(static_cast<std::size_t>(NumberOfPlaces(mesh)));
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    const double u = 0.5 + 0.5 * test::Uniform(1, k);
    const double v = (1.0 - u) * (0.5 + 0.5 * test::Uniform(2, k));
    // Texels come in the order of charts: places beside each other lie in near triangles.
    const auto triangle = static_cast<Index>(k * static_cast<std::size_t>(mesh.NumberOfTriangles()) / places.size());
    places[k] = { triangle, Eigen::Vector3d(u, v, 1.0 - u - v) };
  }
  return places;
}

/// An atlas of one chart with about as many vertices as @p mesh.
TextureCoordinates ChartOfSize(const TriangleMesh& mesh)
{
  const int side = static_cast<int>(std::sqrt(static_cast<double>(mesh.NumberOfPoints())));
  TriangleMesh plane = test::PlanePatch(side, side, 0.9, 0.9, 0.2);
  plane.Points.array() += 0.05;
  TextureCoordinates coordinates(3 * plane.Triangles.rows(), 2);
  for (Eigen::Index c = 0; c < coordinates.rows(); ++c)
  {
    coordinates.row(c) = plane.Points.row(plane.Triangles(c / 3, c % 3)).head<2>();
  }
  return coordinates;
}

void BuildOneRings(benchmark::State& state, const TriangleMesh& mesh)
{
  const MeshTopology topology(mesh);
  const VertexFrames frames = TangentFrames(mesh, topology);
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(OneRings(mesh, topology, frames).Transport.data());
  }
  CountPerSecond(state, "Vertices", mesh.NumberOfPoints());
}

void SampleRings(benchmark::State& state, const TriangleMesh& mesh)
{
  const OneRings rings(mesh);
  std::int64_t samples = 0;
  for ([[maybe_unused]] auto step : state)
  {
    samples = 0;
    for (Index first = 0; first < mesh.NumberOfPoints(); first += 4096)
    {
      std::vector<Index> vertices(static_cast<std::size_t>(std::min<Index>(4096, mesh.NumberOfPoints() - first)));
      std::iota(vertices.begin(), vertices.end(), first);
      samples += SampleRingsUniformly(rings, vertices).Offsets.back();
    }
  }
  CountPerSecond(state, "Samples", static_cast<double>(samples));
}

void Logarithms(benchmark::State& state, const TriangleMesh& mesh)
{
  const OneRings rings(mesh);
  const std::vector<SurfacePlace> places = RandomPlaces(mesh);
  const auto count = static_cast<std::int64_t>(places.size());
  std::vector<std::complex<double>> logs(3 * places.size());
  const auto plain = [&] {
    ParallelFor(count, 1024, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t q = begin; q < end; ++q)
      {
        for (int k = 0; k < 3; ++k)
        {
          const double angle = std::atan2(places[q].Weights[k], places[q].Weights[(k + 1) % 3]);
          logs[3 * q + k] = { std::cos(angle), std::sin(angle) };
        }
      }
    });
    benchmark::ClobberMemory();
  };
  Compare(
    state, "OverPlainLoop", [&] { rings.CornerLogarithms(places.data(), count, logs.data()); }, plain);
  CountPerSecond(state, "Places", static_cast<double>(count));
}

void Rasterize(benchmark::State& state, const TriangleMesh& mesh)
{
  const TextureCoordinates coordinates = ChartOfSize(mesh);
  AtlasRasterOptions options;
  options.Width = options.Height = AtlasSize(mesh);
  const std::int64_t texels = std::int64_t(options.Width) * options.Height;
  const auto fill = [&] {
    std::vector<SurfacePlace> places(static_cast<std::size_t>(texels));
    const SurfacePlace place{ 1, Eigen::Vector3d(0.5, 0.25, 0.25) };
    ParallelFor(texels, 1 << 14,
      [&](std::int64_t begin, std::int64_t end) { std::fill(places.begin() + begin, places.begin() + end, place); });
    benchmark::DoNotOptimize(places.data());
  };
  Compare(
    state, "OverPlainFill", [&] { benchmark::DoNotOptimize(RasterizeAtlas(coordinates, options).Places.data()); },
    fill);
  CountPerSecond(state, "Texels", static_cast<double>(texels));
}

void LookUp(benchmark::State& state, const TriangleMesh& mesh)
{
  const TextureCoordinates coordinates = ChartOfSize(mesh);
  std::vector<SurfacePlace> places = RandomPlaces(mesh);
  for (SurfacePlace& place : places)
  {
    place.Triangle = static_cast<Index>(place.Triangle % (coordinates.rows() / 3));
  }
  const int size = AtlasSize(mesh);
  const std::vector<float> image(3 * static_cast<std::size_t>(size) * size, 0.5F);
  const auto count = static_cast<std::int64_t>(places.size());
  std::vector<float> colors(3 * places.size());
  const auto gather = [&] {
    ParallelFor(count, 1024, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t q = begin; q < end; ++q)
      {
        for (std::uint64_t k = 0; k < 4; ++k)
        {
          const std::size_t texel = test::Mix(k, static_cast<std::uint64_t>(q)) % (image.size() / 3);
          colors[3 * q] += image[3 * texel];
          colors[3 * q + 1] += image[3 * texel + 1];
          colors[3 * q + 2] += image[3 * texel + 2];
        }
      }
    });
    benchmark::ClobberMemory();
  };
  const TextureView view{ image.data(), size, size, 3 };
  Compare(
    state, "OverPlainGather",
    [&] { SampleTexture(view, TextureWrap::Clamp, coordinates, places.data(), count, colors.data()); }, gather);
  CountPerSecond(state, "Places", static_cast<double>(count));
}

/// Heights along normals and displacements by index of a subdivision of a plane with a relief.
void DisplacementMaps(benchmark::State& state, const TriangleMesh& mesh)
{
  const int side = static_cast<int>(std::sqrt(static_cast<double>(mesh.NumberOfPoints()) / 16.0));
  const TriangleMesh plain = test::PlanePatch(side, side);
  TextureCoordinates coordinates(3 * plain.Triangles.rows(), 2);
  for (Eigen::Index c = 0; c < coordinates.rows(); ++c)
  {
    coordinates.row(c) = plain.Points.row(plain.Triangles(c / 3, c % 3)).head<2>();
  }
  TriangleMesh detailed = test::Subdivide(test::Subdivide(plain));
  for (Eigen::Index p = 0; p < detailed.Points.rows(); ++p)
  {
    detailed.Points(p, 2) = 0.02 * std::sin(40.0 * detailed.Points(p, 0)) * std::sin(40.0 * detailed.Points(p, 1));
  }
  DisplacementMapOptions options;
  options.Raster.Width = options.Raster.Height = AtlasSize(mesh) / 2;
  for ([[maybe_unused]] auto step : state)
  {
    benchmark::DoNotOptimize(BakeDisplacementMap(plain, coordinates, detailed, options).Heights.data());
  }
  CountPerSecond(state, "Texels", static_cast<double>(options.Raster.Width) * options.Raster.Height);
}

#ifdef SURFACE_SYNTHESIS_CGAL
void MakeAtlas(benchmark::State& state, const TriangleMesh& mesh)
{
  SurfaceAtlas atlas;
  for ([[maybe_unused]] auto step : state)
  {
    atlas = MakeSurfaceAtlas(mesh);
  }
  state.counters["Charts"] = atlas.NumberOfCharts;
  state.counters["Coverage"] = atlas.Coverage;
  CountPerSecond(state, "Triangles", mesh.NumberOfTriangles());
}
#endif

} // namespace

void RegisterTextures()
{
  Register("OneRings", BuildOneRings);
  Register("RingSamples", SampleRings);
  Register("CornerLogarithms", Logarithms);
  Register("AtlasRaster", Rasterize);
  Register("TextureLookUp", LookUp);
  Register("DisplacementMap", DisplacementMaps);
#ifdef SURFACE_SYNTHESIS_CGAL
  Register("SurfaceAtlas", MakeAtlas, Sizes("10000,26000"));
#endif
}

} // namespace surfsynth::bench
