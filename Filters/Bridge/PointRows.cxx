// SPDX-License-Identifier: BSD-3-Clause
#include "PointRows.h"

#include "Core/Common/Errors.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

namespace surfsynth
{

std::string FormatCount(std::int64_t count, const std::string& thing)
{
  return (count == 0 ? "no" : std::to_string(count)) + " " + thing + (count == 1 ? "" : "s");
}

PointRows ReadPointRows(
  vtkPolyData* surface, const UsedPoints& points, const NamedPointArray& array, std::int64_t components)
{
  vtkDataArray* values = surface->GetPointData()->GetArray(array.Name.c_str());
  const std::string expected = "; the model needs one with " + FormatCount(components, "component") +
    " and a tuple for each point.";
  if (!values)
  {
    throw InvalidInput("There is no point array \"" + array.Name + "\", which " + array.Property + " names" + expected +
      " (Arrays of a surface whose pieces lie on several MPI ranks are not gathered.)");
  }
  if (values->GetNumberOfComponents() != components || values->GetNumberOfTuples() != surface->GetNumberOfPoints())
  {
    throw InvalidInput("The point array \"" + array.Name + "\", which " + array.Property + " names, has " +
      FormatCount(values->GetNumberOfComponents(), "component") + " and " +
      FormatCount(values->GetNumberOfTuples(), "tuple") + " for " + FormatCount(surface->GetNumberOfPoints(), "point") +
      expected);
  }
  PointRows rows(points.Count(), components);
  for (Index k = 0; k < points.Count(); ++k)
  {
    values->GetTuple(points.Id(k), rows.row(k).data());
    if (!rows.row(k).cast<float>().allFinite())
    {
      throw InvalidInput("The point array \"" + array.Name + "\", which " + array.Property +
        " names, is not finite in single precision at point " + std::to_string(points.Id(k)) +
        "; finite numbers are needed at all points that polygons use.");
    }
  }
  return rows;
}

} // namespace surfsynth
