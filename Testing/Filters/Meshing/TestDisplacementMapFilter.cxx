// SPDX-License-Identifier: BSD-3-Clause
//
// vtkDisplacementMapFilter: images, measures, messages, the contract of all filters.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkDisplacementMapFilter.h"

#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
/// A square of side @p side at height @p height with the texture coordinates x / side and y / side.
vtkSmartPointer<vtkPolyData> Square(
  double height, int cells = 4, int corners = 3, int type = VTK_DOUBLE, double side = 1.0)
{
  Soup soup = Grid(cells, corners);
  vtkNew<vtkFloatArray> texture;
  texture->SetName("UV");
  texture->SetNumberOfComponents(2);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    texture->InsertNextTuple2(soup.Points[k], soup.Points[k + 1]);
    soup.Points[k] *= side;
    soup.Points[k + 1] *= side;
    soup.Points[k + 2] = height;
  }
  const auto square = soup.ToPolyData(type);
  square->GetPointData()->SetTCoords(texture);
  return square;
}

/// A fine square with a relief.
vtkSmartPointer<vtkPolyData> Relief(int cells = 60)
{
  const auto square = Square(0.0, cells);
  for (vtkIdType p = 0; p < square->GetNumberOfPoints(); ++p)
  {
    const double* x = square->GetPoint(p);
    square->GetPoints()->SetPoint(p, x[0], x[1], 0.05 * std::sin(9.0 * x[0] + 5.0 * x[1]));
  }
  return square;
}

vtkSmartPointer<vtkDisplacementMapFilter> Filter(vtkDataObject* plain, vtkDataObject* detailed, int size = 64)
{
  auto filter = vtkSmartPointer<vtkDisplacementMapFilter>::New();
  filter->SetInputDataObject(0, plain);
  filter->SetDetailedData(detailed);
  filter->SetResolution(size, size);
  return filter;
}

vtkSmartPointer<vtkDisplacementMapFilter> Baked(vtkDataObject* plain, vtkDataObject* detailed)
{
  const auto filter = Filter(plain, detailed);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_THAT(events.Warnings, IsEmpty());
  return filter;
}

vtkDataArray* ArrayOf(vtkAlgorithm* filter, const char* name)
{
  return vtkImageData::SafeDownCast(filter->GetOutputDataObject(0))->GetPointData()->GetArray(name);
}

double FieldOf(vtkAlgorithm* filter, const char* name)
{
  return filter->GetOutputDataObject(0)->GetFieldData()->GetArray(name)->GetTuple1(0);
}
} // namespace

TEST(DisplacementMapFilter, ImagesHaveHeightVectorAndCoverage)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    for (const int corners : { 3, 4 })
    {
      const auto plain = Square(0.0, 3, corners, type);
      const auto detailed = Square(0.25, 5, corners, type);
      const std::uint64_t before = HashOf(plain);
      const auto filter = Filter(plain, detailed);
      filter->SetResolution(64, 32);
      filter->SetMaximumDistance(0.5);
      EXPECT_TRUE(Update(filter));
      EXPECT_EQ(HashOf(plain), before) << "the input stays";
      auto* image = vtkImageData::SafeDownCast(filter->GetOutputDataObject(0));
      EXPECT_EQ(image->GetDimensions()[0], 64);
      EXPECT_EQ(image->GetDimensions()[1], 32);
      EXPECT_STREQ(image->GetPointData()->GetScalars()->GetName(), "Height");
      for (vtkIdType t = 0; t < 64 * 32; ++t)
      {
        EXPECT_NEAR(ArrayOf(filter, "Height")->GetTuple1(t), 0.25, 1e-7);
        EXPECT_NEAR(ArrayOf(filter, "Displacement")->GetComponent(t, 2), 0.25, 1e-7);
        EXPECT_EQ(ArrayOf(filter, "Coverage")->GetTuple1(t), 255.0);
      }
      EXPECT_EQ(filter->GetSubdivisionLevels(), -1);
      EXPECT_EQ(filter->GetCoveredTexels(), 64 * 32);
      EXPECT_EQ(filter->GetMisses(), 0);
      EXPECT_EQ(filter->GetHeightMidlevel(), 0.0);
      EXPECT_NEAR(filter->GetHeightScale(), 0.25, 1e-7);
    }
  }
}

