// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random mixtures of Gaussians on surfaces: the signals of appendix C.3 of "Matérn Noise for Triangulation-Agnostic Flow
/// Matching on Meshes", after Elhag et al., "Manifold Diffusion Fields" (2024).
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/HeatGeodesics.h"

#include <cstdint>
#include <functional>

namespace surfsynth
{

/// What a mixture is made of.
struct GaussianMixtureOptions
{
  int NumberOfCentres = 3; ///< at least 1
  double Width = 0.08;     ///< the standard deviation sigma, as a fraction of the square root of the area, > 0
  double Separation = 4.0; ///< least distance between two centres, in units of sigma, >= 0
};

/// Which mixtures.
struct GaussianMixtureRequest
{
  std::uint64_t Seed = 0;
  std::uint32_t FirstSample = 0;
  std::uint32_t NumberOfSamples = 1;
  std::uint32_t SampleStep = 1; ///< the samples are FirstSample + k SampleStep
  std::uint32_t Stream = 0;     ///< see NormalKey::Stream
};

/// Mixtures g(x) = sum_c exp(-d(x, c)^2 / (2 sigma^2)) on one mesh, with d the distance along the surface
/// (HeatGeodesics, factored once).
///
/// Centres are vertices, chosen one after the other, each with a probability proportional to its lumped mass among the
/// vertices that are not closer than the separation to an earlier one: uniform on the surface whatever the
/// triangulation. On other components than that of the centre a Gaussian is 0, and so it is at vertices that no triangle
/// uses.
class GaussianMixtures
{
public:
  /// @param mesh passes CheckMesh() with manifold edges; at least one triangle
  /// @param topology the tables of @p mesh
  /// @throws InvalidInput when an option is out of range; SolverFailure; Cancelled
  GaussianMixtures(const TriangleMesh& mesh, const MeshTopology& topology, const GaussianMixtureOptions& options,
    const Progress& progress = {});

  /// Says where sample number @p sample is to be written: V doubles. Called on the calling thread, in order.
  using Destination = std::function<double*(std::uint32_t sample)>;

  /// Draws the samples. The bits of a sample depend on (seed, sample, stream) and the mesh alone.
  /// @throws InvalidInput when a sample beyond number 2^32 - 1 is asked for, or when no vertex is left for a centre.
  /// @throws SolverFailure, Cancelled
  void SampleInto(
    const GaussianMixtureRequest& request, const Destination& destination, const Progress& progress = {}) const;

  /// sigma, world units.
  double StandardDeviation() const { return this->Sigma; }

private:
  struct Group;
  Index ChooseCentre(const Group& group, std::size_t member, double uniform) const;
  void AddGaussians(Group& group) const;
  void SampleGroup(const GaussianMixtureRequest& request, Group& group) const;

  GaussianMixtureOptions Options;
  HeatGeodesics Geodesics;
  double Sigma = 0.0;
};

} // namespace surfsynth
