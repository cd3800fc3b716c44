// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Handles of a shape for posing: its extremities, their joints, and the fixed part. Private to the mesh processing.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Solvers/CholeskySolver.h"

#include <vector>

namespace surfsynth
{

/// Options of the handles. Radii are fractions of the shape's size, the square root of its area.
struct PoseHandleOptions
{
  int NumberOfHandles = 6;    ///< number of extremities, at least 1
  double HandleRadius = 0.08; ///< radius of the rigid region around each extremity, larger than 0
  double AnchorRadius = 0.12; ///< depth of the fixed region, larger than 0
  double PivotPosition = 0.8; ///< place of the joint on the way from the extremity (0) to the fixed region (1)
};

/// An extremity.
struct PoseHandle
{
  Index Point = 0;                                  ///< vertex of the template
  Eigen::Vector3d Center = Eigen::Vector3d::Zero(); ///< position of the vertex
  Eigen::Vector3d Pivot = Eigen::Vector3d::Zero();  ///< the joint: about the middle of the limb's cross section
};

/// Handles of a template shape, and their regions on other triangulations of the same shape.
///
///  - The extremities are chosen one after the other, each at the largest distance along the surface (HeatGeodesics)
///    from the point nearest to the centroid and from those chosen before. A handle is the region within HandleRadius.
///  - The fixed region has a distance from the centroid at most AnchorRadius larger than the smallest one, and is at
///    least three handle radii away from each extremity.
///  - The joint of a handle is the centroid of the band of the surface around PivotPosition of the way, along the
///    surface, from the extremity to the fixed region.
class PoseHandles
{
public:
  /// Finds the handles.
  /// @param shape connected, passes CheckMesh() with manifold edges
  /// @param topology the tables of @p shape
  /// @param finder finds places on the shape, for Regions()
  /// @throws InvalidInput when the shape is too small for so many handles of this size, or has no fixed region.
  /// @throws Cancelled, SolverFailure
  PoseHandles(TriangleMesh shape, const MeshTopology& topology, const PoseHandleOptions& options, PlaceFinder finder,
    const Progress& progress = {});

  /// Extremities, in the order of their choice.
  const std::vector<PoseHandle>& Handles() const { return this->Found; }
  /// Size of the template: the square root of its area, world units.
  double Size() const { return this->ShapeSize; }

  static constexpr int Free = -1; ///< region of a point without a prescribed position

  /// Finds the region of each point of another triangulation of the shape: the index of a handle, Handles().size() for
  /// the fixed region, or Free. Points that no triangle uses are Free. Distances are interpolated at the nearest place
  /// of the template.
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
  double SmallestDistance = 0.0; ///< smallest distance of a point from the centroid
  std::vector<PoseHandle> Found;
  RowMatrix Distances; ///< [V, H], along the template, from each extremity
};

} // namespace surfsynth
