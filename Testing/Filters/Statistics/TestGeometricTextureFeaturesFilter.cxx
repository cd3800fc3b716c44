// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGeometricTextureFeatures: the numbers of the plain census, its arrays, ports, messages, broken surfaces, abort.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "vtkGeometricTextureFeatures.h"

#include "Core/Statistics/GeometricTextureFeatures.h"
#include "SurfaceBridge.h"

#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkTable.h>
#include <vtkVariant.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
/// Square of side 1 with 3 x 3 waves of @p height, the bump in the middle being half as high.
Soup Waves(double height, int corners = 3)
{
  Soup soup = Grid(48, corners);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    const double x = soup.Points[k], y = soup.Points[k + 1];
    const bool isMiddle = std::abs(x - 0.5) < 1.0 / 6.0 && std::abs(y - 0.5) < 1.0 / 6.0;
    const double wave = std::pow(std::sin(3.0 * M_PI * x) * std::sin(3.0 * M_PI * y), 2.0);
    soup.Points[k + 2] = height * (isMiddle ? 0.5 : 1.0) * wave;
  }
  return soup;
}

vtkSmartPointer<vtkGeometricTextureFeatures> Filter(vtkDataObject* surface, vtkDataObject* bare = nullptr)
{
  auto filter = vtkSmartPointer<vtkGeometricTextureFeatures>::New();
  filter->SetInputDataObject(0, surface);
  if (bare)
  {
    filter->SetInputDataObject(1, bare);
  }
  return filter;
}

vtkSmartPointer<vtkGeometricTextureFeatures> Measured(vtkDataObject* surface, vtkDataObject* bare = nullptr)
{
  const auto filter = Filter(surface, bare);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  return filter;
}

double Value(vtkAlgorithm* filter, const char* column)
{
  return vtkTable::SafeDownCast(filter->GetOutputDataObject(1))->GetValueByName(0, column).ToDouble();
}

[[maybe_unused]] vtkDataArray* CellArray(vtkAlgorithm* filter, const char* name)
{
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetCellData()->GetArray(name);
}

std::string RefusalOf(vtkDataObject* surface, vtkDataObject* bare = nullptr)
{
  const auto filter = Filter(surface, bare);
  const std::string text = ErrorOf(filter);
  EXPECT_EQ(vtkTable::SafeDownCast(filter->GetOutputDataObject(1))->GetNumberOfRows(), 0);
  EXPECT_EQ(filter->GetNumberOfPeaks(), 0);
  return text;
}
} // namespace

TEST(GeometricTextureFeaturesFilter, TheRowIsThatOfThePlainCensus)
{
  const auto surface = Waves(0.1).ToPolyData(), bare = Waves(0.0).ToPolyData();
  const std::uint64_t before = HashOf(surface) + HashOf(bare);
  const auto filter = Filter(surface, bare);
  filter->SetUnitLength(0.3);
  filter->SetMinimumProminence(0.01);
  filter->SetMergedSaddle(0.4);
  filter->SetWallLevel(0.6);
  OutputOf(filter);
  EXPECT_EQ(HashOf(surface) + HashOf(bare), before);
  const surfsynth::TriangleMesh bareMesh = surfsynth::ConvertSurface(bare).Mesh;
  const auto expected = surfsynth::MeasureGeometricTextureFeatures(
    surfsynth::ConvertSurface(surface).Mesh, &bareMesh, { 0.3, 0.01, 0.4, 0.6, 0.0 });
  EXPECT_EQ(expected.NumberOfPeaks, 9);
  EXPECT_EQ(Value(filter, "NumberOfPeaks"), 9.0);
  EXPECT_EQ(filter->GetNumberOfPeaks(), 9);
  EXPECT_NEAR(filter->GetPeakDensity(), 9.0, 1e-9);
  EXPECT_NEAR(filter->GetRelativePeakDensity(), 9.0 * 0.09, 1e-9);
  EXPECT_NEAR(filter->GetMeanPeakHeight(), 0.85 / 9.0, 1e-9);
  EXPECT_EQ(filter->GetPeakHeightVariation(), expected.PeakHeightVariation);
  EXPECT_EQ(filter->GetNumberOfMergedPeaks(), 0);
  EXPECT_EQ(filter->GetMergedShare(), 0.0);
  EXPECT_EQ(filter->GetWallLength(), expected.WallLength);
  EXPECT_EQ(filter->GetWallDensity(), expected.WallDensity);
  EXPECT_EQ(filter->GetRelativeWallDensity(), expected.RelativeWallDensity);
  EXPECT_EQ(Value(filter, "WallHeight"), expected.WallHeight);
  EXPECT_EQ(Value(filter, "Area"), expected.Area);
  EXPECT_EQ(Value(filter, "HeightDeviation"), expected.HeightDeviation);
  EXPECT_EQ(Value(filter, "BaseLevel"), expected.BaseLevel);
  EXPECT_EQ(Value(filter, "UnitLength"), 0.3);
  EXPECT_EQ(Value(filter, "MinimumProminence"), 0.01);
  EXPECT_EQ(vtkTable::SafeDownCast(filter->GetOutputDataObject(1))->GetNumberOfColumns(), 17);
}

