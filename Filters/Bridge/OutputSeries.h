// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Several outputs of each dataset that a filter gets: samples of an ensemble, levels of a texture.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkInformationVector;

namespace surfsynth
{

/// Numbers and names of the outputs [First, First + Count). One contract holds for ProcessSurfaces() and
/// ProcessBlocks(): the worker gets all outputs of one dataset at once, and each output as a whole has the structure of
/// the input.
///  - Without a BlockName there is one output: the dataset itself.
///  - With a BlockName the output is a vtkMultiBlockDataSet of Count blocks, "Sample 5", "Sample 6" and so on. Each is
///    a dataset, or for a composite input a vtkMultiBlockDataSet with its structure and field data. Leaves of datasets
///    that are empty or have failed are empty.
struct OutputSeries
{
  int First = 0;         ///< number of the first output, at least 0
  int Count = 1;         ///< number of outputs, at least 1; 1 without a BlockName
  std::string BlockName; ///< first word of the blocks' names: "Sample", "Level"; or empty

  /// Name of block @p index, counted from 0: "Sample 5" for index 2 when First is 3.
  VTKSURFACESYNTHESISBRIDGE_EXPORT std::string NameOf(int index) const;
};

/// Makes the parts of @p output, one for each output of @p series, that a filter then fills.
/// @param input a dataset, or a composite dataset whose structure and field data each part gets.
/// @param datasetClass class of a part when @p input is no composite dataset: "vtkPolyData".
/// @return @p output itself without a BlockName, else the blocks of @p output.
/// @throws InvalidInput when Count is not positive, is not 1 without a BlockName, or @p output is no
/// vtkMultiBlockDataSet with one.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<vtkSmartPointer<vtkDataObject>> MakeOutputs(
  vtkDataObject* input, const OutputSeries& series, const std::string& datasetClass, vtkDataObject* output);

/// Replaces the output of the first port by an empty object of class @p className, unless it is of that class: for
/// RequestDataObject.
VTKSURFACESYNTHESISBRIDGE_EXPORT void SetOutputClass(vtkInformationVector* outputVector, const std::string& className);

} // namespace surfsynth
