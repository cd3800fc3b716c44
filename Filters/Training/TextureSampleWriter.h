// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pictures of samples along the way of a training. Private to the module.
#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <memory>
#include <string>

namespace surfsynth
{

/// Samples a texture with the model of a training so far and writes its image. A failure does not end the training: its text
/// is kept, and no further sample is tried.
struct TextureSampleWriter
{
  vtkSmartPointer<vtkPolyData> Mesh; ///< surface, of its own: the training may run on another thread
  std::string Model;                 ///< path of the model file
  std::string Autoencoder;           ///< path or name of the autoencoder
  std::string LabelArrayName;        ///< "" for none
  std::string DirectionArrayName;    ///< "" for none
  int Seed = 0;
  int NumberOfSteps = 20; ///< of the sample
  std::string Path;       ///< image file that is replaced, PNG

  /// The first failure, "" without; shared by all copies.
  std::shared_ptr<std::string> Problem = std::make_shared<std::string>();

  /// Writes the sample, 512 x 512 texels. @param goOn false to stop without a sample
  void operator()(const std::function<bool()>& goOn) const;

private:
  void Write(const std::function<bool()>& goOn) const;
};

} // namespace surfsynth
