// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Frame around RequestData of filters that make new datasets of each dataset they get: another mesh, a surface of an
/// image, tetrahedra of a surface. (Filters that only add arrays to a surface: ProcessSurfaces() in SurfaceBridge.h.)
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "OutputSeries.h"

#include "Core/Common/Progress.h"

#include <functional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkDataObject;
class vtkInformation;
class vtkInformationVector;

namespace surfsynth
{

/// Classes of the datasets that such a filter takes and gives.
struct BlockTypes
{
  std::vector<std::string> Input; ///< classes of a dataset, or of a block: "vtkPolyData", "vtkImageData"
  std::string Output;             ///< class of what is made of each: "vtkPolyData", "vtkUnstructuredGrid"
  std::string Advice = "vtkDataSetSurfaceFilter extracts a surface"; ///< ends the error of a dataset of another class
};

/// Classes of filters that make another surface of each surface.
inline const BlockTypes SurfaceToSurface{ { "vtkPolyData" }, "vtkPolyData" };

/// One dataset of the input, and what is made of it.
struct Block
{
  vtkDataObject* Input = nullptr;      ///< of one of the types of BlockTypes::Input, with at least one point or cell
  vtkDataObject* Output = nullptr;     ///< empty, of the type of BlockTypes::Output; the first of Outputs
  unsigned int FlatIndex = 0;          ///< 0 for a dataset by itself; the flat index of the block in a composite one
  std::string Where;                   ///< "", "Block 3" or "Block 3 \"hand\"": begins messages
  std::vector<vtkDataObject*> Outputs; ///< one for each output of the series, in order
};

/// Fills block.Output, or all of block.Outputs. Throws what RequestData is to report.
using BlockWorker = std::function<void(const Block& block, const Progress& progress)>;

/// Accepts datasets of these types, and composite datasets, on the port; for FillInputPortInformation.
VTKSURFACESYNTHESISBRIDGE_EXPORT int AcceptBlocks(vtkInformation* info, const BlockTypes& types);

/// RequestDataObject: the output is of types.Output, or for a composite input of the input's class; a
/// vtkMultiBlockDataSet when @p isSeries. An error, and 0, when there is no input.
VTKSURFACESYNTHESISBRIDGE_EXPORT int RequestBlocks(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const BlockTypes& types, bool isSeries = false);

/// RequestData. Calls @p worker for each dataset of the input that is not empty, puts what it made of each into the
/// output as @p series says, and
///  - binds progress to UpdateProgress() and cancellation to AbortExecute;
///  - limits the core to the threads that vtkSMPTools uses;
///  - turns every exception into one error event with its text, and the block's output into an empty one;
///  - leaves empty input empty, without an error;
///  - on several MPI ranks, works on datasets where they lie. A dataset of which several ranks hold a piece is an error
///    on all ranks, because the pieces of a result cannot be made of the pieces of a dataset.
/// @return 0 when an input by itself failed, else 1: in a composite input a failed block is reported and left empty,
/// and the others are kept. An abort is no failure: the output is empty, and the next update runs again.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessBlocks(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const BlockTypes& types, const BlockWorker& worker,
  const OutputSeries& series = {});

} // namespace surfsynth
