// SPDX-License-Identifier: BSD-3-Clause
//
// Surfaces in unstructured grids, as clipping makes them.
#include "FilterChecks.h"
#include "FunctionFilter.h"
#include "VtkSurfaces.h"

#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

using namespace surfsynthtest;
using surfsynth::AsSurfaces;
using surfsynth::DescribeInput;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace
{
/// A grid of 5 points with a point array, and a cell array that numbers its cells.
vtkSmartPointer<vtkUnstructuredGrid> GridOf(const std::vector<std::pair<int, std::vector<vtkIdType>>>& cells)
{
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  for (const auto& [x, y, z] :
    { std::array{ 0., 0., 0. }, { 1., 0., 0. }, { 1., 1., 0. }, { 0., 1., 0. }, { 0., 0., 1. } })
  {
    points->InsertNextPoint(x, y, z);
  }
  grid->SetPoints(points);
  vtkNew<vtkDoubleArray> heights;
  heights->SetName("Height");
  heights->SetNumberOfTuples(5);
  heights->Fill(2.0);
  grid->GetPointData()->AddArray(heights);
  vtkNew<vtkIdTypeArray> numbers;
  numbers->SetName("Number");
  for (const auto& [type, ids] : cells)
  {
    numbers->InsertNextValue(grid->InsertNextCell(type, static_cast<vtkIdType>(ids.size()), ids.data()));
  }
  grid->GetCellData()->AddArray(numbers);
  return grid;
}

std::vector<vtkIdType> NumbersOf(vtkDataSet* surface)
{
  auto* numbers = vtkIdTypeArray::SafeDownCast(surface->GetCellData()->GetArray("Number"));
  return { numbers->GetPointer(0), numbers->GetPointer(0) + numbers->GetNumberOfValues() };
}

std::vector<vtkIdType> PointsOf(vtkPolyData* surface, vtkIdType cell)
{
  vtkNew<vtkIdList> ids;
  surface->GetCellPoints(cell, ids);
  return { ids->begin(), ids->end() };
}

const std::pair<int, std::vector<vtkIdType>> Tetrahedron = { VTK_TETRA, { 0, 1, 2, 4 } };
} // namespace

TEST(AsSurfaces, PolygonsOfAGridAreSharedInTheirOrder)
{
  const auto grid = GridOf(
    { { VTK_TRIANGLE, { 0, 1, 2 } }, { VTK_QUAD, { 0, 1, 2, 3 } }, { VTK_POLYGON, { 2, 3, 4 } } });
  const auto surface = vtkSmartPointer<vtkPolyData>(vtkPolyData::SafeDownCast(AsSurfaces(grid)));
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->GetPoints(), grid->GetPoints());
  EXPECT_EQ(surface->GetPolys(), grid->GetCells());
  EXPECT_EQ(surface->GetPointData()->GetArray("Height"), grid->GetPointData()->GetArray("Height"));
  EXPECT_THAT(NumbersOf(surface), ElementsAre(0, 1, 2));
}

TEST(AsSurfaces, OtherCellsAreSortedAsInPolyDataWithTheirArrays)
{
  const auto grid = GridOf({ { VTK_TRIANGLE_STRIP, { 0, 1, 3, 2 } }, { VTK_PIXEL, { 0, 1, 3, 2 } },
    { VTK_TRIANGLE, { 0, 1, 4 } }, { VTK_LINE, { 0, 4 } }, { VTK_VERTEX, { 4 } } });
  const auto surface = vtkSmartPointer<vtkPolyData>(vtkPolyData::SafeDownCast(AsSurfaces(grid)));
  ASSERT_TRUE(surface);
  EXPECT_THAT(NumbersOf(surface), ElementsAre(4, 3, 1, 2, 0));
  EXPECT_THAT(PointsOf(surface, 2), ElementsAre(0, 1, 2, 3)) << "around the pixel";
  EXPECT_THAT(PointsOf(surface, 4), ElementsAre(0, 1, 3, 2));
  EXPECT_THAT(NumbersOf(grid), ElementsAre(0, 1, 2, 3, 4)) << "the input stays";
}

