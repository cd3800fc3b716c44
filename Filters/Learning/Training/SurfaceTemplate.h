// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The template of a fit that is made from the reference itself. Private to the training; no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/SurfaceSimplification.h"
#include "Core/Mesh/TriangleMesh.h"

#include <memory>

namespace surfsynth
{

/// A coarse smooth mesh of the topology of a reference of any genus, with or without boundary, and the map of its
/// subdivisions onto the reference.
class SurfaceTemplate
{
public:
  /// Smooths the reference (SmoothedForm()) and simplifies it (SurfaceSimplification).
  /// @param triangles number of triangles wanted, at least 4; more where the topology needs them
  /// @param smoothingLength of SmoothedForm(), units of the reference; 0: half of the edge of an equilateral triangle of the
  /// mean area of the template's
  /// @throws InvalidInput when the reference has edges or points that are not manifold, or triangles that are not wound
  /// alike; SolverFailure when the topology of the result differs; Cancelled
  SurfaceTemplate(
    const TriangleMesh& reference, Index triangles, double smoothingLength, const Progress& progress = {});

  /// The template.
  const TriangleMesh& Mesh() const { return this->Coarse; }

  /// Returns the points of the template, subdivided at midpoints @p level times, on the reference.
  TriangleMesh OnReference(int level) const;

private:
  TriangleMesh Reference;
  TriangleMesh Coarse;
  std::unique_ptr<SurfaceSimplification> Map;
};

} // namespace surfsynth
