// SPDX-License-Identifier: BSD-3-Clause
//
// Volumes to surfaces: vtkVDBSurfaceFilter, and beside it, in the same run, OpenVDB alone on the same samples.
//
// The volumes are a synthetic one of 256^3 samples (SURFACE_SYNTHESIS_BENCHMARK_VOLUME gives another side) and, unless
// that is set, the brain of Debian's mricron-data, 181 x 217 x 181.
#include "vtkVDBSurfaceFilter.h"

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkSmartPointer.h>

#ifdef SURFACE_SYNTHESIS_NIFTI
#include <vtkNIFTIImageReader.h>
#endif

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <benchmark/benchmark.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace
{
struct BenchmarkVolume
{
  std::string Name;
  vtkSmartPointer<vtkImageData> Image;
  double IsoValue;
};

/// Folds at several scales around a ball: a surface as intricate as that of a brain.
vtkSmartPointer<vtkImageData> SyntheticImage(int side)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(side, side, side);
  image->AllocateScalars(VTK_FLOAT, 1);
  auto* values = static_cast<float*>(image->GetScalarPointer());
  const double scale = 2.0 / (side - 1);
  for (int k = 0; k < side; ++k)
  {
    for (int j = 0; j < side; ++j)
    {
      for (int i = 0; i < side; ++i)
      {
        const double x = i * scale - 1.0, y = j * scale - 1.0, z = k * scale - 1.0;
        const double folds = std::sin(24.0 * x) * std::sin(23.0 * y) + std::sin(25.0 * y) * std::sin(22.0 * z);
        *values++ = static_cast<float>(0.75 - std::sqrt(x * x + y * y + z * z) + 0.08 * folds);
      }
    }
  }
  return image;
}

std::vector<BenchmarkVolume> MakeVolumes()
{
  const char* text = std::getenv("SURFACE_SYNTHESIS_BENCHMARK_VOLUME");
  const int side = text ? std::max(std::atoi(text), 8) : 256;
  std::vector<BenchmarkVolume> volumes = { { "synthetic" + std::to_string(side), SyntheticImage(side), 0.0 } };
#ifdef SURFACE_SYNTHESIS_NIFTI
  const char* const brain = "/usr/share/mricron/templates/ch2bet.nii.gz";
  if (!text && std::ifstream(brain))
  {
    vtkNew<vtkNIFTIImageReader> reader;
    reader->SetFileName(brain);
    reader->Update();
    volumes.push_back({ "brain", reader->GetOutput(), 46.5 });
  }
#endif
  return volumes;
}

const std::vector<BenchmarkVolume>& Volumes()
{
  static const std::vector<BenchmarkVolume> volumes = MakeVolumes();
  return volumes;
}

void Run(benchmark::State& state, const BenchmarkVolume& volume, vtkVDBSurfaceFilter* filter)
{
  vtkSMPTools::Initialize(static_cast<int>(state.range(0)));
  filter->SetInputDataObject(volume.Image);
  filter->ComputeIsoValueOff();
  filter->SetIsoValue(volume.IsoValue);
  for (auto _ : state)
  {
    filter->Modified();
    filter->Update();
  }
  state.counters["triangles"] = static_cast<double>(filter->GetPolyDataOutput()->GetNumberOfPolys());
  if (filter->GetPolyDataOutput()->GetNumberOfPolys() == 0)
  {
    state.SkipWithError("no surface");
  }
}

void Filter(benchmark::State& state, const BenchmarkVolume& volume)
{
  vtkNew<vtkVDBSurfaceFilter> filter;
  Run(state, volume, filter);
}

void FilterWithLevelSet(benchmark::State& state, const BenchmarkVolume& volume)
{
  vtkNew<vtkVDBSurfaceFilter> filter;
  filter->SetSmoothingToMeanCurvature();
  filter->LargestComponentOn();
  filter->FillCavitiesOn();
  Run(state, volume, filter);
}

/// Samples to a grid, the grid to quadrilaterals: neither manifold, nor triangles, nor in world coordinates, nor
/// capped.
void BareOpenVDB(benchmark::State& state, const BenchmarkVolume& volume)
{
  const int* n = volume.Image->GetDimensions();
  vtkDataArray* scalars = volume.Image->GetPointData()->GetScalars();
  std::vector<float> values(static_cast<std::size_t>(scalars->GetNumberOfTuples()));
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    values[k] = static_cast<float>(volume.IsoValue - scalars->GetComponent(static_cast<vtkIdType>(k), 0));
  }
  tbb::task_arena arena(static_cast<int>(state.range(0)));
  std::size_t quadrilaterals = 0;
  for (auto _ : state)
  {
    arena.execute([&] {
      const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(n[0] - 1, n[1] - 1, n[2] - 1));
      const openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, values.data());
      const auto grid = openvdb::FloatGrid::create(1.0F);
      openvdb::tools::copyFromDense(dense, *grid, 0.0F);
      std::vector<openvdb::Vec3s> points;
      std::vector<openvdb::Vec4I> quads;
      openvdb::tools::volumeToMesh(*grid, points, quads, 0.0);
      quadrilaterals = quads.size();
    });
  }
  state.counters["triangles"] = 2.0 * static_cast<double>(quadrilaterals);
}
} // namespace

int main(int argc, char** argv)
{
  openvdb::initialize();
  for (const BenchmarkVolume& volume : Volumes())
  {
    for (const auto& entry :
      { std::make_pair("SurfaceOfVolume", &Filter), std::make_pair("SurfaceThroughLevelSet", &FilterWithLevelSet),
        std::make_pair("ReferenceOpenVDB", &BareOpenVDB) })
    {
      benchmark::RegisterBenchmark((std::string(entry.first) + "/" + volume.Name).c_str(),
        [&volume, run = entry.second](benchmark::State& state) { run(state, volume); })
        ->ArgName("threads")
        ->Arg(2)
        ->Arg(1)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
  {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