TEST(DisplacementMapFilter, RowsBeginAtTheBottom)
{
  const auto detailed = Square(0.0, 40);
  for (vtkIdType p = 0; p < detailed->GetNumberOfPoints(); ++p)
  {
    const double* x = detailed->GetPoint(p);
    detailed->GetPoints()->SetPoint(p, x[0], x[1], 0.03 * x[0] - 0.06 * x[1]);
  }
  const auto filter = Baked(Square(0.0), detailed);
  const auto expected = [](int i, int j) { return (0.03 * (i + 0.5) - 0.06 * (j + 0.5)) / 64; };
  for (const int t : { 0, 63, 64 * 63, 64 * 64 - 1, 64 * 20 + 5 })
  {
    EXPECT_NEAR(ArrayOf(filter, "Height")->GetTuple1(t), expected(t % 64, t / 64), 1e-7);
  }
  EXPECT_NEAR(filter->GetHeightScale(), 0.09 * 63.0 / 64.0, 1e-6);
  EXPECT_NEAR(filter->GetHeightMidlevel(), 2.0 / 3.0, 0.01);
  for (const char* name : { "CoveredTexels", "Misses", "MeanMiss", "LargestMiss", "HeightMidlevel", "HeightScale" })
  {
    EXPECT_TRUE(filter->GetOutputDataObject(0)->GetFieldData()->GetArray(name)) << name;
  }
  EXPECT_EQ(FieldOf(filter, "HeightScale"), filter->GetHeightScale());
  EXPECT_EQ(FieldOf(filter, "SubdivisionLevels"), -1);
}

TEST(DisplacementMapFilter, TexelsOutsideOfChartsAreFilledUpToTheGutter)
{
  const auto plain = Square(0.0);
  vtkDataArray* texture = plain->GetPointData()->GetTCoords();
  for (vtkIdType p = 0; p < texture->GetNumberOfTuples(); ++p)
  {
    texture->SetComponent(p, 0, 0.25 + 0.5 * texture->GetComponent(p, 0)); // columns 16 to 47
  }
  const auto filter = Filter(plain, Square(0.1, 7));
  filter->SetGutterWidth(4);
  EXPECT_TRUE(Update(filter));
  const auto isFilled = [&](int i) { return ArrayOf(filter, "Height")->GetTuple1(64 * 30 + i) != 0.0; };
  EXPECT_EQ(ArrayOf(filter, "Coverage")->GetTuple1(64 * 30 + 15), 0.0);
  EXPECT_EQ(ArrayOf(filter, "Coverage")->GetTuple1(64 * 30 + 16), 255.0);
  EXPECT_TRUE(isFilled(15));
  EXPECT_TRUE(isFilled(12));
  EXPECT_FALSE(isFilled(5));
  filter->SetGutterWidth(-1);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(isFilled(0));
  EXPECT_EQ(filter->GetCoveredTexels(), 64 * 32) << "gutters are not measured";
}

TEST(DisplacementMapFilter, MovedPointsOfTheSameSurfaceAreFoundByIndex)
{
  const auto plain = Square(0.0);
  const auto detailed = Square(0.02);
  detailed->GetPoints()->SetPoint(7, 0.5, 0.4, 0.02); // from (0.5, 0.25)
  const auto filter = Filter(plain, detailed);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetSubdivisionLevels(), 0);
  EXPECT_GT(ArrayOf(filter, "Displacement")->GetRange(1)[1], 0.1);
  filter->SetCorrespondenceToNormals();
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetSubdivisionLevels(), -1);
  EXPECT_EQ(ArrayOf(filter, "Displacement")->GetRange(1)[1], 0.0);
}

