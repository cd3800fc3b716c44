// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Statistics of any triangle mesh, valid or not: defects, topology, sizes and shapes.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace surfsynth
{

/// Distribution of a quantity over things with ids, such as edge lengths. All is 0 when Count is 0.
struct Distribution
{
  std::int64_t Count = 0;     ///< number of values
  double Minimum = 0.0;       ///< smallest value
  double Mean = 0.0;          ///< arithmetic mean
  double Median = 0.0;        ///< the lower one of two
  double Maximum = 0.0;       ///< largest value
  std::int64_t AtMinimum = 0; ///< the lowest id with the smallest value
  std::int64_t AtMaximum = 0; ///< the lowest id with the largest value
};

/// One connected component: triangles that are joined by points.
struct ComponentStatistics
{
  std::int64_t FirstPoint = 0;          ///< its lowest point id
  std::int64_t Points = 0;              ///< V
  std::int64_t Triangles = 0;           ///< F
  std::int64_t EulerCharacteristic = 0; ///< V - E + F
  std::int64_t BoundaryLoops = 0;       ///< number of boundary loops, see FindBoundaryLoops()
  bool Closed = true;                   ///< no edge has only one triangle
  bool Manifold = true;          ///< no edge has three triangles or more, and every point has one fan of triangles
  bool Orientable = true;        ///< the triangles can be wound alike
  bool ConsistentWinding = true; ///< the triangles are wound alike
  double Area = 0.0;             ///< square world units
  /// Genus, (2 - V + E - F - boundary loops) / 2, of an orientable manifold; else absent.
  std::optional<std::int64_t> Genus;
  /// Enclosed volume, cubic world units, of a closed orientable component; negative when it is wound inwards; else
  /// absent.
  std::optional<double> Volume;
};

/// Statistics of a mesh. Topology counts the proper triangles (see ProperTriangles), degenerate ones included. Lengths,
/// areas and angles count only finite coordinates, and angles no degenerate triangle.
struct MeshStatistics
{
  std::int64_t Points = 0;           ///< number of points, used or not
  std::int64_t Triangles = 0;        ///< number of triangles, proper or not
  std::int64_t ProperTriangles = 0;  ///< number of triangles with three different existing corners
  std::int64_t UsedPoints = 0;       ///< number of points of proper triangles
  std::int64_t Edges = 0;            ///< number of edges of proper triangles
  std::vector<MeshFinding> Findings; ///< every kind of defect, from InspectMesh()

  MeshFinding UnreferencedPoints{
    MeshDefect::IndexOutOfRange
  };                                                           ///< count and first of the points in no proper triangle
  MeshFinding CoincidentPoints{ MeshDefect::IndexOutOfRange }; ///< used points with the coordinates of an earlier one
  MeshFinding DuplicateTriangles{ MeshDefect::IndexOutOfRange }; ///< triangles with the corners of an earlier one
  MeshFinding NeedleTriangles{ MeshDefect::DegenerateTriangle }; ///< triangles with an angle below NeedleAngle
  static constexpr double NeedleAngle = 1.0;                     ///< degrees
  MeshFinding SmallComponents{ MeshDefect::SeveralComponents };  ///< small components; the first one's lowest point
  /// Limit of small components: they have fewer triangles than this fraction of those of the largest one.
  static constexpr double SmallComponentFraction = 0.01;

  std::vector<ComponentStatistics> Components; ///< in order of their lowest point id
  std::int64_t BoundaryLoops = 0;              ///< number of boundary loops
  double LongestBoundaryLoop = 0.0;            ///< length, world units
  std::int64_t LongestBoundaryLoopPoint = 0;   ///< a point on it

  double Area = 0.0;          ///< square world units
  BoundingBox Box;            ///< box of the finite points of proper triangles
  Distribution EdgeLength;    ///< world units; ids are the lower point of the edge
  Distribution SmallestAngle; ///< smallest angle of each triangle, degrees; ids are triangles
  Distribution LargestAngle;  ///< largest angle of each triangle, degrees; ids are triangles
  /// Aspect ratio of each triangle [Stimpson2007], longest edge times perimeter / (4 sqrt(3) area): at least 1, and 1
  /// for an equilateral one. Ids are triangles.
  Distribution AspectRatio;

  bool Closed() const;                       ///< true when all components are closed
  bool Manifold() const;                     ///< true when all components are manifold
  bool Orientable() const;                   ///< true when all components are orientable
  bool ConsistentWinding() const;            ///< true when all components are wound consistently
  std::int64_t EulerCharacteristic() const;  ///< sum over the components
  std::optional<std::int64_t> Genus() const; ///< sum over the components; absent unless all have one
  std::optional<double> Volume() const;      ///< sum over the components, cubic world units; absent unless all have one
};

/// Sum of the areas of the triangles, square world units.
double SurfaceArea(const TriangleMesh& mesh);

/// Mean length of the sides of the triangles, world units: inner edges count twice. 0 without triangles.
double MeanSideLength(const TriangleMesh& mesh);

/// Computes the statistics of any mesh; its defects are findings, not errors. The same bits for every number of
/// threads. About half a second for a million triangles.
/// @throws Cancelled
MeshStatistics ComputeMeshStatistics(const TriangleMesh& mesh, const Progress& progress = {});

} // namespace surfsynth
