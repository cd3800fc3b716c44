// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pictures of samples along the way of a training. Private to the module.
#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>

namespace surfsynth
{

/// Samples a texture with the model of a training so far and writes its image.
struct TextureSampleWriter
{
  vtkSmartPointer<vtkPolyData> Mesh; ///< surface, of its own: the training may run on another thread
  std::string Model;                 ///< path of the model file
  std::string Autoencoder;           ///< path or name of the autoencoder
  std::string LabelArrayName;        ///< "" for none
  std::string DirectionArrayName;    ///< "" for none
  int Seed = 0;
  std::string Path; ///< image file that is replaced, PNG

  /// Writes the sample: 20 steps, 512 x 512 texels.
  /// @throws InvalidInput with the errors of vtkFieldLatentTextureFilter, or when the file cannot be written.
  void operator()() const;
};

} // namespace surfsynth
