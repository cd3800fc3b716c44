// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Level sets by OpenVDB [Museth2013]: from meshes and samples, and back to meshes. Private to the mesh processing.
///
/// All grids have voxels of side 1: the caller scales. Values are negative inside.
#pragma once

#include "MeshProcessing/LevelSets/VolumeSurface.h"

#include <openvdb/Grid.h>
#include <openvdb/openvdb.h>
#include <openvdb/util/NullInterrupter.h>

namespace surfsynth
{

/// Half width of the narrow band of a level set, voxels.
constexpr float HalfWidth = 3.0F;

/// Interrupter of OpenVDB by a StopFlag.
class StopInterrupter : public openvdb::util::NullInterrupter
{
public:
  /// @param stop flag, kept by reference
  explicit StopInterrupter(const StopFlag& stop)
    : Stop(stop)
  {}
  /// True when the flag is set.
  bool wasInterrupted(int = -1) override { return this->Stop.load(std::memory_order_relaxed); }
  /// Throws when the flag is set: results of OpenVDB after an interruption are not usable.
  /// @throws Cancelled
  void Check() const;

private:
  const StopFlag& Stop;
};

/// Converts samples to a grid, with a layer of opposite sign around them that caps the volume. The values are no
/// distances, but the meshing treats the grid as a level set. Leaves exist only near changes of sign.
openvdb::FloatGrid::Ptr GridOfSamples(const VolumeSamples& samples);

/// Computes the signed distance to a mesh that is closed, manifold and consistently wound, by the pseudonormal of the
/// nearest feature [Baerentzen2005]: thin walls and cavities are kept.
/// @throws Cancelled
openvdb::FloatGrid::Ptr LevelSetOfOrientedMesh(const TriangleMesh& mesh, StopInterrupter& interrupter);

/// True when the signs of @p levelSet fit its distances: no two neighbours, in or beside the narrow band, lie on
/// different sides of the surface and yet far from it. Meshes whose parts overlap or are nested with the wrong winding
/// give others.
bool IsConsistent(const openvdb::FloatGrid& levelSet);

/// Computes the signed distance to the solid that a triangle soup encloses: all places that cannot be reached from
/// outside without crossing the mesh or passing a gap narrower than twice @p closing (at least one voxel). Parts of the
/// mesh that enclose nothing become plates, two voxels thick.
/// @param closing voxels, at least 0
/// @throws Cancelled
openvdb::FloatGrid::Ptr LevelSetOfSoup(const TriangleMesh& mesh, double closing, StopInterrupter& interrupter);

/// Moves the surface outwards by @p distance voxels (inwards when negative).
/// @throws Cancelled
void MoveSurface(openvdb::FloatGrid& levelSet, double distance, StopInterrupter& interrupter);

/// Smooths a level set by @p iterations steps of a filter.
/// @throws Cancelled
void Smooth(openvdb::FloatGrid& levelSet, LevelSetSmoothing kind, int iterations, StopInterrupter& interrupter);

/// Fills the cavities of the solid.
void FillCavities(openvdb::FloatGrid& grid);

/// Keeps only the part of the solid with the most voxels; the voxels of a part are connected by their faces.
void KeepLargestPart(openvdb::FloatGrid& grid);

/// Extracts the isosurface, in voxel units, as triangles wound outwards, with balanced edges (SeparateSheets.h).
/// @param adaptivity 0: triangles of about the size of a voxel, to 1: the largest triangles in flat parts
TriangleMesh MeshOfGrid(const openvdb::FloatGrid& grid, double isoValue, double adaptivity);

} // namespace surfsynth
