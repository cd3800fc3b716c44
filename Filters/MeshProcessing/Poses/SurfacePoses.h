// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random poses of a shape by as-rigid-as-possible deformation [Levi2015]. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Poses/PoseHandles.h"

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <functional>
#include <memory>

namespace surfsynth
{

/// Options of the poses.
struct PoseOptions
{
  double MaximumAngle = 60.0;  ///< largest rotation of each handle about its joint, degrees, from 0 to 180
  double MaximumTwist = 20.0;  ///< largest rotation of each handle about its own centre, degrees, from 0 to 180
  int NumberOfIterations = 40; ///< number of iterations of the deformation, at least 1
  double Stiffness = 2e-4;     ///< stiffness against bending, at least 0: alpha of SRE-ARAP [Levi2015]
};

/// Numbers of the poses to sample.
struct PoseRequest
{
  std::uint64_t Seed = 0;            ///< see NormalKey::Seed
  std::uint32_t FirstSample = 0;     ///< number of the first sample
  std::uint32_t NumberOfSamples = 1; ///< number of samples
  std::uint32_t Stream = 0;          ///< see NormalKey::Stream
};

/// Poses of one triangulation: the handles of a shape turn at random, and the rest follows as rigidly as possible
/// [Sorkine2007] with rotations that vary smoothly [Levi2015], by CGAL's Surface_mesh_deformation. The equations are
/// factored once for each thread.
///
/// A handle's rotation about its joint is MaximumAngle times a uniform random vector in the unit ball, as axis times
/// angle: any axis is as likely as any other, and the angle is 3/4 of the largest one on average. Another rotation of
/// this kind, up to MaximumTwist, turns it about its centre. Both depend on (seed, sample, stream, handle) only.
class SurfacePoses
{
public:
  /// Prepares the deformation.
  /// @param mesh connected, manifold edges and vertices, consistent winding; points that no triangle uses stay
  /// @throws InvalidInput, SolverFailure when the system cannot be factored
  SurfacePoses(const TriangleMesh& mesh, const PoseHandles& handles, const PoseOptions& options);
  ~SurfacePoses();
  SurfacePoses(SurfacePoses&&) noexcept;

  /// Receives the pose of a sample, [V, 3]; called by several threads at a time, once for each sample, in any order.
  using Consumer = std::function<void(std::uint32_t sample, PointMatrix points)>;

  /// Region of each point, see PoseHandles::Regions().
  const std::vector<int>& Regions() const;

  /// Samples the poses, in parallel.
  /// @throws SolverFailure, naming the sample, when a pose is not finite or has destroyed the shape; Cancelled
  void Sample(const PoseRequest& request, const Consumer& consume, const Progress& progress = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
