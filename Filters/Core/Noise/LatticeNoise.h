// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// White noise on surfaces that belongs to places in space, not to the vertices of a triangulation.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Load vectors b_i = integral of phi_i dW of a random measure W that is the same on all triangulations of a surface,
/// with a covariance close to the mass matrix [Lindgren2011].
///
/// A cubic lattice of side h is fixed in space. Each lattice point c and each of the six directions d along the axes
/// has a number xi ~ N(0, 1), and on the surface
///   dW(x) = sum over (c, d) of xi w_c(x) v_d(x) / sqrt(a_cd) dA,   a_cd = integral of w_c v_d dA,
/// with w_c the trilinear hat function of c and v_d the square of the coordinate of the unit normal along d (0 on the
/// other side). Both sum to 1, so that the variance of the integral of dW over the whole surface is its area, and the
/// covariance of b with the integral is the lumped mass, on every triangulation. The normals are smoothed over a
/// distance of about h. Sheets that face opposite ways, as on a thin part, share no number; sheets that face the same
/// way within 2 h of each other do, and are correlated.
///
/// W is white over distances of several h: at the eigenvalue lambda of the Laplacian its variance is 1 - lambda h^2 / 6
/// to first order, and integrals over triangles larger than h have the covariance of the consistent mass, M - D,
/// instead of the lumped M. Both are corrected: the load vectors are multiplied by 1 + h^2 / 12 L M^-1 and the series
/// of (1 - D M^-1)^-1/2. The variance is then 1 within about (lambda h^2 / 10)^2. Below a distance of h the noise is
/// smooth. Two triangulations whose surfaces differ by s in space and whose smoothed normals by an angle theta have
/// noise with a correlation of about cos(theta) (1 - (s / h)^2).
///
/// The noise belongs to world coordinates: a surface that is moved gets other noise, and one whose winding is reversed,
/// too. Where the winding is not consistent (on a Moebius strip), it depends on the triangulation.
///
/// Integrals are sums over the corners of triangles with edges up to h, and over centroids of up to 256 parts of
/// larger ones; both are exact for hat functions. Memory and time for a drawing: about 24 numbers for each vertex where
/// the triangles are small, and about 50 for each square of side h of the surface where they are large. On 163,842
/// vertices the shares take 0.4 s to find where h is 1.2 edges, and 4 s where it is 0.6 edges; 32 drawings take 0.6 and
/// 3 s.
class LatticeNoise
{
public:
  /// Numbers of several draws at the vertices or lattice points, a row for each.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Finds the shares of the vertices in each number. Deterministic, with the same bits for every number of threads.
  /// @param mesh a mesh that passes CheckMesh()
  /// @param topology the tables of @p mesh
  /// @param side h, world units, > 0; the same for all triangulations that are to have the same noise
  /// @throws InvalidInput when @p side is not a positive number; Cancelled.
  LatticeNoise(const TriangleMesh& mesh, const MeshTopology& topology, double side, const Progress& progress = {});

  /// Draws load vectors, [V, keys]. The bits of a column depend on its key alone. May be called from several threads.
  /// Rows of vertices without triangles are 0.
  Rows Draw(const std::vector<NormalKey>& keys) const;

  /// Side of the lattice, h, world units.
  double Side() const { return this->LatticeSide; }
  /// Number of random numbers of a draw: pairs (c, d) with a share of the surface.
  Index NumberOfNumbers() const { return static_cast<Index>(this->Shares.cols()); }
  /// Correlates the load vectors b with functions u: u^T b = result^T xi for the numbers xi of a draw, so that
  /// result^T result is the covariance of the u^T b, which is close to u^T M u. For tests and statistics.
  /// @param functions [V, K] values at the vertices
  /// @return [NumberOfNumbers(), K]
  Rows Covariates(const Eigen::Ref<const Eigen::MatrixXd>& functions) const;

private:
  /// Lattice points that share a block of random numbers.
  struct Brick
  {
    std::uint64_t Hash;              ///< of its place
    std::vector<std::uint8_t> Slots; ///< numbers in the block that have a share of the surface, ascending
  };

  void FindShares(
    const TriangleMesh& mesh, const MeshTopology& topology, const PointMatrix& directions, const Progress& progress);
  Rows Numbers(const std::vector<NormalKey>& keys) const;
  void FillDeficit(Rows& loads) const;
  void Sharpen(Rows& loads) const;
  /// Adds factor * matrix M^-1 loads.
  void AddProduct(const SparseMatrix& matrix, double factor, const Rows& loads, Rows& sum) const;

  double LatticeSide;
  std::vector<Brick> Bricks; ///< numbers are in the order of bricks and slots
  SparseRowMatrix Shares;    ///< [V, numbers], integral of phi_i w_c v_d / sqrt(a_cd)
  Eigen::VectorXd Mass;      ///< [V], lumped
  SparseMatrix Stiffness;    ///< L
  SparseMatrix Deficit;      ///< D, lumped less consistent mass where triangles are larger than h
};

} // namespace surfsynth
