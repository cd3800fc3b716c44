// SPDX-License-Identifier: BSD-3-Clause
#include "TextureColors.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <array>
#include <cstddef>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* ImageName = "The texture image on port 1";

/// Returns the scalars of an image of one slice.
vtkDataArray* ScalarsOf(vtkImageData* image, const std::array<int, 3>& size)
{
  const std::string text = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]);
  if (size[0] < 1 || size[1] < 1 || size[2] != 1)
  {
    throw InvalidInput(std::string(ImageName) + " has " + text +
      " texels; one slice of at least 1 x 1 texels is needed, and vtkExtractVOI takes one of a volume.");
  }
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (!scalars)
  {
    throw InvalidInput(
      std::string(ImageName) + " has no active point scalars; colors of 1 to 4 components at its points are needed.");
  }
  if (scalars->GetNumberOfTuples() != static_cast<vtkIdType>(size[0]) * size[1])
  {
    throw InvalidInput(std::string(ImageName) + " has " + text + " texels and " +
      FormatCount(scalars->GetNumberOfTuples(), "tuple") + " of scalars; one for each texel is needed.");
  }
  return scalars;
}

/// Returns the color array of a surface.
vtkDataArray* ColorArray(vtkPolyData* polydata, const std::string& name)
{
  vtkPointData* data = polydata->GetPointData();
  vtkDataArray* array = name.empty() ? data->GetScalars() : data->GetArray(name.c_str());
  if (!array)
  {
    throw InvalidInput((name.empty() ? std::string("The points of the surface have no active scalars")
                                     : "There is no point array \"" + name + "\", which ColorArrayName names") +
      ", and there is no texture image on port 1; one of them is needed.");
  }
  if (array->GetNumberOfTuples() != polydata->GetNumberOfPoints())
  {
    throw InvalidInput("The colors of the points have " + FormatCount(array->GetNumberOfTuples(), "tuple") + " for " +
      FormatCount(polydata->GetNumberOfPoints(), "point") + "; one for each is needed.");
  }
  return array;
}
} // namespace

ColorImage::ColorImage(vtkImageData* image)
{
  std::array<int, 3> size{};
  image->GetDimensions(size.data());
  vtkDataArray* scalars = ScalarsOf(image, size);
  this->Width = size[0];
  this->Height = size[1];
  this->Colors = ReadColors(scalars, ImageName);
}

TextureView ColorImage::View() const { return { this->Colors.Values.data(), this->Width, this->Height, 3 }; }

TextureColors::TextureColors(const ColorImage& image, TextureWrap wrap, TextureCoordinates coordinates)
  : Image(&image)
  , Wrap(wrap)
  , Coordinates(std::move(coordinates))
{}

TextureColors::TextureColors(vtkPolyData* polydata, const Surface& surface, const std::string& name)
  : Triangles(&surface.Mesh.Triangles)
{
  vtkDataArray* array = ColorArray(polydata, name);
  std::vector<bool> isUsed(static_cast<std::size_t>(surface.Mesh.NumberOfPoints()), false);
  for (Eigen::Index k = 0; k < surface.Mesh.Triangles.size(); ++k)
  {
    isUsed[static_cast<std::size_t>(surface.Mesh.Triangles.data()[k])] = true;
  }
  ColorRows rows = ReadColors(
    array, "The array \"" + std::string(array->GetName() ? array->GetName() : "") + "\" of point colors", isUsed);
  this->PointColors = std::move(rows.Values);
  this->Remarks = std::move(rows.Remarks);
}

void TextureColors::Sample(const SurfacePlace* places, std::int64_t count, float* out) const
{
  if (this->Image)
  {
    SampleTexture(this->Image->View(), this->Wrap, this->Coordinates, places, count, out);
    return;
  }
  ParallelFor(count, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
    {
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      for (int corner = 0; corner < 3; ++corner)
      {
        const Index point = (*this->Triangles)(places[k].Triangle, corner);
        const Eigen::Map<const Eigen::Vector3f> own(this->PointColors.data() + 3 * static_cast<std::ptrdiff_t>(point));
        color += places[k].Weights[corner] * own.cast<double>();
      }
      Eigen::Map<Eigen::Vector3f>(out + 3 * k) = color.cast<float>();
    }
  });
}

} // namespace surfsynth
