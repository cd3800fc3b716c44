// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceInspection.h"

#include "CellReading.h"
#include "PolygonTriangulation.h"

#include "Core/Common/Errors.h"

#include <vtkDataArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <limits>

namespace surfsynth
{

namespace
{
/// Reads the cells of one surface.
class SurfaceReader
{
public:
  SurfaceReader(InspectedSurface& surface, vtkPolyData* input)
    : Surface(surface)
    , Input(input)
  {}

  void ReadPoints()
  {
    vtkDataArray* array = this->Input->GetPoints() ? this->Input->GetPoints()->GetData() : nullptr;
    this->Surface.Points = array ? std::max<std::int64_t>(array->GetNumberOfTuples(), 0) : 0;
    this->Surface.PointComponents = array ? array->GetNumberOfComponents() : 3;
    if (this->Surface.Points > std::numeric_limits<Index>::max())
    {
      throw InvalidInput(
        "The mesh has " + std::to_string(this->Surface.Points) + " points; at most 2147483647 are allowed.");
    }
    PointMatrix& points = this->Surface.Mesh.Points;
    points.resize(this->Surface.PointComponents == 3 ? this->Surface.Points : 0, 3);
    for (Eigen::Index p = 0; p < points.rows(); ++p)
    {
      array->GetTuple(p, points.row(p).data());
    }
  }

  void ReadCells()
  {
    InspectedSurface& surface = this->Surface;
    surface.Vertices = CountCells(this->Input->GetVerts());
    surface.Lines = CountCells(this->Input->GetLines());
    surface.Strips = CountCells(this->Input->GetStrips());
    std::int64_t first = 0;
    const auto ignore = [&](std::int64_t cell, const auto* ids, std::int64_t size) {
      if (size < 0 || !InRange(ids, size, surface.Points))
      {
        surface.IgnoredCells.Add(first + cell);
      }
    };
    EachCell(this->Input->GetVerts(), ignore);
    first += surface.Vertices;
    EachCell(this->Input->GetLines(), ignore);
    first += surface.Lines;
    EachCell(this->Input->GetPolys(), [&](std::int64_t cell, const auto* ids, std::int64_t size) {
      this->CountPolygon(size);
      this->ReadPolygon(first + cell, ids, size);
    });
    first += CountCells(this->Input->GetPolys());
    EachCell(this->Input->GetStrips(),
      [&](std::int64_t cell, const auto* ids, std::int64_t size) { this->ReadStrip(first + cell, ids, size); });
    surface.Mesh.Triangles = Eigen::Map<const TriangleMatrix>(
      this->Corners.data(), static_cast<Eigen::Index>(this->Corners.size() / 3), 3);
  }

private:
  void CountPolygon(std::int64_t size)
  {
    this->Surface.Triangles += size == 3 ? 1 : 0;
    this->Surface.Quads += size == 4 ? 1 : 0;
    this->Surface.Polygons += size > 4 ? 1 : 0;
  }

  /// True when the cell can be read; else counts its fault.
  template <typename Id>
  bool IsReadable(std::int64_t cell, const Id* ids, std::int64_t size)
  {
    if (size < 0)
    {
      this->Surface.Unreadable.Add(cell);
    }
    else if (!InRange(ids, size, this->Surface.Mesh.Points.rows()))
    {
      this->Surface.OutOfRange.Add(cell);
    }
    else if (size < 3)
    {
      this->Surface.TooFewPoints.Add(cell);
    }
    else
    {
      return true;
    }
    return false;
  }

  template <typename Id>
  void ReadPolygon(std::int64_t cell, const Id* ids, std::int64_t size)
  {
    if (!this->IsReadable(cell, ids, size))
    {
      return;
    }
    if (size == 3)
    {
      this->AddTriangle(cell, ids[0], ids[1], ids[2]);
      return;
    }
    this->Polygon.assign(ids, ids + size);
    this->Sorted = this->Polygon;
    std::sort(this->Sorted.begin(), this->Sorted.end());
    if (std::adjacent_find(this->Sorted.begin(), this->Sorted.end()) != this->Sorted.end())
    {
      this->Surface.RepeatedPoint.Add(cell);
      return;
    }
    const PointMatrix& points = this->Surface.Mesh.Points;
    const bool finite = std::all_of(
      this->Polygon.begin(), this->Polygon.end(), [&](Index id) { return points.row(id).allFinite(); });
    this->Cut.resize(static_cast<std::size_t>(3 * (size - 2)));
    if (!finite)
    {
      this->CutAsFan(); // into any triangles, so that the points are looked at
    }
    else if (!this->Triangulator.Triangulate(points, this->Polygon.data(), static_cast<Index>(size), this->Cut.data()))
    {
      this->Surface.Uncut.Add(cell);
      return;
    }
    for (std::size_t k = 0; k < this->Cut.size(); k += 3)
    {
      this->AddTriangle(cell, this->Cut[k], this->Cut[k + 1], this->Cut[k + 2]);
    }
  }

  void CutAsFan()
  {
    for (std::size_t k = 0; k + 2 < this->Polygon.size(); ++k)
    {
      this->Cut[3 * k] = this->Polygon[0];
      this->Cut[3 * k + 1] = this->Polygon[k + 1];
      this->Cut[3 * k + 2] = this->Polygon[k + 2];
    }
  }

  /// Triangles of a strip that use a point twice only join its parts.
  template <typename Id>
  void ReadStrip(std::int64_t cell, const Id* ids, std::int64_t size)
  {
    if (!this->IsReadable(cell, ids, size))
    {
      return;
    }
    for (std::int64_t k = 0; k + 2 < size; ++k)
    {
      if (ids[k] != ids[k + 1] && ids[k + 1] != ids[k + 2] && ids[k + 2] != ids[k])
      {
        this->AddTriangle(cell, ids[k % 2 == 0 ? k : k + 1], ids[k % 2 == 0 ? k + 1 : k], ids[k + 2]);
      }
    }
  }

  template <typename Id>
  void AddTriangle(std::int64_t cell, Id a, Id b, Id c)
  {
    this->Corners.insert(this->Corners.end(), { static_cast<Index>(a), static_cast<Index>(b), static_cast<Index>(c) });
    this->Surface.CellOfTriangle.push_back(cell);
  }

  InspectedSurface& Surface;
  vtkPolyData* Input;
  PolygonTriangulator Triangulator;
  std::vector<Index> Corners;
  std::vector<Index> Polygon;
  std::vector<Index> Sorted;
  std::vector<Index> Cut;
};
} // namespace

InspectedSurface InspectSurface(vtkPolyData* input)
{
  InspectedSurface surface;
  SurfaceReader reader(surface, input);
  reader.ReadPoints();
  reader.ReadCells();
  return surface;
}

} // namespace surfsynth
