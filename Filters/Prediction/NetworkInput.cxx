// SPDX-License-Identifier: BSD-3-Clause
#include "NetworkInput.h"

#include "Core/Common/Errors.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

namespace surfsynth
{

namespace
{
using DoubleRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::string Counted(std::int64_t count, const std::string& thing)
{
  return (count == 0 ? "no" : std::to_string(count)) + " " + thing + (count == 1 ? "" : "s");
}

/// The tuples of a point array at the used points.
DoubleRows ReadPointArray(vtkPolyData* surface, const UsedPoints& points, const std::string& name,
  const std::string& property, std::int64_t components)
{
  vtkDataArray* array = surface->GetPointData()->GetArray(name.c_str());
  const std::string expected = "; the model needs one with " + Counted(components, "component") +
    " and a tuple for each point.";
  if (!array)
  {
    throw InvalidInput("There is no point array \"" + name + "\", which " + property + " names" + expected +
      " (Arrays of a surface whose pieces lie on several MPI ranks are not gathered.)");
  }
  if (array->GetNumberOfComponents() != components || array->GetNumberOfTuples() != surface->GetNumberOfPoints())
  {
    throw InvalidInput("The point array \"" + name + "\", which " + property + " names, has " +
      Counted(array->GetNumberOfComponents(), "component") + " and " + Counted(array->GetNumberOfTuples(), "tuple") +
      " for " + Counted(surface->GetNumberOfPoints(), "point") + expected);
  }
  DoubleRows rows(points.Count(), components);
  for (Index k = 0; k < points.Count(); ++k)
  {
    array->GetTuple(points.Id(k), rows.row(k).data());
    if (!rows.row(k).cast<float>().allFinite())
    {
      throw InvalidInput("The point array \"" + name + "\", which " + property +
        " names, is not finite in single precision at point " + std::to_string(points.Id(k)) +
        "; finite numbers are needed at all points that polygons use.");
    }
  }
  return rows;
}

FeatureMatrix BroadcastConditions(const PoissonNetModel& model, const std::vector<double>& conditions)
{
  const std::int64_t wanted = model.Options.ExtraFeatures;
  const auto found = static_cast<std::int64_t>(conditions.size());
  if (found != wanted)
  {
    throw InvalidInput("The model takes " + Counted(wanted, "condition") + "; Conditions holds " +
      (found == 0 ? "none" : std::to_string(found)) + ". " +
      (wanted == 0 ? std::string("Leave Conditions empty.")
                   : "Set " + std::to_string(wanted) + ", or name a point array with " + Counted(wanted, "component") +
            " by ConditionArrayName."));
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
  const UsedPoints& points, const MeshNormalisation& normalisation)
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
    input.Extra = ReadPointArray(
      surface, points, request.ConditionArrayName, "ConditionArrayName", options.ExtraFeatures)
                    .cast<float>();
  }
  if (!request.SignalArrayName.empty())
  {
    DoubleRows signal = ReadPointArray(
      surface, points, request.SignalArrayName, "SignalArrayName", options.InputChannels);
    if (options.Head == PoissonNetHead::GradientDomain)
    {
      signal = (signal.rowwise() - normalisation.Centre) / normalisation.Scale;
    }
    input.Signal = signal.cast<float>();
  }
  else if (options.InputChannels != 3)
  {
    throw InvalidInput("The model takes " + Counted(options.InputChannels, "channel") +
      " at each point, and positions have 3; SignalArrayName must name a point array with " +
      Counted(options.InputChannels, "component") + ".");
  }
  return input;
}

} // namespace surfsynth