TEST(DisplacementMapFilter, RefusesWrongInputsInWords)
{
  vtkNew<vtkPolyData> empty;
  EXPECT_THAT(ErrorOf(Filter(Square(0.0), empty)), HasSubstr("detailed surface on port 1 is empty"));
  EXPECT_THAT(ErrorOf(Filter(empty, Square(0.0))), HasSubstr("plain surface on port 0 is empty"));
  EXPECT_EQ(vtkImageData::SafeDownCast(Baked(empty, empty)->GetOutputDataObject(0))->GetNumberOfPoints(), 0);
  const auto bare = Square(0.0);
  bare->GetPointData()->SetTCoords(nullptr);
  EXPECT_THAT(ErrorOf(Filter(bare, Square(0.1))),
    testing::AllOf(HasSubstr("no texture coordinates"), HasSubstr("vtkTextureAtlasFilter")));
  const auto outside = Square(0.0);
  outside->GetPointData()->GetTCoords()->SetComponent(3, 0, 1.5);
  EXPECT_THAT(ErrorOf(Filter(outside, Square(0.1))), HasSubstr("outside"));
  const auto broken = Square(0.0);
  broken->GetPoints()->SetPoint(7, std::numeric_limits<double>::infinity(), 0.0, 0.0);
  EXPECT_THAT(ErrorOf(Filter(broken, Square(0.1))), HasSubstr("The plain surface on port 0"));
  EXPECT_THAT(ErrorOf(Filter(Square(0.1), broken)), HasSubstr("The detailed surface on port 1 has 1"));
  const auto infinite = Square(0.0);
  infinite->GetPointData()->GetTCoords()->SetComponent(3, 0, std::numeric_limits<float>::infinity());
  EXPECT_THAT(ErrorOf(Filter(infinite, Square(0.1))), HasSubstr("texture coordinate"));
}

TEST(DisplacementMapFilter, WarnsOfChartsThatOverlap)
{
  const auto plain = Square(0.0);
  vtkDataArray* texture = plain->GetPointData()->GetTCoords();
  for (vtkIdType p = 0; p < texture->GetNumberOfTuples(); ++p)
  {
    texture->SetComponent(p, 0, std::abs(texture->GetComponent(p, 0) - 0.5)); // folded
  }
  EXPECT_THAT(WarningsOf(Filter(plain, Square(0.1, 9))), ElementsAre(HasSubstr("overlap")));
}

TEST(DisplacementMapFilter, DegenerateTrianglesOfTheDetailedSurfaceAreAllowed)
{
  const auto detailed = Square(0.1, 7);
  detailed->GetPoints()->SetPoint(9, detailed->GetPoint(10));
  const auto filter = Baked(Square(0.0), detailed);
  EXPECT_EQ(filter->GetMisses(), 0);
  EXPECT_NEAR(ArrayOf(filter, "Height")->GetRange()[0], 0.1, 1e-7);
}

TEST(DisplacementMapFilter, SameBitsForAllNumbersOfThreads)
{
  const auto plain = Square(0.0), detailed = Relief();
  ExpectSameBitsForAllThreads(
    [&] { return Filter(plain, detailed, 300); }, [](vtkAlgorithm* filter) { return ArrayOf(filter, "Displacement"); });
}

TEST(DisplacementMapFilter, ReportsProgressAndEndsOnAbort)
{
  const auto plain = Square(0.0), detailed = Relief();
  ExpectSteadyProgress(Filter(plain, detailed, 1024));
  for (const double fraction : { 0.0, 0.1, 0.5 })
  {
    ExpectAbort(Filter(plain, detailed, 1024), fraction, 2.0);
  }
}

TEST(DisplacementMapFilter, EachPropertyRunsItOnce)
{
  const auto filter = Filter(Square(0.0), Relief());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  using Map = vtkDisplacementMapFilter;
  const PropertyChanges<Map> changes = {
    { "Resolution", [](Map* f) { f->SetResolution(32, 48); } },
    { "GutterWidth", [](Map* f) { f->SetGutterWidth(2); } },
    { "VectorSpace", [](Map* f) { f->SetVectorSpaceToTangent(); } },
    { "Correspondence", [](Map* f) { f->SetCorrespondenceToNormals(); } },
    { "MaximumDistance", [](Map* f) { f->SetMaximumDistance(0.5); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  filter->SetResolution(1, 99999);
  EXPECT_EQ(filter->GetResolution()[0], 16);
  EXPECT_EQ(filter->GetResolution()[1], 16384);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "Resolution: 16 x 16384", "GutterWidth: 2", "VectorSpace: TANGENT",
         "Correspondence: NORMALS", "MaximumDistance: 0.5", "SubdivisionLevels: -1", "Misses: 0", "HeightScale: 0." })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
