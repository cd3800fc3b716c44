// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkTextureAtlasFilter: texture coordinates, doubled points, cells, attributes.
#include "SurfaceChecks.h"

#include "vtkTextureAtlasFilter.h"

#include "Core/Atlas/AtlasRaster.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>

#include <Eigen/Core>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

using namespace surfsynthtest;
using Atlas = vtkTextureAtlasFilter;

namespace
{
vtkSmartPointer<vtkPolyData> WithAtlas(vtkDataObject* input)
{
  vtkNew<Atlas> filter;
  return OutputOf(filter, input);
}

/// The texture coordinates of the corners of the output's triangles.
surfsynth::TextureCoordinates CornersOf(vtkPolyData* output)
{
  const surfsynth::TriangleMesh mesh = MeshOf(output);
  surfsynth::TextureCoordinates corners(3 * mesh.NumberOfTriangles(), 2);
  vtkDataArray* texture = output->GetPointData()->GetTCoords();
  for (Eigen::Index corner = 0; corner < corners.rows(); ++corner)
  {
    const double* uv = texture->GetTuple2(mesh.Triangles(corner / 3, corner % 3));
    corners.row(corner) << uv[0], uv[1];
  }
  return corners;
}

/// Expects texture coordinates without a defect, and points that are copies of those of the input.
void ExpectAtlas(vtkPolyData* input, vtkPolyData* output)
{
  vtkDataArray* texture = output->GetPointData()->GetTCoords();
  ASSERT_TRUE(texture);
  EXPECT_STREQ(texture->GetName(), "TCoords");
  EXPECT_EQ(texture->GetNumberOfComponents(), 2);
  EXPECT_TRUE(surfsynth::RasterizeAtlas(CornersOf(output), { 1024, 1024, 0 }).Findings.empty());
  auto* original = vtkIdTypeArray::SafeDownCast(output->GetPointData()->GetArray("OriginalPoint"));
  ASSERT_TRUE(original);
  ASSERT_EQ(original->GetNumberOfTuples(), output->GetNumberOfPoints());
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const vtkIdType from = original->GetValue(p);
    ASSERT_TRUE(p < input->GetNumberOfPoints() ? from == p : from >= 0 && from < input->GetNumberOfPoints());
    double x[3];
    input->GetPoint(from, x);
    EXPECT_TRUE(std::equal(x, x + 3, output->GetPoint(p)));
  }
}

/// The points of a cell, as points of the input.
std::vector<vtkIdType> OriginalCell(vtkPolyData* output, vtkIdType cell)
{
  vtkNew<vtkIdList> ids;
  output->GetCellPoints(cell, ids);
  std::vector<vtkIdType> points;
  for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k)
  {
    const double point = output->GetPointData()->GetArray("OriginalPoint")->GetTuple1(ids->GetId(k));
    points.push_back(static_cast<vtkIdType>(point));
  }
  return points;
}

vtkIntArray* ChartOf(vtkPolyData* output)
{
  return vtkIntArray::SafeDownCast(output->GetCellData()->GetArray("Chart"));
}

void AddCellNumbers(vtkPolyData* surface)
{
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("number");
  for (vtkIdType c = 0; c < surface->GetNumberOfCells(); ++c)
  {
    numbers->InsertNextValue(static_cast<int>(c));
  }
  surface->GetCellData()->AddArray(numbers);
}
} // namespace

TEST(TextureAtlas, ClosedSurfaceKeepsItsTrianglesAndHasAPointForEachChart)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto sphere = Icosphere(3).ToPolyData(type);
    const auto output = WithAtlas(sphere);
    ExpectAtlas(sphere, output);
    EXPECT_EQ(output->GetPoints()->GetDataType(), type);
    ASSERT_EQ(output->GetNumberOfCells(), sphere->GetNumberOfCells());
    std::map<vtkIdType, std::set<int>> charts;
    for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
    {
      EXPECT_EQ(OriginalCell(output, c), std::vector<vtkIdType>(Icosphere(3).Polys[c]));
      vtkNew<vtkIdList> ids;
      output->GetCellPoints(c, ids);
      for (vtkIdType k = 0; k < 3; ++k)
      {
        charts[ids->GetId(k)].insert(ChartOf(output)->GetValue(c));
      }
    }
    EXPECT_GT(output->GetNumberOfPoints(), sphere->GetNumberOfPoints());
    EXPECT_EQ(static_cast<vtkIdType>(charts.size()), output->GetNumberOfPoints());
    EXPECT_TRUE(std::all_of(charts.begin(), charts.end(), [](const auto& point) { return point.second.size() == 1; }));
  }
}

