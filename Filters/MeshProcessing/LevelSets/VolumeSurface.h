// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Closed surfaces of volumes and of meshes, by level sets [Museth2013]: the algorithm of vtkVDBSurfaceFilter. Private
/// to the mesh processing.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Filter of a level set.
enum class LevelSetSmoothing
{
  None,          ///< no smoothing
  Gaussian,      ///< Gaussian filter
  MeanCurvature, ///< mean curvature flow
  Median,        ///< median filter
  Laplacian      ///< Laplacian flow
};

/// Options of a conversion, the properties of vtkVDBSurfaceFilter; lengths in world units.
struct LevelSetOptions
{
  double VoxelSize = 0.0;                                ///< side of a voxel, at least 0; 0: chosen from the input
  double Closing = 0.0;                                  ///< gaps up to twice this length are closed, at least 0
  LevelSetSmoothing Smoothing = LevelSetSmoothing::None; ///< filter
  int SmoothingIterations = 3;                           ///< number of steps of the filter, at least 0
  double Offset = 0.0;                                   ///< the surface moves outwards by this length; may be negative
  double Adaptivity = 0.0;                               ///< in [0, 1], see MeshOfGrid()
  bool FillCavities = false;                             ///< makes cavities solid
  bool LargestComponent = false;                         ///< keeps only the part with the most voxels
  double MaximumNumberOfVoxels = 2e8; ///< limit of the voxels along the surface; visits by Offset: 10 times as many
  bool SinglePrecision = false;       ///< points of the result are rounded to floats

  /// True when the surface of a volume can be extracted from its own samples.
  bool LeavesLevelSetAlone() const
  {
    return this->Closing == 0.0 && this->Offset == 0.0 && this->VoxelSize == 0.0 &&
      (this->Smoothing == LevelSetSmoothing::None || this->SmoothingIterations == 0);
  }
};

/// A scalar function on a lattice, negative inside the region. Sample (i, j, k), with i running fastest, lies at
/// (i Spacing[0], j Spacing[1], k Spacing[2]).
struct VolumeSamples
{
  std::array<int, 3> Dimensions{ { 0, 0, 0 } };      ///< numbers of samples along the axes
  Eigen::Vector3d Spacing = Eigen::Vector3d::Ones(); ///< world units, larger than 0
  std::vector<float> Values;                         ///< in [-1, 1], finite
};

/// Flag that makes a running call throw Cancelled soon; set from another thread.
using StopFlag = std::atomic<bool>;

/// Extracts the surface of the region of negative @p samples, capped half a sample beyond the outermost ones. Closed,
/// manifold, wound outwards; empty when there is no such region.
/// @throws InvalidInput when the voxels would be too many or larger than the surface, Cancelled
TriangleMesh SurfaceOfVolume(const VolumeSamples& samples, const LevelSetOptions& options, const StopFlag& stop);

/// Extracts the surface of the solid that @p mesh bounds, and of a plate two voxels thick around parts that bound none.
/// @param mesh any triangles with finite points and ids in range.
/// @throws InvalidInput when the mesh has no extent or the voxels would be too many or larger than it, Cancelled
TriangleMesh SurfaceOfMesh(const TriangleMesh& mesh, const LevelSetOptions& options, const StopFlag& stop);

} // namespace surfsynth
