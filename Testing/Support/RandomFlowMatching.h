// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Flow matching models with random weights.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"

#include <cstdint>

namespace surfsynth::test
{

/// A small model that generates positions, as if trained on @p shape: two blocks of width 16, gradient-domain head.
FlowMatchingModel RandomDeformer(const TriangleMesh& shape, std::uint64_t seed = 1);

/// A small model that generates a signal "Mixture" of @p components, with mean 2, 3, ... and scale 0.5, 1, ...
FlowMatchingModel RandomSignalModel(const TriangleMesh& shape, std::int64_t components, std::uint64_t seed = 1);

/// Adds an encoder of @p channels channels, and a velocity that takes them.
void AddRandomEncoder(FlowMatchingModel& model, std::int64_t channels, std::uint64_t seed = 1);

} // namespace surfsynth::test
