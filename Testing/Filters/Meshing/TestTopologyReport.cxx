// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"
#include "MalformedCorpus.h"
#include "VtkSurfaces.h"

#include "SurfaceBridge.h"
#include "vtkTopologyReport.h"

#include <vtkDoubleArray.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>
#include <vtkTable.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>
#include <thread>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
vtkSmartPointer<vtkTopologyReport> ReportOn(vtkDataObject* input)
{
  auto report = vtkSmartPointer<vtkTopologyReport>::New();
  report->SetInputDataObject(input);
  EventRecorder events(report);
  EXPECT_TRUE(Update(report));
  EXPECT_THAT(events.Errors, IsEmpty());
  return report;
}

struct Row
{
  int Block, Component;
  double Value;
  vtkIdType First;
  std::string Remark;
};

/// The only row of the property of the whole surface.
Row RowOf(vtkTable* table, const std::string& property, int block = 0)
{
  auto* names = vtkStringArray::SafeDownCast(table->GetColumnByName("Property"));
  std::vector<Row> rows;
  for (vtkIdType k = 0; k < table->GetNumberOfRows(); ++k)
  {
    const Row row{ table->GetValueByName(k, "Block").ToInt(), table->GetValueByName(k, "Component").ToInt(),
      table->GetValueByName(k, "Value").ToDouble(), table->GetValueByName(k, "First").ToTypeInt64(),
      table->GetValueByName(k, "Remark").ToString() };
    if (names->GetValue(k) == property && row.Block == block && row.Component == -1)
    {
      rows.push_back(row);
    }
  }
  EXPECT_EQ(rows.size(), 1u) << property;
  return rows.empty() ? Row{ -1, -1, std::nan(""), -1, "" } : rows[0];
}

void ExpectWellFormed(vtkTable* table)
{
  auto* values = vtkDoubleArray::SafeDownCast(table->GetColumnByName("Value"));
  auto* first = vtkIdTypeArray::SafeDownCast(table->GetColumnByName("First"));
  ASSERT_TRUE(values && first);
  ASSERT_TRUE(vtkIntArray::SafeDownCast(table->GetColumnByName("Block")));
  ASSERT_TRUE(vtkIntArray::SafeDownCast(table->GetColumnByName("Component")));
  ASSERT_TRUE(vtkStringArray::SafeDownCast(table->GetColumnByName("Property")));
  ASSERT_TRUE(vtkStringArray::SafeDownCast(table->GetColumnByName("Remark")));
  EXPECT_EQ(table->GetNumberOfColumns(), 6);
  std::set<std::string> seen;
  for (vtkIdType k = 0; k < table->GetNumberOfRows(); ++k)
  {
    EXPECT_TRUE(std::isfinite(values->GetValue(k))) << table->GetValueByName(k, "Property").ToString();
    EXPECT_GE(first->GetValue(k), -1);
    std::ostringstream key;
    key << table->GetValueByName(k, "Block").ToInt() << " " << table->GetValueByName(k, "Component").ToInt() << " "
        << table->GetValueByName(k, "Property").ToString();
    EXPECT_TRUE(seen.insert(key.str()).second) << key.str();
  }
}

/// True when the gate of the remesher accepts the surface.
bool PassesTheGate(vtkPolyData* input)
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  try
  {
    surfsynth::ToSurface(input, requirements);
    return true;
  }
  catch (const std::exception&)
  {
    return false;
  }
}

class ReportOfMalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

INSTANTIATE_TEST_SUITE_P(Corpus, ReportOfMalformedInput, ::testing::ValuesIn(MalformedCorpus()),
  [](const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; });
} // namespace

