// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Bones, poses and weights in the tables and arrays of vtkSkinningFilter.
#pragma once

#include "Core/Mesh/Skinning.h"

#include <string>

class vtkPointSet;
class vtkTable;

namespace surfsynth
{

/// Reads the columns Head and Parent of a table of bones.
/// @throws InvalidInput, naming the column, when one is absent or has the wrong number of components.
Skeleton ReadSkeleton(vtkTable* bones);

/// Reads the columns Rotation, Translation and Name of a pose, for the rows of @p bones.
/// @throws InvalidInput, naming the column, when Rotation is absent or a column has the wrong number of components, is not
/// numeric or lacks some of its parts ("Translation:0", ...); without names, when the tables have different numbers of rows;
/// with names, for one that is unknown or there twice.
SkeletonPose ReadSkeletonPose(vtkTable* pose, vtkTable* bones);

/// Reads the weights of the points of @p body; @p indexName is empty for an array of all bones.
/// @throws InvalidInput, naming the array, when it is absent or does not fit.
SkinWeights ReadSkinWeights(vtkPointSet* body, const std::string& indexName, const std::string& weightName);

} // namespace surfsynth
