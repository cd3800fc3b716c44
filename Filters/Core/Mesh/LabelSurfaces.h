// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces of the labels of a volume, which keep the volume of each label and share their borders.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Labels at the points of a lattice; x runs fastest. Outside lies the background, label 0.
struct LabelVolume
{
  std::array<int, 3> Dimensions{};                   ///< number of samples along x, y, z
  Eigen::Vector3d Spacing = Eigen::Vector3d::Ones(); ///< world units between samples, larger than 0
  const std::int32_t* Labels = nullptr;              ///< [x y z]; memory of the caller
};

/// Options of MakeLabelSurfaces().
struct LabelSurfaceOptions
{
  /// Steps of smoothing, at least 0, each a low-pass filter of [Taubin1995] (factors 0.5 and -0.51) over the whole network
  /// of borders.
  int SmoothingIterations = 30;
  /// Largest move by smoothing along each axis, samples, at least 0.
  double MaximumMove = 1.5;
  /// Moves borders along their normals until each label has the volume of its samples, to a relative error of 1e-4.
  bool PreserveVolume = true;
  /// Surfaces of touching labels have the same points in their border. Without it each label is smoothed by itself, as if
  /// the others were background.
  bool SharedBorders = true;
};

/// Surface of one label.
struct LabelSurface
{
  std::int32_t Label = 0;
  TriangleMesh Mesh;         ///< world units with sample (0, 0, 0) at the origin; closed, manifold, wound outwards
  double SampleVolume = 0.0; ///< number of samples times the volume of one
};

/// Makes the surfaces of all labels other than 0, in ascending order.
///
/// One point for each cube of eight samples with several labels, in the mean of the middles of its edges between different
/// labels, and a quadrilateral of two triangles for each such edge ([Gibson1998], for many labels as in [Frisken2022]). All
/// surfaces are parts of one network of points that is smoothed and moved as a whole: where labels touch, their surfaces
/// have the same points and triangles, wound in opposite ways. Points where a surface touches itself are taken apart
/// (SeparateSheets()). Volumes are preserved by a pressure p_l in each label and 0 in the background: a point moves by
/// 3 sum_l p_l g_l / A, with g_l the gradient of the volume of label l and A the area of the triangles at the point, and p
/// solves the linearized equations of the volumes, some times over.
///
/// Serial. O(samples + iterations * points) time; memory of 8 bytes for each sample, and the network.
/// @throws InvalidInput for dimensions or spacing that are not positive, options out of range, or more than 2^31 - 1
/// points; SolverFailure when volumes do not converge; Cancelled
std::vector<LabelSurface> MakeLabelSurfaces(
  const LabelVolume& volume, const LabelSurfaceOptions& options = {}, const Progress& progress = {});

} // namespace surfsynth
