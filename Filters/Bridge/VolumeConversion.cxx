// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeBridge.h"

#include "CellReading.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>

namespace surfsynth
{

namespace
{
/// Least points of a thread's part of a search.
constexpr std::int64_t SearchGrain = 64;

/// True for cells of at most two dimensions, which are no part of a volume.
bool IsFlat(int type)
{
  switch (type)
  {
    case VTK_EMPTY_CELL:
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
    case VTK_LINE:
    case VTK_POLY_LINE:
    case VTK_TRIANGLE:
    case VTK_TRIANGLE_STRIP:
    case VTK_POLYGON:
    case VTK_PIXEL:
    case VTK_QUAD:
    case VTK_QUADRATIC_EDGE:
    case VTK_QUADRATIC_TRIANGLE:
    case VTK_QUADRATIC_QUAD:
      return true;
    default:
      return false;
  }
}

/// Type of a cell; that of an empty one where the grid has no type for it.
int TypeOf(vtkUnstructuredGrid* grid, vtkIdType cell)
{
  vtkUnsignedCharArray* types = grid->GetCellTypesArray();
  return types && cell < types->GetNumberOfValues() ? static_cast<int>(types->GetValue(cell))
                                                    : static_cast<int>(VTK_EMPTY_CELL);
}

/// Throws InvalidInput with the number of cells of each type, unless those of three dimensions are tetrahedra.
void RequireTetrahedra(vtkUnstructuredGrid* grid)
{
  std::map<int, std::int64_t> counts;
  bool hasOthers = false;
  for (vtkIdType cell = 0; cell < CountCells(grid->GetCells()); ++cell)
  {
    const int type = TypeOf(grid, cell);
    ++counts[type];
    hasOthers = hasOthers || !(type == VTK_TETRA || IsFlat(type));
  }
  if (!hasOthers)
  {
    return;
  }
  std::string found;
  for (const auto& [type, count] : counts)
  {
    const char* name = vtkCellTypes::GetClassNameFromTypeId(type);
    found += (found.empty() ? "" : ", ") + std::to_string(count) + " " + (name ? name + 3 : "?"); // without "vtk"
  }
  throw InvalidInput("The volume has cells that are no tetrahedra (" + found +
    "); vtkDataSetTriangleFilter divides other cells into tetrahedra, and vtkDataSetSurfaceFilter extracts the "
    "surface.");
}
} // namespace

bool IsVolume(vtkDataObject* data)
{
  auto* grid = vtkUnstructuredGrid::SafeDownCast(data);
  const vtkIdType cells = grid ? CountCells(grid->GetCells()) : 0;
  for (vtkIdType cell = 0; cell < cells; ++cell)
  {
    if (!IsFlat(TypeOf(grid, cell)))
    {
      return true;
    }
  }
  return false;
}

Surface ConvertVolume(vtkUnstructuredGrid* input)
{
  RequireTetrahedra(input);
  vtkNew<vtkPolyData> points;
  points->SetPoints(input->GetPoints());
  Surface volume;
  volume.Mesh.Points = ConvertPoints(points);
  const vtkIdType cells = CountCells(input->GetCells());
  if (cells > std::numeric_limits<Index>::max())
  {
    throw InvalidInput("The volume has " + std::to_string(cells) + " cells; at most 2147483647 are allowed.");
  }
  TetrahedronMatrix tetrahedra(cells, 4);
  Eigen::Index count = 0;
  EachCell(input->GetCells(), [&](vtkIdType cell, const auto* ids, vtkIdType size) {
    const bool isTetrahedron = TypeOf(input, cell) == VTK_TETRA;
    if (size < 0 || (isTetrahedron && size != 4))
    {
      throw InvalidInput("The offset of cell " + std::to_string(cell) +
        " does not fit the connectivity; a tetrahedron has four points. Write the dataset again with the program that "
        "made it.");
    }
    if (!isTetrahedron)
    {
      return;
    }
    for (int k = 0; k < 4; ++k)
    {
      const auto id = static_cast<std::int64_t>(ids[k]);
      tetrahedra(count, k) = id < volume.Mesh.NumberOfPoints() ? static_cast<Index>(std::max<std::int64_t>(id, -1))
                                                               : volume.Mesh.NumberOfPoints();
    }
    volume.CellOfTriangle.push_back(cell);
    ++count;
  });
  if (count == cells)
  {
    volume.CellOfTriangle.clear();
  }
  tetrahedra.conservativeResize(count, 4);
  volume.Volume = TetrahedralMesh{ volume.Mesh.Points, std::move(tetrahedra) };
  return volume;
}

std::vector<VolumePlace> FindNearestPlaces(const TetrahedralMesh& mesh, const PointMatrix& points)
{
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetArray(const_cast<double*>(mesh.Points.data()), mesh.Points.size(), 1); // which only is read
  vtkNew<vtkPoints> places;
  places->SetDataTypeToDouble();
  places->SetData(coordinates);
  grid->SetPoints(places);
  vtkNew<vtkIdTypeArray> ids;
  ids->SetNumberOfValues(mesh.Tetrahedra.size());
  std::copy_n(mesh.Tetrahedra.data(), mesh.Tetrahedra.size(), ids->GetPointer(0));
  vtkNew<vtkCellArray> cells;
  cells->SetData(4, ids);
  grid->SetCells(VTK_TETRA, cells);
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(grid);
  locator->BuildLocator();
  std::vector<VolumePlace> found(static_cast<std::size_t>(points.rows()));
  ParallelFor(points.rows(), SearchGrain, [&](std::int64_t begin, std::int64_t end) {
    vtkNew<vtkGenericCell> cell;
    for (std::int64_t p = begin; p < end; ++p)
    {
      double nearest[3];
      vtkIdType id = -1;
      int subId = 0;
      double squaredDistance = 0.0;
      locator->FindClosestPoint(points.row(p).data(), nearest, cell, id, subId, squaredDistance);
      const Index t = id >= 0 ? static_cast<Index>(id) : 0;
      found[static_cast<std::size_t>(p)] = NearestInTetrahedron(mesh, t, points.row(p).transpose());
    }
  });
  return found;
}

} // namespace surfsynth
