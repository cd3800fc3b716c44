// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Masks of geometric textures on surfaces, and other numbers at their points.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/UsedPoints.h"

#include <Eigen/Core>

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// Point array that a texture depends on.
struct GeometricTextureArray
{
  const char* Kind;   ///< "mask", for messages
  double Minimum;     ///< lowest value
  double Maximum;     ///< highest value
  const char* Values; ///< the range in words
};

/// Array that multiplies displacements in the synthesis.
constexpr GeometricTextureArray MaskArray{ "mask", 0.0, 1.0, "values from 0, no texture, to 1" };
/// Array that multiplies displacements after the synthesis.
constexpr GeometricTextureArray StrengthArray{ "strength", 0.0, 1e6, "values from 0, no texture, to 1e6" };

/// Array with the share of the second model.
constexpr GeometricTextureArray BlendArray{ "blend", 0.0, 1.0,
  "values from 0, the texture of ModelFileName, to 1, that of SecondModelFileName" };

/// Array with the share of the second example.
constexpr GeometricTextureArray ExampleBlendArray{ "blend", 0.0, 1.0,
  "values from 0, the texture of the first example, to 1, that of the second" };

/// Array that multiplies the length of edges in a remeshing.
constexpr GeometricTextureArray SizeArray{ "size", 0.01, 100.0, "values from 0.01 to 100" };

/// Array that multiplies the size of the texture of an example.
constexpr GeometricTextureArray ExampleSizeArray{ "size", 0.1, 10.0, "values from 0.1 to 10" };

/// Reads the values of a point array at the used points of @p surface; empty when @p name is empty.
/// @throws InvalidInput when there is no such array with one component, or a value is out of the range of @p kind.
Eigen::VectorXf ReadGeometricTextureArray(
  vtkPolyData* surface, const UsedPoints& points, const std::string& name, const GeometricTextureArray& kind);

/// Reads the array of a surface whose arrays were interpolated from one that ReadGeometricTextureArray() accepts; values
/// are clamped to the range, against rounding.
Eigen::VectorXf ReadInterpolatedArray(
  vtkPolyData* surface, const UsedPoints& points, const std::string& name, const GeometricTextureArray& kind);

/// Returns true for two arrays of the same values, and for two empty ones.
bool SameValues(const Eigen::VectorXf& a, const Eigen::VectorXf& b);

/// Smooths the rise of a mask: values are multiplied by s = t^2 (3 - 2 t), where t is the distance along edges from the
/// nearest vertex with value 0 over @p falloff, at most 1. Without such vertices, or with a falloff of 0, the mask is
/// unchanged.
/// @param mask [V], the vertices of @p mesh @param falloff world units, at least 0
void SoftenMask(const TriangleMesh& mesh, double falloff, Eigen::VectorXf& mask);

} // namespace surfsynth
