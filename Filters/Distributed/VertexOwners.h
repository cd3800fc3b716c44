// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Rows of the equations of a distributed mesh, and the exchange of numbers on its seams. Private to the library.
#pragma once

#include "Distributed/PieceMerge.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Distribution of the vertices over ranks: each vertex has a row on the lowest rank of those that use it.
class VertexOwners
{
public:
  /// Chooses owners and numbers their rows. Collective.
  /// @param components [U], component of each vertex on this rank, -1 for those that it does not use
  VertexOwners(const RankGroup& ranks, const MergedPiece& piece, const std::vector<Index>& components);

  std::vector<std::int64_t> Rows;     ///< [U], row of each vertex in the equations of all ranks
  std::vector<Index> OwnVertices;     ///< vertices with rows on this rank, in their order
  std::int64_t FirstRow = 0;          ///< row of the first of them
  std::int64_t NumberOfRows = 0;      ///< of all ranks together
  std::vector<int> Owners;            ///< [U], rank of each vertex
  std::vector<Index> OwnerComponents; ///< [U], component of each vertex on the rank of its row

  /// True for vertices with rows on this rank.
  bool IsOwn(Index v) const { return this->Owners[static_cast<std::size_t>(v)] == this->Ranks.Rank(); }
  /// Row on this rank, from 0, of an own vertex.
  Index OwnRow(Index v) const { return static_cast<Index>(this->Rows[static_cast<std::size_t>(v)] - this->FirstRow); }
  /// Returns for each own row the sum of the values of its vertex on all ranks, in the order of ranks. Collective.
  Eigen::VectorXd Sum(const Eigen::VectorXd& values) const;
  /// Returns for each vertex the value of its row. Collective.
  Eigen::VectorXd Spread(const Eigen::VectorXd& rows) const;

  const RankGroup& Group() const { return this->Ranks; } ///< the ranks

private:
  void ChooseOwners(const MergedPiece& piece, const std::vector<Index>& components);
  void NumberRows();

  RankGroup Ranks;
  std::vector<std::int64_t> NumbersThere;   ///< [U], number of each vertex on the rank of its row
  std::vector<std::vector<Index>> Borrowed; ///< for each rank, vertices here whose rows are there
  std::vector<std::vector<Index>> Lent; ///< for each rank, own vertices that are vertices there, in the order of there
};

} // namespace surfsynth
