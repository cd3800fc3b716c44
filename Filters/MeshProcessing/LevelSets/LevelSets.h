// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// OpenVDB's level sets and the meshes and samples that they are made of and become. Private to the module.
///
/// All grids have voxels of side 1: whoever calls scales. Values are negative inside.
#pragma once

#include "MeshProcessing/LevelSets/VolumeSurface.h"

#include <openvdb/Grid.h>
#include <openvdb/openvdb.h>
#include <openvdb/util/NullInterrupter.h>

namespace surfsynth
{

/// Voxels from the surface to either edge of the narrow band of a level set.
constexpr float HalfWidth = 3.0F;

/// Hands a StopFlag on to OpenVDB.
class StopInterrupter : public openvdb::util::NullInterrupter
{
public:
  explicit StopInterrupter(const StopFlag& stop)
    : Stop(stop)
  {}
  bool wasInterrupted(int = -1) override { return this->Stop.load(std::memory_order_relaxed); }
  /// Throws Cancelled when the flag is set: what OpenVDB returns after an interruption is not usable.
  void Check() const;

private:
  const StopFlag& Stop;
};

/// The samples as a grid, with a layer of opposite sign around them that caps the volume; no level set, as values are
/// no distances, but treated as one by the meshing. Leaves lie only where the sign changes.
openvdb::FloatGrid::Ptr GridOfSamples(const VolumeSamples& samples);

/// The signed distance to a mesh that is closed, manifold and consistently wound, by the pseudonormal of the nearest
/// feature (Baerentzen and Aanaes 2005): thin walls and cavities are kept.
openvdb::FloatGrid::Ptr LevelSetOfOrientedMesh(const TriangleMesh& mesh, StopInterrupter& interrupter);

/// True when the signs of @p levelSet fit its distances: no two neighbours, in or beside the narrow band, lie on different
/// sides of the surface and yet far from it. Meshes whose parts overlap or are nested with the wrong winding give others.
bool IsConsistent(const openvdb::FloatGrid& levelSet);

/// The signed distance to the solid that any mesh encloses, that is, whatever cannot be reached from outside without
/// crossing the mesh or squeezing through a gap of less than twice @p closing (at least one voxel). Parts of the mesh that
/// enclose nothing become plates, two voxels thick.
openvdb::FloatGrid::Ptr LevelSetOfSoup(const TriangleMesh& mesh, double closing, StopInterrupter& interrupter);

/// Moves the surface outwards by @p distance voxels (inwards when negative).
void MoveSurface(openvdb::FloatGrid& levelSet, double distance, StopInterrupter& interrupter);

void Smooth(openvdb::FloatGrid& levelSet, LevelSetSmoothing kind, int iterations, StopInterrupter& interrupter);

/// Makes solid what the solid encloses.
void FillCavities(openvdb::FloatGrid& grid);

/// Drops all parts of the solid, whose voxels hang together by their faces, but that of most voxels.
void KeepLargestPart(openvdb::FloatGrid& grid);

/// The isosurface in voxel units as triangles wound outwards, with balanced edges (SeparateSheets.h).
TriangleMesh MeshOfGrid(const openvdb::FloatGrid& grid, double isoValue, double adaptivity);

} // namespace surfsynth
