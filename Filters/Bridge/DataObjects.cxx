// SPDX-License-Identifier: BSD-3-Clause
#include "DataObjects.h"

#include <vtkDataObjectTypes.h>

#include <algorithm>

namespace surfsynth
{

std::int64_t SizeOf(vtkDataObject* data)
{
  return data ? std::max<vtkIdType>(data->GetNumberOfElements(vtkDataObject::POINT), 0) +
      std::max<vtkIdType>(data->GetNumberOfElements(vtkDataObject::CELL), 0)
              : 0;
}

bool IsEmpty(vtkDataObject* data) { return SizeOf(data) == 0; }

vtkSmartPointer<vtkDataObject> NewDataObject(const std::string& className)
{
  return vtkSmartPointer<vtkDataObject>::Take(vtkDataObjectTypes::NewDataObject(className.c_str()));
}

} // namespace surfsynth
