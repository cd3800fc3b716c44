// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// One pass of the repair of a surface. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Repair/IntersectionRemoval.h"
#include "MeshProcessing/Repair/SurfaceExtent.h"
#include "MeshProcessing/Repair/SurfaceRepair.h"

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace surfsynth
{

/// State of a repair between two passes.
struct RepairState
{
  TriangleMesh Mesh;
  std::vector<bool> IsFilling; ///< [F], true for triangles that close a hole
  bool IsClosed = false;       ///< no boundary

  TriangleMesh RefusedMesh;    ///< last mesh from which intersections could not be removed; without triangles: none
  IntersectionRemoval Refused; ///< result for RefusedMesh
};

/// A line of the report of a pass.
struct RepairLine
{
  std::string Text;
  std::int64_t Count = 0;
  bool IsLeft = false; ///< counts what the pass left, not what it changed
};

/// Report of a pass.
struct PassReport
{
  std::vector<RepairLine> Lines; ///< in order of the steps
  bool NeedsAnother = false;     ///< the pass made new triangles or moved points
  SurfaceExtent Before;          ///< after duplicate triangles were removed and sheets separated; area: before merging
  SurfaceExtent Removed;         ///< components that were removed on request
  IntersectionRemoval Removal;   ///< intersecting triangles
  std::int64_t FlatOutlines = 0; ///< number of boundaries left open, see FilledHoles
  std::int64_t Unsuitable = 0;   ///< number of boundaries left open, see FilledHoles
};

/// True when points and triangles are equal, in the same order.
bool IsSameMesh(const TriangleMesh& a, const TriangleMesh& b);

/// Runs all steps of a repair once.
/// @param state the mesh before, then the mesh after the pass
/// @param mergeTolerance world units, at least 0, in place of that of @p options
/// @throws InvalidInput when no triangle is left; Cancelled
PassReport RunRepairPass(
  RepairState& state, const RepairOptions& options, double mergeTolerance, const std::atomic<bool>* stop);

} // namespace surfsynth
