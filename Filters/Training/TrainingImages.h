// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Images of an input port for the training of field latents. Private to the module.
#pragma once

#include "IO/Datasets/TextureDataset.h"

#include <string>
#include <vector>

class vtkDataObject;

namespace surfsynth
{

/// Images that are trained on, and warnings about them.
struct TrainingImages
{
  std::vector<TextureImage> Images; ///< as bytes, the row of the largest y first, as in files
  std::vector<std::string> Remarks; ///< as those of ReadColors()
};

/// Reads a vtkImageData, or the leaves of a composite dataset in order; empty ones are left out. Colors are the active
/// point scalars, as ReadColors() reads them.
/// @throws InvalidInput naming the image: when it is no vtkImageData, has fewer than 16 pixels in a direction of its
/// plane, several slices or no scalars; as ReadColors().
TrainingImages ReadTrainingImages(vtkDataObject* data);

} // namespace surfsynth
