// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Examples of geometric textures in files.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <string>

namespace surfsynth
{

/// An example of a geometric texture, as a file holds it.
struct TextureExampleFile
{
  std::string Name;
  TriangleMesh Textured;
  /// Points of the example without its texture, [V, 3]; empty where the smooth form stands for them.
  PointMatrix PlainPoints;
  /// Direction of the texture at the points, [V, 3]; empty without one.
  PointMatrix Directions;
  /// Length of the smoothing that takes the texture off, world units; 0 with PlainPoints.
  double SmoothingLength = 0.0;
};

/// Reads an example from a safetensors file: the tensors `points` [V, 3], `triangles` [F, 3], and, as they are there,
/// `plain_points` and `directions` [V, 3]; in the metadata the architecture "geometric_texture_example" and, under that key, a
/// JSON object with the strings and numbers `name` and `smoothing_length`, above 0 without `plain_points`.
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of the format; ModelMismatch when it
/// holds no such example, or one that does not meet GeometricTextureExample::Requirements()
TextureExampleFile ReadTextureExample(const std::string& path);

} // namespace surfsynth
