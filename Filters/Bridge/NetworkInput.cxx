// SPDX-License-Identifier: BSD-3-Clause
#include "NetworkInput.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"

#include <vtkPolyData.h>

namespace surfsynth
{

namespace
{
FeatureMatrix BroadcastConditions(const PoissonNetModel& model, const std::vector<double>& conditions)
{
  const std::int64_t wanted = model.Options.ExtraFeatures;
  const auto found = static_cast<std::int64_t>(conditions.size());
  if (found != wanted)
  {
    throw InvalidInput("The model takes " + FormatCount(wanted, "condition") + "; Conditions holds " +
      (found == 0 ? "none" : std::to_string(found)) + ". " +
      (wanted == 0 ? std::string("Leave Conditions empty.")
                   : "Set " + std::to_string(wanted) + ", or name a point array with " +
            FormatCount(wanted, "component") + " by ConditionArrayName."));
  }
  FeatureMatrix row(wanted == 0 ? 0 : 1, wanted);
  for (std::int64_t k = 0; k < wanted; ++k)
  {
    row(0, k) = static_cast<float>(conditions[static_cast<std::size_t>(k)]);
  }
  if (!row.allFinite())
  {
    throw InvalidInput("A number of Conditions is not finite in single precision; finite numbers are needed.");
  }
  return row;
}
} // namespace

PoissonNetInput MakeNetworkInput(const PoissonNetModel& model, const NetworkInputRequest& request, vtkPolyData* surface,
  const UsedPoints& points, const MeshNormalization& normalization)
{
  const PoissonNetOptions& options = model.Options;
  PoissonNetInput input;
  if (request.ConditionArrayName.empty())
  {
    input.Extra = BroadcastConditions(model, request.Conditions);
  }
  else if (options.ExtraFeatures == 0)
  {
    throw InvalidInput(
      "The model takes no conditions; ConditionArrayName is \"" + request.ConditionArrayName + "\". Leave it empty.");
  }
  else
  {
    const NamedPointArray array{ request.ConditionArrayName, "ConditionArrayName" };
    input.Extra = ReadPointRows(surface, points, array, options.ExtraFeatures).cast<float>();
  }
  if (!request.SignalArrayName.empty())
  {
    const NamedPointArray array{ request.SignalArrayName, "SignalArrayName" };
    PointRows signal = ReadPointRows(surface, points, array, options.InputChannels);
    if (options.Head == PoissonNetHead::GradientDomain)
    {
      signal = (signal.rowwise() - normalization.Center) / normalization.Scale;
    }
    input.Signal = signal.cast<float>();
  }
  else if (options.InputChannels != 3)
  {
    throw InvalidInput("The model takes " + FormatCount(options.InputChannels, "channel") +
      " at each point, and positions have 3; SignalArrayName must name a point array with " +
      FormatCount(options.InputChannels, "component") + ".");
  }
  return input;
}

} // namespace surfsynth
