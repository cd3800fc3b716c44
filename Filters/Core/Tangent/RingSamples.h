// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Uniformly distributed points of one-rings, at which an encoder looks at a texture: [Mitchel2024], section 9.1.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Tangent/OneRings.h"

#include <complex>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Samples of the one-rings of several vertices.
struct RingSamples
{
  /// Samples of the k-th vertex asked for are those with numbers in [Offsets[k], Offsets[k + 1]).
  std::vector<std::int64_t> Offsets;            ///< [K + 1]
  std::vector<SurfacePlace> Places;             ///< [S], triangles and barycentric coordinates
  std::vector<std::complex<double>> Logarithms; ///< [S], logarithm of each sample from its vertex, world units
};

/// Distributes samples evenly over one-rings; the same ones at every call.
///
/// A triangle with the share a of its ring's area has round(a numberOfSamples - 1e-6) samples, at least one, so that a ring
/// has about @p numberOfSamples. Sample i of n of a triangle p, a, b (counter-clockwise, p the vertex) is
///   p + sqrt(s) ((1 - t) (a - p) + t (b - p)),  s = (i + 1/2) / n,  t = frac((i + 1/2) (sqrt(5) - 1) / 2),
/// a Fibonacci lattice taken to the triangle without change of area. Samples depend on the shapes of triangles only: not on
/// the numbers of vertices, the frames, the start of the ring or the threads. Their order is that of the ring.
///
/// A ring with more than n = max(1024, numberOfSamples) triangles has n samples: one in each of the triangles that hold
/// the fractions (i + 1/2) / n of its area, counted counter-clockwise from its largest triangle. The cost of a vertex
/// with very many triangles stays bounded.
/// @param vertices vertex ids; the samples of all rings of a large mesh take about 3 kB for each vertex
/// @param numberOfSamples samples of a ring, 1 to 65536
/// @throws InvalidInput when a vertex is out of range, or the number of samples.
RingSamples SampleRingsUniformly(const OneRings& rings, const std::vector<Index>& vertices, int numberOfSamples = 64);
/// Distributes samples evenly over the one-rings of all vertices.
RingSamples SampleRingsUniformly(const OneRings& rings, int numberOfSamples = 64);

/// Draws random samples of one-rings, exactly @p numberOfSamples for each vertex with triangles, for training.
///
/// Sample i lies in the triangle that holds the fraction (i + u) / numberOfSamples of the ring's area, with u uniform, at a
/// uniformly distributed point: the expected number of samples in every part of the ring is proportional to its area. A
/// pure function of the ring, the seed, @p sample, the vertex id and i.
/// @param vertices vertex ids
/// @param sample number of the drawing, such as the iteration of a training
/// @throws InvalidInput when a vertex is out of range, or the number of samples.
RingSamples SampleRingsAtRandom(const OneRings& rings, const std::vector<Index>& vertices, int numberOfSamples,
  std::uint64_t seed, std::uint32_t sample = 0);

} // namespace surfsynth