TEST(GeometricTextureFeaturesFilter, ArraysShowThePeaks)
{
  const auto filter = Measured(Waves(0.1).ToPolyData(VTK_FLOAT), Waves(0.0).ToPolyData(VTK_FLOAT));
  auto* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  vtkDataArray *height = PointArray(output, "Height"), *prominence = PointArray(output, "Prominence"),
               *peak = PointArray(output, "Peak"), *region = PointArray(output, "Region");
  ASSERT_TRUE(height && prominence && peak && region);
  EXPECT_EQ(output->GetPointData()->GetScalars(), height);
  int peaks = 0;
  for (vtkIdType v = 0; v < output->GetNumberOfPoints(); ++v)
  {
    EXPECT_NEAR(height->GetTuple1(v), output->GetPoint(v)[2], 1e-7);
    EXPECT_EQ(peak->GetTuple1(v) > 0.0, prominence->GetTuple1(v) > 0.0);
    peaks += peak->GetTuple1(v) > 0.0 ? 1 : 0;
    EXPECT_GE(region->GetTuple1(v), 0.0);
    EXPECT_LT(region->GetTuple1(v), 9.0);
  }
  EXPECT_EQ(peaks, 9);
}

TEST(GeometricTextureFeaturesFilter, NeedsNoBareSurface)
{
  const auto filter = Measured(Waves(0.1).ToPolyData());
  EXPECT_EQ(filter->GetNumberOfPeaks(), 9);
  const double height = 0.85 / 9.0, part = filter->GetMeanPeakHeight();
  EXPECT_GT(part, 0.5 * height) << "a tenth of the side is short for waves of a third";
  EXPECT_LT(part, height);
  filter->SetSmoothingLength(1.0);
  OutputOf(filter);
  EXPECT_NEAR(filter->GetMeanPeakHeight(), height, 0.1 * height);
  filter->SetSmoothingLength(0.02);
  OutputOf(filter);
  EXPECT_LT(filter->GetMeanPeakHeight(), 0.03) << "waves of a third of the side are shape";
}

TEST(GeometricTextureFeaturesFilter, PolygonsAreCutAlikeOnBothSurfaces)
{
  // Cells of four corners, which ear cutting would cut as the relief has it.
  const auto filter = Measured(Waves(0.3, 4).ToPolyData(), Waves(0.0, 4).ToPolyData());
  EXPECT_EQ(filter->GetNumberOfPeaks(), 9);
  EXPECT_EQ(filter->GetOutput()->GetNumberOfCells(), 48 * 48);
}

#ifdef SURFACE_SYNTHESIS_CGAL
TEST(GeometricTextureFeaturesFilter, IntersectionsArePairsOfTriangles)
{
  // Two triangles upright in a third one.
  Soup soup;
  for (const double x : { -9.0, 9.0 })
  {
    soup.AddPoint(x, -9.0, 0.0);
  }
  soup.AddPoint(0.0, 9.0, 0.0);
  soup.Polys.push_back({ 0, 1, 2 });
  for (const double x : { -1.0, 1.0 })
  {
    const vtkIdType first = soup.AddPoint(x, -1.0, -1.0);
    soup.AddPoint(x, 1.0, -1.0);
    soup.AddPoint(x, 0.0, 1.0);
    soup.Polys.push_back({ first, first + 1, first + 2 });
  }
  const auto surface = soup.ToPolyData();
  const auto filter = Measured(surface, surface);
  EXPECT_EQ(filter->GetNumberOfSelfIntersections(), 2);
  EXPECT_EQ(Value(filter, "NumberOfSelfIntersections"), 2.0);
  EXPECT_EQ(CellArray(filter, "SelfIntersections")->GetTuple1(0), 2.0);
  EXPECT_EQ(CellArray(filter, "SelfIntersections")->GetTuple1(1), 1.0);
  EXPECT_EQ(Measured(Waves(0.1).ToPolyData())->GetNumberOfSelfIntersections(), 0);
}
#endif

TEST(GeometricTextureFeaturesFilter, Messages)
{
  vtkNew<vtkPolyData> nothing;
  const auto waves = Waves(0.1).ToPolyData();
  EXPECT_THAT(RefusalOf(waves, nothing), HasSubstr("The bare surface on port 1 is empty"));
  EXPECT_THAT(RefusalOf(waves, Icosphere(1).ToPolyData()),
    HasSubstr("the bare surface has 42 points and 80 triangles; expected those of the surface, 2401 points"));
  Soup turned = Waves(0.0);
  std::rotate(turned.Polys.begin(), turned.Polys.begin() + 1, turned.Polys.end());
  EXPECT_THAT(RefusalOf(waves, turned.ToPolyData()), HasSubstr("other triangles"));
  Soup lines;
  lines.AddPoint(0.0, 0.0, 0.0);
  lines.AddPoint(1.0, 0.0, 0.0);
  lines.Lines.push_back({ 0, 1 });
  EXPECT_THAT(RefusalOf(lines.ToPolyData()), HasSubstr("The surface on port 0: "));
  for (const int port : { 0, 1 })
  {
    const auto broken = Waves(0.1).ToPolyData();
    broken->GetPoints()->SetPoint(77, 0.5, 0.5, std::numeric_limits<double>::quiet_NaN());
    const std::string text = port == 0 ? RefusalOf(broken, waves) : RefusalOf(waves, broken);
    EXPECT_THAT(text, HasSubstr(port == 0 ? "The surface on port 0: " : "The bare surface on port 1: "));
    EXPECT_THAT(text, HasSubstr("77"));
  }
}