TEST(AsSurfaces, GridsWithOtherCellsStayAndAreDescribed)
{
  const auto grid = GridOf({ { VTK_TRIANGLE, { 0, 1, 2 } }, Tetrahedron });
  EXPECT_EQ(AsSurfaces(grid), grid);
  EXPECT_EQ(DescribeInput(grid), "a vtkUnstructuredGrid with cells that are no polygons (first cell 1: Tetra)");
  const auto curved = GridOf({ { VTK_QUADRATIC_TRIANGLE, { 0, 1, 2, 3, 4, 0 } } });
  EXPECT_EQ(AsSurfaces(curved), curved);
  EXPECT_EQ(AsSurfaces(nullptr), nullptr);
  const auto sphere = Icosphere(1).ToPolyData();
  EXPECT_EQ(AsSurfaces(sphere), sphere);
  vtkNew<vtkUnstructuredGrid> empty;
  EXPECT_TRUE(vtkPolyData::SafeDownCast(AsSurfaces(empty)));
}

TEST(AsSurfaces, LeavesOfATreeAreReplacedInACopy)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  const auto grid = GridOf({ { VTK_TRIANGLE, { 0, 1, 2 } } });
  blocks->SetBlock(0, grid);
  blocks->SetBlock(1, GridOf({ Tetrahedron }));
  blocks->SetBlock(3, Icosphere(1).ToPolyData());
  const auto made = AsSurfaces(blocks.Get());
  auto* tree = vtkMultiBlockDataSet::SafeDownCast(made);
  ASSERT_TRUE(tree);
  EXPECT_TRUE(vtkPolyData::SafeDownCast(tree->GetBlock(0)));
  EXPECT_TRUE(vtkUnstructuredGrid::SafeDownCast(tree->GetBlock(1)));
  EXPECT_EQ(tree->GetBlock(2), nullptr);
  EXPECT_TRUE(vtkPolyData::SafeDownCast(tree->GetBlock(3)));
  EXPECT_EQ(blocks->GetBlock(0), grid) << "the input stays";
  vtkNew<vtkMultiBlockDataSet> surfaces;
  surfaces->SetBlock(0, Icosphere(1).ToPolyData());
  EXPECT_EQ(AsSurfaces(surfaces), surfaces.Get());
}

TEST(AsSurfaces, FiltersOnSurfacesTakeGridsOfPolygons)
{
  const auto filter = vtkSmartPointer<FunctionFilter>::New();
  filter->Input = surfsynth::AcceptSurfaces;
  filter->DataObject = [](vtkAlgorithm*, vtkInformationVector** input, vtkInformationVector* output) {
    return surfsynth::RequestSurfaces(vtkDataObject::GetData(input[0]), output);
  };
  filter->Data = [](vtkAlgorithm* self, vtkInformationVector** input, vtkInformationVector* output) {
    return surfsynth::ProcessSurfaces(self, input, output, surfsynth::MeshRequirements(),
      [](const surfsynth::Surface& surface, vtkPolyData* made, const surfsynth::Progress&) {
        EXPECT_EQ(surface.Mesh.NumberOfTriangles(), 2);
        EXPECT_TRUE(made->GetCellData()->GetArray("Number"));
      });
  };
  filter->SetInputDataObject(GridOf({ { VTK_QUAD, { 0, 1, 2, 3 } } }));
  EventRecorder events(filter);
  filter->Update();
  EXPECT_THAT(events.Errors, ElementsAre());
  EXPECT_TRUE(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0)));
  filter->SetInputDataObject(GridOf({ Tetrahedron }));
  filter->Update();
  EXPECT_THAT(events.Errors, ElementsAre(HasSubstr("(first cell 0: Tetra)")));
}
