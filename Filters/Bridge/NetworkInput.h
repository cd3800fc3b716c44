// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a network takes beside the mesh: conditions and, in place of the positions, a signal; from VTK's arrays.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/UsedPoints.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace surfsynth
{

/// What the user of a filter has set.
struct NetworkInputRequest
{
  std::vector<double> Conditions; ///< the same for all points
  std::string ConditionArrayName; ///< point array, one tuple for each point; "" for none; goes before Conditions
  std::string SignalArrayName;    ///< point array; "" for the positions
};

/// The input of @p model on the used points of @p surface.
/// @param normalisation from the caller's coordinates to the network's: the signal of a gradient-domain head is a set
/// of positions and goes through it.
/// @throws InvalidInput, in terms of the filter's properties, when the model takes another number of conditions or
/// channels, an array is missing or has another shape, or a number is not finite.
VTKSURFACESYNTHESISBRIDGE_EXPORT PoissonNetInput MakeNetworkInput(const PoissonNetModel& model,
  const NetworkInputRequest& request, vtkPolyData* surface, const UsedPoints& points,
  const MeshNormalisation& normalisation);

} // namespace surfsynth