TEST_P(ReportOfMalformedInput, IsATableAndValidMeansWhatTheGateSays)
{
  const auto input = GetParam().Make();
  auto* surface = vtkPolyData::SafeDownCast(input);
  const bool isSurface = surface || vtkUnstructuredGrid::SafeDownCast(input) ||
    vtkMultiBlockDataSet::SafeDownCast(input);
  const std::uint64_t before = HashOf(input);
  vtkNew<vtkTopologyReport> report;
  report->SetInputDataObject(input);
  EventRecorder events(report);
  const double start = Now();
  const bool updated = Update(report);
  EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
  EXPECT_EQ(HashOf(input), before) << "R6";
  if (!isSurface)
  {
    EXPECT_FALSE(updated);
    EXPECT_EQ(events.Errors.size(), 1u);
    return;
  }
  EXPECT_TRUE(updated);
  EXPECT_EQ(events.Errors.size(), GetParam().Name == "CompositeWithTable" ? 1u : 0u) << events.AllErrors();
  vtkTable* table = report->GetOutput();
  if (table->GetNumberOfRows() > 0)
  {
    ExpectWellFormed(table);
  }
  if (surface && (surface->GetNumberOfPoints() > 0 || surface->GetNumberOfCells() > 0))
  {
    const bool isValid = PassesTheGate(surface) && report->GetValue("DuplicateTriangles") == 0.0 &&
      report->GetValue("IntersectingTriangles") == 0.0;
    EXPECT_EQ(report->GetValue("Valid") == 1.0, isValid);
    EXPECT_EQ(report->GetValid(), isValid);
  }
}

TEST(TopologyReport, SphereByTheTable)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto report = ReportOn(sphere);
  vtkTable* table = report->GetOutput();
  ExpectWellFormed(table);
  EXPECT_EQ(RowOf(table, "Valid").Value, 1.0);
  EXPECT_EQ(RowOf(table, "Points").Value, 642);
  EXPECT_EQ(RowOf(table, "TriangleCells").Value, 1280);
  EXPECT_EQ(RowOf(table, "Genus").Value, 0);
  EXPECT_EQ(RowOf(table, "EulerCharacteristic").Value, 2);
  EXPECT_EQ(RowOf(table, "Closed").Remark, "yes");
  EXPECT_NEAR(RowOf(table, "Volume").Value, 4.15274, 1e-4);
  EXPECT_LT(RowOf(table, "XMinimum").Value, -0.9);
  EXPECT_EQ(RowOf(table, "BoundaryEdges").Value, 0);
  EXPECT_EQ(RowOf(table, "BoundaryEdges").First, -1);
  EXPECT_EQ(RowOf(table, "BoundaryEdges").Remark, "");
  EXPECT_EQ(report->GetValue("Points"), 642);
  EXPECT_TRUE(report->GetValid());
}

TEST(TopologyReport, FormerNamesAnswer)
{
  const auto report = ReportOn(Icosphere(1).ToPolyData());
  EXPECT_EQ(report->GetValue("Sound"), 1.0);
  EXPECT_TRUE(report->HasValue("Sound"));
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  EXPECT_TRUE(report->GetSound());
#pragma GCC diagnostic pop
}

