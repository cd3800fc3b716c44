// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Curves of a surface that remeshing keeps: boundaries, creases and attribute seams. Private to the mesh processing.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"
#include "MeshProcessing/Remeshing/AdaptiveRemeshing.h"

#include <memory>
#include <vector>

namespace surfsynth
{

struct RemeshingOptions;

/// A triangle mesh for CGAL's remeshing: points of the same coordinates sewn together, its curves marked.
class CurvedMesh
{
public:
  /// Converts @p mesh and marks its curves.
  /// @throws InvalidInput when the mesh is not manifold or not consistently wound.
  CurvedMesh(const TriangleMesh& mesh, const RemeshingOptions& options);

  CgalMesh Mesh;                    ///< the sewn mesh
  RemeshingConstraints Constraints; ///< curves and fixed vertices; refers to Mesh

private:
  void MarkSeams(const TriangleMesh& mesh, const std::vector<Index>& classes);
  void MarkCreases(const RemeshingOptions& options);
  void FixCorners(bool fixBoundary);
  void RequireThickness() const;
  bool TurnsSharply(CgalVertex v, const std::vector<CgalHalfedge>& curve) const;
};

/// Curves of a mesh before remeshing, for putting points back onto them afterwards.
class OriginalCurves
{
public:
  /// Copies the curves.
  /// @param sewn the mesh before remeshing; triangle f of @p sewn is triangle f of the input.
  explicit OriginalCurves(const CurvedMesh& sewn);
  ~OriginalCurves();
  OriginalCurves(const OriginalCurves&) = delete;
  OriginalCurves& operator=(const OriginalCurves&) = delete;

  /// A place on a curve.
  struct Foot
  {
    Eigen::Vector3d Point;        ///< its position
    std::vector<Index> Triangles; ///< triangles around it: one or two inside a segment, any number at its end
  };
  /// Finds the nearest place on a curve.
  Foot Nearest(const Eigen::Vector3d& point) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
