// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The frame around RequestData of filters that make a new dataset of each dataset they get: another mesh, a surface of
/// an image, tetrahedra of a surface. (Filters that only add arrays to a surface: ProcessSurfaces() in SurfaceBridge.h.)
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

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

/// What goes into such a filter and what comes out.
struct BlockTypes
{
  std::vector<std::string> Input; ///< the classes that a dataset, or a block, may be of: "vtkPolyData", "vtkImageData"
  std::string Output;             ///< the class of what is made of each: "vtkPolyData", "vtkUnstructuredGrid"
  std::string Advice = "vtkDataSetSurfaceFilter extracts a surface"; ///< what to do with a dataset of another class
};

/// One dataset of the input.
struct Block
{
  vtkDataObject* Input = nullptr;  ///< of one of the types of BlockTypes::Input, with at least one point or cell
  vtkDataObject* Output = nullptr; ///< empty, of the type of BlockTypes::Output
  unsigned int FlatIndex = 0;      ///< 0 for a dataset by itself; the flat index of the block in a composite one
  std::string Where;               ///< "", or "Block 3": begins messages
};

/// Fills block.Output. Throws what RequestData is to report.
using BlockWorker = std::function<void(const Block& block, const Progress& progress)>;

/// Accepts datasets of these types, and composite datasets, on the port; for FillInputPortInformation.
VTKSURFACESYNTHESISBRIDGE_EXPORT int AcceptBlocks(vtkInformation* info, const BlockTypes& types);

/// RequestDataObject: the output is of types.Output, or for a composite input of the input's class. An error, and 0, when
/// there is no input.
VTKSURFACESYNTHESISBRIDGE_EXPORT int RequestBlocks(
  vtkAlgorithm* self, vtkInformationVector** inputVector, vtkInformationVector* outputVector, const BlockTypes& types);

/// RequestData. Calls @p worker for each dataset of the input that is not empty, and
///  - binds progress to UpdateProgress() and cancellation to AbortExecute;
///  - limits the core to the threads that vtkSMPTools uses;
///  - turns every exception into one error event with its text, and the block's output into an empty one;
///  - leaves empty input empty, without an error;
///  - on several MPI ranks, works on datasets where they lie. A dataset of which several ranks hold a piece is an error on
///    all ranks: what is made of a part is no part of what is made of the whole.
/// @return 0 when an input by itself failed, else 1: in a composite input a failed block is reported and left empty, and
/// the others are kept. An abort is no failure: the output is empty, and the next update runs again.
VTKSURFACESYNTHESISBRIDGE_EXPORT int ProcessBlocks(vtkAlgorithm* self, vtkInformationVector** inputVector,
  vtkInformationVector* outputVector, const BlockTypes& types, const BlockWorker& worker);

} // namespace surfsynth
