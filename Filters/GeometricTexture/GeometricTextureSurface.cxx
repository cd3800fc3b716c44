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
/// Returns the place of each point of @p level on the target, which has @p triangles triangles: triangle f of a
/// subdivided mesh comes from triangle f modulo that number.
std::vector<SurfacePlace> PlacesOn(const TriangleMesh& surface, const GeometricTextureLevel& level)
{
  const TriangleMatrix& triangles = level.Mesh.Triangles;
  std::vector<SurfacePlace> places(static_cast<std::size_t>(level.Base.rows()));
  for (Eigen::Index f = triangles.rows() - 1; f >= 0; --f)
  {
    for (int k = 0; k < 3; ++k)
    {
      places[static_cast<std::size_t>(triangles(f, k))].Triangle = static_cast<Index>(f % surface.Triangles.rows());
    }
  }
  ParallelFor(level.Base.rows(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p)
    {
      SurfacePlace& place = places[static_cast<std::size_t>(p)];
      place = NearestOnTriangle(surface, place.Triangle, level.Base.row(p).transpose());
    }
  });
  return places;
}

void CarryArrays(vtkPolyData* input, const Surface& surface, const GeometricTextureLevel& level, vtkPolyData* output)
{
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
  if (input->GetPointData()->GetNumberOfArrays() > 0)
  {
    InterpolateArrays(input->GetPointData(), surface.Mesh, PlacesOn(surface.Mesh, level), output->GetPointData());
  }
  if (input->GetCellData()->GetNumberOfArrays() > 0)
  {
    std::vector<std::int64_t> cells(static_cast<std::size_t>(level.Mesh.NumberOfTriangles()));
    for (std::size_t f = 0; f < cells.size(); ++f)
    {
      cells[f] = surface.Cell(static_cast<std::int64_t>(f) % surface.Mesh.NumberOfTriangles());
    }
    PickArrays(input->GetCellData(), cells, output->GetCellData());
  }
  DropNormals(output);
}
} // namespace

void FillGeometricTextureSurface(vtkPolyData* input, const Surface& surface, const GeometricTextureResult& texture,
  int step, double part, const GeometricTextureArrayNames& names, vtkPolyData* output)
{
  const GeometricTextureLevel& level = texture.Level(step);
  TriangleMesh mesh = level.Mesh;
  if (part < 1.0)
  {
    mesh.Points -= (1.0 - part) * level.Displacement;
  }
  SetGeometry(output, mesh, HasDoublePoints(input));
  CarryArrays(input, surface, level, output);

  const auto points = static_cast<vtkIdType>(mesh.NumberOfPoints());
  auto displacement = NewArray<vtkDoubleArray>(names.Displacement, points, 3);
  Eigen::Map<PointMatrix>(displacement->GetPointer(0), points, 3) = mesh.Points - level.Base;
  auto levels = NewArray<vtkIntArray>(names.Level, points, 1);
  for (vtkIdType p = 0; p < points; ++p)
  {
    levels->SetValue(p, texture.LevelOfPoint(static_cast<Index>(p)));
  }
  vtkPointData* data = output->GetPointData();
  data->AddArray(displacement);
  data->AddArray(levels);
  if (!data->GetVectors())
  {
    data->SetActiveVectors(names.Displacement.c_str());
  }
}

} // namespace surfsynth
