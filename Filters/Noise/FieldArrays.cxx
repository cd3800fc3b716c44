// SPDX-License-Identifier: BSD-3-Clause
#include "FieldArrays.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkPointData.h>

#include <cmath>

namespace surfsynth
{

namespace
{
/// One array, and how messages call it.
struct ArrayPlace
{
  vtkDataSetAttributes* Data;
  const char* Kind; ///< "point" or "cell"
  vtkIdType Tuples; ///< number of points or cells
  std::string Name;
  const char* Property;
};

std::string Describe(const ArrayPlace& place)
{
  return std::string("The ") + place.Kind + " array \"" + place.Name + "\", which " + place.Property + " names, ";
}

/// The tuples as rows. @throws InvalidInput as ReadFieldArrays().
PointRows ReadRows(const ArrayPlace& place, int components)
{
  vtkDataArray* array = place.Data->GetArray(place.Name.c_str());
  const std::string expected = "; one with " + FormatCount(components, "component") + " and a tuple for each " +
    place.Kind + " is needed.";
  if (!array)
  {
    throw InvalidInput(std::string("There is no ") + place.Kind + " array \"" + place.Name + "\", which " +
      place.Property + " names" + expected +
      " (Arrays of a surface whose pieces lie on several MPI ranks are not gathered.)");
  }
  if (array->GetNumberOfComponents() != components || array->GetNumberOfTuples() != place.Tuples)
  {
    throw InvalidInput(Describe(place) + "has " + FormatCount(array->GetNumberOfComponents(), "component") + " and " +
      FormatCount(array->GetNumberOfTuples(), "tuple") + " for " + FormatCount(place.Tuples, place.Kind) + expected);
  }
  PointRows rows(place.Tuples, components);
  for (vtkIdType k = 0; k < place.Tuples; ++k)
  {
    array->GetTuple(k, rows.row(k).data());
    if (!rows.row(k).allFinite())
    {
      throw InvalidInput(
        Describe(place) + "is not finite at " + place.Kind + " " + std::to_string(k) + "; finite numbers are needed.");
    }
  }
  return rows;
}

Eigen::VectorXd ReadPositive(const ArrayPlace& place)
{
  const PointRows rows = ReadRows(place, 1);
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
  {
    if (!(rows(k, 0) > 0.0))
    {
      throw InvalidInput(Describe(place) + "is " + FormatNumber(rows(k, 0)) + " at " + place.Kind + " " +
        std::to_string(k) + "; numbers above 0 are needed.");
    }
  }
  return rows.col(0);
}
} // namespace

bool FieldArrayNames::Any() const
{
  return !(this->RangeFactor.empty() && this->Direction.empty() && this->Boundary.empty() && this->Barrier.empty());
}

MaternFieldArrays ReadFieldArrays(vtkDataSet* dataset, const Surface& surface, const FieldArrayNames& names)
{
  const auto onPoints = [&](const std::string& name, const char* property) {
    return ArrayPlace{ dataset->GetPointData(), "point", dataset->GetNumberOfPoints(), name, property };
  };
  MaternFieldArrays arrays;
  if (!names.RangeFactor.empty())
  {
    arrays.RangeFactors = ReadPositive(onPoints(names.RangeFactor, "RangeFactorArrayName"));
  }
  if (!names.Direction.empty())
  {
    arrays.Directions = ReadRows(onPoints(names.Direction, "DirectionArrayName"), 3);
  }
  if (!names.Boundary.empty())
  {
    const PointRows rows = ReadRows(onPoints(names.Boundary, "BoundaryArrayName"), 1);
    for (Eigen::Index v = 0; v < rows.rows(); ++v)
    {
      arrays.BoundaryMask.push_back(rows(v, 0) != 0.0);
    }
  }
  if (!names.Barrier.empty())
  {
    const PointRows rows = ReadRows(
      { dataset->GetCellData(), "cell", dataset->GetNumberOfCells(), names.Barrier, "BarrierArrayName" }, 1);
    const Index cells = surface.Volume ? surface.Volume->NumberOfTetrahedra() : surface.Mesh.NumberOfTriangles();
    for (Index f = 0; f < cells; ++f)
    {
      arrays.Barrier.push_back(rows(surface.Cell(f), 0) != 0.0);
    }
  }
  return arrays;
}

} // namespace surfsynth
