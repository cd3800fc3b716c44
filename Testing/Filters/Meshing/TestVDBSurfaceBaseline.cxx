// SPDX-License-Identifier: BSD-3-Clause
//
// R19, the numbers: surfaces of one image and one mesh, compared with Testing/Data/VDBSurfaceBaseline.txt.
//
// The file changes only when the surfaces are meant to change. To write it again, from the build folder:
//   SURFACE_SYNTHESIS_REGENERATE_BASELINES=1 bin/TestVDBSurfaceBaseline
#include "ExampleImages.h"
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkVDBSurfaceFilter.h"

#include <vtkNew.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

using namespace surfsynthtest;
using Filter = vtkVDBSurfaceFilter;
using Numbers = std::map<std::string, double>;

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

Numbers ReadNumbers()
{
  Numbers numbers;
  std::ifstream file(BaselineFile);
  std::string name;
  for (double value; file >> name >> value;)
  {
    numbers[name] = value;
  }
  return numbers;
}
} // namespace

TEST(VDBSurfaceBaseline, NumbersAreThoseOfTheFile)
{
  const Numbers found = ComputeNumbers();
  if (std::getenv("SURFACE_SYNTHESIS_REGENERATE_BASELINES"))
  {
    std::ofstream file(BaselineFile);
    file.precision(9);
    for (const auto& number : found)
    {
      file << number.first << " " << number.second << "\n";
    }
    GTEST_SKIP() << "wrote " << BaselineFile;
  }
  const Numbers expected = ReadNumbers();
  ASSERT_EQ(expected.size(), 50u) << BaselineFile;
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& number : expected)
  {
    ASSERT_EQ(found.count(number.first), 1u) << number.first;
    EXPECT_NEAR(found.at(number.first), number.second, Tolerance * std::max(1.0, std::abs(number.second)))
      << number.first;
  }
}
