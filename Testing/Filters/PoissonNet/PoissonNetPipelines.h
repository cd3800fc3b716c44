// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pipelines of vtkPoissonNetFilter with small model files of random weights.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkPoissonNetFilter.h"

#include "Inference/PoissonNet/PoissonNetModel.h"

#include <string>

namespace surfsynthtest
{

/// Two blocks of width 16 with a linear head of five channels.
surfsynth::PoissonNetOptions SmallOptions(surfsynth::PoissonNetDomain domain, surfsynth::LastActivation activation);

/// The same with a gradient-domain head and @p conditions extra features.
surfsynth::PoissonNetOptions SmallGradientOptions(int conditions = 0);

/// Writes a model with random weights into the folder of the test and returns its path, which is @p name.
std::string WriteModel(const std::string& name, const surfsynth::PoissonNetOptions& options, std::uint64_t seed = 1,
  surfsynth::InputNormalization normalization = surfsynth::InputNormalization::None);

/// A filter on @p input with that model file.
vtkSmartPointer<vtkPoissonNetFilter> PoissonNetOn(vtkDataObject* input, const std::string& model);

/// A sphere of about unit area, which needs no normalisation.
Soup UnitAreaSphere(int levels);

} // namespace surfsynthtest