TEST(TopologyReport, EachDefectHasItsCountFirstIdAndRepair)
{
  Soup soup = Icosphere(2);
  const vtkIdType cells = static_cast<vtkIdType>(soup.Polys.size());
  soup.Lines = { { 0, 1 } }; // cell 0, so that polygons are cells from 1 on
  soup.Polys.push_back({ 0, 1, 5000 });
  soup.Polys.push_back({ 3, 3, 4 });
  soup.Polys.push_back({ 1, 2 });
  soup.Polys.push_back({ 0, 1, 1, 2 });
  soup.Polys.push_back(soup.Polys[7]);
  const vtkIdType a = soup.AddPoint(5, 0, 0);
  soup.AddPoint(6, 0, 0);
  soup.AddPoint(7, 0, 0);
  soup.Polys.push_back({ a, a + 1, a + 2 });
  soup.AddPoint(9, 9, 9);
  const auto report = ReportOn(soup.ToPolyData());
  vtkTable* table = report->GetOutput();
  const auto expect = [&](const std::string& property, double count, vtkIdType first, const std::string& repair) {
    const Row row = RowOf(table, property);
    EXPECT_EQ(row.Value, count) << property;
    EXPECT_EQ(row.First, first) << property;
    EXPECT_THAT(row.Remark, HasSubstr(repair)) << property;
  };
  expect("CellsWithMissingPoints", 1, cells + 1, "write it again");
  expect("CellsWithRepeatedPoints", 2, cells + 2, "vtkCleanPolyData");
  expect("CellsWithTooFewPoints", 1, cells + 3, "vtkCleanPolyData");
  expect("DuplicateTriangles", 1, cells + 5, "vtkCleanPolyData");
  expect("DegenerateTriangles", 1, cells + 6, "vtkCleanPolyData");
  expect("UnreferencedPoints", 1, a + 3, "vtkCleanPolyData");
  EXPECT_EQ(RowOf(table, "NonManifoldEdges").Value, 3);
  EXPECT_EQ(RowOf(table, "Valid").Value, 0);
  EXPECT_FALSE(report->GetValid());
  EXPECT_THAT(RowOf(table, "Triangles").Remark, HasSubstr("broken cells are left out"));
}

#ifdef SURFACE_SYNTHESIS_CGAL
/// A unit square in x and y at height @p z, of two triangles.
void AddSquare(Soup& soup, double z)
{
  const vtkIdType first = soup.AddPoint(0, 0, z);
  soup.AddPoint(1, 0, z);
  soup.AddPoint(1, 1, z);
  soup.AddPoint(0, 1, z);
  soup.Polys.push_back({ first, first + 1, first + 2 });
  soup.Polys.push_back({ first, first + 2, first + 3 });
}

TEST(TopologyReport, TrianglesThatIntersectAreCountedAndNotValid)
{
  Soup soup;
  AddSquare(soup, 0.0);
  AddSquare(soup, 1.0);
  EXPECT_EQ(ReportOn(soup.ToPolyData())->GetValue("IntersectingTriangles"), 0);
  EXPECT_TRUE(ReportOn(soup.ToPolyData())->GetValid());
  const vtkIdType first = soup.AddPoint(0.9, 0.1, 0.5); // through the first triangle of the upper square
  soup.AddPoint(0.8, 0.1, 1.5);
  soup.AddPoint(0.8, 0.15, 1.5);
  soup.Polys.push_back({ first, first + 1, first + 2 });
  const auto report = ReportOn(soup.ToPolyData());
  const Row row = RowOf(report->GetOutput(), "IntersectingTriangles");
  EXPECT_EQ(row.Value, 2);
  EXPECT_EQ(row.First, 2);
  EXPECT_THAT(row.Remark, HasSubstr("RemoveSelfIntersectionsOn()"));
  EXPECT_FALSE(report->GetValid());
}
#endif

TEST(TopologyReport, PointsOfEqualCoordinatesAreOneWhereTrianglesTouch)
{
  Soup soup = Icosphere(1);
  Soup torn;
  for (const auto& cell : soup.Polys)
  {
    std::vector<vtkIdType> ids;
    for (const vtkIdType id : cell)
    {
      ids.push_back(torn.AddPoint(soup.Points[3 * id], soup.Points[3 * id + 1], soup.Points[3 * id + 2]));
    }
    torn.Polys.emplace_back(ids.begin(), ids.end());
  }
  EXPECT_EQ(ReportOn(torn.ToPolyData())->GetValue("IntersectingTriangles"), 0);
}

TEST(TopologyReport, NeedlesAreCountedAndValid)
{
  Soup soup;
  soup.AddPoint(0, 0, 0);
  soup.AddPoint(100, 0, 0);
  soup.AddPoint(50, 0.5, 0);
  soup.Polys.push_back({ 0, 1, 2 });
  const auto report = ReportOn(soup.ToPolyData());
  EXPECT_EQ(RowOf(report->GetOutput(), "NeedleTriangles").Value, 1);
  EXPECT_EQ(RowOf(report->GetOutput(), "NeedleTriangles").First, 0);
  EXPECT_TRUE(report->GetValid());
}

