// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTextureSurface.h"

#include "NewArray.h"
#include "SurfaceArrays.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <vector>

namespace surfsynth
{

namespace
{
/// Returns the place of each point of @p base, a subdivision of the target: triangle f of it comes from triangle f modulo the
/// number of triangles of the target.
std::vector<SurfacePlace> PlacesOn(const TriangleMesh& surface, const TriangleMesh& base)
{
  const TriangleMatrix& triangles = base.Triangles;
  std::vector<SurfacePlace> places(static_cast<std::size_t>(base.NumberOfPoints()));
  for (Eigen::Index f = triangles.rows() - 1; f >= 0; --f)
  {
    for (int k = 0; k < 3; ++k)
    {
      places[static_cast<std::size_t>(triangles(f, k))].Triangle = static_cast<Index>(f % surface.Triangles.rows());
    }
  }
  ParallelFor(base.NumberOfPoints(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p)
    {
      SurfacePlace& place = places[static_cast<std::size_t>(p)];
      place = NearestOnTriangle(surface, place.Triangle, base.Points.row(p).transpose());
    }
  });
  return places;
}

void CarryArrays(vtkPolyData* input, const Surface& surface, const TriangleMesh& base, vtkPolyData* output)
{
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  if (input->GetPointData()->GetNumberOfArrays() > 0)
  {
    InterpolateArrays(input->GetPointData(), surface.Mesh, PlacesOn(surface.Mesh, base), output->GetPointData());
  }
  if (input->GetCellData()->GetNumberOfArrays() > 0)
  {
    std::vector<std::int64_t> cells(static_cast<std::size_t>(base.NumberOfTriangles()));
    for (std::size_t f = 0; f < cells.size(); ++f)
    {
      cells[f] = surface.Cell(static_cast<std::int64_t>(f) % surface.Mesh.NumberOfTriangles());
    }
    PickArrays(input->GetCellData(), cells, output->GetCellData());
  }
  DropNormals(output);
}
} // namespace

void FillDisplacedSurface(vtkPolyData* input, const Surface& surface, const TriangleMesh& base,
  const PointMatrix& displacement, const std::string& name, vtkPolyData* output)
{
  SetGeometry(output, { base.Points + displacement, base.Triangles }, HasDoublePoints(input));
  CarryArrays(input, surface, base, output);
  auto array = NewArray<vtkDoubleArray>(name, static_cast<vtkIdType>(displacement.rows()), 3);
  Eigen::Map<PointMatrix>(array->GetPointer(0), displacement.rows(), 3) = displacement;
  vtkPointData* data = output->GetPointData();
  data->AddArray(array);
  if (!data->GetVectors())
  {
    data->SetActiveVectors(name.c_str());
  }
}

void FillGeometricTextureSurface(vtkPolyData* input, const Surface& surface, const GeometricTextureResult& texture,
  int step, double part, const GeometricTextureArrayNames& names, vtkPolyData* output)
{
  const GeometricTextureLevel& level = texture.Level(step);
  PointMatrix displacement = level.Mesh.Points - level.Base;
  if (part < 1.0)
  {
    displacement -= (1.0 - part) * level.Displacement;
  }
  FillDisplacedSurface(input, surface, { level.Base, level.Mesh.Triangles }, displacement, names.Displacement, output);
  const auto points = static_cast<vtkIdType>(displacement.rows());
  auto levels = NewArray<vtkIntArray>(names.Level, points, 1);
  for (vtkIdType p = 0; p < points; ++p)
  {
    levels->SetValue(p, texture.LevelOfPoint(static_cast<Index>(p)));
  }
  output->GetPointData()->AddArray(levels);
}

} // namespace surfsynth
