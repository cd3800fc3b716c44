// SPDX-License-Identifier: BSD-3-Clause
#include "OutputSeries.h"

#include "DataObjects.h"

#include "Core/Common/Errors.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>

namespace surfsynth
{

namespace
{
void CopyTree(vtkDataObject* input, vtkDataObject* output)
{
  if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    vtkDataObjectTree::SafeDownCast(output)->CopyStructure(tree);
    output->GetFieldData()->ShallowCopy(tree->GetFieldData());
  }
}
} // namespace

std::string OutputSeries::NameOf(int index) const
{
  return this->BlockName + " " + std::to_string(static_cast<long long>(this->First) + index);
}

std::vector<vtkSmartPointer<vtkDataObject>> MakeOutputs(
  vtkDataObject* input, const OutputSeries& series, const std::string& datasetClass, vtkDataObject* output)
{
  if (series.Count < 1 || (series.Count > 1 && series.BlockName.empty()))
  {
    throw InvalidInput("A series has " + std::to_string(series.Count) + " outputs and the block name \"" +
      series.BlockName + "\"; at least one is needed, and a name for several.");
  }
  if (series.BlockName.empty())
  {
    CopyTree(input, output);
    return { output };
  }
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(output);
  if (!blocks)
  {
    throw InvalidInput(std::string("The output of a series is ") + (output ? output->GetClassName() : "missing") +
      "; a vtkMultiBlockDataSet is needed.");
  }
  const bool isTree = vtkDataObjectTree::SafeDownCast(input) != nullptr;
  std::vector<vtkSmartPointer<vtkDataObject>> outputs;
  blocks->SetNumberOfBlocks(static_cast<unsigned int>(series.Count));
  for (int k = 0; k < series.Count; ++k)
  {
    outputs.push_back(NewDataObject(isTree ? "vtkMultiBlockDataSet" : datasetClass));
    CopyTree(input, outputs.back());
    const auto block = static_cast<unsigned int>(k);
    blocks->SetBlock(block, outputs.back());
    blocks->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), series.NameOf(k).c_str());
  }
  return outputs;
}

void SetOutputClass(vtkInformationVector* outputVector, const std::string& className)
{
  vtkDataObject* present = vtkDataObject::GetData(outputVector);
  if (!present || className != present->GetClassName())
  {
    outputVector->GetInformationObject(0)->Set(vtkDataObject::DATA_OBJECT(), NewDataObject(className));
  }
}

} // namespace surfsynth
