// SPDX-License-Identifier: BSD-3-Clause
#include "vtkEnsembleLayoutFilter.h"

#include "EnsembleTranslation.h"
#include "JointProcessing.h"
#include "ProcessingSupport.h"
#include "Reporting.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/GridLayout.h"

#include <vtkBoundingBox.h>
#include <vtkDataObjectTree.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <map>
#include <string>
#include <vector>

vtkStandardNewMacro(vtkEnsembleLayoutFilter);

namespace
{
using surfsynth::BoundingBox;

/// @throws InvalidInput for a leaf of a class that has no places to move.
void RequireMovable(vtkDataSet* leaf, vtkDataObject* found, const std::string& name)
{
  if (!leaf || !(leaf->IsA("vtkPointSet") || leaf->IsA("vtkImageData")))
  {
    throw surfsynth::InvalidInput(name + " is a " + found->GetClassName() +
      ", which cannot be moved; blocks with points (vtkPointSet) or images (vtkImageData) are needed.");
  }
}

/// A leaf with points.
struct LayoutLeaf
{
  unsigned int FlatIndex;
  int Child; ///< of the root
  vtkBoundingBox Box;
};

/// The leaves with points, in order.
std::vector<LayoutLeaf> LayoutLeavesOf(vtkDataObjectTree* tree)
{
  std::vector<LayoutLeaf> boxes;
  std::vector<unsigned int> children; // their flat indices, which are those of the tree in preorder
  const auto top = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  top->TraverseSubTreeOff();
  top->VisitOnlyLeavesOff();
  top->SkipEmptyNodesOff();
  for (top->InitTraversal(); !top->IsDoneWithTraversal(); top->GoToNextItem())
  {
    children.push_back(top->GetCurrentFlatIndex());
  }
  std::size_t child = 0;
  surfsynth::EachLeaf(tree, [&](vtkDataObjectTreeIterator* place) {
    const unsigned int flatIndex = place->GetCurrentFlatIndex();
    while (child + 1 < children.size() && children[child + 1] <= flatIndex)
    {
      ++child;
    }
    vtkDataObject* found = place->GetCurrentDataObject();
    if (!found || found->GetNumberOfElements(vtkDataObject::POINT) <= 0)
    {
      return;
    }
    auto* leaf = vtkDataSet::SafeDownCast(found);
    RequireMovable(leaf, found, surfsynth::PlaceOf(place).Name);
    boxes.push_back({ flatIndex, static_cast<int>(child), vtkBoundingBox(leaf->GetBounds()) });
  });
  return boxes;
}

BoundingBox ConvertBox(const vtkBoundingBox& box)
{
  BoundingBox converted;
  box.GetMinPoint(converted.Lower.data());
  box.GetMaxPoint(converted.Upper.data());
  return converted;
}

/// The translation of each of @p leaves; those of one group are moved as one.
std::map<unsigned int, Eigen::Vector3d> LayoutTranslations(
  const std::vector<LayoutLeaf>& leaves, bool children, const surfsynth::GridLayoutOptions& options)
{
  std::vector<vtkBoundingBox> groups;
  std::vector<std::size_t> groupOf;
  for (std::size_t k = 0; k < leaves.size(); ++k)
  {
    if (k == 0 || !children || leaves[k].Child != leaves[k - 1].Child)
    {
      groups.emplace_back();
    }
    groups.back().AddBox(leaves[k].Box);
    groupOf.push_back(groups.size() - 1);
  }
  std::vector<BoundingBox> boxes;
  for (const vtkBoundingBox& group : groups)
  {
    boxes.push_back(ConvertBox(group));
  }
  const std::vector<Eigen::Vector3d> moves = surfsynth::LayOutInGrid(boxes, options);
  std::map<unsigned int, Eigen::Vector3d> translations;
  for (std::size_t k = 0; k < leaves.size(); ++k)
  {
    translations[leaves[k].FlatIndex] = moves[groupOf[k]];
  }
  return translations;
}

/// A copy of @p leaf that shares all but the points.
vtkSmartPointer<vtkDataObject> MovedLeaf(vtkDataObject* leaf, const Eigen::Vector3d& translation)
{
  const auto moved = vtkSmartPointer<vtkDataObject>::Take(leaf->NewInstance());
  moved->ShallowCopy(leaf);
  if (auto* image = vtkImageData::SafeDownCast(moved))
  {
    Eigen::Vector3d origin;
    image->GetOrigin(origin.data());
    origin += translation;
    image->SetOrigin(origin.data());
  }
  else
  {
    surfsynth::TranslatePoints(vtkPointSet::SafeDownCast(moved), translation);
  }
  surfsynth::AddTranslationField(moved, translation);
  return moved;
}
} // namespace

int vtkEnsembleLayoutFilter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  return 1;
}

int vtkEnsembleLayoutFilter::RequestDataObject(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!vtkDataObject::GetData(inputVector[0]))
  {
    surfsynth::ReportError(this, "", "There is no input; a composite dataset is needed.");
    return 0;
  }
  return this->Superclass::RequestDataObject(request, inputVector, outputVector);
}

int vtkEnsembleLayoutFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  surfsynth::GridLayoutOptions options;
  options.Columns = this->Arrangement == ROW ? VTK_INT_MAX : this->Arrangement == COLUMN ? 1 : this->NumberOfColumns;
  options.Spacing = this->Spacing;
  options.Across = this->Plane == YZ ? 1 : 0;
  options.Down = this->Plane == XY ? 1 : 2;
  options.Center = this->Centering;
  return surfsynth::ProcessJointly(this, inputVector, outputVector, [&](const surfsynth::Progress& progress) {
    auto* input = vtkDataObjectTree::GetData(inputVector[0]);
    auto* output = vtkDataObjectTree::GetData(outputVector);
    const std::vector<LayoutLeaf> leaves = LayoutLeavesOf(input);
    const auto translations = LayoutTranslations(leaves, this->Unit == CHILDREN, options);
    output->CopyStructure(input);
    output->SetFieldData(input->GetFieldData());
    double done = 0.0;
    surfsynth::EachLeaf(input, [&](vtkDataObjectTreeIterator* place) {
      vtkDataObject* leaf = place->GetCurrentDataObject();
      const auto found = translations.find(place->GetCurrentFlatIndex());
      if (found != translations.end())
      {
        surfsynth::Report(progress, done++ / static_cast<double>(leaves.size()));
        output->SetDataSet(place, MovedLeaf(leaf, found->second));
      }
      else if (leaf)
      {
        output->SetDataSet(place, leaf);
      }
    });
  });
}

void vtkEnsembleLayoutFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Arrangement: " << this->Arrangement << "\n";
  os << indent << "NumberOfColumns: " << this->NumberOfColumns << "\n";
  os << indent << "Spacing: " << this->Spacing << "\n";
  os << indent << "Plane: " << this->Plane << "\n";
  os << indent << "Unit: " << this->Unit << "\n";
  os << indent << "Centering: " << this->Centering << "\n";
}
