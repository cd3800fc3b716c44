// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Frame around RequestData of filters that make one result of all their inputs together: a comparison, a table.
/// (Filters that work on one dataset after the other: SurfaceBridge.h, BlockBridge.h.)
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Common/Progress.h"

#include <functional>

class vtkAlgorithm;
class vtkInformationVector;

namespace surfsynth
{

/// Reads the inputs and fills the outputs, which are empty. Throws what RequestData is to report.
using JointWorker = std::function<void(const Progress& progress)>;

/// RequestData. Calls @p worker once and
///  - binds progress to UpdateProgress() and cancellation to AbortExecute;
///  - limits the core to the threads that vtkSMPTools uses;
///  - turns every exception into one error event with its text, and all outputs into empty ones;
///  - on several MPI ranks, works where the inputs lie, on the first when all are empty. Inputs on several ranks are an
///    error on all of them, because no part of the result can be made of a part of the inputs.
/// @return 0 after an error, else 1. An abort is no failure: the outputs are empty, and the next update runs again.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessJointly(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const JointWorker& worker);

} // namespace surfsynth
