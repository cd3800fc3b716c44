// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceCoordinates.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr const char* Remedy = " vtkTextureAtlasFilter makes texture coordinates.";

/// Sentences about those findings that are of the kind @p defect; empty without such.
std::string Describe(const std::vector<AtlasFinding>& findings, AtlasDefect defect, const Surface& surface)
{
  std::vector<AtlasFinding> chosen;
  std::copy_if(findings.begin(), findings.end(), std::back_inserter(chosen),
    [defect](const AtlasFinding& finding) { return finding.Defect == defect; });
  return DescribeAtlasFindings(chosen, [&surface](std::int64_t f) { return surface.Cell(f); });
}

std::string Describe(const TextureCoordinates& coordinates, AtlasDefect defect, const Surface& surface)
{
  return Describe(CheckTextureCoordinates(coordinates, surface.Mesh.NumberOfTriangles()), defect, surface);
}

vtkDataArray* CoordinateArray(vtkPolyData* polydata)
{
  vtkDataArray* array = polydata->GetPointData()->GetTCoords();
  if (!array)
  {
    throw InvalidInput(std::string("The surface has no texture coordinates.") + Remedy);
  }
  if (array->GetNumberOfComponents() < 2 || array->GetNumberOfComponents() > 3 ||
    array->GetNumberOfTuples() != polydata->GetNumberOfPoints())
  {
    throw InvalidInput("The texture coordinates of the surface have " +
      FormatCount(array->GetNumberOfComponents(), "component") + " and " +
      FormatCount(array->GetNumberOfTuples(), "tuple") + " for " + FormatCount(polydata->GetNumberOfPoints(), "point") +
      "; two components and a tuple for each point are needed." + Remedy);
  }
  return array;
}
} // namespace

TextureCoordinates ReadTextureCoordinates(vtkPolyData* polydata, const Surface& surface)
{
  vtkDataArray* array = CoordinateArray(polydata);
  const TriangleMatrix& triangles = surface.Mesh.Triangles;
  TextureCoordinates coordinates(triangles.size(), 2);
  std::array<double, 3> tuple{};
  for (Eigen::Index corner = 0; corner < triangles.size(); ++corner)
  {
    array->GetTuple(triangles.data()[corner], tuple.data());
    coordinates.row(corner) << tuple[0], tuple[1];
  }
  if (!coordinates.allFinite())
  {
    throw InvalidInput(Describe(coordinates, AtlasDefect::NonFiniteCoordinate, surface) + Remedy);
  }
  return coordinates;
}

bool IsRepeated(const TextureCoordinates& coordinates, const Surface& surface)
{
  return !Describe(coordinates, AtlasDefect::OutsideUnitSquare, surface).empty();
}

std::string DescribeDegenerateCoordinates(const TextureCoordinates& coordinates, const Surface& surface)
{
  return Describe(coordinates, AtlasDefect::DegenerateTriangle, surface);
}

void RequireAtlas(const TextureCoordinates& coordinates, const Surface& surface)
{
  const std::string outside = Describe(coordinates, AtlasDefect::OutsideUnitSquare, surface);
  if (!outside.empty())
  {
    throw InvalidInput(outside + Remedy);
  }
}

} // namespace surfsynth
