// SPDX-License-Identifier: BSD-3-Clause
//
// R19, the numbers: surfaces of one image and one mesh, compared with Testing/Data/VDBSurfaceBaseline.txt.
//
// The file changes only when the surfaces are meant to change. To write it again, from the build folder:
//   SURFACE_SYNTHESIS_REGENERATE_BASELINES=1 bin/TestVDBSurfaceBaseline
#include "ExampleImages.h"
#include "FilterChecks.h"
#include "NumberBaseline.h"
#include "VtkSurfaces.h"

#include "vtkVDBSurfaceFilter.h"

#include <vtkNew.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace surfsynthtest;
using Filter = vtkVDBSurfaceFilter;

namespace
{
const char* const BaselineFile = SURFSYNTH_TEST_DATA "/VDBSurfaceBaseline.txt";
/// Another version of OpenVDB may round otherwise, and cut a few triangles otherwise.
constexpr double Tolerance = 1e-3;

void Describe(const std::string& name, Filter* filter, Numbers& numbers)
{
  ASSERT_TRUE(Update(filter));
  vtkPolyData* surface = filter->GetPolyDataOutput();
  numbers[name + ".points"] = static_cast<double>(surface->GetNumberOfPoints());
  numbers[name + ".triangles"] = static_cast<double>(surface->GetNumberOfPolys());
  numbers[name + ".area"] = AreaOf(surface);
  numbers[name + ".volume"] = VolumeOf(surface);
  for (int k = 0; k < 6; ++k)
  {
    numbers[name + ".bound" + std::to_string(k)] = surface->GetBounds()[k];
  }
}

Numbers ComputeNumbers()
{
  Numbers numbers;
  ImageGeometry geometry;
  geometry.Dimensions = { { 40, 36, 30 } };
  geometry.Spacing = { 1.0, 1.0, 1.25 };
  geometry.Origin = { 10.0, -20.0, 5.0 };
  const Eigen::Vector3d center = geometry.Center();
  const auto image = MakeImage(geometry, [center](const Eigen::Vector3d& x) {
    const Eigen::Vector3d d = x - center;
    return 12.0 - d.norm() + std::sin(0.7 * d[0]) * std::cos(0.5 * d[1]) * 2.0;
  });
  vtkNew<Filter> filter;
  filter->SetInputDataObject(image);
  filter->ComputeIsoValueOff();
  Describe("samples", filter, numbers);
  filter->SetVoxelSize(1.0);
  filter->SetClosing(2.0);
  Describe("closing", filter, numbers);
  filter->SetSmoothingToGaussian();
  filter->SetSmoothingIterations(1);
  filter->SetOffset(0.75);
  Describe("gaussian", filter, numbers);
  filter->SetAdaptivity(0.3);
  Describe("adaptive", filter, numbers);
  vtkNew<Filter> ofMesh;
  ofMesh->SetInputDataObject(Icosphere(3).ToPolyData());
  ofMesh->SetVoxelSize(0.06);
  Describe("mesh", ofMesh, numbers);
  return numbers;
}
} // namespace

TEST(VDBSurfaceBaseline, NumbersAreThoseOfTheFile)
{
  ExpectBaseline(ComputeNumbers(), { BaselineFile, 50, Tolerance, 9 });
}
