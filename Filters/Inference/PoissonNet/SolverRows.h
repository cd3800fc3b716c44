// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Right-hand sides and solutions of one Poisson solve for many channels. Private to the inference.
#pragma once

#include "Core/Common/LargeArray.h"
#include "Core/Common/Progress.h"
#include "Core/Solvers/CholeskySolver.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Vertex signals in the order of the solver, in blocks of columns that fit one pass over the factor, float64.
class SolverRows
{
public:
  /// Allocates the rows.
  /// @param channels number of right-hand sides
  /// @param mass [V], kept by the caller
  /// @param unused the vertices that no face uses
  SolverRows(std::shared_ptr<const CholeskySolver> solver, std::int64_t channels, const Eigen::VectorXf& mass,
    const std::vector<Index>& unused);

  /// Writes the right-hand side of a vertex, [channels]. Different vertices may be written from different threads.
  void Set(Index vertex, const float* values);

  /// Adds @p values, [V, channels], to the right-hand sides of the vertices.
  void Add(const RowMatrix& values);

  /// Replaces right-hand sides by solutions, in parallel over blocks of columns. At unused vertices, which the equation
  /// does not determine, the solution is the mean of its channel.
  /// @throws Cancelled
  void Solve(const Progress& progress);

  /// Map from a solution to a signal: value * Scale + Shift for each channel.
  struct Channels
  {
    std::vector<double> Scale; ///< [channels]
    std::vector<double> Shift; ///< [channels]
  };
  /// Map to mass-weighted mean 0.
  Channels WithoutMean() const;
  /// Map of a per-channel norm over the vertices: see VertexNorm.
  Channels Normalized(bool massWeighted, const std::vector<float>& weight, const std::vector<float>& bias) const;

  /// Reads the values of a vertex, [channels], mapped by @p channels.
  void Get(Index vertex, const Channels& channels, float* values) const;

private:
  /// Sums of weight * (value - centre)^power over the rows, in a fixed order.
  std::vector<double> Moments(const std::vector<double>& weights, const std::vector<double>& centers, int power) const;
  template <typename Values>
  void SetUnused(const Values& values);

  struct Block
  {
    std::int64_t First;    ///< channel
    std::int64_t Channels; ///< without padding
    std::int64_t Columns;  ///< with padding
    LargeArray<double> Values;
  };
  std::shared_ptr<const CholeskySolver> Solver;
  std::vector<Index> RowOfVertex;
  std::vector<double> MassInOrder; ///< [V], of the solver's rows
  std::vector<Index> Unused;
  std::vector<double> Means; ///< of the solutions
  std::int64_t NumberOfChannels;
  std::vector<Block> Blocks;
};

} // namespace surfsynth
