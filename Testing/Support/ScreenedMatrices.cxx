// SPDX-License-Identifier: BSD-3-Clause
#include "ScreenedMatrices.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "ExampleMeshes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>
#include <vector>

namespace surfsynth::test
{

ScreenedMatrix ScreenedSurface(const TriangleMesh& mesh, double screening)
{
  ScreenedMatrix screened;
  {
    const MeshTopology topology(mesh);
    screened.Mass = LumpedMass(mesh, topology);
    screened.Matrix = CotangentStiffness(mesh, topology);
  }
  const double tau = screening / screened.Mass.sum();
  for (Index v = 0; v < screened.Mass.size(); ++v)
  {
    screened.Matrix.coeffRef(v, v) += screened.Mass[v] > 0.0 ? tau * screened.Mass[v] : 1.0;
  }
  return screened;
}

ScreenedMatrix ScreenedCube(int cells, double screening, double jitter, double stretch)
{
  const Index side = cells + 1;
  const Index size = side * side * side;
  const std::array<Index, 3> step = { 1, side, side * side };
  Eigen::Matrix3Xd points(3, size);
  for (Index v = 0; v < size; ++v)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      const Index place = v / step[static_cast<std::size_t>(axis)] % side;
      const bool inner = place > 0 && place < cells;
      points(axis, v) = (place + (inner ? jitter * Uniform(static_cast<std::uint64_t>(v), 77U + axis) : 0.0)) / cells;
    }
  }
  points.row(0) *= stretch;

  ScreenedMatrix screened;
  screened.Mass = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(static_cast<std::size_t>(cells) * cells * cells * 96 + static_cast<std::size_t>(size));
  constexpr std::array<std::array<int, 3>, 6> Paths = { { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 },
    { 2, 0, 1 }, { 2, 1, 0 } } };
  for (Index v = 0; v < size; ++v)
  {
    if (v % side == cells || v / side % side == cells || v / (side * side) == cells)
    {
      continue;
    }
    for (const auto& path : Paths)
    {
      std::array<Index, 4> corner = { v };
      for (std::size_t k = 0; k < 3; ++k)
      {
        corner[k + 1] = corner[k] + step[static_cast<std::size_t>(path[k])];
      }
      Eigen::Matrix4d affine = Eigen::Matrix4d::Ones(); // its inverse holds the gradients of the hat functions
      for (int k = 0; k < 4; ++k)
      {
        affine.block<1, 3>(k, 1) = points.col(corner[static_cast<std::size_t>(k)]).transpose();
      }
      const double volume = std::abs(affine.determinant()) / 6.0;
      const Eigen::Matrix<double, 3, 4> gradients = affine.inverse().bottomRows<3>();
      const Eigen::Matrix4d element = volume * gradients.transpose() * gradients;
      for (int i = 0; i < 4; ++i)
      {
        screened.Mass[corner[static_cast<std::size_t>(i)]] += volume / 4.0;
        for (int j = 0; j < 4; ++j)
        {
          entries.emplace_back(corner[static_cast<std::size_t>(i)], corner[static_cast<std::size_t>(j)],
            0.5 * (element(i, j) + element(j, i)));
        }
      }
    }
  }
  const double tau = screening / screened.Mass.sum();
  for (Index v = 0; v < size; ++v)
  {
    entries.emplace_back(v, v, tau * screened.Mass[v]);
  }
  screened.Matrix.resize(size, size);
  screened.Matrix.setFromTriplets(entries.begin(), entries.end());
  return screened;
}

TriangleMesh LargeSphere(int level)
{
  TriangleMesh mesh = Icosphere(std::min(level, 5));
  for (int k = 5; k < level; ++k)
  {
    mesh = SubdivideAtMidpoints(mesh).Mesh;
    mesh.Points.rowwise().normalize();
  }
  return mesh;
}

RowMatrix NoiseSides(const Eigen::VectorXd& mass, Eigen::Index columns, std::uint64_t seed)
{
  RowMatrix sides(mass.size(), columns);
  for (Eigen::Index v = 0; v < sides.rows(); ++v)
  {
    for (Eigen::Index c = 0; c < columns; ++c)
    {
      sides(v, c) = std::sqrt(mass[v]) *
        Uniform(static_cast<std::uint64_t>(v), seed * 1000U + static_cast<std::uint64_t>(c));
    }
  }
  return sides;
}

} // namespace surfsynth::test
