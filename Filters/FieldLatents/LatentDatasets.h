// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field latents of one textured surface on several triangulations, as training data.
#pragma once

#include "vtkSurfaceSynthesisFieldLatentsModule.h" // For export macro

#include "Core/Common/Progress.h"
#include "IO/Datasets/LatentDataset.h"
#include "Inference/FieldLatents/FieldLatentModel.h"

#include <cstdint>
#include <functional>
#include <string>

class vtkImageData;
class vtkPolyData;

namespace surfsynth
{

/// Textured surface, and how it is triangulated and encoded.
struct LatentDatasetRequest
{
  vtkPolyData* Mesh = nullptr;     ///< surface; with texture coordinates where there is an image
  vtkImageData* Image = nullptr;   ///< texture; null for the colors of points
  std::string ColorArrayName;      ///< point array of colors when there is no image; "" for the active point scalars
  std::string LabelArrayName;      ///< point array of labels, 0 to 65535, or -1 for none; "" for no labels
  std::string DirectionArrayName;  ///< point array of directions; "" for none
  int NumberOfTriangulations = 16; ///< 1 or more
  int NumberOfPoints = 3000;       ///< mean number of vertices of a triangulation
  std::uint64_t Seed = 0;          ///< of the triangulations
  const FieldLatentModel* Autoencoder = nullptr;               ///< model of the latents
  std::function<void(const std::string& text)> Warn = nullptr; ///< receives remarks about colors
};

/// Remeshes the surface NumberOfTriangulations times and encodes its texture on each. The numbers of vertices are evenly
/// spread over 0.85 to 1.15 times NumberOfPoints, in an order that the seed sets. Edge lengths vary at random from vertex to
/// vertex, anew for each: equal lengths keep so many vertices in place that a network learns the places by heart.
/// @throws InvalidInput when the surface, its texture or an array is not as vtkFieldLatentEncoder and
/// vtkFieldLatentTextureFilter need them, or the library was built without CGAL; Cancelled.
VTKSURFACESYNTHESISFIELDLATENTS_EXPORT LatentDataset MakeLatentDataset(
  const LatentDatasetRequest& request, const Progress& progress);

} // namespace surfsynth
