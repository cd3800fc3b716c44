// SPDX-License-Identifier: BSD-3-Clause
#include "BenchmarkMeshes.h"

#include "ExampleMeshes.h"
#include "ScreenedMatrices.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#ifdef SURFACE_SYNTHESIS_CHOLMOD
extern "C" void sgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
  const float* alpha, const float* a, const int* lda, const float* b, const int* ldb, const float* beta, float* c,
  const int* ldc);
#endif

extern "C" {
// Present when the BLAS in use is OpenBLAS.
__attribute__((weak)) void openblas_set_num_threads(int threads);
__attribute__((weak)) int openblas_get_num_threads();
}

namespace surfsynth::bench
{
namespace
{

/// A field of /proc/self/status in MiB; 0 when there is none.
double StatusMiB(const std::string& field)
{
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
  {
    if (line.rfind(field + ":", 0) == 0)
    {
      return std::strtod(line.c_str() + field.size() + 1, nullptr) / 1024.0;
    }
  }
  return 0.0;
}

} // namespace

std::vector<Index> Sizes(const std::string& otherwise)
{
  const char* text = std::getenv("SURFACE_SYNTHESIS_BENCHMARK_SIZES");
  std::istringstream list(text != nullptr ? text : otherwise);
  std::vector<Index> sizes;
  for (std::string item; std::getline(list, item, ',');)
  {
    sizes.push_back(static_cast<Index>(std::strtol(item.c_str(), nullptr, 10)));
  }
  return sizes;
}

const TriangleMesh& MeshOfSize(Index points)
{
  static std::map<Index, TriangleMesh> kept;
  const auto found = kept.find(points);
  if (found != kept.end())
  {
    return found->second;
  }
  TriangleMesh mesh = test::ScannedSurface();
  while (std::int64_t(mesh.NumberOfPoints()) * 4 < points)
  {
    mesh = test::Subdivide(mesh);
  }
  mesh = mesh.NumberOfPoints() > points ? test::Decimate(mesh, points) : test::RefineToSize(mesh, points);
  return kept.emplace(points, std::move(mesh)).first->second;
}

SparseMatrix ScreenedLaplacian(const TriangleMesh& mesh)
{
  const double range = 0.2 * ComputeBoundingBox(mesh).LongestSide();
  SparseMatrix diagonal(mesh.NumberOfPoints(), mesh.NumberOfPoints());
  diagonal = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>(
    (8.0 / (range * range) * LumpedMass(mesh)).asDiagonal());
  return CotangentStiffness(mesh) + diagonal;
}

Threads::Threads(int threads)
  : Scope(threads)
{
  if (openblas_set_num_threads != nullptr && openblas_get_num_threads != nullptr)
  {
    this->BlasBefore = openblas_get_num_threads();
    openblas_set_num_threads(threads);
  }
}

Threads::~Threads()
{
  if (this->BlasBefore > 0)
  {
    openblas_set_num_threads(this->BlasBefore);
  }
}

void PeakMemory::Restart()
{
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  std::ofstream("/proc/self/clear_refs") << "5"; // resets the peak to what is resident now
  this->Start = StatusMiB("VmRSS");
}

double PeakMemory::PeakMiB() const { return StatusMiB("VmHWM"); }

double PeakMemory::AboveStartMiB() const { return this->PeakMiB() - this->Start; }

SparseMatrix ScreenedVolume(Index points)
{
  const int cells = static_cast<int>(std::cbrt(static_cast<double>(points) + 0.5)) - 1;
  return test::ScreenedCube(std::max(cells, 1)).Matrix;
}

namespace
{
/// Registers @p run for every size, and for one thread and two.
void RegisterSizes(
  const std::string& name, const std::vector<Index>& sizes, const std::function<void(benchmark::State&, Index)>& run)
{
  for (const int threads : { 1, 2 })
  {
    for (const Index points : sizes)
    {
      const std::string full = name + "/vertices:" + std::to_string(points) + "/threads:" + std::to_string(threads);
      benchmark::RegisterBenchmark(full.c_str(),
        [run, points, threads](benchmark::State& state) {
          const Threads limit(threads);
          run(state, points);
        })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
    }
  }
}
} // namespace

void Register(const std::string& name, const Body& body, const std::vector<Index>& sizes)
{
  RegisterSizes(name, sizes, [body](benchmark::State& state, Index points) { body(state, MeshOfSize(points)); });
}

void RegisterVolume(const std::string& name, const MatrixBody& body, const std::vector<Index>& sizes)
{
  RegisterSizes(name, sizes, [body](benchmark::State& state, Index points) { body(state, ScreenedVolume(points)); });
}

#ifdef SURFACE_SYNTHESIS_CHOLMOD
double MeasuredProductRate()
{
  const int rows = 512;
  const int width = 128;
  const std::vector<float> a(static_cast<std::size_t>(rows * width), 1.0F);
  const std::vector<float> b(static_cast<std::size_t>(width * width), 0.5F);
  std::vector<float> c(a.size());
  const float one = 1.0F;
  const float zero = 0.0F;
  double best = 0.0;
  for (int trial = 0; trial < 5; ++trial)
  {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < 200; ++k)
    {
      sgemm_("N", "N", &width, &rows, &width, &one, b.data(), &width, a.data(), &width, &zero, c.data(), &width);
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    best = std::max(best, 200.0 * 2.0 * rows * width * width / seconds.count());
  }
  return best;
}
#endif

} // namespace surfsynth::bench

/// Options beyond Google Benchmark's: --write-mesh=<vertices>:<file.off> writes a mesh of the benchmarks and ends.
int main(int argc, char** argv)
{
  using namespace surfsynth;
  benchmark::Initialize(&argc, argv);
  for (int i = 1; i < argc; ++i)
  {
    const std::string argument = argv[i];
    const std::string option = "--write-mesh=";
    const std::size_t colon = argument.find(':');
    if (argument.rfind(option, 0) == 0 && colon != std::string::npos)
    {
      const auto points = static_cast<Index>(std::strtol(argument.c_str() + option.size(), nullptr, 10));
      test::WriteOff(bench::MeshOfSize(points), argument.substr(colon + 1));
      return EXIT_SUCCESS;
    }
  }
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
  {
    return EXIT_FAILURE;
  }
  bench::RegisterCore();
  bench::RegisterElasticity();
  bench::RegisterStatistics();
  bench::RegisterReferences();
  bench::RegisterPoissonNet();
  bench::RegisterFlowMatching();
  bench::RegisterGeometricTexture();
  bench::RegisterTextures();
  bench::RegisterFieldLatents();
  benchmark::AddCustomContext("surface", test::HasArmadillo() ? "armadillo" : "generated");
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return EXIT_SUCCESS;
}
