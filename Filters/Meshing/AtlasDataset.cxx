// SPDX-License-Identifier: BSD-3-Clause
#include "AtlasDataset.h"

#include "NewArray.h"
#include "SurfaceArrays.h"

#include "Core/Mesh/MeshCheck.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// The mesh with points of equal coordinates as one, where it then meets the requirements of an atlas; else as it is.
TriangleMesh Welded(vtkPolyData* input, const TriangleMesh& mesh)
{
  vtkNew<vtkPolyData> bare; // without arrays, so that only coordinates count
  bare->SetPoints(input->GetPoints());
  const std::vector<Index> lowest = AttributeClasses(bare, mesh.Points);
  TriangleMesh welded = mesh;
  std::for_each(welded.Triangles.data(), welded.Triangles.data() + welded.Triangles.size(),
    [&](Index& point) { point = lowest[static_cast<std::size_t>(point)]; });
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  return CheckMesh(welded, requirements).empty() ? welded : mesh;
}

/// Multiplies the points by a power of two, which changes no ratio, so that the longest side of the triangles' box is
/// between 1/2 and 1: areas then neither overflow nor vanish. Returns the exponent.
int ScaleToUnitSize(TriangleMesh& mesh)
{
  Eigen::RowVector3d lower = mesh.Points.row(mesh.Triangles(0, 0));
  Eigen::RowVector3d upper = lower;
  std::for_each(mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size(), [&](Index point) {
    lower = lower.cwiseMin(mesh.Points.row(point));
    upper = upper.cwiseMax(mesh.Points.row(point));
  });
  int exponent = 0;
  std::frexp((upper - lower).maxCoeff(), &exponent);
  std::for_each(mesh.Points.data(), mesh.Points.data() + mesh.Points.size(),
    [exponent](double& value) { value = std::ldexp(value, -exponent); });
  return -exponent;
}

/// Points of the output: those of the input, in order, then copies of points with several texture coordinates.
class AtlasPoints
{
public:
  AtlasPoints(const TriangleMesh& mesh, const TextureCoordinates& coordinates)
    : Next(static_cast<std::size_t>(mesh.NumberOfPoints()), None)
    , Corner(static_cast<std::size_t>(mesh.NumberOfPoints()), None)
    , Originals(static_cast<std::size_t>(mesh.NumberOfPoints()))
    , PointOfCorner(static_cast<std::size_t>(coordinates.rows()))
  {
    for (std::size_t p = 0; p < this->Originals.size(); ++p)
    {
      this->Originals[p] = static_cast<std::int64_t>(p);
    }
    for (std::int64_t corner = 0; corner < coordinates.rows(); ++corner)
    {
      this->PointOfCorner[corner] = this->Find(mesh.Triangles(corner / 3, corner % 3), corner, coordinates);
    }
  }

  static constexpr std::int64_t None = -1;
  std::vector<std::int64_t> Next;          ///< the next copy of the same point
  std::vector<std::int64_t> Corner;        ///< a corner at each point, whose texture coordinates it has; None without
  std::vector<std::int64_t> Originals;     ///< point of the input
  std::vector<std::int64_t> PointOfCorner; ///< [3 F]

private:
  std::int64_t Find(std::int64_t point, std::int64_t corner, const TextureCoordinates& coordinates)
  {
    const std::int64_t original = point;
    while (this->Corner[point] != None && coordinates.row(this->Corner[point]) != coordinates.row(corner))
    {
      if (this->Next[point] == None)
      {
        this->Next[point] = static_cast<std::int64_t>(this->Originals.size());
        this->Originals.push_back(original);
        this->Next.push_back(None);
        this->Corner.push_back(None);
      }
      point = this->Next[point];
    }
    this->Corner[point] = corner;
    return point;
  }
};

/// Cells of the output, their charts, and the cells of the input that they come from.
struct AtlasCells
{
  vtkNew<vtkCellArray> Polygons;
  std::vector<std::int64_t> Origins;
  std::vector<int> Charts;

  void Add(vtkIdType size, const vtkIdType* points, std::int64_t origin, int chart)
  {
    this->Polygons->InsertNextCell(size, points);
    this->Origins.push_back(origin);
    this->Charts.push_back(chart);
  }
};

