// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "SurfaceBridge.h"
#include "ThrownText.h"
#include "vtkSurfaceDistance.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/SurfaceDistance.h"

#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
vtkSmartPointer<vtkPolyData> Sphere(double radius, int levels = 3)
{
  Soup soup = Icosphere(levels);
  for (double& coordinate : soup.Points)
  {
    coordinate *= radius;
  }
  return soup.ToPolyData();
}

vtkSmartPointer<vtkPolyData> Square(double height, int cells = 4, double scale = 1.0)
{
  Soup soup = Grid(cells);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] *= scale;
    soup.Points[k + 2] = height;
  }
  return soup.ToPolyData();
}

vtkSmartPointer<vtkSurfaceDistance> Filter(vtkDataObject* first, vtkDataObject* second)
{
  auto filter = vtkSmartPointer<vtkSurfaceDistance>::New();
  filter->SetInputDataObject(0, first);
  filter->SetInputDataObject(1, second);
  return filter;
}

vtkSmartPointer<vtkSurfaceDistance> Measured(vtkDataObject* first, vtkDataObject* second)
{
  const auto filter = Filter(first, second);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  return filter;
}

double Value(vtkSurfaceDistance* filter, int row, const char* column)
{
  return vtkTable::SafeDownCast(filter->GetOutputDataObject(1))->GetValueByName(row, column).ToDouble();
}
} // namespace

TEST(SurfaceDistanceFilter, ParallelSquaresHaveOneDistance)
{
  const auto first = Square(0.0);
  const std::uint64_t before = HashOf(first);
  const auto filter = Measured(first, Square(0.25, 7));
  EXPECT_EQ(HashOf(first), before) << "the input stays";
  for (int row = 0; row < 3; ++row)
  {
    for (const char* column : { "Mean", "RMS", "Percentile95", "Maximum" })
    {
      EXPECT_NEAR(Value(filter, row, column), 0.25, 1e-12) << row << " " << column;
    }
  }
  EXPECT_NEAR(PointArray(filter->GetOutputDataObject(0), "Distance")->GetTuple1(3), 0.25, 1e-12);
  EXPECT_NEAR(filter->GetHausdorffDistance(), 0.25, 1e-12);
}

TEST(SurfaceDistanceFilter, DirectionsDifferWhereOneSurfaceIsLarger)
{
  const auto filter = Measured(Square(0.0), Square(0.0, 4, 2.0)); // x from 0 to 2
  EXPECT_NEAR(Value(filter, 0, "Maximum"), 0.0, 1e-12);
  EXPECT_NEAR(Value(filter, 1, "Maximum"), 1.0, 1e-12) << "a vertex, exactly";
  EXPECT_NEAR(Value(filter, 1, "Mean"), 0.25, 1e-4) << "half of the area from 0 to 1";
  EXPECT_NEAR(Value(filter, 1, "RMS"), std::sqrt(1.0 / 6.0), 1e-4);
  EXPECT_NEAR(Value(filter, 1, "Percentile95"), 0.9, 1e-3);
  EXPECT_NEAR(Value(filter, 2, "Mean"), 0.125, 1e-4) << "each surface with half of the weight";
  EXPECT_NEAR(filter->GetMean(), 0.125, 1e-4);
  EXPECT_NEAR(filter->GetHausdorffDistance(), 1.0, 1e-12);
  EXPECT_GT(filter->GetRMS(), filter->GetMean());
  EXPECT_LE(filter->GetPercentile95(), 1.0);
}

TEST(SurfaceDistanceFilter, TriangulationsOfOneSphereAreNear)
{
  const auto filter = Measured(Sphere(10.0, 4), Sphere(11.0, 3));
  EXPECT_NEAR(filter->GetMean(), 1.0, 0.04) << "chords lie inside the spheres by up to 1 - cos(4 degrees)";
  EXPECT_NEAR(filter->GetHausdorffDistance(), 1.0, 0.06);
}

TEST(SurfaceDistanceFilter, ASurfaceHasNoDistanceFromItself)
{
  const auto sphere = Sphere(1.0);
  EXPECT_LT(Measured(sphere, sphere)->GetHausdorffDistance(), 1e-12);
}

TEST(SurfaceDistanceFilter, SameBitsForAllNumbersOfThreads)
{
  const auto first = Sphere(10.0), second = Sphere(11.0, 2);
  const auto make = [&] {
    const auto filter = Filter(first, second);
    filter->SetNumberOfSamples(3000); // several parts for the threads
    return filter;
  };
  ExpectSameBitsForAllThreads(make, [](vtkAlgorithm* filter) {
    auto* table = vtkTable::SafeDownCast(filter->GetOutputDataObject(1));
    return vtkDataArray::SafeDownCast(table->GetColumnByName("Mean"));
  });
}

TEST(SurfaceDistanceFilter, RefusesWrongInputsInWords)
{
  vtkNew<vtkPolyData> empty;
  EXPECT_THAT(ErrorOf(Filter(Sphere(1.0), empty)), HasSubstr("second surface is empty"));
  EXPECT_EQ(vtkTable::SafeDownCast(Measured(empty, empty)->GetOutputDataObject(1))->GetNumberOfColumns(), 0);
  const auto broken = Sphere(1.0);
  broken->GetPoints()->SetPoint(7, std::numeric_limits<double>::infinity(), 0.0, 0.0);
  EXPECT_THAT(ErrorOf(Filter(broken, Sphere(1.0))), HasSubstr("The first surface has 1"));
  EXPECT_THAT(
    ErrorOf(Filter(Sphere(0.0), Sphere(1.0))), HasSubstr("expected triangles with finite points and an area"));
}

TEST(SurfaceDistanceFilter, SamplesThatDoNotFitIntoMemoryAreRefused)
{
  const surfsynth::TriangleMesh mesh = surfsynth::ConvertSurface(Sphere(1.0)).Mesh;
  const std::string text = surfsynthtest::TextOf<surfsynth::InvalidInput>(
    [&] { surfsynth::ComputeSurfaceDistance(mesh, mesh, {}, std::int64_t(1) << 45); });
  EXPECT_THAT(text, HasSubstr("35184372088832 samples need 1.04858e+06 GiB"));
}

TEST(SurfaceDistanceFilter, PointsThatNoPolygonUsesHaveTheDistance0)
{
  const auto sphere = Sphere(1.0);
  const vtkIdType unused = sphere->GetPoints()->InsertNextPoint(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0);
  const auto expected = Measured(Sphere(1.0), Sphere(1.1));
  for (const auto& filter : { Measured(sphere, Sphere(1.1)), Measured(Sphere(1.1), sphere) })
  {
    EXPECT_EQ(Value(filter, 2, "Mean"), Value(expected, 2, "Mean"));
  }
  const auto filter = Measured(sphere, Sphere(1.1));
  EXPECT_EQ(PointArray(filter->GetOutputDataObject(0), "Distance")->GetTuple1(unused), 0.0);
}

TEST(SurfaceDistanceFilter, EachPropertyRunsItOnce)
{
  const auto filter = Filter(Square(0.0), Square(0.5));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  const PropertyChanges<vtkSurfaceDistance> changes = {
    { "NumberOfSamples", [](vtkSurfaceDistance* f) { f->SetNumberOfSamples(50); } },
    { "Seed", [](vtkSurfaceDistance* f) { f->SetSeed(3); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("HausdorffDistance: 0.5"));
}
