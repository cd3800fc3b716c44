// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sources of the colors of a surface: a texture image, or colors of points.
#pragma once

#include "ColorRows.h"
#include "SurfaceBridge.h"

#include "Core/Atlas/TextureSampling.h"
#include "Core/Mesh/SurfacePlace.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkImageData;
class vtkPolyData;

namespace surfsynth
{

/// A texture image as RGB from -1 to 1.
struct ColorImage
{
  /// Reads the active point scalars of @p image.
  /// @throws InvalidInput when the image is empty, has several slices or no scalars; as ReadColors().
  explicit ColorImage(vtkImageData* image);

  /// Returns the image for SampleTexture().
  TextureView View() const;

  int Width = 0;    ///< texels along x, which is u
  int Height = 0;   ///< texels along y, which is v
  ColorRows Colors; ///< of the texels, row by row
};

/// Colors at the places of a surface.
class TextureColors
{
public:
  /// Of an image, which must outlive this object, through the texture coordinates of @p coordinates [3 F, 2].
  TextureColors(const ColorImage& image, TextureWrap wrap, TextureCoordinates coordinates);
  /// Of the point array @p name of @p polydata, from which @p surface was converted, or of its active point scalars for
  /// "". Linear in triangles. @p surface must outlive this object.
  /// @throws InvalidInput when there is no such array, it has not a tuple for each point, or as ReadColors().
  TextureColors(vtkPolyData* polydata, const Surface& surface, const std::string& name);

  /// Computes the colors of @p count places, RGB from -1 to 1 into @p out [@p count, 3].
  void Sample(const SurfacePlace* places, std::int64_t count, float* out) const;

  std::vector<std::string> Remarks; ///< warnings about point colors; see ColorRows

private:
  const ColorImage* Image = nullptr;
  TextureWrap Wrap = TextureWrap::Clamp;
  TextureCoordinates Coordinates;
  const TriangleMatrix* Triangles = nullptr;
  std::vector<float> PointColors; ///< [V, 3]
};

} // namespace surfsynth
