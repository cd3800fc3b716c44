// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Neighborhoods of tangent vector fields on a surface and on one coarser level, for networks such as those of
/// [Mitchel2024], section 9.2.
#pragma once

#include "Core/Tangent/OneRings.h"

#include <complex>
#include <vector>

namespace surfsynth
{

/// Neighborhood of each vertex: the vertex itself, which comes first, and its neighbors. All numbers but the ids are
/// without unit, and do not depend on the numbers of the vertices; a frame turned by an angle turns its logarithms by
/// the opposite one.
struct TangentNeighborhoods
{
  std::vector<Index> Start;   ///< [V + 1], first edge of each vertex
  std::vector<Index> Sources; ///< [E], the vertex at the other end
  /// [E], logarithm of the source in the frame of the vertex, over Radius; 0 for the vertex itself.
  std::vector<std::complex<float>> Logarithms;
  std::vector<std::complex<float>> Transport; ///< [E], parallel transport from the source to the vertex, of modulus 1
  std::vector<float> Weights;                 ///< [E], area of the source over the area of all sources of the vertex
  /// [V], direction from the vertex to the centroid of its ring on the surface: m / sqrt(|m|^2 + (1e-3 r)^2) with the mean m,
  /// by area, of the logarithms of the triangles' centroids, and r the Radius of the surface. 0 without triangles.
  std::vector<std::complex<float>> Centroids;
  double Radius = 0.0; ///< radius of the mean vertex area element, sqrt(A / (pi V)), world units

  /// Number of vertices, V.
  Index NumberOfVertices() const { return static_cast<Index>(this->Start.size()) - 1; }
};

/// A surface and one coarser level. Coarse vertices are a maximal independent set: no two are neighbors, and each other
/// vertex has one as a neighbor and belongs to the nearest of those, along the edge. Vertices are chosen in descending
/// order of the area of their rings (then of the angle, then of the number of neighbors, each in single precision; then
/// ascending by number), which bending keeps and renumbering keeps where these differ. Vertices that agree in all three, as
/// those of regular meshes do, are chosen by number: other numbers then give another hierarchy of the same quality. Among
/// several nearest coarse vertices, and among shortest paths of equal length, the one of the lowest number counts.
///
/// Coarse vertices are neighbors when an edge joins their clusters. Logarithm and transport follow the shortest path of
/// at most three edges through such an edge: the logarithm is the sum of those of the edges, each transported back, so
/// that the transport of log_a b to b is -log_b a, as for the edges of OneRings.
struct TangentHierarchy
{
  /// Builds both levels, O(V log V). Deterministic. Vertices without triangles are coarse vertices without neighbors and
  /// do not count in Radius.
  explicit TangentHierarchy(const OneRings& rings);

  TangentNeighborhoods Fine;
  TangentNeighborhoods Coarse;
  std::vector<Index> Centers;                ///< [W], vertex of each coarse vertex, ascending
  std::vector<Index> Clusters;               ///< [V], coarse vertex of each vertex
  std::vector<std::complex<float>> ToCenter; ///< [V], parallel transport to the coarse vertex, of modulus 1
  std::vector<Index> MemberStart;            ///< [W + 1], first of the members of each coarse vertex
  std::vector<Index> Members;                ///< [V], vertices by cluster, ascending in each
};

/// Returns the vertices within @p part of the radius r of the centroid of their ring, ascending: |m| < part r, see
/// TangentNeighborhoods::Centroids. Directions of such rings are uncertain.
std::vector<Index> CentralVertices(const OneRings& rings, double part);

/// Returns the vertices of regular parts of a surface, ascending: those at the centroid of their ring, with a neighbor of
/// which the same holds. At a centroid is a vertex with |m| < 1e-3 r: see TangentNeighborhoods::Centroids. Such rings have
/// no direction of their own, and a field latent of one flat color is 0 there whatever the color; at 3e-3 r colors are
/// right to 2 per cent. On irregular triangulations about one vertex in 20,000 is at its centroid by chance: without a
/// neighbor, it is left out.
std::vector<Index> RegularVertices(const OneRings& rings);

} // namespace surfsynth
