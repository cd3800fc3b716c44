// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGeometricTextureDistance: the numbers of the plain comparison, its ports, messages, broken surfaces, abort.
#include "FilterChecks.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "vtkGeometricTextureDistance.h"

#include "Core/Statistics/GeometricTextureDistance.h"
#include "SurfaceBridge.h"

#include <vtkIdTypeArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkTable.h>
#include <vtkVariant.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace
{
/// A ball that is longer along x.
Soup Egg()
{
  Soup soup = Icosphere(2);
  for (std::size_t k = 0; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] *= 3.0;
  }
  return soup;
}

vtkSmartPointer<vtkGeometricTextureDistance> Comparing(vtkDataObject* surface, vtkDataObject* reference)
{
  auto filter = vtkSmartPointer<vtkGeometricTextureDistance>::New();
  filter->SetInputDataObject(0, surface);
  filter->SetInputDataObject(1, reference);
  return filter;
}

double ValueOf(vtkDataObject* table, const char* column)
{
  return vtkTable::SafeDownCast(table)->GetValueByName(0, column).ToDouble();
}

std::string ErrorOf(vtkDataObject* surface, vtkDataObject* reference)
{
  const auto filter = Comparing(surface, reference);
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_THAT(events.Errors, SizeIs(1));
  EXPECT_EQ(filter->GetOutput()->GetNumberOfRows(), 0);
  EXPECT_EQ(filter->GetDistance(), 0.0);
  return events.AllErrors();
}
} // namespace

TEST(GeometricTextureDistance, TheRowIsThatOfThePlainComparison)
{
  const auto surface = Egg().ToPolyData(VTK_FLOAT);
  const auto reference = Grid(12, 4).ToPolyData();
  const std::uint64_t before = HashOf(surface) + HashOf(reference);
  const auto filter = Comparing(surface, reference);
  filter->SetUnitLength(0.5);
  filter->SetReferenceUnitLength(0.1);
  filter->SetNumberOfProjections(30);
  filter->SetSeed(-7);
  const auto table = OutputOf(filter);
  EXPECT_EQ(HashOf(surface) + HashOf(reference), before);
  const surfsynth::TextureDistance expected = surfsynth::CompareGeometricTextures(
    surfsynth::ConvertSurface(surface).Mesh, surfsynth::ConvertSurface(reference).Mesh,
    { 0.5, 0.1, 30, static_cast<std::uint64_t>(-7) });
  EXPECT_GT(expected.Distance, 0.01);
  EXPECT_EQ(ValueOf(table, "Distance"), expected.Distance);
  EXPECT_EQ(filter->GetDistance(), expected.Distance);
  EXPECT_EQ(ValueOf(table, "StandardError"), expected.StandardError);
  EXPECT_EQ(filter->GetStandardError(), expected.StandardError);
  EXPECT_EQ(ValueOf(table, "MeanEdgeLength"), expected.MeanEdgeLength);
  EXPECT_EQ(ValueOf(table, "ReferenceMeanEdgeLength"), expected.ReferenceMeanEdgeLength);
  EXPECT_EQ(ValueOf(table, "NumberOfTriangles"), 320.0);
  EXPECT_EQ(ValueOf(table, "NumberOfReferenceTriangles"), 2.0 * 12 * 12);
  EXPECT_EQ(vtkTable::SafeDownCast(table)->GetNumberOfColumns(), 6);
}

TEST(GeometricTextureDistance, RingsAreThoseOfThePlainComparison)
{
  const auto surface = Egg().ToPolyData(), reference = Icosphere(2).ToPolyData();
  const auto filter = Comparing(surface, reference);
  filter->SetNumberOfRings(3);
  surfsynth::GeometricTextureDistanceOptions options;
  options.Rings = 3;
  const surfsynth::TextureDistance expected = surfsynth::CompareGeometricTextures(
    surfsynth::ConvertSurface(surface).Mesh, surfsynth::ConvertSurface(reference).Mesh, options);
  EXPECT_EQ(ValueOf(OutputOf(filter), "Distance"), expected.Distance);
  EXPECT_GT(expected.Distance, 0.01);
}

TEST(GeometricTextureDistance, BlocksOfTheSurfaceHaveATableEach)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Egg().ToPolyData());
  blocks->SetBlock(1, Icosphere(2).ToPolyData());
  const auto filter = Comparing(blocks, Icosphere(2).ToPolyData());
  auto* tables = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(tables && tables->GetNumberOfBlocks() == 2);
  const auto alone = OutputOf(Comparing(Egg().ToPolyData(), Icosphere(2).ToPolyData()));
  EXPECT_EQ(ValueOf(tables->GetBlock(0), "Distance"), ValueOf(alone, "Distance"));
  EXPECT_EQ(ValueOf(tables->GetBlock(1), "Distance"), 0.0);
}

