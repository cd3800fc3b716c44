// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Ensembles of shapes or signals in VTK's data objects.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Statistics/EnsembleMetrics.h"

#include <vtkDataArray.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkDataObject;

namespace surfsynth
{

/// One sample: coordinates or an array on the points of a surface.
struct EnsembleSample
{
  std::string Name;                     ///< "Block 3", "Noise_2", "Block 3: Noise_2", or "Points" for the only surface
  vtkSmartPointer<vtkPolyData> Surface; ///< of the input; of an unstructured grid as AsSurfaces() makes it
  vtkSmartPointer<vtkDataArray> Values; ///< [V, C] float32 or float64, tuple after tuple; a copy of what is neither
};

/// Samples of one input, in order.
struct VTKSURFACESYNTHESISBRIDGE_EXPORT Ensemble
{
  std::string Role; ///< "generated" or "reference": begins messages
  std::vector<EnsembleSample> Samples;

  /// Name of a sample in messages: "generated sample 4 (Block 7)".
  std::string NameOf(std::size_t sample) const;
  /// Values of all samples in place, each [V, C] in its own precision; valid while the samples are.
  std::vector<SampleValues> Values() const;
};

/// Reads the samples of a vtkPolyData, of an unstructured grid of polygons or of the leaves of a composite dataset, in order; null and empty leaves are left
/// out.
/// With an empty @p arrayName the sample of a surface is its points. Else it is the point array of that name where the
/// surface has one, and otherwise the arrays <arrayName>_0, <arrayName>_1 and so on, in order of these numbers.
/// @throws InvalidInput when a leaf is no surface or lacks the array, or an array is too short
VTKSURFACESYNTHESISBRIDGE_EXPORT Ensemble ReadEnsemble(
  vtkDataObject* input, const std::string& role, const std::string& arrayName);

/// Surface whose points and cells all samples must have.
struct SharedSurface
{
  vtkPolyData* Surface = nullptr; ///< belongs to the input
  std::string Name;               ///< "the source", "reference sample 0 (Block 1)"
};

/// Checks that the samples lie on @p shared and have @p components components.
/// @throws InvalidInput naming the first sample with other points, cells, values or components.
VTKSURFACESYNTHESISBRIDGE_EXPORT void RequireOneTriangulation(
  const Ensemble& ensemble, const SharedSurface& shared, int components);

/// Lumped barycentric mass of the points, [V] float64: a third of the area of the triangles at each. Edges of more than
/// two triangles are allowed.
/// @throws InvalidInput when the surface is not valid otherwise.
VTKSURFACESYNTHESISBRIDGE_EXPORT Eigen::VectorXd MassOf(const SharedSurface& shared);

} // namespace surfsynth
