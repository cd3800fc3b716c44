// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The volumes of tetrahedra that the tests run on.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"
#include "ExampleMeshes.h"

#include <array>

namespace surfsynth::test
{

/// Box [0, @p size] of @p cells cubes along each axis, each divided into six tetrahedra around a diagonal (Kuhn); inner
/// vertices are moved at random by up to @p jitter cells along each axis; below 0.15 no tetrahedron is inverted.
inline TetrahedralMesh BoxOfTetrahedra(
  const std::array<Index, 3>& cells, const Eigen::Vector3d& size = Eigen::Vector3d::Ones(), double jitter = 0.0)
{
  const std::array<Index, 3> step{ 1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1) };
  TetrahedralMesh mesh{ PointMatrix(step[2] * (cells[2] + 1), 3),
    TetrahedronMatrix(6 * cells[0] * cells[1] * cells[2], 4) };
  constexpr std::array<std::array<std::size_t, 3>, 6> Paths{ { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 },
    { 2, 0, 1 }, { 2, 1, 0 } } };
  constexpr std::array<bool, 6> IsEven{ true, false, false, true, true, false };
  Eigen::Index t = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    bool isLast = false;
    bool isInside = true;
    std::array<Index, 3> place{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      place[axis] = v / step[axis] % (cells[axis] + 1);
      isLast = isLast || place[axis] == cells[axis];
      isInside = isInside && place[axis] > 0 && place[axis] < cells[axis];
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double shift = isInside ? jitter * Uniform(static_cast<std::uint64_t>(v), 91 + axis) : 0.0;
      const auto column = static_cast<Eigen::Index>(axis);
      mesh.Points(v, column) = (place[axis] + shift) * size[column] / cells[axis];
    }
    for (std::size_t path = 0; path < 6 && !isLast; ++path, ++t)
    {
      std::array<Index, 4> corner{ v };
      for (std::size_t k = 0; k < 3; ++k)
      {
        corner[k + 1] = corner[k] + step[Paths[path][k]];
      }
      const std::size_t third = IsEven[path] ? 2 : 3;
      mesh.Tetrahedra.row(t) << corner[0], corner[1], corner[third], corner[5 - third];
    }
  }
  return mesh;
}

/// Vertex of BoxOfTetrahedra() at a place of its grid.
inline Index BoxVertex(const std::array<Index, 3>& cells, Index i, Index j, Index k)
{
  return i + (cells[0] + 1) * (j + (cells[1] + 1) * k);
}

} // namespace surfsynth::test