TEST(GeometricTextureDistance, Messages)
{
  vtkNew<vtkPolyData> nothing;
  const auto ball = Icosphere(1).ToPolyData();
  EXPECT_THAT(ErrorOf(nothing, ball), HasSubstr("The surface on port 0 is empty"));
  EXPECT_THAT(ErrorOf(ball, nothing), HasSubstr("The reference on port 1 is empty"));
  Soup needle = Icosphere(1);
  needle.Polys[5] = { 0, 0, 1 };
  EXPECT_THAT(
    ErrorOf(needle.ToPolyData(), ball), AllOf(HasSubstr("The surface on port 0: "), HasSubstr("first cell 5")));
  EXPECT_THAT(ErrorOf(ball, needle.ToPolyData()), HasSubstr("The reference on port 1: "));
  Soup turned = Icosphere(1);
  std::swap(turned.Polys[7][0], turned.Polys[7][1]);
  EXPECT_THAT(ErrorOf(ball, turned.ToPolyData()), HasSubstr("3 edge(s)"));
  const auto filter = Comparing(ball, ball);
  filter->SetUnitLength(std::nan(""));
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_THAT(events.AllErrors(), HasSubstr("the unit length of the surface is nan"));
}

TEST(GeometricTextureDistance, TwoEmptySurfacesGiveAnEmptyTable)
{
  vtkNew<vtkPolyData> nothing;
  const auto filter = Comparing(nothing, nothing);
  EXPECT_EQ(vtkTable::SafeDownCast(OutputOf(filter))->GetNumberOfRows(), 0);
  EXPECT_EQ(filter->GetDistance(), 0.0);
}

TEST(GeometricTextureDistance, RunsOnceForEachChangeAndCanBeStopped)
{
  const auto filter = Comparing(RingSphere(60, 60), RingSphere(50, 70));
  {
    EventRecorder events(filter);
    ASSERT_TRUE(Update(filter));
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_GE(events.Progress.size(), 20u);
    EXPECT_EQ(events.Progress.back(), 1.0);
    EXPECT_FALSE(events.ForeignThread);
    filter->SetSeed(0);
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(events.Executions, 1) << "nothing has changed";
  }
  const double distance = filter->GetDistance();
  filter->SetNumberOfProjections(100000);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.101;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
    EXPECT_EQ(filter->GetOutput()->GetNumberOfRows(), 0);
  }
  filter->SetNumberOfProjections(128);
  OutputOf(filter);
  EXPECT_EQ(filter->GetDistance(), distance);
}

TEST(GeometricTextureDistance, PropertiesAreClampedAndPrinted)
{
  vtkNew<vtkGeometricTextureDistance> filter;
  filter->SetUnitLength(-1.0);
  EXPECT_EQ(filter->GetUnitLength(), 0.0);
  filter->SetReferenceUnitLength(-1.0);
  EXPECT_EQ(filter->GetReferenceUnitLength(), 0.0);
  filter->SetNumberOfProjections(0);
  EXPECT_EQ(filter->GetNumberOfProjections(), 1);
  filter->SetNumberOfRings(17);
  EXPECT_EQ(filter->GetNumberOfRings(), 16);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "UnitLength: 0", "NumberOfRings: 16", "ReferenceUnitLength: 0", "NumberOfProjections: 1\n",
         "Seed: 0", "Distance: 0", "StandardError: 0" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}

namespace
{
class MalformedGeometricTexture : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }

/// R1, R2 and R6 for one of the ports, the other one having a valid surface.
void CheckPort(const MalformedCase& malformed, int port)
{
  const vtkSmartPointer<vtkDataObject> data = malformed.Make();
  const vtkSmartPointer<vtkDataObject> sound = Icosphere(2).ToPolyData();
  const auto filter = port == 0 ? Comparing(data, sound) : Comparing(sound, data);
  EventRecorder events(filter);
  const std::uint64_t before = HashOf(data);
  const double start = Now();
  const bool succeeded = Update(filter);
  EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
  EXPECT_EQ(HashOf(data), before) << "R6: the input was modified";
  auto* table = vtkTable::SafeDownCast(filter->GetOutputDataObject(0));
  if (!vtkPolyData::SafeDownCast(data) || !table)
  {
    return; // a composite: a table for each block, or VTK's own refusal of it as the reference
  }
  EXPECT_EQ(succeeded, events.Errors.empty());
  EXPECT_EQ(table->GetNumberOfRows(), succeeded ? 1 : 0);
  EXPECT_LE(events.Errors.size(), 1u);
  if (malformed.Expected == Expectation::Error || malformed.Expected == Expectation::Empty)
  {
    EXPECT_FALSE(succeeded); // an empty surface beside one that is not cannot be compared
  }
  if (succeeded)
  {
    EXPECT_TRUE(std::isfinite(ValueOf(table, "Distance")));
    EXPECT_TRUE(std::isfinite(ValueOf(table, "StandardError")));
  }
}
} // namespace

TEST_P(MalformedGeometricTexture, AsTheSurface) { CheckPort(GetParam(), 0); }

TEST_P(MalformedGeometricTexture, AsTheReference) { CheckPort(GetParam(), 1); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedGeometricTexture, ::testing::ValuesIn(MalformedCorpus()), NameOf);
