// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What can be said about a triangle mesh, however broken: defects, topology, sizes and shapes.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Some numbers, each of which belongs to something with an id.
struct Distribution
{
  std::int64_t Count = 0; ///< how many numbers; the rest is 0 when there are none
  double Minimum = 0.0;
  double Mean = 0.0;
  double Median = 0.0; ///< the lower one of two
  double Maximum = 0.0;
  std::int64_t AtMinimum = 0; ///< the lowest id that has the smallest number
  std::int64_t AtMaximum = 0; ///< the lowest id that has the largest number
};

/// One connected component: triangles that are joined by points.
struct ComponentStatistics
{
  std::int64_t FirstPoint = 0; ///< its lowest point id
  std::int64_t Points = 0;
  std::int64_t Triangles = 0;
  std::int64_t EulerCharacteristic = 0; ///< V - E + F
  std::int64_t BoundaryLoops = 0;
  bool Closed = true;            ///< no edge has only one triangle
  bool Manifold = true;          ///< no edge has three triangles or more, and every point has one fan of triangles
  bool Orientable = true;        ///< the triangles can be wound alike
  bool ConsistentWinding = true; ///< and they are
  double Area = 0.0;             ///< square world units
  /// (2 - V + E - F - boundary loops) / 2, where the component is an orientable manifold.
  std::optional<std::int64_t> Genus;
  /// The enclosed volume, cubic world units, where the component is closed and can be oriented; less than zero when it is
  /// wound inwards.
  std::optional<double> Volume;
};

/// Topology counts the triangles with three different existing corners, degenerate ones included; lengths, areas and
/// angles count what has finite coordinates, and angles no degenerate triangle.
struct MeshStatistics
{
  std::int64_t Points = 0;
  std::int64_t Triangles = 0;       ///< all
  std::int64_t ProperTriangles = 0; ///< those with three different existing corners: what topology is about
  std::int64_t UsedPoints = 0;      ///< points of proper triangles
  std::int64_t Edges = 0;
  std::vector<MeshFinding> Findings; ///< every kind of defect, from InspectMesh()

  MeshFinding UnreferencedPoints{
    MeshDefect::IndexOutOfRange
  };                                                           ///< count and first of the points in no proper triangle
  MeshFinding CoincidentPoints{ MeshDefect::IndexOutOfRange }; ///< used points at the very place of an earlier one
  MeshFinding DuplicateTriangles{ MeshDefect::IndexOutOfRange }; ///< triangles with the corners of an earlier one
  MeshFinding SmallComponents{ MeshDefect::SeveralComponents }; ///< of the fraction below; the first one's lowest point
  /// A component is small when it has fewer triangles than this fraction of those of the largest one.
  static constexpr double SmallComponentFraction = 0.01;

  std::vector<ComponentStatistics> Components; ///< in order of their lowest point id
  std::int64_t BoundaryLoops = 0;
  double LongestBoundaryLoop = 0.0;          ///< world units
  std::int64_t LongestBoundaryLoopPoint = 0; ///< a point on it

  double Area = 0.0;          ///< square world units
  BoundingBox Box;            ///< of the finite points of proper triangles
  Distribution EdgeLength;    ///< world units; ids are the lower point of the edge
  Distribution SmallestAngle; ///< of each triangle, degrees; ids are triangles
  Distribution LargestAngle;  ///< likewise
  /// Of each triangle, longest edge times perimeter / (4 sqrt(3) area): 1 for an equilateral one. Ids are triangles.
  Distribution AspectRatio;

  bool Closed() const;
  bool Manifold() const;
  bool Orientable() const;
  bool ConsistentWinding() const;
  std::int64_t EulerCharacteristic() const;
  std::optional<std::int64_t> Genus() const; ///< the sum over the components, where all have one
  std::optional<double> Volume() const;      ///< likewise
};

/// Never throws because of the mesh. The same bits for every number of threads. About half a second for a million
/// triangles.
/// @throws Cancelled
MeshStatistics ComputeMeshStatistics(const TriangleMesh& mesh, const Progress& progress = {});

} // namespace surfsynth
