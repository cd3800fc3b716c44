// SPDX-License-Identifier: BSD-3-Clause
//
// Remeshing: vtkIsotropicRemeshFilter, and beside it, in the same run, CGAL's isotropic_remeshing() alone on the same
// surface with the same target; repair; and the way from a scan of a brain to a surface of 60,000 even triangles.
//
// The surface is the scanned armadillo of Debian's libcgal-demo, or a generated one when there is none.
// SURFACE_SYNTHESIS_BENCHMARK_SIZES="1000" takes a small one instead, and leaves the brain out.
#include "vtkIsotropicRemeshFilter.h"
#include "vtkSurfaceRepairFilter.h"
#ifdef SURFACE_SYNTHESIS_BRAIN
#include "vtkVDBSurfaceFilter.h"
#include <vtkNIFTIImageReader.h>
#endif

#include "ExampleMeshes.h"
#include "SurfaceArrays.h"

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace
{
using surfsynth::Index;
using surfsynth::TriangleMesh;
using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

bool IsSmoke() { return std::getenv("SURFACE_SYNTHESIS_BENCHMARK_SIZES") != nullptr; }

const TriangleMesh& TheMesh()
{
  static const TriangleMesh mesh = IsSmoke() ? surfsynth::test::BumpySurface(3) : surfsynth::test::ScannedSurface();
  return mesh;
}

vtkSmartPointer<vtkPolyData> TheSurface(bool withArray)
{
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surfsynth::SetGeometry(surface, TheMesh(), true);
  if (withArray)
  {
    const auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(VTK_DOUBLE));
    array->SetName("x");
    array->SetNumberOfTuples(surface->GetNumberOfPoints());
    for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
    {
      array->SetTuple1(p, surface->GetPoint(p)[0]);
    }
    surface->GetPointData()->AddArray(array);
  }
  return surface;
}

/// The filter, edge lengths as they are, without creases: what CGAL alone does below.
void Filter(benchmark::State& state, bool withArray)
{
  vtkSMPTools::Initialize(static_cast<int>(state.range(0)));
  const auto surface = TheSurface(withArray);
  for (auto _ : state)
  {
    vtkNew<vtkIsotropicRemeshFilter> filter;
    filter->SetInputData(surface);
    filter->KeepFeatureEdgesOff();
    filter->Update();
    state.counters["points"] = static_cast<double>(
      filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT));
  }
}

void CgalAlone(benchmark::State& state)
{
  const TriangleMesh& mesh = TheMesh();
  for (auto _ : state)
  {
    state.PauseTiming();
    Mesh surface;
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      surface.add_vertex(Point(mesh.Points(v, 0), mesh.Points(v, 1), mesh.Points(v, 2)));
    }
    double sum = 0.0;
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const auto t = mesh.Triangles.row(f);
      surface.add_face(Mesh::Vertex_index(t(0)), Mesh::Vertex_index(t(1)), Mesh::Vertex_index(t(2)));
      for (int k = 0; k < 3; ++k)
      {
        sum += (mesh.Points.row(t(k)) - mesh.Points.row(t((k + 1) % 3))).norm();
      }
    }
    state.ResumeTiming();
    CGAL::Polygon_mesh_processing::isotropic_remeshing(
      surface.faces(), sum / (3.0 * mesh.NumberOfTriangles()), surface, CGAL::parameters::number_of_iterations(3));
    state.counters["points"] = static_cast<double>(surface.number_of_vertices());
  }
}

void Repair(benchmark::State& state)
{
  const auto surface = TheSurface(false);
  for (auto _ : state)
  {
    vtkNew<vtkSurfaceRepairFilter> filter;
    filter->SetInputData(surface);
    filter->Update();
  }
}

#ifdef SURFACE_SYNTHESIS_BRAIN
constexpr const char* Brain = "/usr/share/mricron/templates/ch2bet.nii.gz";

/// From the samples in memory to 60,000 even triangles.
void BrainToSurface(benchmark::State& state)
{
  vtkSMPTools::Initialize(static_cast<int>(state.range(0)));
  vtkNew<vtkNIFTIImageReader> reader;
  reader->SetFileName(Brain);
  reader->Update();
  for (auto _ : state)
  {
    vtkNew<vtkVDBSurfaceFilter> surface;
    surface->SetInputData(reader->GetOutput());
    surface->SetSmoothingToMeanCurvature();
    surface->SetSmoothingIterations(2);
    surface->SetClosing(2.0);
    surface->FillCavitiesOn();
    surface->LargestComponentOn();
    vtkNew<vtkIsotropicRemeshFilter> remesh;
    remesh->SetInputConnection(surface->GetOutputPort());
    remesh->SetTargetNumberOfPoints(30000);
    remesh->KeepFeatureEdgesOff();
    remesh->Update();
    state.counters["triangles"] = static_cast<double>(
      remesh->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::CELL));
  }
}
#endif
} // namespace

int main(int argc, char** argv)
{
  const auto measure = [](const std::string& name, const auto& body) {
    return benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  measure("Remesh/CGAL alone", CgalAlone);
  measure("Remesh/filter", [](benchmark::State& state) { Filter(state, false); })->ArgName("threads")->Arg(1)->Arg(2);
  measure("Remesh/filter with a point array", [](benchmark::State& state) { Filter(state, true); })
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2);
  measure("Repair/filter", Repair);
#ifdef SURFACE_SYNTHESIS_BRAIN
  if (!IsSmoke() && std::ifstream(Brain).good())
  {
    measure("Brain to 60,000 triangles", BrainToSurface)->ArgName("threads")->Arg(1)->Arg(2);
  }
#endif
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
