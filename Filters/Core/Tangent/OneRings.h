// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Logarithm maps of the one-rings of a surface, and parallel transport along its edges: [Mitchel2024], section 4, by the
/// rescaled angles of [Knoppel2013].
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <cmath>
#include <complex>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The unfolded triangle of a one-ring, seen from the corner p at its center. Corner k of triangle f is p, a is the
/// triangle's next corner and b the one after: p, a, b run counter-clockwise.
struct RingCorner
{
  double Angle = 0.0;  ///< argument of the logarithm of a in the frame of p, radians
  double Scale = 1.0;  ///< ratio of the rescaled to the true angles at p
  double Length = 0.0; ///< |a - p|, world units
  double OtherX = 0.0; ///< component of b - p along a - p, world units
  double OtherY = 0.0; ///< component of b - p across a - p, world units, larger than 0

  /// Logarithm of the point q with barycentric coordinates @p weightA of a and @p weightB of b:
  /// |q - p| exp(i (Angle + Scale angle(a, p, q))), world units.
  std::complex<double> Logarithm(double weightA, double weightB) const
  {
    const double x = weightA * this->Length + weightB * this->OtherX;
    const double y = weightB * this->OtherY;
    const double radius = std::sqrt(x * x + y * y);
    const double angle = this->Angle + this->Scale * std::atan2(y, x);
    return { radius * std::cos(angle), radius * std::sin(angle) };
  }
};

/// Logarithm maps of all one-rings of a manifold, oriented surface with or without boundary.
///
/// The triangles around vertex p are laid side by side, counter-clockwise. Their angles at p are multiplied so that they
/// sum to 2 pi inside the surface; at its boundary they stay as they are, unless they sum to more than 2 pi. The
/// logarithm log_p q of a point q of the ring, a complex number in the frame of p, is its distance |q - p| times
/// exp(i angle), world units: the exact polar coordinates of the cone at p.
///
/// The zero of the angles belongs to the frame: the angles are turned by the argument of
///   sum over the edges e of the ring of  P(e) exp(-i angle(e)),
/// with P(e) the edge projected to the tangent plane (so that edges weigh by their projected length). Where this sum
/// vanishes (below 1e-6 of the sum of the lengths), the edge with the longest projection keeps the argument of its
/// projection. So the numbers of vertices and triangles do not matter, a frame that is turned by an angle turns its
/// logarithms by the opposite one, and bending without stretching turns all logarithms of a vertex alike.
///
/// Vertices that no triangle uses have empty rings. Built in O(V + F), in parallel; the same bits for every number of
/// threads.
class OneRings
{
public:
  /// Unfolds the rings of @p mesh in the frames of TangentFrames().
  /// @throws InvalidInput when the mesh has a defect, is not manifold or not consistently wound; see CheckMesh().
  explicit OneRings(const TriangleMesh& mesh);
  /// Unfolds the rings of a mesh that passes CheckMesh(), in frames of the caller.
  /// @param topology the tables of @p mesh
  /// @param frames the frame of each vertex; X and Y orthonormal, counter-clockwise seen from outside
  /// @throws InvalidInput when the triangles around a vertex form no single fan of one winding, or the number of frames is
  /// not that of the vertices.
  OneRings(const TriangleMesh& mesh, const MeshTopology& topology, VertexFrames frames);

  VertexFrames Frames; ///< frames of the vertices

  /// Corners (3 f + k for corner k of triangle f) around vertex v, counter-clockwise, are
  /// RingCorners[RingStart[v] .. RingStart[v + 1]); at a boundary the first one has the boundary edge to a.
  std::vector<Index> RingStart;         ///< [V + 1]
  std::vector<Index> RingCorners;       ///< [3 F]
  std::vector<RingCorner> Corners;      ///< [3 F], by corner
  std::vector<std::uint8_t> OnBoundary; ///< [V], 1 for vertices on a boundary
  Eigen::VectorXd TotalAngles;          ///< [V], sum of the true angles, radians; 0 without triangles
  Eigen::VectorXd Areas;                ///< [V], area of the triangles of the ring, square world units

  /// Vertices joined to v by an edge, ascending, are Neighbors[NeighborStart[v] .. NeighborStart[v + 1]), as in
  /// MeshTopology.
  std::vector<Index> NeighborStart;    ///< [V + 1]
  std::vector<Index> Neighbors;        ///< [2 E]
  Eigen::VectorXcd NeighborLogarithms; ///< [2 E], log_v of each neighbor
  /// [2 E], parallel transport from v to each neighbor w along their edge, of modulus 1: a tangent vector z of v becomes
  /// exp(i (arg log_w v + pi - arg log_v w)) z. That of the opposite direction is the conjugate.
  Eigen::VectorXcd Transport;

  /// Number of vertices, V.
  Index NumberOfPoints() const { return static_cast<Index>(this->RingStart.size()) - 1; }

  /// Computes the logarithms of places from all three corners of their triangles. Parallel; the same bits for every
  /// number of threads.
  /// @param places [@p count], triangle and barycentric coordinates; those without a triangle (-1) give 0
  /// @param out [@p count, 3], the logarithm from corner k of the triangle in column k
  /// @throws InvalidInput when a triangle is out of range.
  void CornerLogarithms(const SurfacePlace* places, std::int64_t count, std::complex<double>* out) const;

  /// Radius of the ring of vertex @p v as a disk, sqrt(Areas[v] / pi), world units; 0 without triangles.
  double RingRadius(Index v) const;

private:
  struct RingEdge
  {
    Index Vertex;                   ///< vertex at the end of the edge
    double Angle;                   ///< angle before the offset
    double Length;                  ///< world units
    std::complex<double> Direction; ///< exp(i Angle), rescaled
  };
  void UnfoldRing(const TriangleMesh& mesh, Index v, std::vector<RingEdge>& edges);
  void Unfold(const TriangleMesh& mesh, const MeshTopology& topology);
  void ConnectNeighbors();
};

/// Radius of the mean vertex area element, sqrt(A / (pi V)), world units ([Mitchel2024], section 6.6), with A the area of
/// the surface and V the number of vertices that triangles use. Rings overlap three times: the radius of a mean ring is
/// sqrt(3) times as large. 0 without triangles.
double MeanRingRadius(const OneRings& rings);

} // namespace surfsynth
