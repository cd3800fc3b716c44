// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Patches of an example surface with a geometric texture, at several scales.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Options of a GeometricTextureExample.
struct GeometricTextureExampleOptions
{
  /// Number of scales, 1 to 8; 0 for as many as make the widest patches 2.5 times as wide as the mean distance of peaks, but no
  /// wider than half of the root of the area.
  int Scales = 0;
  /// [V, 3], direction of the texture at the vertices of the example: the first axis of patches. Empty for axes at
  /// random, and four patches at each place that are turned by quarters.
  PointMatrix Directions;
  std::uint64_t Seed = 0; ///< of the places of the patches
  /// Distance from the boundary, along edges, within which no center of a patch lies, world units, at least 0: a form that is
  /// the example, smoothed, is none of its forms there.
  double Margin = 0.0;
};

/// Patches of an example at one scale. Values are in units of the spacing of the grids.
struct ExamplePatches
{
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  double Spacing =
    0.0;            ///< of the grids, mean edge lengths of the example: 2 to the number of the scale, 0 for the finest
  Rows Values;      ///< [N, C], displacements at the samples of the patches, sorted by cluster
  Rows Basis;       ///< [C, D], weighted principal components: coordinates of a patch are its values times Basis
  Rows Coordinates; ///< [D, N], those of the patches
  Eigen::VectorXf Squares;      ///< [N], their squared norms
  std::vector<Index> Clusters;  ///< [K + 1], first patch of each cluster of patches that look alike, and N; empty: none
  Eigen::VectorXf Mean;         ///< [C], mean of the patches
  double MeanHeight = 0.0;      ///< mean of the displacements along the normals
  double HeightDeviation = 0.0; ///< their standard deviation
  double Amplitude = 0.0;       ///< root of the mean square of the displacements

  /// Number of patches, N.
  std::int64_t Count() const { return this->Values.rows(); }
};

/// Numbers of scales of an example.
struct ExampleScaleCounts
{
  int Automatic = 1; ///< as many as GeometricTextureExampleOptions::Scales of 0 makes
  int Most = 1;      ///< as many as make the widest patches no wider than half of the root of the area, at most 6
};

/// Counts the scales of an example. @param plain the same triangles without texture
ExampleScaleCounts CountExampleScales(const TriangleMesh& textured, const TriangleMesh& plain);

/// An example of a geometric texture: patches of the difference of a surface and the same one without the texture, at several
/// scales. At coarser scales the difference is smoothed over about half of the spacing first. Patches lie at random places,
/// evenly by area, away from the boundary where there is room; without directions four at each, turned by quarters. Deterministic,
/// the same bits for every number of threads.
class GeometricTextureExample
{
public:
  /// Cuts the patches. Up to eight seconds for a scale on one thread.
  /// @param textured the example @param plain the same triangles without texture
  /// @throws InvalidInput when a mesh does not meet Requirements(), the triangles differ, an option is out of its range, or the
  /// surface is too small for a patch; SolverFailure, Cancelled
  GeometricTextureExample(const TriangleMesh& textured, const TriangleMesh& plain,
    const GeometricTextureExampleOptions& options = {}, const Progress& progress = {});

  /// Patches by scale, finest first.
  const std::vector<ExamplePatches>& Scales() const { return this->Patches; }
  /// Mean edge length of the example without texture, world units.
  double MeanEdgeLength() const { return this->EdgeLength; }
  /// True when the patches are turned along the directions of the example.
  bool IsOriented() const { return this->Oriented; }

  /// Requirements on the meshes: those of GeometricTextureSampler.
  static MeshRequirements Requirements();

private:
  std::vector<ExamplePatches> Patches;
  double EdgeLength = 0.0;
  bool Oriented = false;
};

} // namespace surfsynth
