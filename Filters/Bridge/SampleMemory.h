// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Bound of the memory of filters that make many samples: estimate before work.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include <cstdint>
#include <string>

class vtkDataObject;

namespace surfsynth
{

/// Memory that the samples of a filter need beside its input.
struct SampleMemory
{
  int NumberOfSamples = 1;      ///< at least 1
  double BytesOfPoint = 0.0;    ///< for each sample and point of the input
  double BytesOfCell = 0.0;     ///< for each sample and cell of the input
  double BytesOfSample = 1024;  ///< for each sample
  std::int64_t MemoryLimit = 0; ///< MiB; 0 for DefaultMemoryLimit()
};

/// Returns three quarters of the memory of the machine or, where it is smaller, of the memory that limits of its control
/// group and of its address space leave to this process; bytes, 0 when it is not known.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::int64_t DefaultMemoryLimit();

/// Returns "" when the samples of @p input, a dataset or composite dataset, fit into the limit; else a message with the
/// number of samples that fits. On several MPI ranks collective, with the same text on all when they do not fit on one.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string ProblemOfMemory(vtkDataObject* input, const SampleMemory& memory);

} // namespace surfsynth