TEST(TextureAtlas, PlaneIsOneChartWithoutDoubledPointsAndWithoutStretch)
{
  vtkNew<Atlas> filter;
  filter->SetResolution(64, 64);
  const auto square = Grid(4).ToPolyData();
  const auto output = OutputOf(filter, square);
  ExpectAtlas(square, output);
  EXPECT_EQ(output->GetNumberOfPoints(), square->GetNumberOfPoints());
  EXPECT_EQ(filter->GetNumberOfCharts(), 1);
  EXPECT_NEAR(filter->GetTexelsPerLength(), 60.0, 0.1) << "64 texels without two of margin at each side";
  EXPECT_NEAR(filter->GetCoverage(), 60.0 * 60.0 / (64.0 * 64.0), 0.01);
  EXPECT_NEAR(filter->GetRootMeanStretch(), 1.0, 1e-6);
  EXPECT_NEAR(filter->GetLargestStretch(), 1.0, 1e-6);
  const std::map<std::string, double> measures = { { "NumberOfCharts", 1.0 }, { "Coverage", filter->GetCoverage() },
    { "RootMeanStretch", filter->GetRootMeanStretch() }, { "LargestStretch", filter->GetLargestStretch() },
    { "TexelsPerLength", filter->GetTexelsPerLength() } };
  for (const auto& measure : measures)
  {
    ASSERT_TRUE(output->GetFieldData()->HasArray(measure.first.c_str())) << measure.first;
    EXPECT_EQ(output->GetFieldData()->GetArray(measure.first.c_str())->GetTuple1(0), measure.second);
  }
}

TEST(TextureAtlas, PolygonsStayWhereNoChartDividesThem)
{
  const auto square = Grid(4, 4).ToPolyData();
  const auto flat = WithAtlas(square);
  ExpectAtlas(square, flat);
  EXPECT_EQ(flat->GetNumberOfCells(), 16);
  for (vtkIdType c = 0; c < 16; ++c)
  {
    EXPECT_EQ(OriginalCell(flat, c), std::vector<vtkIdType>(Grid(4, 4).Polys[c]));
  }
  const auto cube = Cube(3).ToPolyData();
  const auto boxed = WithAtlas(cube);
  ExpectAtlas(cube, boxed);
  EXPECT_GE(boxed->GetNumberOfCells(), 54);
}

TEST(TextureAtlas, DividedPolygonsBecomeTrianglesWithTheArraysOfTheirCell)
{
  Soup ball = Cube(8);
  for (vtkIdType p = 0; p < ball.NumberOfPoints(); ++p)
  {
    Eigen::Map<Eigen::Vector3d> point(ball.Points.data() + 3 * p);
    point = (point - Eigen::Vector3d::Constant(0.5)).normalized();
  }
  const auto input = ball.ToPolyData();
  AddCellNumbers(input);
  vtkNew<Atlas> filter;
  filter->SetMaximumStretch(1.1);
  const auto output = OutputOf(filter, input);
  ExpectAtlas(input, output);
  EXPECT_GT(output->GetNumberOfCells(), input->GetNumberOfCells()) << "charts divide some squares";
  vtkDataArray* numbers = output->GetCellData()->GetArray("number");
  std::map<double, std::vector<vtkIdType>> cells;
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    EXPECT_TRUE(c == 0 || numbers->GetTuple1(c) >= numbers->GetTuple1(c - 1)) << "in order";
    cells[numbers->GetTuple1(c)].push_back(c);
  }
  ASSERT_EQ(static_cast<vtkIdType>(cells.size()), input->GetNumberOfCells());
  for (const auto& cell : cells)
  {
    const auto& square = ball.Polys[static_cast<std::size_t>(cell.first)];
    if (cell.second.size() == 1)
    {
      EXPECT_EQ(OriginalCell(output, cell.second[0]), square);
      continue;
    }
    ASSERT_EQ(cell.second.size(), 2u);
    EXPECT_NE(ChartOf(output)->GetValue(cell.second[0]), ChartOf(output)->GetValue(cell.second[1]));
    std::set<vtkIdType> points;
    for (const vtkIdType part : cell.second)
    {
      const auto corners = OriginalCell(output, part);
      EXPECT_EQ(corners.size(), 3u);
      points.insert(corners.begin(), corners.end());
    }
    EXPECT_EQ(points, std::set<vtkIdType>(square.begin(), square.end()));
  }
}

