// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// White noise of tangent vectors that belongs to places in space, not to vertices.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Tangent/OneRings.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Independent N(0, 1) tangent vectors at the vertices of a surface, as averages of a random measure.
///
/// Space is divided into cubes of side h = 2^k, the largest power of two that is at most a quarter of MeanRingRadius().
/// Each cube has random vectors with N(0, 1) components in world axes. The noise of a vertex is their sum over the cubes
/// that its barycentric cell crosses, with weights proportional to the area within each cube (by midpoints of patches of
/// about h), scaled so that the sum of the squared weights is 1, and projected to the tangent plane: each component is
/// exactly N(0, 1). Cells share the cubes at their borders, so that neighbors are correlated by about 0.03.
///
/// The noise does not depend on the numbers of vertices and triangles, and turns with the frames. Averages of it over
/// regions larger than the triangles are nearly those on any other triangulation of the same surface at the same place
/// with the same h. A drawing takes about 80 cubes for a vertex; that of DrawAtVertices() has numbers of its own at each
/// vertex and is cheaper by that factor.
class TangentNoise
{
public:
  /// Numbers at the vertices, [V, columns].
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Finds the cubes of each vertex. Deterministic.
  /// @param mesh the mesh of @p rings
  TangentNoise(const TriangleMesh& mesh, const OneRings& rings);

  /// Side of the cubes, world units; 0 for a mesh without area.
  double CubeSide() const { return this->Side; }

  /// Draws noise, parallel, with the same bits for every number of threads.
  /// @param key seed, sample and stream; Component is not read
  /// @param vectors number of tangent vectors at each vertex, 1 or more
  /// @param draw number of the drawing
  /// @return [V, 2 vectors] components in the frames of the vertices; 0 at vertices without triangles.
  Rows Draw(const NormalKey& key, std::int64_t vectors, std::uint32_t draw = 0) const;
  /// Draws noise of the positions of vertices, bit by bit: exactly independent, and unlike that on any other triangulation.
  /// Parameters and results are those of Draw(); vertices at the same position have the same vectors.
  Rows DrawAtVertices(const NormalKey& key, std::int64_t vectors, std::uint32_t draw = 0) const;

private:
  Rows Project(const Rows& vectors) const;

  double Side = 0.0;
  VertexFrames Frames;
  std::vector<std::int64_t> Vertices; ///< [V], numbers below 2^40 from the positions of vertices; -1 without triangles
  std::vector<std::int64_t> Cubes;    ///< [C], numbers below 2^40 from the places of the cubes
  std::vector<std::size_t> Start;     ///< [V + 1], first cube of each vertex in Members and Weights
  std::vector<std::uint32_t> Members; ///< by vertex, places in Cubes
  std::vector<float> Weights;         ///< by vertex; the squares sum to 1
};

} // namespace surfsynth
