// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The curves of a surface that remeshing keeps: boundaries, creases and attribute seams. Private to the meshing module.
#pragma once

#include "MeshProcessing/Cgal/CgalMesh.h"
#include "MeshProcessing/Remeshing/AdaptiveRemeshing.h"

#include <memory>
#include <vector>

namespace surfsynth
{

struct RemeshingOptions;

/// A triangle mesh as CGAL remeshes it: points of the same coordinates sewn together, its curves marked.
class CurvedMesh
{
public:
  /// @throws InvalidInput when the mesh is not manifold or not consistently wound.
  CurvedMesh(const TriangleMesh& mesh, const RemeshingOptions& options);

  CgalMesh Mesh;
  RemeshingConstraints Constraints; ///< refers to Mesh

private:
  void MarkSeams(const TriangleMesh& mesh, const std::vector<Index>& classes);
  void MarkCreases(const RemeshingOptions& options);
  void FixCorners(bool fixBoundary);
  void RequireThickness() const;
  bool TurnsSharply(CgalVertex v, const std::vector<CgalHalfedge>& curve) const;
};

/// The curves as they are before remeshing, to which points are put back afterwards.
class OriginalCurves
{
public:
  /// @param sewn the mesh before remeshing; triangle f of @p sewn is triangle f of the input.
  explicit OriginalCurves(const CurvedMesh& sewn);
  ~OriginalCurves();
  OriginalCurves(const OriginalCurves&) = delete;
  OriginalCurves& operator=(const OriginalCurves&) = delete;

  /// A place on a curve.
  struct Foot
  {
    Eigen::Vector3d Point;
    std::vector<Index> Triangles; ///< those around it: one or two inside a segment, any number at its end
  };
  /// The nearest place on a curve.
  Foot Nearest(const Eigen::Vector3d& point) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