TEST(TextureAtlas, StripsBecomeTrianglesAndOtherCellsStay)
{
  Soup soup;
  for (const double x : { 0.0, 5.0 })
  {
    soup.AddPoint(x, 0, 0);
    soup.AddPoint(x + 1, 0, 0);
    soup.AddPoint(x, 1, 0);
    soup.AddPoint(x + 1, 1, 0);
  }
  soup.Verts = { { 0 } };
  soup.Lines = { { 0, 1 } };
  soup.Polys = { { 0, 1, 3, 2 } };
  soup.Strips = { { 4, 5, 6, 7 } };
  const auto input = soup.ToPolyData();
  AddCellNumbers(input);
  const auto output = WithAtlas(input);
  ExpectAtlas(input, output);
  EXPECT_EQ(output->GetNumberOfVerts(), 1);
  EXPECT_EQ(output->GetNumberOfLines(), 1);
  EXPECT_EQ(output->GetNumberOfStrips(), 0);
  ASSERT_EQ(output->GetNumberOfCells(), 5);
  const int numbers[] = { 0, 1, 2, 3, 3 };
  const int charts[] = { -1, -1, 0, 1, 1 };
  for (vtkIdType c = 0; c < 5; ++c)
  {
    EXPECT_EQ(output->GetCellData()->GetArray("number")->GetTuple1(c), numbers[c]);
    EXPECT_EQ(ChartOf(output)->GetValue(c), charts[c]);
  }
}

TEST(TextureAtlas, ArraysAreCopied)
{
  const auto sphere = Icosphere(2).ToPolyData();
  AddPointArray(sphere, "height", [](const double* p) { return p[2]; });
  AddPointArray(sphere, "TCoords", [](const double* p) { return p[0]; });
  vtkNew<vtkStringArray> names;
  names->SetName("names");
  vtkNew<vtkIdTypeArray> ids;
  for (vtkIdType p = 0; p < sphere->GetNumberOfPoints(); ++p)
  {
    names->InsertNextValue(std::to_string(p));
    ids->InsertNextValue(p);
  }
  sphere->GetPointData()->AddArray(names);
  sphere->GetPointData()->SetGlobalIds(ids);
  vtkNew<vtkDoubleArray> kept;
  kept->SetName("kept");
  kept->InsertNextValue(3.0);
  sphere->GetFieldData()->AddArray(kept);
  AddCellNumbers(sphere);
  const std::uint64_t before = HashOf(sphere);
  const auto output = WithAtlas(sphere);
  EXPECT_EQ(HashOf(sphere), before);
  ExpectAtlas(sphere, output);
  EXPECT_FALSE(output->GetPointData()->GetGlobalIds()) << "copies would have the same";
  EXPECT_TRUE(output->GetFieldData()->HasArray("kept"));
  auto* texts = vtkStringArray::SafeDownCast(output->GetPointData()->GetAbstractArray("names"));
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const auto from = static_cast<vtkIdType>(output->GetPointData()->GetArray("OriginalPoint")->GetTuple1(p));
    EXPECT_EQ(texts->GetValue(p), std::to_string(from));
    EXPECT_EQ(output->GetPointData()->GetArray("height")->GetTuple1(p), output->GetPoint(p)[2]);
  }
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    EXPECT_EQ(output->GetCellData()->GetArray("number")->GetTuple1(c), c);
  }
}

TEST(TextureAtlas, TriangleSoupIsOneSurfaceAndSheetsThatTouchStayApart)
{
  Soup soup; // as STL stores a square
  const Soup square = Grid(3);
  for (const auto& cell : square.Polys)
  {
    std::vector<vtkIdType> corners;
    for (const vtkIdType id : cell)
    {
      corners.push_back(soup.AddPoint(square.Points[3 * id], square.Points[3 * id + 1], square.Points[3 * id + 2]));
    }
    soup.Polys.push_back(corners);
  }
  vtkNew<Atlas> filter;
  const auto input = soup.ToPolyData();
  ExpectAtlas(input, OutputOf(filter, input));
  EXPECT_EQ(filter->GetNumberOfCharts(), 1) << "points of equal coordinates are one";

  Soup fins; // three triangles at one edge, each with points of its own
  for (const double y : { -1.0, 0.0, 1.0 })
  {
    const vtkIdType first = fins.AddPoint(0, 0, 0);
    fins.AddPoint(1, 0, 0);
    fins.AddPoint(0.5, y, 1.0 - std::abs(y));
    fins.Polys.push_back({ first, first + 1, first + 2 });
  }
  const auto sheets = fins.ToPolyData();
  ExpectAtlas(sheets, OutputOf(filter, sheets));
  EXPECT_EQ(filter->GetNumberOfCharts(), 3);
}

