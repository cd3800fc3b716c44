// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Point arrays as matrices.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/UsedPoints.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>

class vtkPolyData;

namespace surfsynth
{

/// A point array that a property of a filter names.
struct NamedPointArray
{
  std::string Name;     ///< of the array
  std::string Property; ///< name of the property, for messages
};

/// Tuples as rows.
using PointRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// "no components", "1 component", "2 components". For messages.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::string FormatCount(std::int64_t count, const std::string& thing);

/// Reads the tuples of a point array of @p surface at the used points, [V, components] float64.
/// @throws InvalidInput, naming array and property, when it is not there, has other than @p components components or
/// not a tuple for each point, or is not finite in single precision, which is what the networks compute in.
VTKSURFACESYNTHESISBRIDGE_EXPORT PointRows ReadPointRows(
  vtkPolyData* surface, const UsedPoints& points, const NamedPointArray& array, std::int64_t components);

} // namespace surfsynth
