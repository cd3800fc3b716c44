// SPDX-License-Identifier: BSD-3-Clause
//
// Each thing that can be wrong, and the text that the user reads.
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkDataArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace
{
std::string ErrorOfMesh(const Soup& soup)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(soup.ToPolyData());
  return ErrorOf(filter);
}

std::string ErrorWith(const std::function<void(vtkMaternNoiseFilter*)>& change)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(3).ToPolyData());
  change(filter);
  return ErrorOf(filter);
}

Soup Three(const std::vector<double>& points)
{
  Soup soup;
  soup.Points = points;
  soup.Polys = { { 0, 1, 2 } };
  return soup;
}
} // namespace

TEST(MaternNoiseMessages, NoInput)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("There is no input"), HasSubstr("vtkPolyData")));
}

TEST(MaternNoiseMessages, EmptyInputIsNoError)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  vtkNew<vtkPolyData> empty;
  filter->SetInputDataObject(empty);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_THAT(events.Warnings, IsEmpty());
  EXPECT_EQ(filter->GetPolyDataOutput()->GetNumberOfPoints(), 0);
}

TEST(MaternNoiseMessages, AnotherTypeOfInput)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  vtkNew<vtkStructuredGrid> grid;
  filter->SetInputDataObject(grid);
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("vtkStructuredGrid"), HasSubstr("vtkPolyData")));
}

TEST(MaternNoiseMessages, PointsWithoutPolygons)
{
  Soup points = Icosphere(1);
  points.Polys.clear();
  EXPECT_THAT(ErrorOfMesh(points), AllOf(HasSubstr("42 points"), HasSubstr("no polygon"), HasSubstr("vtkDelaunay2D")));
}

TEST(MaternNoiseMessages, NonManifoldEdge)
{
  Soup soup = Three({ 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0 });
  soup.Polys.push_back({ 0, 1, 3 });
  soup.Polys.push_back({ 0, 1, 4 });
  EXPECT_THAT(ErrorOfMesh(soup),
    AllOf(HasSubstr("1 non-manifold edge"), HasSubstr("first at point 0"), HasSubstr("vtkFeatureEdges")));
}

TEST(MaternNoiseMessages, DegenerateTriangle)
{
  Soup soup = Grid(3);
  const vtkIdType first = soup.AddPoint(5, 0, 0);
  soup.AddPoint(6, 0, 0);
  soup.AddPoint(7, 0, 0);
  soup.Polys.push_back({ first, first + 1, first + 2 });
  EXPECT_THAT(ErrorOfMesh(soup),
    AllOf(HasSubstr("1 degenerate triangle"), HasSubstr("first cell 18"), HasSubstr("vtkCleanPolyData")));
}

TEST(MaternNoiseMessages, NaNPoint)
{
  EXPECT_THAT(ErrorOfMesh(Three({ 0, 0, 0, 1, 0, 0, 0, std::nan(""), 0 })),
    AllOf(HasSubstr("1 point(s)"), HasSubstr("NaN"), HasSubstr("first point 2")));
}

TEST(MaternNoiseMessages, IdOutOfRange)
{
  Soup soup = Grid(3);
  soup.Polys[4][2] = 99;
  EXPECT_THAT(ErrorOfMesh(soup), AllOf(HasSubstr("1 cell(s)"), HasSubstr("does not exist"), HasSubstr("first cell 4")));
}

TEST(MaternNoiseMessages, PolygonThatRepeatsAVertex)
{
  Soup soup = Grid(3);
  soup.Polys.push_back({ 0, 1, 2, 3, 0 });
  EXPECT_THAT(
    ErrorOfMesh(soup), AllOf(HasSubstr("a point twice"), HasSubstr("first cell 18"), HasSubstr("vtkCleanPolyData")));
}

TEST(MaternNoiseMessages, PolygonThatCrossesItself)
{
  Soup soup;
  soup.Points = { 0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0 };
  soup.Polys = { { 0, 1, 2, 3 } };
  EXPECT_THAT(ErrorOfMesh(soup),
    AllOf(HasSubstr("1 polygon(s)"), HasSubstr("cannot be triangulated"), HasSubstr("vtkTriangleFilter")));
}

TEST(MaternNoiseMessages, ParametersThatAreNotNumbers)
{
  const double nan = std::nan("");
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetCorrelationRange(nan); }), HasSubstr("range is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetStandardDeviation(nan); }), HasSubstr("StandardDeviation is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) {
    f->SetScaleModeToScreening();
    f->SetScreening(nan);
  }),
    HasSubstr("tau is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) {
    f->SetScaleModeToNormalizedScreening();
    f->SetNormalizedScreening(nan);
  }),
    HasSubstr("c is nan"));
}

TEST(MaternNoiseMessages, ExtremeParametersAreErrorsOrFinite)
{
  const auto sphere = Icosphere(3).ToPolyData();
  for (const double value : { 1e-320, 1e-300, 1e-150, 1e-20, 1e-8, 1e8, 1e20, 1e150, 1e298, HUGE_VAL })
  {
    for (int mode = vtkMaternNoiseFilter::CORRELATION_RANGE; mode <= vtkMaternNoiseFilter::NORMALIZED_SCREENING; ++mode)
    {
      vtkNew<vtkMaternNoiseFilter> filter;
      filter->SetInputDataObject(sphere);
      filter->SetScaleMode(mode);
      filter->SetCorrelationRange(value);
      filter->SetScreening(value);
      filter->SetNormalizedScreening(value);
      EventRecorder events(filter);
      const bool succeeded = Update(filter);
      EXPECT_EQ(succeeded, events.Errors.empty()) << "value " << value << " mode " << mode;
      vtkDataArray* noise = filter->GetPolyDataOutput()->GetPointData()->GetArray("MaternNoise");
      EXPECT_EQ(succeeded, noise != nullptr) << "value " << value << " mode " << mode;
      for (vtkIdType p = 0; noise && p < noise->GetNumberOfTuples(); ++p)
      {
        ASSERT_TRUE(std::isfinite(noise->GetComponent(p, 0))) << "value " << value << " mode " << mode;
      }
    }
  }
}

