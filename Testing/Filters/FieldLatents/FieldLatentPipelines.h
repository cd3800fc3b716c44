// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pipelines of vtkFieldLatentEncoder and vtkFieldLatentDecoder with small model files of random weights.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkFieldLatentDecoder.h"
#include "vtkFieldLatentEncoder.h"

#include "Inference/FieldLatents/FieldLatentOptions.h"

#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>

namespace surfsynthtest
{

/// Dimension 2, 4 channels, 1 layer, 2 heads, 12 samples, decoder 2 x 8.
surfsynth::FieldLatentOptions SmallFieldLatents();

/// Returns the path of a file @p name in a temporary folder of this process, which is removed at its end.
std::string ModelFile(const std::string& name);

/// Writes a model with random weights to ModelFile(@p name) and returns its path. The last layer is scaled so that colors
/// differ.
std::string WriteFieldLatentModel(
  const std::string& name, const surfsynth::FieldLatentOptions& options = SmallFieldLatents(), std::uint64_t seed = 1);

/// Two numbers for a position: texture coordinates.
using PlaneMap = std::function<std::array<double, 2>(double x, double y, double z)>;

/// Adds active texture coordinates to @p surface.
void AddTextureCoordinates(vtkPolyData* surface, const PlaneMap& map, int type = VTK_FLOAT);

/// Adds the point array "Color", 3 components from 0 to 1, smooth in the position.
void AddColors(vtkPolyData* surface);

/// A square of n x n cells in the plane, cut into triangles, with texture coordinates (x, y).
vtkSmartPointer<vtkPolyData> TexturedGrid(int n);

/// Smooth RGB image of 48 x 32 texels with values from 20 to 235 (of 255), and its conversion to other types and
/// components: gray is the red component, alpha is opaque.
vtkSmartPointer<vtkImageData> Pattern(int components = 3, int type = VTK_UNSIGNED_CHAR);

vtkSmartPointer<vtkFieldLatentEncoder> EncoderOn(
  vtkDataObject* surface, vtkDataObject* image, const std::string& model);

/// A decoder of 64 x 64 texels on the codes of @p surface.
vtkSmartPointer<vtkFieldLatentDecoder> DecoderOn(vtkDataObject* surface, const std::string& model);

/// The result of an encoder; no error. @param samplesPerRing 0 for those of the training
vtkSmartPointer<vtkPolyData> Encoded(
  vtkDataObject* surface, vtkDataObject* image, const std::string& model, int samplesPerRing = 0);

/// The image on the second output.
vtkImageData* ImageOf(vtkAlgorithm* decoder);

/// The scalars of that image.
vtkDataArray* TexelsOf(vtkAlgorithm* decoder);

} // namespace surfsynthtest
