// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Pipelines of vtkFlowMatchingSampler and vtkFlowMatchingDeformer with small model files of random weights.
#pragma once

#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkFlowMatchingDeformer.h"
#include "vtkFlowMatchingSampler.h"

#include "Inference/FlowMatching/FlowMatchingModel.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynthtest
{

/// Writes a model into the folder of the test and returns its path, which is @p name. @p change, where there is one,
/// edits it first. The shape of its training is a sphere.
using ModelChange = std::function<void(surfsynth::FlowMatchingModel& model)>;
std::string WriteDeformer(const std::string& name, std::uint64_t seed = 1, const ModelChange& change = {});
std::string WriteSignalModel(
  const std::string& name, int components = 2, std::uint64_t seed = 1, const ModelChange& change = {});

/// A filter on @p input with that model file and few steps.
vtkSmartPointer<vtkFlowMatchingDeformer> DeformerOn(vtkDataObject* input, const std::string& model);
vtkSmartPointer<vtkFlowMatchingSampler> SamplerOn(vtkDataObject* input, const std::string& model);

} // namespace surfsynthtest
