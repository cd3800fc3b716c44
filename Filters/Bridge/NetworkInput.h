// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Input of a network beside the mesh, from VTK's arrays: conditions and, in place of the positions, a signal.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/UsedPoints.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// Properties of a filter that say where the input comes from.
struct NetworkInputRequest
{
  std::vector<double> Conditions; ///< the same for all points
  std::string ConditionArrayName; ///< point array, one tuple for each point; "" for none; goes before Conditions
  std::string SignalArrayName;    ///< point array; "" for the positions
};

/// Makes the input of @p model on the used points of @p surface.
/// @param normalization step from the caller's coordinates to the network's: the signal of a gradient-domain head is a
/// set of positions and goes through it.
/// @throws InvalidInput, in terms of the filter's properties, when the model takes another number of conditions or
/// channels, an array is missing or has another shape, or a number is not finite.
VTKSURFACESYNTHESISBRIDGE_EXPORT PoissonNetInput MakeNetworkInput(const PoissonNetModel& model,
  const NetworkInputRequest& request, vtkPolyData* surface, const UsedPoints& points,
  const MeshNormalization& normalization);

} // namespace surfsynth