/// Turns the cells of a surface, with their triangles, into cells on the points of its atlas.
class CellMaker
{
public:
  CellMaker(vtkPolyData* input, const Surface& surface, const SurfaceAtlas& atlas, const AtlasPoints& points)
    : Input(input)
    , TheSurface(surface)
    , Atlas(atlas)
    , Points(points)
  {
    const vtkIdType others = input->GetNumberOfVerts() + input->GetNumberOfLines();
    for (vtkIdType cell = 0; cell < others; ++cell)
    {
      this->Made.Origins.push_back(cell);
      this->Made.Charts.push_back(-1);
    }
    const std::int64_t count = surface.Mesh.NumberOfTriangles();
    for (std::int64_t begin = 0, end = 0; begin < count; begin = end)
    {
      for (end = begin + 1; end < count && surface.Cell(end) == surface.Cell(begin); ++end)
      {}
      this->AddCell(begin, end);
    }
  }

  AtlasCells Made;

private:
  /// Adds the polygon of triangles begin to end, or these triangles when a seam divides it, or for a strip.
  void AddCell(std::int64_t begin, std::int64_t end)
  {
    const std::int64_t cell = this->TheSurface.Cell(begin);
    const bool isPolygon = cell <
      this->Input->GetNumberOfVerts() + this->Input->GetNumberOfLines() + this->Input->GetNumberOfPolys();
    if (isPolygon && end - begin > 1 && this->Undivided(begin, end))
    {
      this->AddPolygon(cell, begin);
      return;
    }
    for (std::int64_t f = begin; f < end; ++f)
    {
      const vtkIdType triangle[3] = { this->Points.PointOfCorner[3 * f], this->Points.PointOfCorner[3 * f + 1],
        this->Points.PointOfCorner[3 * f + 2] };
      this->Made.Add(3, triangle, cell, static_cast<int>(this->Atlas.ChartOfTriangle[f]));
    }
  }

  /// True when the triangles lie in one chart, which gives each point of the polygon one place.
  bool Undivided(std::int64_t begin, std::int64_t end)
  {
    this->Corners.clear();
    for (std::int64_t corner = 3 * begin; corner < 3 * end; ++corner)
    {
      this->Corners.emplace_back(
        this->TheSurface.Mesh.Triangles(corner / 3, corner % 3), this->Points.PointOfCorner[corner]);
    }
    std::sort(this->Corners.begin(), this->Corners.end());
    this->Corners.erase(std::unique(this->Corners.begin(), this->Corners.end()), this->Corners.end());
    const auto& charts = this->Atlas.ChartOfTriangle;
    return static_cast<std::int64_t>(this->Corners.size()) == end - begin + 2 &&
      std::all_of(charts.begin() + begin, charts.begin() + end, [&](Index chart) { return chart == charts[begin]; });
  }

  void AddPolygon(std::int64_t cell, std::int64_t begin)
  {
    const vtkIdType first = this->Input->GetNumberOfVerts() + this->Input->GetNumberOfLines();
    this->Input->GetPolys()->GetCellAtId(cell - first, this->Ids);
    this->Polygon.clear();
    for (vtkIdType k = 0; k < this->Ids->GetNumberOfIds(); ++k)
    {
      const std::pair<std::int64_t, std::int64_t> from(this->Ids->GetId(k), 0);
      this->Polygon.push_back(std::lower_bound(this->Corners.begin(), this->Corners.end(), from)->second);
    }
    this->Made.Add(static_cast<vtkIdType>(this->Polygon.size()), this->Polygon.data(), cell,
      static_cast<int>(this->Atlas.ChartOfTriangle[begin]));
  }

  vtkPolyData* Input;
  const Surface& TheSurface;
  const SurfaceAtlas& Atlas;
  const AtlasPoints& Points;
  std::vector<std::pair<std::int64_t, std::int64_t>> Corners; ///< points of the cell at hand: of input and output
  std::vector<vtkIdType> Polygon;
  vtkNew<vtkIdList> Ids;
};

