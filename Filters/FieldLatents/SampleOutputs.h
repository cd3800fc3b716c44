// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Results of samples on the output ports after the first. Private to the module.
#pragma once

#include "OutputSeries.h"

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>

#include <map>
#include <utility>

class vtkDataObject;

namespace surfsynth
{

/// Results of an update on one port, by number of the sample in the series and flat index of the block.
using SampleResults = std::map<std::pair<int, unsigned int>, vtkSmartPointer<vtkDataSet>>;

/// Fills the output of a port with the results, in the arrangement that ProcessBlocks() gives the first port.
/// @param input of the filter: a dataset, or a composite dataset
/// @param datasetClass class of a result: "vtkImageData"
void FillPort(vtkDataObject* input, const OutputSeries& series, const char* datasetClass, const SampleResults& results,
  vtkDataObject* output);

/// Number of blocks of the input, and of points of the largest one.
std::pair<double, double> SizesOfBlocks(vtkDataObject* input);

} // namespace surfsynth
