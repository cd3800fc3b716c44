// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Field convolutions of tangent vector fields as published [Mitchel2021]: the reference of the convolutions in networks.
#pragma once

#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <complex>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Pairs of vertices in each other's support, the pair of a vertex with itself included. E in all.
struct FieldConvolutionEdges
{
  std::vector<Index> Sources;  ///< [E]
  std::vector<Index> Targets;  ///< [E]
  Eigen::VectorXcd Logarithms; ///< [E], log of the target in the frame of the source, world units
  Eigen::VectorXcd Transport;  ///< [E], parallel transport from the source to the target, of modulus 1
};

/// Values of all basis filters at all edges.
struct FieldConvolutionStencil
{
  Index Vertices = 0;         ///< number of vertices, V
  int Rings = 0;              ///< radial knots, R
  int BandLimit = 0;          ///< largest angular frequency, B
  std::vector<Index> Sources; ///< [E]
  std::vector<Index> Targets; ///< [E]
  Eigen::MatrixXcd Values;    ///< [E, R (2 B + 1)]; column k (2 B + 1) + B + m for ring k and frequency m

  /// Number of frequencies, 2 B + 1.
  int Frequencies() const { return 2 * this->BandLimit + 1; }
};

/// Computes the stencil: radial hat functions with knots at sqrt(k / (R - 1)) times exp(i m angle), times the weight of
/// the source over the sum of the weights that reach the target, times the transport. Edges longer than @p radius are
/// left out first.
/// @param weights [V], areas of the vertices, larger than 0
/// @param radius radius of the support, world units, larger than 0
/// @param rings R, 2 or more
/// @param bandLimit B, 0 or more
/// @throws InvalidInput when sizes do not fit or a vertex does not exist.
FieldConvolutionStencil MakeFieldConvolutionStencil(
  const FieldConvolutionEdges& edges, const Eigen::VectorXd& weights, double radius, int rings, int bandLimit);

/// Coefficients of the filters from C to O vector fields.
struct FieldFilters
{
  int Type = 1;    ///< 0: plain; 1: a phase for each frequency; 2: free complex coefficients
  int Inputs = 0;  ///< C
  int Outputs = 0; ///< O
  /// [O, C, R], coefficients of frequency 0; real for types 0 and 1.
  std::vector<std::complex<double>> Zonal;
  /// [O, C, R, B], coefficients of frequencies 1 to B, those of -m are the conjugates. Type 2: [O, C, R, 2 B], those of
  /// -B to -1, then 1 to B.
  std::vector<std::complex<double>> Spherical;
  /// [O, C, B + 1], radians, by |m|; read for type 1 only.
  std::vector<double> Phase;
};

/// Convolves tangent vector fields. With the feature X_j at the source and its argument phi (0 where both parts are
/// below 1e-7), the result at i is
///   sum over the edges (j, i), c, k, m of  X_j exp(-i m phi) stencil(k, m) filter(o, c, k, m) / (2 B + 1).
/// @param field [V, C] complex, in the frames of the vertices
/// @return [V, O] complex
/// @throws InvalidInput when sizes do not fit.
Eigen::MatrixXcd ConvolveField(
  const FieldConvolutionStencil& stencil, const Eigen::MatrixXcd& field, const FieldFilters& filters);

} // namespace surfsynth
