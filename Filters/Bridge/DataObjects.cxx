// SPDX-License-Identifier: BSD-3-Clause
#include "DataObjects.h"

#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDataObjectTypes.h>
#include <vtkDataSet.h>
#include <vtkPointData.h>

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

std::vector<Leaf> LeavesOf(vtkDataObject* data)
{
  auto* tree = vtkDataObjectTree::SafeDownCast(data);
  if (!tree)
  {
    return data ? std::vector<Leaf>{ { data, "" } } : std::vector<Leaf>{};
  }
  std::vector<Leaf> leaves;
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem()) // null leaves are passed over
  {
    leaves.push_back({ place->GetCurrentDataObject(), "Block " + std::to_string(place->GetCurrentFlatIndex()) });
  }
  return leaves;
}

vtkSmartPointer<vtkDataObject> NewDataObject(const std::string& className)
{
  return vtkSmartPointer<vtkDataObject>::Take(vtkDataObjectTypes::NewDataObject(className.c_str()));
}

void SelectScalars(vtkDataObject* data, const std::vector<std::string>& names)
{
  if (auto* tree = vtkCompositeDataSet::SafeDownCast(data))
  {
    const auto place = vtkSmartPointer<vtkCompositeDataIterator>::Take(tree->NewIterator());
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      SelectScalars(place->GetCurrentDataObject(), names);
    }
  }
  auto* surface = vtkDataSet::SafeDownCast(data);
  for (std::size_t k = 0; surface && k < names.size(); ++k)
  {
    const char* name = names[k].c_str();
    const bool atPoints = surface->GetPointData()->HasArray(name);
    if (atPoints)
    {
      surface->GetPointData()->SetActiveScalars(name);
    }
    else if (surface->GetCellData()->HasArray(name))
    {
      surface->GetPointData()->SetActiveScalars(nullptr);
      surface->GetCellData()->SetActiveScalars(name);
    }
    if (atPoints || surface->GetCellData()->HasArray(name))
    {
      return;
    }
  }
}

} // namespace surfsynth
