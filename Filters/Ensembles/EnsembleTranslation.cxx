// SPDX-License-Identifier: BSD-3-Clause
#include "EnsembleTranslation.h"

#include "NewArray.h"

#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>

namespace surfsynth
{

void TranslatePoints(vtkPointSet* set, const Eigen::Vector3d& translation)
{
  vtkPoints* points = set->GetPoints();
  vtkNew<vtkPoints> moved;
  moved->SetDataType(points->GetDataType());
  moved->SetNumberOfPoints(points->GetNumberOfPoints());
  for (vtkIdType k = 0; k < points->GetNumberOfPoints(); ++k)
  {
    Eigen::Vector3d point;
    points->GetPoint(k, point.data());
    point += translation;
    moved->SetPoint(k, point.data());
  }
  set->SetPoints(moved);
}

void AddTranslationField(vtkDataObject* data, const Eigen::Vector3d& translation)
{
  auto array = NewArray<vtkDoubleArray>("Translation", 1, 3);
  array->SetTuple(0, translation.data());
  vtkNew<vtkFieldData> fields; // a shallow copy shares that of its source
  fields->ShallowCopy(data->GetFieldData());
  fields->AddArray(array);
  data->SetFieldData(fields);
}

} // namespace surfsynth
