// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Surfaces that lie on several MPI ranks. Private to the bridge.
///
/// Everything here is collective: all ranks call it in the same order, and no rank leaves early, whatever happens on
/// it.
#pragma once

#include "vtkSmartPointer.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkDataArray;
class vtkMultiProcessController;
class vtkPolyData;

namespace surfsynth
{

/// Ranks that run this pipeline together.
class Ranks
{
public:
  /// Returns the global controller, or null when there is one process only.
  static vtkMultiProcessController* Several();

  /// @param controller null for a pipeline that runs in one process.
  explicit Ranks(vtkMultiProcessController* controller)
    : Controller(controller)
  {}
  int Rank() const;  ///< of this process
  int Count() const; ///< number of ranks, at least 1

  /// Returns the numbers of all ranks, in the order of ranks: [Count()][values.size()]. The lengths must agree.
  std::vector<std::vector<std::int64_t>> Gather(const std::vector<std::int64_t>& values) const;
  /// Returns the lowest rank's text that is not empty, the same on all ranks; empty when there is none.
  std::string FirstText(const std::string& text) const;
  /// Returns the array of rank @p source: @p array there, one of the same name, type and content on every other rank,
  /// whose own argument is not used.
  vtkSmartPointer<vtkDataArray> Share(vtkDataArray* array, int source) const;
  /// Replaces @p polydata on all ranks by that of rank @p source.
  void Broadcast(vtkPolyData* polydata, int source) const;

private:
  vtkMultiProcessController* Controller;
};

/// A surface of which each rank holds a piece, whole on every rank.
struct GatheredSurface
{
  vtkSmartPointer<vtkPolyData> Whole;     ///< points, polygons and strips; no arrays
  std::vector<std::int64_t> WholeOfLocal; ///< for each point of this rank's piece, its id in Whole
  int Owners = 0;                         ///< ranks with at least one polygon or strip
  int TakenFrom = -1;                     ///< the rank whose piece is the whole surface as it is; -1 when there is none
};

/// Points, polygons and strips of a piece without its ghost cells, with global ids where they are there.
vtkSmartPointer<vtkPolyData> GeometryOf(vtkPolyData* piece);

/// Number of ranks whose @p geometry has polygons or strips. Collective.
int CountOwners(const Ranks& ranks, vtkPolyData* geometry);

/// Puts the pieces of all ranks together, so that every rank has the same.
///
///  - Cells that are marked as ghosts are left out, and so are cells that several pieces hold.
///  - Points are the same when their global ids are (the global ids of the point data, on all pieces), and are then in
///    the order of these ids; else when pieces of different ranks hold the same coordinates, and are then in the order
///    of ranks.
///  - Cells are in the order of their global ids where all pieces have them, else in the order of ranks.
///
/// With both kinds of global ids the whole is the mesh as it was before it was distributed, bit for bit.
/// A surface that lies on one rank only, and in which no global id of a point is repeated, is taken as it is.
GatheredSurface GatherPieces(const Ranks& ranks, vtkPolyData* piece);

/// True when two points of @p piece have the same global id: pieces of a distributed surface that one process has read.
bool RepeatsGlobalIds(vtkPolyData* piece);

/// Returns the tuples of @p whole, an array on the points of the whole surface, that belong to the local piece.
vtkSmartPointer<vtkDataArray> TakeLocal(const GatheredSurface& surface, vtkDataArray* whole);

} // namespace surfsynth
