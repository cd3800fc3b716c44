// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random mixtures of Gaussians on surfaces: the signals of [Kuai2026], appendix C.3, after [Elhag2024].
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/HeatGeodesics.h"

#include <cstdint>
#include <functional>

namespace surfsynth
{

/// Options of a mixture.
struct GaussianMixtureOptions
{
  int NumberOfCenters = 3; ///< number of Gaussians, at least 1
  double Width = 0.08;     ///< the standard deviation sigma, as a fraction of the square root of the area, > 0
  double Separation = 4.0; ///< minimum distance between two centres, in units of sigma, >= 0
};

/// Numbers of the mixtures to draw.
struct GaussianMixtureRequest
{
  std::uint64_t Seed = 0;            ///< see NormalKey::Seed
  std::uint32_t FirstSample = 0;     ///< number of the first sample
  std::uint32_t NumberOfSamples = 1; ///< may be 0
  std::uint32_t SampleStep = 1;      ///< the samples are FirstSample + k SampleStep
  std::uint32_t Stream = 0;          ///< see NormalKey::Stream
};

/// Mixtures g(x) = sum_c exp(-d(x, c)^2 / (2 sigma^2)) on one mesh, with d the distance along the surface
/// (HeatGeodesics, factored once).
///
/// Centres are vertices, chosen one after the other, each with a probability proportional to its lumped mass among the
/// vertices that are not closer than the separation to an earlier one: uniform on the surface whatever the
/// triangulation. A Gaussian is 0 on other components than that of its centre, and at vertices that no triangle uses.
class GaussianMixtures
{
public:
  /// Prepares the distances on @p mesh: two factorisations.
  /// @param mesh passes CheckMesh() with manifold edges; at least one triangle
  /// @param topology the tables of @p mesh
  /// @throws InvalidInput when an option is out of range; SolverFailure; Cancelled
  GaussianMixtures(const TriangleMesh& mesh, const MeshTopology& topology, const GaussianMixtureOptions& options,
    const Progress& progress = {});

  /// Returns the memory for sample number @p sample: V doubles. Called on the calling thread, in order.
  using Destination = std::function<double*(std::uint32_t sample)>;

  /// Draws the samples. The bits of a sample depend on (seed, sample, stream) and the mesh alone.
  /// @throws InvalidInput when a sample beyond number 2^32 - 1 is asked for, or when no vertex is left for a centre.
  /// @throws SolverFailure, Cancelled
  void SampleInto(
    const GaussianMixtureRequest& request, const Destination& destination, const Progress& progress = {}) const;

  /// Standard deviation sigma of each Gaussian, world units.
  double StandardDeviation() const { return this->Sigma; }

private:
  struct Group;
  Index ChooseCenter(const Group& group, std::size_t member, double uniform) const;
  void AddGaussians(Group& group) const;
  void SampleGroup(const GaussianMixtureRequest& request, Group& group) const;

  GaussianMixtureOptions Options;
  HeatGeodesics Geodesics;
  double Sigma = 0.0;
};

} // namespace surfsynth
