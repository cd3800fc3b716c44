// SPDX-License-Identifier: BSD-3-Clause
//
// Conversion of polydata to triangles: what each triangle is, and which cell it comes from.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Operators/SurfaceOperators.h"

#include <vtkCellArray.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace surfsynthtest;
using surfsynth::InvalidInput;
using surfsynth::MeshRequirements;
using surfsynth::Surface;
using surfsynth::ToSurface;

namespace
{
double AreaOf(const Surface& surface) { return surfsynth::FaceAreas(surface.Mesh).sum(); }

/// z component of the sum of the area vectors: the area of a planar mesh whose triangles all face upwards.
double UpwardArea(const Surface& surface)
{
  double area = 0.0;
  for (Eigen::Index f = 0; f < surface.Mesh.Triangles.rows(); ++f)
  {
    const auto t = surface.Mesh.Triangles.row(f);
    const Eigen::RowVector3d a = surface.Mesh.Points.row(t(1)) - surface.Mesh.Points.row(t(0));
    const Eigen::RowVector3d b = surface.Mesh.Points.row(t(2)) - surface.Mesh.Points.row(t(0));
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

Surface Convert(const Soup& soup) { return ToSurface(soup.ToPolyData(), MeshRequirements()); }

std::string MessageOf(const Soup& soup)
{
  try
  {
    Convert(soup);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "no error";
}

Soup PolygonOf(const std::vector<std::pair<double, double>>& corners)
{
  Soup soup;
  soup.Polys.emplace_back();
  for (const auto& corner : corners)
  {
    soup.Polys[0].push_back(soup.AddPoint(corner.first, corner.second, 0.0));
  }
  return soup;
}
} // namespace

TEST(SurfaceBridge, TrianglesAreTakenAsTheyAre)
{
  const Soup sphere = Icosphere(2);
  const Surface surface = Convert(sphere);
  ASSERT_EQ(surface.Mesh.NumberOfPoints(), sphere.NumberOfPoints());
  ASSERT_EQ(surface.Mesh.NumberOfTriangles(), static_cast<int>(sphere.Polys.size()));
  EXPECT_TRUE(surface.CellOfTriangle.empty());
  for (std::size_t f = 0; f < sphere.Polys.size(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      ASSERT_EQ(surface.Mesh.Triangles(static_cast<int>(f), k), sphere.Polys[f][k]);
    }
  }
  EXPECT_TRUE(std::equal(sphere.Points.begin(), sphere.Points.end(), surface.Mesh.Points.data()));
}

TEST(SurfaceBridge, BothStoragesOfCellsGiveTheSameMesh)
{
  const auto polyData = Icosphere(2).ToPolyData();
  const Surface wide = ToSurface(polyData, MeshRequirements());
  ASSERT_TRUE(polyData->GetPolys()->IsStorage64Bit());
  polyData->GetPolys()->ConvertTo32BitStorage();
  const Surface narrow = ToSurface(polyData, MeshRequirements());
  EXPECT_EQ(surfsynth::ContentHash(wide.Mesh), surfsynth::ContentHash(narrow.Mesh));
}

TEST(SurfaceBridge, CellIdsCountVerticesLinesPolygonsAndStrips)
{
  Soup soup = PolygonOf({ { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } });
  soup.Verts = { { 0 }, { 1 } };
  soup.Lines = { { 0, 1 } };
  const vtkIdType first = soup.AddPoint(5, 0, 0);
  for (const auto& x : { std::make_pair(6.0, 0.0), std::make_pair(5.0, 1.0), std::make_pair(6.0, 1.0) })
  {
    soup.AddPoint(x.first, x.second, 0.0);
  }
  soup.Strips = { { first, first + 1, first + 2, first + 3 } };
  const Surface surface = Convert(soup);
  EXPECT_THAT(surface.CellOfTriangle, ::testing::ElementsAre(3, 3, 4, 4));
  EXPECT_EQ(surface.Cell(2), 4);
  EXPECT_NEAR(UpwardArea(surface), 2.0, 1e-14) << "strips and polygons keep their winding";
}

TEST(SurfaceBridge, TrianglesBehindLinesKeepTheirCells)
{
  Soup soup = Icosphere(1);
  soup.Lines = { { 0, 1 }, { 1, 2 } };
  const Surface surface = Convert(soup);
  ASSERT_EQ(surface.CellOfTriangle.size(), 80u);
  for (std::int64_t f = 0; f < 80; ++f)
  {
    EXPECT_EQ(surface.Cell(f), f + 2);
  }
}

TEST(SurfaceBridge, QuadrilateralsAreCutAlongTheShorterDiagonalInside)
{
  const Surface wide = Convert(PolygonOf({ { 0, 0 }, { 3, -1 }, { 6, 0 }, { 3, 1 } }));
  EXPECT_NEAR(AreaOf(wide), 6.0, 1e-14);
  EXPECT_THAT(std::vector<int>(wide.Mesh.Triangles.data(), wide.Mesh.Triangles.data() + 6),
    ::testing::ElementsAre(1, 2, 3, 1, 3, 0));
  // A dart: the diagonal 1 - 3 lies outside although it is the shorter one.
  const Surface dart = Convert(PolygonOf({ { 0, 0 }, { -1, 3 }, { 0, 2.5 }, { 1, 3 } }));
  EXPECT_NEAR(AreaOf(dart), 2.5, 1e-14);
  EXPECT_NEAR(UpwardArea(dart), -2.5, 1e-14);
}

TEST(SurfaceBridge, PolygonsOfAnyShapeKeepAreaAndWinding)
{
  const Surface letter = Convert(
    PolygonOf({ { 0, 0 }, { 4, 0 }, { 4, 3 }, { 3, 3 }, { 3, 1 }, { 1, 1 }, { 1, 3 }, { 0, 3 } }));
  EXPECT_EQ(letter.Mesh.NumberOfTriangles(), 6);
  EXPECT_NEAR(UpwardArea(letter), 8.0, 1e-13);
  EXPECT_NEAR(AreaOf(letter), 8.0, 1e-13) << "no triangle overlaps another";

  Soup circle;
  circle.Polys.emplace_back();
  const int corners = 500;
  for (int k = 0; k < corners; ++k)
  {
    const double angle = 2.0 * std::acos(-1.0) * k / corners;
    circle.Polys[0].push_back(circle.AddPoint(1e6 + 1e-3 * std::cos(angle), 1e-3 * std::sin(angle), 0.0));
  }
  const Surface disc = Convert(circle);
  EXPECT_EQ(disc.Mesh.NumberOfTriangles(), corners - 2);
  const double expected = 0.5 * corners * std::sin(2.0 * std::acos(-1.0) / corners) * 1e-6;
  EXPECT_NEAR(UpwardArea(disc), expected, 1e-6 * expected) << "far from the origin, and small";
}

TEST(SurfaceBridge, StripsAlternateTheirWinding)
{
  Soup soup;
  soup.Strips.emplace_back();
  for (int k = 0; k < 10; ++k)
  {
    soup.Strips[0].push_back(soup.AddPoint(0.5 * k, k % 2, 0.0));
  }
  const Surface surface = Convert(soup);
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 8);
  EXPECT_NEAR(std::abs(UpwardArea(surface)), 4.0, 1e-14);
  EXPECT_NEAR(AreaOf(surface), 4.0, 1e-14);
}

TEST(SurfaceBridge, JoinsOfStripsAreLeftOut)
{
  Soup soup;
  for (int k = 0; k < 8; ++k)
  {
    soup.AddPoint(0.5 * k, k % 2, 0.0);
  }
  soup.Strips = { { 0, 1, 2, 3, 3, 4, 4, 5, 6, 7 } };
  const Surface surface = Convert(soup);
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 4);
  EXPECT_THAT(surface.CellOfTriangle, ::testing::ElementsAre(0, 0, 0, 0));
}

TEST(SurfaceBridge, MessagesNameCountFirstCellAndRepair)
{
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  Soup repeated = Icosphere(1);
  repeated.Lines = { { 0, 1 } };
  repeated.Polys.push_back({ 0, 1, 2, 3, 0 });
  repeated.Polys.push_back({ 4, 4, 5 });
  EXPECT_THAT(MessageOf(repeated),
    AllOf(HasSubstr("2 cell(s)"), HasSubstr("use a point twice"), HasSubstr("first cell 81"),
      HasSubstr("vtkCleanPolyData")));

  Soup small = Icosphere(1);
  small.Polys.push_back({ 0, 1 });
  EXPECT_THAT(MessageOf(small),
    AllOf(HasSubstr("1 polygon(s)"), HasSubstr("fewer than three points"), HasSubstr("first cell 80"),
      HasSubstr("vtkCleanPolyData")));

  EXPECT_THAT(MessageOf(PolygonOf({ { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } })),
    AllOf(HasSubstr("1 polygon(s)"), HasSubstr("cannot be triangulated"), HasSubstr("first cell 0"),
      HasSubstr("vtkTriangleFilter")));

  Soup range = Icosphere(1);
  range.Polys[5][1] = 42;
  range.Polys[9] = { 0, 1, -1, 3 };
  EXPECT_THAT(
    MessageOf(range), AllOf(HasSubstr("2 cell(s)"), HasSubstr("point that does not exist"), HasSubstr("first cell 5")));

  Soup points = Icosphere(1);
  points.Polys.clear();
  EXPECT_THAT(MessageOf(points),
    AllOf(HasSubstr("42 points"), HasSubstr("no polygon"), HasSubstr("vtkDelaunay2D"),
      HasSubstr("vtkSurfaceReconstructionFilter")));
}

TEST(SurfaceBridge, RequirementsAreChecked)
{
  MeshRequirements closed;
  closed.Closed = true;
  EXPECT_NO_THROW(ToSurface(Icosphere(1).ToPolyData(), closed));
  EXPECT_THROW(ToSurface(Grid(3).ToPolyData(), closed), InvalidInput);
  EXPECT_THROW(ToSurface(nullptr, closed), InvalidInput);
}

TEST(SurfaceBridge, PointsOfEveryTypeConvert)
{
  const Soup grid = [] {
    Soup soup = Grid(4);
    for (double& x : soup.Points)
    {
      x *= 4.0; // whole numbers, so that every type holds them exactly
    }
    return soup;
  }();
  const auto hash = surfsynth::ContentHash(Convert(grid).Mesh);
  for (const int type : { VTK_FLOAT, VTK_INT, VTK_SHORT, VTK_UNSIGNED_CHAR, VTK_LONG_LONG })
  {
    const Surface surface = ToSurface(grid.ToPolyData(type), MeshRequirements());
    EXPECT_EQ(surfsynth::ContentHash(surface.Mesh), hash) << "type " << type;
  }
}
