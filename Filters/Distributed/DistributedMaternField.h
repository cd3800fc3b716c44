// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Gaussian random fields on surfaces that lie in pieces on several MPI ranks, solved where they lie.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Noise/MaternField.h"
#include "Distributed/MeshPiece.h"
#include "Distributed/RankGroup.h"

#include <cstdint>
#include <functional>
#include <memory>

namespace surfsynth
{

/// A Matérn field on a distributed surface: what MaternField makes of the whole surface, to 1e-8 of its norm, for every
/// number of ranks. No rank ever holds the whole: each assembles its triangles, sends the rows of vertices on seams to the
/// lowest rank that uses them, and PETSc's conjugate gradients with hypre's algebraic multigrid solve to a relative
/// residual of 1e-12. Random numbers are those of the points of the whole, which are numbered as GlobalIds, or the order of
/// ranks, say (see MeshPiece). The same pieces give the same bits.
///
/// All functions but those of results are collective, with the same options and requests on all ranks, and throw on all
/// ranks when they throw on one.
class DistributedMaternField
{
public:
  /// Assembles, and builds the multigrid hierarchy.
  /// @param options the model Matern with OperatorPower 2 or 4, the boundary condition Neumann, and neither arrays,
  /// VarianceCorrection nor CoherentNoise; FactorMemoryLimit is not used
  /// @throws InvalidInput for other options, when the pieces together do not pass CheckMesh() with manifold edges; the text
  /// begins with the rank.
  /// @throws SolverFailure, Cancelled
  DistributedMaternField(
    const RankGroup& ranks, const MeshPiece& piece, const MaternFieldOptions& options, const Progress& progress = {});
  ~DistributedMaternField();
  DistributedMaternField(DistributedMaternField&&) noexcept;
  DistributedMaternField& operator=(DistributedMaternField&&) noexcept;

  /// Draws the samples and writes each to its destination, V * C doubles for the V points of this rank's piece: see
  /// MaternField::SampleInto(). Points that no triangle uses get 0.
  /// @throws InvalidInput, SolverFailure, Cancelled as MaternField::SampleInto().
  void SampleInto(
    const SampleRequest& request, const MaternField::Destination& destination, const Progress& progress = {});

  // Results, the same on all ranks.

  double EffectiveScreening() const;        ///< see MaternField
  double EffectiveCorrelationRange() const; ///< see MaternField
  double Gamma() const;                     ///< see MaternField
  double RelativeResidual() const;          ///< largest of the solves of the last call of SampleInto()
  int Iterations() const;                   ///< largest number of iterations of a solve so far
  double LongestEdge() const;               ///< of all pieces, world units
  double LongestSide() const;               ///< of the box around all pieces, world units
  std::int64_t NumberOfPoints() const;      ///< of the whole surface

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Throws InvalidInput for options that DistributedMaternField does not take, naming the first.
void RequireDistributedOptions(const MaternFieldOptions& options);

} // namespace surfsynth
