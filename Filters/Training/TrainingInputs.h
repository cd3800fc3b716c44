// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The two ports of a trainer, in all time steps, as a dataset. Private to the module.
#pragma once

#include "IO/Datasets/SignalDataset.h"

#include <optional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkInformation;
class vtkInformationVector;

namespace surfsynth
{

/// The times of a time series; none where @p info is null or of no series.
std::vector<double> TimeSteps(vtkInformation* info);

/// Reads the sources on port 0 and the samples on port 1 of @p self, in whose RequestData this is called and where the
/// pipeline has made the samples of the first time. Those of the other times are requested one by one.
/// @param progressShare the part of the progress of @p self that reading the time steps takes.
/// @return nothing when both inputs are empty.
/// @throws InvalidInput as TrainingReader, and naming what is missing or the time step that is wrong; Cancelled.
std::optional<SignalDataset> ReadTrainingInputs(
  vtkAlgorithm* self, vtkInformationVector** inputVector, const std::string& arrayName, double progressShare);

} // namespace surfsynth
