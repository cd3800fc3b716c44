// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Noise on surfaces that stay in their pieces on several MPI ranks. Private to the module.
#pragma once

#include "RandomFields.h"
#include "SurfaceBridge.h"

#include "Core/Noise/MaternField.h"

#include <functional>
#include <memory>

namespace surfsynth
{

/// Properties of the whole surface and of its field.
struct PieceNoiseResults
{
  double EffectiveScreening = 0.0;        ///< see MaternField
  double EffectiveCorrelationRange = 0.0; ///< see MaternField
  double Gamma = 0.0;                     ///< see MaternField
  double RelativeResidual = 0.0;          ///< see MaternField
  double LongestEdge = 0.0;               ///< world units
  double LongestSide = 0.0;               ///< of the box around the surface, world units
  int Iterations = 0;                     ///< see MaternField
  bool IsNew = false; ///< false when operators and multigrid hierarchy are those of an earlier update
};

/// True for two options with the same operators.
using SameOperators = std::function<bool(const MaternFieldOptions& a, const MaternFieldOptions& b)>;

/// Fields in pieces of the last update.
class PieceNoise
{
public:
  PieceNoise();
  ~PieceNoise();

  void Begin();      ///< begins an update: see BlockCache::Begin()
  void DropUnused(); ///< ends it: see BlockCache::DropUnused()

  /// Adds the samples of @p request to the points of this rank's piece. Collective.
  /// @throws InvalidInput when the library was built without PETSc, and as DistributedMaternField.
  PieceNoiseResults AddSamples(const SurfacePiece& piece, const MaternFieldOptions& options, const SameOperators& same,
    const SampleRequest& request, const SampleSeries& series, vtkDataSet* output, const Progress& progress);

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
