// SPDX-License-Identifier: BSD-3-Clause
#include "LevelBlocks.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>

#include <algorithm>
#include <string>

namespace surfsynth
{

namespace
{
/// The tree with the surfaces of one level in its leaves.
vtkSmartPointer<vtkMultiBlockDataSet> TreeOf(const LevelSurfaces& surfaces, vtkDataObjectTree* held, std::size_t step)
{
  auto tree = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  tree->CopyStructure(held);
  tree->GetFieldData()->ShallowCopy(held->GetFieldData());
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(held->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    const auto found = surfaces.find(place->GetCurrentFlatIndex());
    const bool known = found != surfaces.end() && step < found->second.size();
    tree->SetDataSet(place, known ? found->second[step] : vtkSmartPointer<vtkPolyData>::New());
  }
  return tree;
}
} // namespace

void ArrangeLevels(const LevelSurfaces& surfaces, vtkDataObject* held, int firstLevel, vtkMultiBlockDataSet* output)
{
  std::size_t steps = 0;
  for (const auto& entry : surfaces)
  {
    steps = std::max(steps, entry.second.size());
  }
  auto* tree = vtkDataObjectTree::SafeDownCast(held);
  for (std::size_t step = 0; step < steps; ++step)
  {
    const auto block = static_cast<unsigned int>(step);
    if (tree)
    {
      output->SetBlock(block, TreeOf(surfaces, tree, step));
    }
    else
    {
      output->SetBlock(block, surfaces.begin()->second[step]);
    }
    output->GetMetaData(block)->Set(
      vtkCompositeDataSet::NAME(), ("Level " + std::to_string(firstLevel + static_cast<int>(step))).c_str());
  }
}

} // namespace surfsynth
