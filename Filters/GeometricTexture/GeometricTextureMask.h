// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Where on a surface a texture grows.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/UsedPoints.h"

#include <Eigen/Core>

#include <string>

class vtkPolyData;

namespace surfsynth
{

/// The values of a point array at the used points of @p surface; empty when @p name is.
/// @throws InvalidInput when there is no such array with one component, or a value is not between 0 and 1.
Eigen::VectorXf ReadGeometricTextureMask(vtkPolyData* surface, const UsedPoints& points, const std::string& name);

/// The same of a surface whose arrays were interpolated from one that ReadGeometricTextureMask() accepts: what rounding
/// adds beyond 0 and 1 is cut off.
Eigen::VectorXf ReadInterpolatedMask(vtkPolyData* surface, const UsedPoints& points, const std::string& name);

/// Lets a mask rise gently: values are multiplied by s = t^2 (3 - 2 t), where t is the distance along edges from the
/// nearest vertex whose value is 0 over @p falloff, at most 1. Without such vertices, or a falloff of 0, nothing
/// changes.
/// @param mask [V], the vertices of @p mesh @param falloff world units, at least 0
void SoftenMask(const TriangleMesh& mesh, double falloff, Eigen::VectorXf& mask);

} // namespace surfsynth
