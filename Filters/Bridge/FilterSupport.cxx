// SPDX-License-Identifier: BSD-3-Clause
#include "FilterSupport.h"

#include "Reporting.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkInformationVector.h>
#include <vtkObject.h>

namespace surfsynth
{

void SetString(vtkObject* self, std::string& property, const char* text)
{
  const std::string wanted = text ? text : "";
  if (property != wanted)
  {
    property = wanted;
    self->Modified();
  }
}

bool RequireSurfaces(vtkAlgorithm* self, vtkInformationVector** inputVector)
{
  const bool isPresent = vtkDataObject::GetData(inputVector[0]) != nullptr;
  if (!isPresent)
  {
    ReportError(self, "", "There is no input; a vtkPolyData or a composite dataset of them is needed.");
  }
  return isPresent;
}

} // namespace surfsynth