TEST(TopologyReport, BrokenVerticesAndLinesDoNotMakeASurfaceInvalid)
{
  Soup soup = Icosphere(1);
  soup.Verts = { { -3 } };
  soup.Lines = { { 0, 99999 } };
  const auto report = ReportOn(soup.ToPolyData());
  EXPECT_EQ(report->GetValue("BrokenVerticesAndLines"), 2);
  EXPECT_EQ(report->GetValue("VertexCells"), 1);
  EXPECT_TRUE(report->GetValid());
}

TEST(TopologyReport, QuadsAndStripsCountAsTheirTriangles)
{
  Soup soup = Grid(4, 4);
  const vtkIdType first = soup.NumberOfPoints();
  for (int k = 0; k < 5; ++k)
  {
    soup.AddPoint(3.0 + k, k % 2, 0.0);
  }
  soup.Strips = { { first, first + 1, first + 2, first + 3, first + 4 } };
  const auto report = ReportOn(soup.ToPolyData());
  EXPECT_EQ(report->GetValue("QuadCells"), 16);
  EXPECT_EQ(report->GetValue("StripCells"), 1);
  EXPECT_EQ(report->GetValue("Triangles"), 35);
  EXPECT_EQ(report->GetValue("Components"), 2);
  EXPECT_EQ(report->GetValue("BoundaryLoops"), 2);
}

TEST(TopologyReport, WhatASurfaceDoesNotHaveHasNoRow)
{
  const auto grid = ReportOn(Grid(4).ToPolyData());
  EXPECT_FALSE(grid->HasValue("Volume"));
  EXPECT_EQ(grid->GetValue("Volume"), 0.0);
  EXPECT_TRUE(grid->HasValue("Genus"));
  EXPECT_FALSE(grid->HasValue("Nonesuch"));
  EXPECT_FALSE(grid->HasValue(nullptr));
  EXPECT_FALSE(grid->HasValue("Points", 7));
}

TEST(TopologyReport, ComponentsHaveRowsOfTheirOwnTheLargestFirst)
{
  Soup soup = Icosphere(1);
  const Soup other = Icosphere(2);
  for (std::size_t k = 0; k < other.Points.size(); k += 3)
  {
    soup.AddPoint(other.Points[k] + 4.0, other.Points[k + 1], other.Points[k + 2]);
  }
  for (auto cell : other.Polys)
  {
    for (vtkIdType& id : cell)
    {
      id += 42;
    }
    soup.Polys.push_back(cell);
  }
  const auto report = ReportOn(soup.ToPolyData());
  EXPECT_EQ(report->GetValue("Components"), 2);
  EXPECT_EQ(report->GetValue("Triangles", 0, 0), 80);
  EXPECT_EQ(report->GetValue("Triangles", 0, 1), 320);
  EXPECT_NEAR(report->GetValue("Volume"), report->GetValue("Volume", 0, 0) + report->GetValue("Volume", 0, 1), 1e-12);
  vtkTable* table = report->GetOutput();
  vtkIdType firstComponentRow = 0;
  while (table->GetValueByName(firstComponentRow, "Component").ToInt() < 0)
  {
    ++firstComponentRow;
  }
  EXPECT_EQ(table->GetValueByName(firstComponentRow, "Component").ToInt(), 1) << "the larger one first";
  report->SetNumberOfComponentRows(1);
  ASSERT_TRUE(Update(report));
  EXPECT_FALSE(report->HasValue("Triangles", 0, 0));
  EXPECT_TRUE(report->HasValue("Triangles", 0, 1));
}

