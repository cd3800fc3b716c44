// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Masks of geometric textures on surfaces.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/UsedPoints.h"

#include <Eigen/Core>

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// Reads the values of a point array at the used points of @p surface; empty when @p name is empty.
/// @throws InvalidInput when there is no such array with one component, or a value is not between 0 and 1.
Eigen::VectorXf ReadGeometricTextureMask(vtkPolyData* surface, const UsedPoints& points, const std::string& name);

/// Reads the mask of a surface whose arrays were interpolated from one that ReadGeometricTextureMask() accepts; values
/// are clamped to [0, 1], against rounding.
Eigen::VectorXf ReadInterpolatedMask(vtkPolyData* surface, const UsedPoints& points, const std::string& name);

/// Smooths the rise of a mask: values are multiplied by s = t^2 (3 - 2 t), where t is the distance along edges from the
/// nearest vertex with value 0 over @p falloff, at most 1. Without such vertices, or with a falloff of 0, the mask is
/// unchanged.
/// @param mask [V], the vertices of @p mesh @param falloff world units, at least 0
void SoftenMask(const TriangleMesh& mesh, double falloff, Eigen::VectorXf& mask);

} // namespace surfsynth
