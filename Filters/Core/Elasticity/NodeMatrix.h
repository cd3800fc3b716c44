// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sparse symmetric matrix of 3 x 3 blocks, one for each pair of nodes that act on each other. Private to the library.
#pragma once

#include "Core/Mesh/TetrahedralMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace surfsynth
{

/// A pair of nodes.
using NodePair = std::pair<Index, Index>;

/// Second derivatives by the positions of nodes, [3 V, 3 V]: row 3 v + k is coordinate k of node v.
class NodeMatrix
{
public:
  /// Pattern of the nodes of each tetrahedron, and of more @p pairs; every node has a diagonal block.
  NodeMatrix(const TetrahedralMesh& mesh, const std::vector<NodePair>& pairs);

  /// Sets all entries to 0.
  void SetZero() { std::fill_n(this->Entries.valuePtr(), this->Entries.nonZeros(), 0.0); }
  /// Adds @p block to rows of corner @p a and columns of corner @p b of tetrahedron @p t.
  void AddCorners(Index t, int a, int b, const Eigen::Matrix3d& block)
  {
    const auto& corner = this->Corners[static_cast<std::size_t>(t)][static_cast<std::size_t>(4 * a + b)];
    this->AddAt(corner, this->Stride(this->Nodes(t, b)), block);
  }
  /// Adds @p block to rows of node @p a and columns of node @p b; the pattern has the pair.
  void Add(Index a, Index b, const Eigen::Matrix3d& block) { this->AddAt(this->Place(a, b), this->Stride(b), block); }
  /// True when the pattern has the pair.
  bool Has(Index a, Index b) const;
  /// Turns rows and columns of the nodes that are marked into those of the unit matrix, times @p scale.
  void Fix(const std::vector<bool>& isFixed, double scale);

  /// The matrix, both triangles, with ascending rows.
  const SparseMatrix& Matrix() const { return this->Entries; }

private:
  int Stride(Index node) const { return 3 * (this->Start[node + 1] - this->Start[node]); }
  int Place(Index a, Index b) const;
  void AddAt(int place, int stride, const Eigen::Matrix3d& block)
  {
    double* values = this->Entries.valuePtr() + place;
    for (int column = 0; column < 3; ++column)
    {
      for (int row = 0; row < 3; ++row)
      {
        values[column * stride + row] += block(row, column);
      }
    }
  }

  TetrahedronMatrix Nodes;
  std::vector<Index> Start;     ///< [V + 1], neighbors of node v, itself among them, are Neighbors[Start[v] ..)
  std::vector<Index> Neighbors; ///< ascending
  std::vector<std::array<int, 16>> Corners; ///< [T], places of the blocks of each tetrahedron
  SparseMatrix Entries;
};

} // namespace surfsynth
