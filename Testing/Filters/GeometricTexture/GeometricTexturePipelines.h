// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pipelines of vtkGeometricTextureSynthesizer with small model files of random weights.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkGeometricTextureSynthesizer.h"

#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <cstdint>
#include <functional>
#include <string>

namespace surfsynthtest
{

/// Writes a texture of two levels into the folder of the test and returns its path, which is @p name. @p change, where
/// there is one, edits it first.
std::string WriteRandomGeometricTexture(const std::string& name, std::uint64_t seed = 1,
  const std::function<void(surfsynth::GeometricTextureModel& model)>& change = {});

/// A filter on @p input, or on none, with that model file.
vtkSmartPointer<vtkGeometricTextureSynthesizer> SynthesizerOn(vtkDataObject* input, const std::string& model);

/// Adds a point array: @p value(x, y, z) of each point.
void AddPointField(vtkPolyData* surface, const char* name, const std::function<double(const double* point)>& value);

} // namespace surfsynthtest
