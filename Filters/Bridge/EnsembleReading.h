// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Ensembles of shapes or signals in VTK's data objects. Private to the module.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Statistics/EnsembleMetrics.h"

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkDataObject;
class vtkPolyData;

namespace surfsynth
{

/// One sample: coordinates or an array on the points of a surface.
struct EnsembleSample
{
  std::string Name;                     ///< "Block 3", "Noise_2", "Block 3: Noise_2", or "Points" for the only surface
  vtkPolyData* Surface = nullptr;       ///< belongs to the input
  vtkSmartPointer<vtkDataArray> Values; ///< [V, C] float32 or float64, tuple after tuple; a copy of what is neither
};

struct VTKSURFACESYNTHESISBRIDGE_EXPORT Ensemble
{
  std::string Role; ///< "generated" or "reference": begins messages
  std::vector<EnsembleSample> Samples;

  /// "generated sample 4 (Block 7)"
  std::string NameOf(std::size_t sample) const;
  std::vector<SampleValues> Values() const;
};

/// The samples of a vtkPolyData or of the leaves of a composite dataset, in order; null and empty leaves are left out.
/// With an empty @p arrayName the sample of a surface is its points. Else it is the point array of that name where the
/// surface has one, and otherwise the arrays <arrayName>_0, <arrayName>_1 and so on, in order of these numbers.
/// @throws InvalidInput when a leaf is no vtkPolyData or lacks the array, or an array is too short
VTKSURFACESYNTHESISBRIDGE_EXPORT Ensemble ReadEnsemble(
  vtkDataObject* input, const std::string& role, const std::string& arrayName);

/// What all samples must have the points and cells of.
struct SharedSurface
{
  vtkPolyData* Surface = nullptr;
  std::string Name; ///< "the source", "reference sample 0 (Block 1)"
};

/// Expects that the samples lie on @p shared and have @p components components.
/// @throws InvalidInput
VTKSURFACESYNTHESISBRIDGE_EXPORT void RequireOneTriangulation(
  const Ensemble& ensemble, const SharedSurface& shared, int components);

/// Lumped barycentric mass of the points.
/// @throws InvalidInput when the surface is not sound
VTKSURFACESYNTHESISBRIDGE_EXPORT Eigen::VectorXd MassOf(const SharedSurface& shared);

} // namespace surfsynth
