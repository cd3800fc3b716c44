// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Small datasets, and recipes of networks that are trained on them in seconds.
#pragma once

#include "IO/Mesh/SignalDataset.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <string>
#include <vector>

namespace surfsynth::test
{

/// @p samples deformations of a sphere of @p level (42 points at level 1, 162 at level 2): ellipsoids with a bump.
SignalDataset DeformedSpheres(int samples, int level = 1);

/// Two channels, smooth on the sphere and different in mean and range, called "Heat".
SignalDataset HeatOnSphere(int samples, int level = 1);

/// Two blocks of width 8, batches of 2, on the processor.
FlowMatchingTrainingOptions TinyRecipe(std::int64_t iterations);

/// The bytes of a file; fails the test when there is none.
std::string BytesOf(const std::string& path);

/// The rows of a step that say what was computed.
std::vector<double> Numbers(const TrainingStep& step);

} // namespace surfsynth::test
