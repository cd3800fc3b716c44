// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Members of an ensemble moved as a whole. Private to the module.
#pragma once

#include <Eigen/Core>

class vtkDataObject;
class vtkPointSet;

namespace surfsynth
{

/// Gives @p set points of its own type that are moved by @p translation; those it had stay as they were.
void TranslatePoints(vtkPointSet* set, const Eigen::Vector3d& translation);

/// Adds the field array "Translation" of three components to @p data, in field data of its own.
void AddTranslationField(vtkDataObject* data, const Eigen::Vector3d& translation);

} // namespace surfsynth
