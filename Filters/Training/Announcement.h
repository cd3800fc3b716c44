// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The time that a training is expected to take, said once while it runs. Private to the module.
#pragma once

#include <string>

class vtkAlgorithm;

namespace surfsynth
{

class TrainingClock;

/// Says the forecast of @p clock, when there is one, and a time budget that ends the update before: to the observers of
/// vtkCommand::MessageEvent of @p self, with the text as call data, or without any to VTK's output window.
/// @param stage comes before it.
/// @param budget minutes; 0 for no limit.
void AnnounceTime(vtkAlgorithm* self, const std::string& stage, TrainingClock& clock, double budget);

} // namespace surfsynth