TEST(TextureAtlas, ParametersChangeTheAtlas)
{
  const auto sphere = Icosphere(3).ToPolyData();
  vtkNew<Atlas> filter;
  OutputOf(filter, sphere);
  const vtkTypeInt64 charts = filter->GetNumberOfCharts();
  const double density = filter->GetTexelsPerLength();
  EXPECT_LE(filter->GetLargestStretch(), 2.0);
  filter->SetMaximumStretch(1.05);
  OutputOf(filter, sphere);
  EXPECT_GT(filter->GetNumberOfCharts(), charts);
  EXPECT_LE(filter->GetLargestStretch(), 1.05);
  filter->SetMaximumStretch(2.0);
  filter->SetMargin(32);
  OutputOf(filter, sphere);
  EXPECT_LT(filter->GetTexelsPerLength(), density);
  filter->SetMargin(4);
  filter->SetResolution(2048, 2048);
  OutputOf(filter, sphere);
  EXPECT_NEAR(filter->GetTexelsPerLength(), 2.0 * density, 0.2 * density);
}

TEST(TextureAtlas, BlocksGetAnAtlasEach)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(2, Grid(5, 4).ToPolyData());
  vtkNew<Atlas> filter;
  filter->SetInputData(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  for (const unsigned int block : { 0u, 2u })
  {
    const auto alone = WithAtlas(blocks->GetBlock(block));
    auto* found = vtkPolyData::SafeDownCast(output->GetBlock(block));
    ASSERT_TRUE(found);
    EXPECT_TRUE(SameBits(alone->GetPointData()->GetTCoords(), found->GetPointData()->GetTCoords()));
  }
}

TEST(TextureAtlas, DefectsAreRefusedWithTheFilterThatRepairsThem)
{
  Soup fan = Grid(2);
  fan.Polys.push_back(fan.Polys[0]);
  Soup wound = Icosphere(1);
  std::swap(wound.Polys[3][0], wound.Polys[3][1]);
  vtkNew<Atlas> filter;
  ExpectRefusal(filter, fan.ToPolyData(), { "non-manifold edge", "vtkSurfaceRepairFilter" });
  ExpectRefusal(filter, wound.ToPolyData(), { "wound in opposite senses", "vtkSurfaceRepairFilter" });
  filter->SetResolution(16, 16);
  filter->SetMargin(256);
  ExpectRefusal(filter, Icosphere(1).ToPolyData(), { "do not fit", "16 x 16", "larger image" });
  vtkNew<Atlas> lonely;
  EventRecorder events(lonely);
  EXPECT_FALSE(Update(lonely));
  EXPECT_EQ(events.Errors.size(), 1u) << events.AllErrors();
}

TEST(TextureAtlas, UnchangedParametersRunNothingAndChangesRunOnce)
{
  vtkNew<Atlas> filter;
  filter->SetInputData(Icosphere(1).ToPolyData());
  EventRecorder events(filter);
  const auto expectOne = [&](const char* what) {
    const int before = events.Executions;
    Update(filter);
    Update(filter);
    EXPECT_EQ(events.Executions, before + 1) << what;
  };
  expectOne("first");
  filter->SetResolution(512, 256);
  expectOne("resolution");
  filter->SetResolution(512, 256);
  filter->SetMargin(4);
  filter->SetMaximumStretch(2.0);
  Update(filter);
  EXPECT_EQ(events.Executions, 2) << "the same values are no change";
  filter->SetMargin(8);
  expectOne("margin");
  filter->SetMaximumStretch(1.5);
  expectOne("stretch");
}

TEST(TextureAtlas, ParametersAreClampedAndPrinted)
{
  vtkNew<Atlas> filter;
  filter->SetResolution(1, 100000);
  filter->SetMargin(0);
  filter->SetMaximumStretch(0.5);
  EXPECT_EQ(filter->GetResolution()[0], 16);
  EXPECT_EQ(filter->GetResolution()[1], 32768);
  EXPECT_EQ(filter->GetMargin(), 1);
  EXPECT_EQ(filter->GetMaximumStretch(), 1.01);
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "Resolution: 16 32768", "Margin: 1", "MaximumStretch: 1.01", "NumberOfCharts: 0",
         "Coverage: 0", "RootMeanStretch: 1", "LargestStretch: 1", "TexelsPerLength: 0" })
  {
    EXPECT_NE(text.str().find(name), std::string::npos) << name;
  }
}
