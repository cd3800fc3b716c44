// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Meshes, threads and memory of the benchmarks.
#pragma once

#include "Core/Common/Parallel.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <benchmark/benchmark.h>

#include <functional>
#include <string>
#include <vector>

namespace surfsynth::bench
{

/// Vertex counts to measure: 10,000, 104,000 and 603,000, or those of the environment variable
/// SURFACE_SYNTHESIS_BENCHMARK_SIZES ("1000,5000"); @p otherwise replaces the former.
std::vector<Index> Sizes(const std::string& otherwise = "10000,104000,603000");

/// The scanned surface (a generated one when there is none) decimated or refined to about @p points points; kept.
const TriangleMesh& MeshOfSize(Index points);

/// L + tau M of MeshOfSize() for the default correlation range, 0.2 times the longest side.
SparseMatrix ScreenedLaplacian(const TriangleMesh& mesh);

/// L + tau M of a cube of tetrahedra with at most @p points points, inner ones moved at random; tau is 100 over the volume.
SparseMatrix ScreenedVolume(Index points);

/// Limits the library and OpenBLAS to @p threads threads while the object lives.
class Threads
{
public:
  explicit Threads(int threads);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

private:
  ThreadScope Scope;
  int BlasBefore = 0;
};

/// Peak resident memory since Restart(), MiB. Zero on systems without this number.
class PeakMemory
{
public:
  void Restart();
  double PeakMiB() const;       ///< of the whole process
  double AboveStartMiB() const; ///< beyond what was resident at Restart()

private:
  double Start = 0.0;
};

using Body = std::function<void(benchmark::State&, const TriangleMesh&)>;
/// Registers @p body for every size, and for one thread and two.
void Register(const std::string& name, const Body& body, const std::vector<Index>& sizes = Sizes());
using MatrixBody = std::function<void(benchmark::State&, const SparseMatrix&)>;
/// Registers @p body for ScreenedVolume() of every size, for one thread and two.
void RegisterVolume(
  const std::string& name, const MatrixBody& body, const std::vector<Index>& sizes = Sizes("33000,125000"));

#ifdef SURFACE_SYNTHESIS_CHOLMOD
/// Speed of sgemm on tiles of 512 x 128 by 128 x 128, operations per second.
double MeasuredProductRate();
#endif

void RegisterCore();
void RegisterElasticity();
void RegisterStatistics();
void RegisterReferences();
void RegisterPoissonNet();
void RegisterFlowMatching();
void RegisterGeometricTexture();
void RegisterTextures();
void RegisterFieldLatents();

} // namespace surfsynth::bench
