// SPDX-License-Identifier: BSD-3-Clause
//
// Conversions of broken surfaces: SurfaceInspection.h counts faults, UncheckedSurface.h uses the rest.
#include "FilterChecks.h"
#include "ThrownText.h"
#include "VtkSurfaces.h"

#include "SurfaceInspection.h"
#include "UncheckedSurface.h"

#include "Core/Common/Errors.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynthtest;
using surfsynth::CellFault;
using surfsynth::ConvertUnchecked;
using surfsynth::InspectedSurface;
using surfsynth::InspectSurface;
using surfsynth::InvalidInput;
using surfsynth::UncheckedSurface;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace
{
/// A unit square as points 0 to 3, without cells.
Soup Square()
{
  Soup soup;
  soup.Points = { 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0 };
  return soup;
}

vtkSmartPointer<vtkPolyData> WithTwoCoordinates()
{
  Soup soup;
  soup.Polys = { { 0, 1, 2 } };
  auto surface = soup.ToPolyData();
  vtkNew<vtkPoints> points;
  points->GetData()->SetNumberOfComponents(2);
  points->GetData()->SetNumberOfTuples(3);
  points->GetData()->Fill(0.0);
  surface->SetPoints(points);
  return surface;
}

std::vector<int> CornersOf(const surfsynth::TriangleMesh& mesh)
{
  return { mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size() };
}

/// Counts and first ids of two faults agree.
void ExpectFault(const CellFault& fault, std::int64_t count, std::int64_t first)
{
  EXPECT_EQ(fault.Count, count);
  EXPECT_EQ(fault.First, first);
}
} // namespace

// --- SurfaceInspection -----------------------------------------------------------------------------------------------

TEST(SurfaceInspection, CellsAreCountedByKind)
{
  Soup soup = Icosphere(1);
  soup.Verts = { { 0 }, { 1 } };
  soup.Lines = { { 0, 1 }, { 1, 2 }, { 2, 3 } };
  soup.Polys.push_back({ 0, 1, 2, 3 });
  soup.Strips = { { 4, 5, 6, 7 } };
  const InspectedSurface surface = InspectSurface(soup.ToPolyData());
  EXPECT_EQ(surface.Points, 42);
  EXPECT_EQ(surface.PointComponents, 3);
  EXPECT_EQ(surface.Vertices, 2);
  EXPECT_EQ(surface.Lines, 3);
  EXPECT_EQ(surface.Triangles, 80);
  EXPECT_EQ(surface.Quads, 1);
  EXPECT_EQ(surface.Polygons, 0);
  EXPECT_EQ(surface.Strips, 1);
}

TEST(SurfaceInspection, AValidSurfaceHasNoFaultAndAllTriangles)
{
  Soup soup = Square();
  soup.Lines = { { 0, 1 } };
  soup.Polys = { { 0, 1, 2, 3 } };
  const InspectedSurface surface = InspectSurface(soup.ToPolyData());
  for (const CellFault& fault : { surface.Unreadable, surface.OutOfRange, surface.TooFewPoints, surface.RepeatedPoint,
         surface.Uncut, surface.IgnoredCells })
  {
    ExpectFault(fault, 0, -1);
  }
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 2);
  EXPECT_THAT(surface.CellOfTriangle, ElementsAre(1, 1)) << "the line is cell 0";
}

TEST(SurfaceInspection, FaultsAreCountedWithTheirFirstCell)
{
  Soup soup = Square();
  soup.Verts = { { 99 } };
  soup.Polys = { { 0, 1 }, { 0, 1, 7 }, { 0, 1, 2, 0 }, { 0, 2, 1, 3 }, { 0, 1, 2 }, { -1, 1, 2 } };
  const InspectedSurface surface = InspectSurface(soup.ToPolyData());
  ExpectFault(surface.TooFewPoints, 1, 1);
  ExpectFault(surface.OutOfRange, 2, 2);
  ExpectFault(surface.RepeatedPoint, 1, 3);
  ExpectFault(surface.Uncut, 1, 4); // an outline that crosses itself
  ExpectFault(surface.IgnoredCells, 1, 0);
  EXPECT_THAT(CornersOf(surface.Mesh), ElementsAre(0, 1, 2));
  EXPECT_THAT(surface.CellOfTriangle, ElementsAre(5));
}

TEST(SurfaceInspection, OffsetsThatDoNotFitAreUnreadable)
{
  const auto square = Square().ToPolyData();
  vtkNew<vtkIdTypeArray> offsets;
  vtkNew<vtkIdTypeArray> ids;
  for (const vtkIdType offset : { 0, 3, 9 })
  {
    offsets->InsertNextValue(offset);
  }
  for (const vtkIdType id : { 0, 1, 2, 3 })
  {
    ids->InsertNextValue(id);
  }
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  square->SetPolys(cells);
  const InspectedSurface surface = InspectSurface(square);
  ExpectFault(surface.Unreadable, 1, 1);
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 1);
}