TEST(TopologyReport, BlocksHaveRowsUnderTheirFlatIndex)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(2, Grid(3).ToPolyData());
  const auto report = ReportOn(blocks);
  EXPECT_EQ(report->GetValue("Closed", 1), 1);
  EXPECT_EQ(report->GetValue("Closed", 3), 0);
  EXPECT_FALSE(report->HasValue("Closed", 0));
  EXPECT_FALSE(report->HasValue("Closed", 2));
  EXPECT_TRUE(report->GetValid());
  ExpectWellFormed(report->GetOutput());
}

TEST(TopologyReport, ABlockOfAnotherTypeIsAnErrorAndTheOthersStay)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkStructuredGrid> grid;
  blocks->SetBlock(0, grid);
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  vtkNew<vtkTopologyReport> report;
  report->SetInputDataObject(blocks);
  EventRecorder events(report);
  EXPECT_TRUE(Update(report));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], HasSubstr("Block 1: "));
  EXPECT_THAT(events.Errors[0], HasSubstr("vtkDataSetSurfaceFilter"));
  EXPECT_TRUE(report->HasValue("Closed", 2));
}

TEST(TopologyReport, EmptyAndAbsentInput)
{
  vtkNew<vtkPolyData> empty;
  const auto report = ReportOn(empty);
  EXPECT_EQ(report->GetOutput()->GetNumberOfRows(), 0);
  EXPECT_FALSE(report->GetValid());
  vtkNew<vtkTopologyReport> absent;
  EventRecorder events(absent);
  EXPECT_FALSE(Update(absent));
  EXPECT_FALSE(events.Errors.empty());
}

TEST(TopologyReport, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto report = ReportOn(Icosphere(1).ToPolyData());
  EventRecorder events(report);
  EXPECT_TRUE(Update(report));
  EXPECT_EQ(events.Executions, 0);
  report->SetNumberOfComponentRows(3);
  EXPECT_TRUE(Update(report));
  EXPECT_EQ(events.Executions, 1);
  report->SetNumberOfComponentRows(3);
  EXPECT_TRUE(Update(report));
  EXPECT_EQ(events.Executions, 1);
  report->SetNumberOfComponentRows(-3);
  EXPECT_EQ(report->GetNumberOfComponentRows(), 0);
}

TEST(TopologyReport, AnAbortLeavesAnEmptyTableAndTheNextUpdateIsComplete)
{
  vtkNew<vtkTopologyReport> report;
  report->SetInputDataObject(RingSphere(200, 200));
  {
    EventRecorder events(report);
    events.AbortAt = 0.3;
    EXPECT_TRUE(Update(report)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
  }
  EXPECT_EQ(report->GetOutput()->GetNumberOfRows(), 0);
  EXPECT_FALSE(report->GetValid());
  EventRecorder events(report);
  EXPECT_TRUE(Update(report));
  EXPECT_EQ(events.Executions, 1);
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end())) << "R10";
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_EQ(report->GetValue("Genus"), 0);
}

TEST(TopologyReport, FloatPointsGiveTheSameTopology)
{
  const auto single = ReportOn(Icosphere(2).ToPolyData(VTK_FLOAT));
  const auto both = ReportOn(Icosphere(2).ToPolyData());
  EXPECT_EQ(single->GetValue("Genus"), both->GetValue("Genus"));
  EXPECT_NEAR(single->GetValue("Area"), both->GetValue("Area"), 1e-5);
}

TEST(TopologyReport, TwoReportsOnTwoThreads)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto work = [&] {
    vtkNew<vtkPolyData> mine;
    mine->DeepCopy(sphere);
    const auto report = ReportOn(mine);
    EXPECT_EQ(report->GetValue("Edges"), 1920);
  };
  std::thread other(work);
  work();
  other.join();
}

TEST(TopologyReport, PrintsItsProperties)
{
  std::ostringstream text;
  vtkNew<vtkTopologyReport> report;
  report->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("NumberOfComponentRows: 10"));
}
