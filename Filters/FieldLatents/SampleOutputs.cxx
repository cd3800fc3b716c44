// SPDX-License-Identifier: BSD-3-Clause
#include "SampleOutputs.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>

#include <algorithm>
#include <cstddef>

namespace surfsynth
{

void FillPort(vtkDataObject* input, const OutputSeries& series, const char* datasetClass, const SampleResults& results,
  vtkDataObject* output)
{
  const auto parts = MakeOutputs(input, series, datasetClass, output);
  for (const auto& [key, dataset] : results)
  {
    vtkDataObject* part = parts[static_cast<std::size_t>(key.first)];
    auto* tree = vtkDataObjectTree::SafeDownCast(part);
    if (!tree)
    {
      part->ShallowCopy(dataset);
      continue;
    }
    const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(
      vtkDataObjectTree::SafeDownCast(input)->NewTreeIterator());
    place->VisitOnlyLeavesOn();
    place->TraverseSubTreeOn();
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      if (place->GetCurrentFlatIndex() == key.second)
      {
        tree->SetDataSet(place, dataset);
      }
    }
  }
}

std::pair<double, double> SizesOfBlocks(vtkDataObject* input)
{
  const auto pointsOf = [](vtkDataObject* data) {
    auto* set = vtkDataSet::SafeDownCast(data);
    return set ? static_cast<double>(set->GetNumberOfPoints()) : 0.0;
  };
  auto* tree = vtkDataObjectTree::SafeDownCast(input);
  if (!tree)
  {
    return { 1.0, pointsOf(input) };
  }
  std::pair<double, double> sizes{ 0.0, 0.0 };
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    sizes.first += 1.0;
    sizes.second = std::max(sizes.second, pointsOf(place->GetCurrentDataObject()));
  }
  return sizes;
}

} // namespace surfsynth