TEST(SurfaceInspection, TrianglesMayBeDegenerateAndPointsNotFinite)
{
  Soup soup = Square();
  soup.Points[0] = std::nan("");
  soup.Polys = { { 0, 0, 1 }, { 0, 1, 2, 3 } };
  const InspectedSurface surface = InspectSurface(soup.ToPolyData());
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 3) << "they are for the check of the mesh to find";
  EXPECT_TRUE(std::isnan(surface.Mesh.Points(0, 0)));
}

TEST(SurfaceInspection, OtherNumbersOfCoordinatesAreReported)
{
  const InspectedSurface surface = InspectSurface(WithTwoCoordinates());
  EXPECT_EQ(surface.PointComponents, 2);
  EXPECT_EQ(surface.Points, 3);
  EXPECT_EQ(surface.Mesh.NumberOfPoints(), 0);
}

TEST(SurfaceInspection, AnEmptySurfaceIsAllZeros)
{
  const InspectedSurface surface = InspectSurface(vtkSmartPointer<vtkPolyData>::New());
  EXPECT_EQ(surface.Points, 0);
  EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 0);
  ExpectFault(surface.Unreadable, 0, -1);
}

// --- UncheckedSurface ------------------------------------------------------------------------------------------------

TEST(UncheckedSurface, AValidSurfaceLosesNothing)
{
  Soup soup = Icosphere(1);
  soup.Lines = { { 0, 1 } };
  const UncheckedSurface surface = ConvertUnchecked(soup.ToPolyData());
  const auto checked = surfsynth::ConvertSurface(soup.ToPolyData());
  EXPECT_EQ(surface.Usable.MeshHash(), checked.MeshHash());
  EXPECT_EQ(surface.Usable.CellOfTriangle, checked.CellOfTriangle);
  EXPECT_EQ(surface.Losses.CellsOutOfRange + surface.Losses.CellsTooSmall + surface.Losses.NonFinitePoints +
      surface.Losses.CellsNotFinite + surface.Losses.PolygonsNotSimple + surface.Losses.RepeatedPoints,
    0);
}

TEST(UncheckedSurface, LossesAreCountedByKind)
{
  Soup soup = Square();
  soup.AddPoint(0.0, 0.0, std::nan(""));
  soup.Polys = { { 0, 1, 2 }, { 0, 1, 9 }, { 0, 1 }, { 0, 0, 1 }, { 0, 1, 4 }, { 0, 1, 2, 0, 3 }, { 0, 2, 1, 3 } };
  soup.Strips = { { 0, 1 }, { 0, 1, 2, 4 }, { 0, 1, 2, 3 } };
  const UncheckedSurface surface = ConvertUnchecked(soup.ToPolyData());
  EXPECT_EQ(surface.Losses.NonFinitePoints, 1);
  EXPECT_EQ(surface.Losses.CellsOutOfRange, 1);
  EXPECT_EQ(surface.Losses.CellsTooSmall, 3) << "two polygons and a strip";
  EXPECT_EQ(surface.Losses.CellsNotFinite, 2) << "a polygon, and a strip in part";
  EXPECT_EQ(surface.Losses.RepeatedPoints, 1);
  EXPECT_EQ(surface.Losses.PolygonsNotSimple, 1);
  EXPECT_THAT(surface.Usable.CellOfTriangle, ElementsAre(0, 5, 5, 6, 6, 8, 9, 9));
}

TEST(UncheckedSurface, PointsThatAreNotFiniteAreZeroAndUnused)
{
  Soup soup = Square();
  soup.AddPoint(1.0, std::nan(""), 2.0);
  soup.Polys = { { 0, 1, 2 }, { 1, 2, 4 } };
  const UncheckedSurface surface = ConvertUnchecked(soup.ToPolyData());
  ASSERT_EQ(surface.Usable.Mesh.NumberOfPoints(), 5);
  EXPECT_EQ(surface.Usable.Mesh.Points.row(4), Eigen::RowVector3d(0.0, 0.0, 0.0));
  EXPECT_THAT(CornersOf(surface.Usable.Mesh), ElementsAre(0, 1, 2));
}

TEST(UncheckedSurface, OtherNumbersOfCoordinatesAreAnError)
{
  EXPECT_THAT(TextOf<InvalidInput>([] { ConvertUnchecked(WithTwoCoordinates()); }),
    HasSubstr("The points have 2 coordinates each; 3 are needed."));
}