TEST(MaternNoiseMessages, EmptyArrayName)
{
  EXPECT_THAT(ErrorWith([](auto* f) { f->SetOutputArrayName(""); }), HasSubstr("OutputArrayName is empty"));
  EXPECT_THAT(ErrorWith([](auto* f) { f->SetOutputArrayName(nullptr); }), HasSubstr("OutputArrayName is empty"));
}

TEST(MaternNoiseMessages, MoreEigenpairsThanTheMeshHas)
{
  EXPECT_THAT(ErrorWith([](auto* f) {
    f->SetNoiseModelToSpectral();
    f->SetNumberOfEigenpairs(100000);
  }),
    AllOf(HasSubstr("100000"), HasSubstr("eigenpairs")));
}

TEST(MaternNoiseMessages, BlocksAreNamedInMessages)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkStructuredGrid> grid;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Three({ 0, 0, 0, 1, 0, 0, 2, 0, 0 }).ToPolyData());
  blocks->SetBlock(2, grid);
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(blocks);
  filter->SetCorrelationRange(5.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_THAT(events.Errors, SizeIs(2));
  EXPECT_THAT(events.Errors[0], AllOf(HasSubstr("degenerate triangle"), HasSubstr("Block 2: ")));
  EXPECT_THAT(events.Errors[1],
    AllOf(HasSubstr("vtkStructuredGrid"), HasSubstr("vtkDataSetSurfaceFilter"), HasSubstr("Block 3: ")));
}

TEST(MaternNoiseMessages, ARangeOfManySurfacesIsAWarning)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(2).ToPolyData());
  filter->SetCorrelationRange(50.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_THAT(events.Warnings, SizeIs(1));
  EXPECT_THAT(events.Warnings[0],
    AllOf(HasSubstr("correlation range 50 is 25 times the longest side of the surface, 2"), HasSubstr("below 2")));
  filter->SetCorrelationRange(9.0);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Warnings, SizeIs(1)) << "a field that varies little";
}

TEST(MaternNoiseMessages, ASolverThatNeedsNoFactorIsNamedAndGivesTheSameSampleTo1em8)
{
  const auto sample = [](int limit, const std::string& solver) {
    vtkNew<vtkMaternNoiseFilter> filter;
    filter->SetInputDataObject(Icosphere(5).ToPolyData());
    filter->SetMemoryLimit(limit);
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(filter->GetSolverName(), solver);
    EXPECT_EQ(filter->GetNumberOfIterations() > 0, solver == "Multigrid");
    EXPECT_LE(filter->GetRelativeResidual(), 1.001e-10);
    vtkDataArray* values =
      vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetPointData()->GetArray("MaternNoise");
    std::vector<double> numbers;
    for (vtkIdType k = 0; k < values->GetNumberOfTuples(); ++k)
    {
      numbers.push_back(values->GetComponent(k, 0));
    }
    return numbers;
  };
  const std::vector<double> factored = sample(0, "Cholesky");
  const std::vector<double> iterated = sample(2, "Multigrid"); // the factor takes five MiB
  ASSERT_EQ(factored.size(), iterated.size());
  for (std::size_t k = 0; k < factored.size(); ++k)
  {
    ASSERT_NEAR(factored[k], iterated[k], 1e-8) << k;
  }
}

TEST(MaternNoiseMessages, MoreSamplesThanFitAreRefusedAndTheNumberThatIsNamedFits)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(2).ToPolyData());
  filter->SetCorrelationRange(1.5);
  filter->SetNumberOfComponents(3);
  filter->SetMemoryLimit(1);
  filter->SetNumberOfSamples(VTK_INT_MAX);
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_THAT(events.Errors, SizeIs(1));
  const std::string mark = "A NumberOfSamples of ";
  const std::size_t place = events.Errors[0].find(mark);
  ASSERT_NE(place, std::string::npos) << events.Errors[0];
  const int fitting = std::stoi(events.Errors[0].substr(place + mark.size()));
  EXPECT_GT(fitting, 10);
  filter->SetNumberOfSamples(fitting);
  EXPECT_TRUE(Update(filter));
  filter->SetNumberOfSamples(fitting + 1);
  EXPECT_FALSE(Update(filter));
}

TEST(MaternNoiseMessages, EdgesTooLongForTheRangeAreAWarning)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(2).ToPolyData()); // edges of about 0.3
  filter->SetCorrelationRange(0.5);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  ASSERT_THAT(events.Warnings, SizeIs(1));
  EXPECT_THAT(events.Warnings[0],
    AllOf(
      HasSubstr("longest edge is 0.3"), HasSubstr("correlation range 0.5"), HasSubstr("vtkAdaptiveSubdivisionFilter")));
  filter->SetCorrelationRange(1.5);
  EXPECT_TRUE(Update(filter));
  filter->SetScaleModeToScreening();
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Warnings, SizeIs(1)) << "a long enough range, and tau given by hand, are no reason to warn";
}