TEST(GeometricTextureFeaturesFilter, AnEmptySurfaceGivesEmptyOutputs)
{
  vtkNew<vtkPolyData> nothing;
  const auto filter = Measured(nothing, Waves(0.0).ToPolyData());
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(vtkTable::SafeDownCast(filter->GetOutputDataObject(1))->GetNumberOfRows(), 0);
}

TEST(GeometricTextureFeaturesFilter, SameBitsForAllNumbersOfThreads)
{
  const auto surface = Waves(0.1).ToPolyData();
  ExpectSameBitsForAllThreads([&] { return Filter(surface); },
    [](vtkAlgorithm* filter) { return PointArray(filter->GetOutputDataObject(0), "Height"); });
}

TEST(GeometricTextureFeaturesFilter, CanBeStopped)
{
  const auto surface = RingSphere(300, 300);
  const auto filter = Filter(surface);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.3;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_GT(filter->GetOutput()->GetNumberOfPoints(), 0);
}

TEST(GeometricTextureFeaturesFilter, EachPropertyRunsItOnceIsClampedAndPrinted)
{
  const auto filter = Filter(Waves(0.1).ToPolyData());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  using Features = vtkGeometricTextureFeatures;
  const PropertyChanges<Features> changes = {
    { "UnitLength", [](Features* f) { f->SetUnitLength(0.5); } },
    { "MinimumProminence", [](Features* f) { f->SetMinimumProminence(0.01); } },
    { "MergedSaddle", [](Features* f) { f->SetMergedSaddle(0.6); } },
    { "WallLevel", [](Features* f) { f->SetWallLevel(0.5); } },
    { "SmoothingLength", [](Features* f) { f->SetSmoothingLength(0.2); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "UnitLength: 0.5", "MinimumProminence: 0.01", "MergedSaddle: 0.6", "WallLevel: 0.5",
         "SmoothingLength: 0.2", "NumberOfPeaks: 9", "MergedShare: 0", "NumberOfSelfIntersections: " })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
  filter->SetUnitLength(-1.0);
  EXPECT_EQ(filter->GetUnitLength(), 0.0);
  filter->SetMinimumProminence(-1.0);
  EXPECT_EQ(filter->GetMinimumProminence(), 0.0);
  filter->SetMergedSaddle(2.0);
  EXPECT_EQ(filter->GetMergedSaddle(), 1.0);
  filter->SetWallLevel(2.0);
  EXPECT_EQ(filter->GetWallLevel(), 1.0);
  filter->SetSmoothingLength(-1.0);
  EXPECT_EQ(filter->GetSmoothingLength(), 0.0);
}

namespace
{
class MalformedFeatures : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }

/// R1, R2 and R6 for one of the ports, the other one having a valid surface.
void CheckPort(const MalformedCase& malformed, int port)
{
  const vtkSmartPointer<vtkDataObject> data = malformed.Make();
  const vtkSmartPointer<vtkDataObject> valid = Icosphere(2).ToPolyData();
  const auto filter = port == 0 ? Filter(data) : Filter(valid, data);
  EventRecorder events(filter);
  const std::uint64_t before = HashOf(data);
  const double start = Now();
  const bool succeeded = Update(filter);
  EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
  EXPECT_EQ(HashOf(data), before) << "R6: the input was modified";
  auto* table = vtkTable::SafeDownCast(filter->GetOutputDataObject(1));
  if (!vtkPolyData::SafeDownCast(data) || !table)
  {
    return; // a composite: blocks, or VTK's own refusal of it as the bare surface
  }
  EXPECT_EQ(succeeded, events.Errors.empty());
  EXPECT_LE(events.Errors.size(), 1u);
  const bool isEmpty = malformed.Expected == Expectation::Empty;
  EXPECT_EQ(table->GetNumberOfRows(), succeeded && !(isEmpty && port == 0) ? 1 : 0);
  if (malformed.Expected == Expectation::Error || (isEmpty && port == 1))
  {
    EXPECT_FALSE(succeeded);
  }
  for (vtkIdType column = 0; table->GetNumberOfRows() > 0 && column < table->GetNumberOfColumns(); ++column)
  {
    EXPECT_TRUE(std::isfinite(table->GetValue(0, column).ToDouble())) << table->GetColumnName(column);
  }
}
} // namespace

TEST_P(MalformedFeatures, AsTheSurface) { CheckPort(GetParam(), 0); }

TEST_P(MalformedFeatures, AsTheBareSurface) { CheckPort(GetParam(), 1); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedFeatures, ::testing::ValuesIn(MalformedCorpus()), NameOf);
