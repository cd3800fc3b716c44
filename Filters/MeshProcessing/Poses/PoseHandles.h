// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Where a shape is taken hold of to be posed: its extremities, the joints they turn about, and the part that stays.
/// Private to the meshing module.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/CholeskySolver.h"

#include <vector>

namespace surfsynth
{

/// Fractions are of the shape's size, the square root of its area.
struct PoseHandleOptions
{
  int NumberOfHandles = 6;    ///< at least 1
  double HandleRadius = 0.08; ///< of the region around each extremity that moves rigidly, larger than 0
  double AnchorRadius = 0.12; ///< depth of the region that stays where it is, larger than 0
  double PivotPosition = 0.8; ///< of the joint, on the way from the extremity (0) to the region that stays (1)
};

/// An extremity.
struct PoseHandle
{
  Index Point = 0;                                  ///< of the template
  Eigen::Vector3d Centre = Eigen::Vector3d::Zero(); ///< its position
  Eigen::Vector3d Pivot = Eigen::Vector3d::Zero();  ///< the joint: about the middle of the limb's cross section
};

/// Finds the handles of a template shape, and their places on other triangulations of the same shape.
///
///  - The extremities are chosen one after the other, each at the largest distance along the surface (HeatGeodesics)
///    from the point nearest to the centroid and from those chosen before. A handle is the region within HandleRadius.
///  - What stays is the region whose distance from the centroid is at most AnchorRadius larger than the smallest one,
///    less what is closer than three handle radii to an extremity.
///  - The joint of a handle is the centroid of the band of the surface around PivotPosition of the way, along the surface,
///    from the extremity to what stays.
class PoseHandles
{
public:
  /// @param shape connected, passes CheckMesh() with manifold edges
  /// @param finder finds places on the shape, for Regions()
  /// @throws InvalidInput when the shape is too small for so many handles of this size, or nothing would stay.
  /// @throws Cancelled, SolverFailure
  PoseHandles(TriangleMesh shape, const MeshTopology& topology, const PoseHandleOptions& options, PlaceFinder finder,
    const Progress& progress = {});

  const std::vector<PoseHandle>& Handles() const { return this->Found; }
  /// The square root of the area of the template, world units.
  double Size() const { return this->ShapeSize; }

  static constexpr int Free = -1; ///< region of a point that may go where it wants

  /// The region of each point of another triangulation of the shape: the index of a handle, Handles().size() for what
  /// stays, or Free, which points that no triangle uses always are. Distances are interpolated at the nearest place of the
  /// template.
  /// @throws InvalidInput when a region has no point, because the triangulation is too coarse or another shape.
  std::vector<int> Regions(const TriangleMesh& mesh) const;

private:
  void FindExtremities(const class HeatGeodesics& geodesics);
  void FindPivots(const Eigen::VectorXd& mass);
  int RegionOf(const Eigen::Vector3d& point, const Eigen::VectorXd& distances) const;

  TriangleMesh Shape;
  PoseHandleOptions Options;
  PlaceFinder Finder;
  double ShapeSize = 0.0;
  Eigen::Vector3d Centroid = Eigen::Vector3d::Zero();
  double SmallestDistance = 0.0; ///< of a point from the centroid
  std::vector<PoseHandle> Found;
  RowMatrix Distances; ///< [V, H], along the template, from each extremity
};

} // namespace surfsynth
