// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Volumes and surfaces to level sets and back: what vtkVDBSurfaceFilter does, without VTK. Private to the module.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

namespace surfsynth
{

enum class LevelSetSmoothing
{
  None,
  Gaussian,
  MeanCurvature,
  Median,
  Laplacian
};

/// The properties of vtkVDBSurfaceFilter that say how; lengths in world units.
struct LevelSetOptions
{
  double VoxelSize = 0.0; ///< 0: chosen from the input
  double Closing = 0.0;
  LevelSetSmoothing Smoothing = LevelSetSmoothing::None;
  int SmoothingIterations = 3;
  double Offset = 0.0;
  double Adaptivity = 0.0;
  bool FillCavities = false;
  bool LargestComponent = false;
  double MaximumNumberOfVoxels = 2e8;
  bool SinglePrecision = false; ///< points of the result are rounded to floats

  /// True when the surface of a volume can be taken from its own samples.
  bool LeavesLevelSetAlone() const
  {
    return this->Closing == 0.0 && this->Offset == 0.0 && this->VoxelSize == 0.0 &&
      (this->Smoothing == LevelSetSmoothing::None || this->SmoothingIterations == 0);
  }
};

/// A scalar function on a lattice, negative inside of what is wanted. Sample (i, j, k), with i running fastest, lies at
/// (i Spacing[0], j Spacing[1], k Spacing[2]).
struct VolumeSamples
{
  std::array<int, 3> Dimensions{ { 0, 0, 0 } };
  Eigen::Vector3d Spacing = Eigen::Vector3d::Ones(); ///< larger than 0
  std::vector<float> Values;                         ///< in [-1, 1], finite
};

/// Set from another thread to make a running call throw Cancelled soon.
using StopFlag = std::atomic<bool>;

/// The surface of the region where @p samples is negative, capped half a sample beyond the outermost ones. Closed,
/// manifold, wound outwards; empty when there is no such region.
/// @throws InvalidInput when the voxels would be too many, Cancelled
TriangleMesh SurfaceOfVolume(const VolumeSamples& samples, const LevelSetOptions& options, const StopFlag& stop);

/// The surface of the solid that @p mesh bounds or, where it bounds none, of a plate two voxels thick around it.
/// @param mesh any triangles with finite points and ids in range.
/// @throws InvalidInput when the mesh has no extent or the voxels would be too many, Cancelled
TriangleMesh SurfaceOfMesh(const TriangleMesh& mesh, const LevelSetOptions& options, const StopFlag& stop);

} // namespace surfsynth
