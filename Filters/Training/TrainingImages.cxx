// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingImages.h"

#include "ColorRows.h"
#include "PointRows.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"

#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace surfsynth
{

namespace
{
/// Least width and height: a ring covers some pixels.
constexpr int LeastSide = 16;

/// Returns the scalars of an image of one slice. @param name for messages
vtkDataArray* ScalarsOf(vtkImageData* image, const std::array<int, 3>& size, const std::string& name)
{
  const std::string text = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
  if (size[0] < LeastSide || size[1] < LeastSide || size[2] != 1)
  {
    throw InvalidInput(name + " has " + text +
      " pixels; one slice of at least 16 x 16 pixels is needed, and "
      "vtkExtractVOI takes one of a volume.");
  }
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (!scalars)
  {
    throw InvalidInput(name + " has no active point scalars; colors of 1 to 4 components at its points are needed.");
  }
  if (scalars->GetNumberOfTuples() != static_cast<vtkIdType>(size[0]) * size[1])
  {
    throw InvalidInput(name + " has " + text + " pixels and " + FormatCount(scalars->GetNumberOfTuples(), "tuple") +
      " of scalars; one for each pixel is needed.");
  }
  return scalars;
}

void AddImage(vtkDataObject* data, TrainingImages& read)
{
  const std::string name = "Image " + std::to_string(read.Images.size());
  auto* image = vtkImageData::SafeDownCast(data);
  if (!image)
  {
    throw InvalidInput(name + " is " + DescribeInput(data) + "; a vtkImageData is needed.");
  }
  std::array<int, 3> size{};
  image->GetDimensions(size.data());
  ColorRows rows = ReadColors(ScalarsOf(image, size, name), name);
  read.Remarks.insert(read.Remarks.end(), rows.Remarks.begin(), rows.Remarks.end());
  TextureImage bytes;
  bytes.Width = size[0];
  bytes.Height = size[1];
  const std::size_t length = 3 * static_cast<std::size_t>(size[0]);
  bytes.Pixels.resize(rows.Values.size());
  for (std::size_t k = 0; k < rows.Values.size(); ++k)
  {
    const std::size_t row = static_cast<std::size_t>(size[1]) - 1 - k / length;
    bytes.Pixels[row * length + k % length] = static_cast<unsigned char>(
      std::floor(127.5F * (rows.Values[k] + 1.0F) + 0.5F));
  }
  read.Images.push_back(std::move(bytes));
}

bool HasNoPixels(vtkDataObject* data)
{
  auto* image = vtkImageData::SafeDownCast(data);
  return !data || (image && image->GetNumberOfPoints() == 0);
}
} // namespace

TrainingImages ReadTrainingImages(vtkDataObject* data)
{
  TrainingImages read;
  auto* tree = vtkDataObjectTree::SafeDownCast(data);
  if (!tree)
  {
    if (!HasNoPixels(data))
    {
      AddImage(data, read);
    }
    return read;
  }
  const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  place->VisitOnlyLeavesOn();
  place->TraverseSubTreeOn();
  for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
  {
    if (!HasNoPixels(place->GetCurrentDataObject()))
    {
      AddImage(place->GetCurrentDataObject(), read);
    }
  }
  return read;
}

} // namespace surfsynth
