// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Elastic bodies whose deformation theory knows: for the test and for the table.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"

#include <Eigen/Core>

#include <array>
#include <functional>

namespace surfsynth::test
{

using PointMap = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// The unit cube of so many cells of six tetrahedra, whose points are mapped.
TetrahedralMesh MappedBox(const std::array<Index, 3>& cells, const PointMap& map);

/// Deflection of the end of a cantilever, ten times as long as high, over that of beam theory with shear, with @p cells
/// cells across its height.
double BendingRatio(int cells, double poissonsRatio);

/// Indentation of a ball of @p cells cells across that lies on the floor under its weight, by a hundredth of its radius,
/// over that of Hertz.
double IndentationRatio(int cells, double poissonsRatio);

} // namespace surfsynth::test