void SetPoints(vtkPolyData* input, const std::vector<std::int64_t>& originals, vtkPolyData* output)
{
  vtkNew<vtkPoints> points;
  points->SetDataType(input->GetPoints()->GetDataType());
  points->SetNumberOfPoints(static_cast<vtkIdType>(originals.size()));
  for (std::size_t p = 0; p < originals.size(); ++p)
  {
    points->GetData()->SetTuple(static_cast<vtkIdType>(p), originals[p], input->GetPoints()->GetData());
  }
  output->SetPoints(points);
}

void AddPointArrays(const AtlasPoints& points, const TextureCoordinates& coordinates, vtkPointData* data)
{
  const auto count = static_cast<vtkIdType>(points.Originals.size());
  const auto texture = NewArray<vtkDoubleArray>("TCoords", count, 2);
  const auto originals = NewArray<vtkIdTypeArray>("OriginalPoint", count, 1);
  for (vtkIdType p = 0; p < count; ++p)
  {
    originals->SetValue(p, points.Originals[p]);
    if (points.Corner[p] != AtlasPoints::None)
    {
      texture->SetTypedComponent(p, 0, coordinates(points.Corner[p], 0));
      texture->SetTypedComponent(p, 1, coordinates(points.Corner[p], 1));
    }
  }
  data->AddArray(originals);
  data->SetTCoords(texture); // the former active ones stay as an array
}

void AddMeasures(const SurfaceAtlas& atlas, vtkFieldData* data)
{
  const std::pair<const char*, double> measures[] = { { "NumberOfCharts", static_cast<double>(atlas.NumberOfCharts) },
    { "Coverage", atlas.Coverage }, { "RootMeanStretch", atlas.RootMeanStretch },
    { "LargestStretch", atlas.LargestStretch }, { "TexelsPerLength", atlas.TexelsPerLength } };
  for (const auto& measure : measures)
  {
    const auto array = NewArray<vtkDoubleArray>(measure.first, 1, 1);
    array->SetValue(0, measure.second);
    data->AddArray(array);
  }
}
} // namespace

SurfaceAtlas MakeAtlas(vtkPolyData* input, const std::shared_ptr<const Surface>& surface,
  const SurfaceAtlasOptions& options, const Progress& progress)
{
  TriangleMesh welded = Welded(input, surface->Mesh);
  const int exponent = ScaleToUnitSize(welded);
  const auto mesh = std::make_shared<const TriangleMesh>(std::move(welded));
  const auto atlas = std::make_shared<SurfaceAtlas>(); // shared with the work, which outlives a cancelled call
  const double expectedSeconds = 0.2 + 3e-5 * mesh->NumberOfTriangles();
  const auto work = [mesh, atlas, options](
                      const std::atomic<bool>& stop) { *atlas = MakeSurfaceAtlas(*mesh, options, &stop); };
  RunCancellable(work, expectedSeconds, progress);
  atlas->TexelsPerLength = std::ldexp(atlas->TexelsPerLength, exponent);
  return std::move(*atlas);
}

void FillAtlas(vtkPolyData* input, const Surface& surface, const SurfaceAtlas& atlas, vtkPolyData* output)
{
  const AtlasPoints points(surface.Mesh, atlas.Coordinates);
  const CellMaker cells(input, surface, atlas, points);
  SetPoints(input, points.Originals, output);
  output->SetVerts(input->GetVerts());
  output->SetLines(input->GetLines());
  output->SetPolys(cells.Made.Polygons);
  PickArrays(input->GetPointData(), points.Originals, output->GetPointData());
  AddPointArrays(points, atlas.Coordinates, output->GetPointData());
  PickArrays(input->GetCellData(), cells.Made.Origins, output->GetCellData());
  const auto charts = NewArray<vtkIntArray>("Chart", static_cast<vtkIdType>(cells.Made.Charts.size()), 1);
  std::copy(cells.Made.Charts.begin(), cells.Made.Charts.end(), charts->GetPointer(0));
  output->GetCellData()->AddArray(charts);
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  AddMeasures(atlas, output->GetFieldData());
}

} // namespace surfsynth
