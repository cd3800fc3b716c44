// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceInputs.h"

#include "CellReading.h"
#include "OutputSeries.h"
#include "ProcessingSupport.h"

#include <vtkAlgorithm.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <vector>

namespace surfsynth
{

namespace
{
/// Lists of cells of a vtkPolyData, in their order; cells of no list are no part of a surface.
enum CellList
{
  Vertices,
  Lines,
  Polygons,
  Strips,
  None
};

CellList ListOf(int type)
{
  switch (type)
  {
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
      return Vertices;
    case VTK_LINE:
    case VTK_POLY_LINE:
      return Lines;
    case VTK_TRIANGLE:
    case VTK_POLYGON:
    case VTK_PIXEL:
    case VTK_QUAD:
      return Polygons;
    case VTK_TRIANGLE_STRIP:
      return Strips;
    default:
      return None;
  }
}

/// Types of the cells of a grid, and the first cell that is no part of a surface.
struct Inspection
{
  explicit Inspection(vtkUnstructuredGrid* grid)
    : Types(grid->GetCellTypesArray())
    , Count(CountCells(grid->GetCells()))
  {
    const vtkIdType types = this->Types ? this->Types->GetNumberOfValues() : 0;
    for (vtkIdType cell = 0; cell < this->Count && this->FirstOther < 0; ++cell)
    {
      const int type = cell < types ? static_cast<int>(this->Types->GetValue(cell)) : static_cast<int>(VTK_EMPTY_CELL);
      this->OnlyPolygons = this->OnlyPolygons && ListOf(type) == Polygons && type != VTK_PIXEL;
      this->FirstOther = ListOf(type) == None ? cell : -1;
    }
  }

  vtkUnsignedCharArray* Types;
  vtkIdType Count;
  vtkIdType FirstOther = -1;
  bool OnlyPolygons = true; ///< whose points are in the order of polygons
};

/// Cells of a grid, sorted into the lists of a vtkPolyData.
class SortedCells
{
public:
  /// @return false for a cell whose offsets do not fit the connectivity.
  bool Add(vtkCellArray* cells, vtkUnsignedCharArray* types)
  {
    bool fits = true;
    EachCell(cells, [&](vtkIdType cell, const auto* ids, vtkIdType size) {
      fits = fits && size >= 0;
      if (fits)
      {
        const int type = types->GetValue(cell);
        this->AddCell(cell, type, { ids, ids + size });
      }
    });
    return fits;
  }

  void Fill(vtkUnstructuredGrid* grid, vtkPolyData* surface) const
  {
    surface->SetVerts(this->Lists[Vertices]);
    surface->SetLines(this->Lists[Lines]);
    surface->SetPolys(this->Lists[Polygons]);
    surface->SetStrips(this->Lists[Strips]);
    vtkNew<vtkIdList> from;
    vtkNew<vtkIdList> to;
    for (const std::vector<vtkIdType>& ids : this->Ids)
    {
      for (const vtkIdType id : ids)
      {
        to->InsertNextId(from->InsertNextId(id));
      }
    }
    surface->GetCellData()->CopyAllOn();
    surface->GetCellData()->CopyAllocate(grid->GetCellData(), from->GetNumberOfIds());
    surface->GetCellData()->CopyData(grid->GetCellData(), from, to);
  }

private:
  void AddCell(vtkIdType cell, int type, std::vector<vtkIdType> points)
  {
    if (type == VTK_PIXEL && points.size() == 4)
    {
      std::swap(points[2], points[3]);
    }
    const CellList list = ListOf(type);
    this->Lists[list]->InsertNextCell(static_cast<vtkIdType>(points.size()), points.data());
    this->Ids[list].push_back(cell);
  }

  std::array<vtkNew<vtkCellArray>, None> Lists;
  std::array<std::vector<vtkIdType>, None> Ids; ///< of the cells of each list in the grid
};

/// The grid as surface; null when it has other cells.
vtkSmartPointer<vtkPolyData> SurfaceOf(vtkUnstructuredGrid* grid)
{
  const Inspection found(grid);
  if (found.FirstOther >= 0)
  {
    return nullptr;
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(grid->GetPoints());
  surface->GetPointData()->ShallowCopy(grid->GetPointData());
  surface->GetFieldData()->ShallowCopy(grid->GetFieldData());
  if (found.OnlyPolygons)
  {
    surface->SetPolys(found.Count > 0 ? grid->GetCells() : nullptr);
    surface->GetCellData()->ShallowCopy(grid->GetCellData());
    return surface;
  }
  SortedCells cells;
  if (!cells.Add(grid->GetCells(), found.Types))
  {
    return nullptr;
  }
  cells.Fill(grid, surface);
  return surface;
}

/// The tree with surfaces in place of its grids.
vtkSmartPointer<vtkDataObject> TreeOfSurfaces(vtkDataObjectTree* tree)
{
  vtkSmartPointer<vtkDataObjectTree> copy;
  EachLeaf(tree, [&](vtkDataObjectTreeIterator* place) {
    auto* grid = vtkUnstructuredGrid::SafeDownCast(place->GetCurrentDataObject());
    const auto surface = grid ? SurfaceOf(grid) : nullptr;
    if (surface && !copy)
    {
      copy = vtkSmartPointer<vtkDataObjectTree>::Take(tree->NewInstance());
      copy->ShallowCopy(tree);
    }
    if (surface)
    {
      copy->SetDataSet(place, surface);
    }
  });
  return copy ? vtkSmartPointer<vtkDataObject>(copy) : vtkSmartPointer<vtkDataObject>(tree);
}
} // namespace

vtkSmartPointer<vtkDataObject> AsSurfaces(vtkDataObject* data)
{
  if (auto* grid = vtkUnstructuredGrid::SafeDownCast(data))
  {
    const auto surface = SurfaceOf(grid);
    return surface ? vtkSmartPointer<vtkDataObject>(surface) : vtkSmartPointer<vtkDataObject>(data);
  }
  auto* tree = vtkDataObjectTree::SafeDownCast(data);
  return tree ? TreeOfSurfaces(tree) : vtkSmartPointer<vtkDataObject>(data);
}

vtkSmartPointer<vtkPolyData> SurfaceOn(vtkInformationVector* port)
{
  return vtkPolyData::SafeDownCast(AsSurfaces(vtkDataObject::GetData(port)));
}

std::string DescribeInput(vtkDataObject* data)
{
  if (!data)
  {
    return "missing";
  }
  std::string text = std::string("a ") + data->GetClassName();
  if (auto* grid = vtkUnstructuredGrid::SafeDownCast(data))
  {
    const Inspection found(grid);
    if (found.FirstOther >= 0)
    {
      const std::string name = vtkCellTypes::GetClassNameFromTypeId(grid->GetCellType(found.FirstOther));
      text += " with cells that are no polygons (first cell " + std::to_string(found.FirstOther) + ": " +
        name.substr(3) + ")"; // without "vtk"
    }
  }
  return text;
}

int AcceptSurface(vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  return 1;
}

int RequestSurfaces(vtkDataObject* input, vtkInformationVector* outputVector)
{
  SetOutputClass(outputVector, vtkDataObjectTree::SafeDownCast(input) ? input->GetClassName() : "vtkPolyData");
  return 1;
}

} // namespace surfsynth
