// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Smooth normals of a surface, and the tangent frames of its texture coordinates.
#pragma once

#include "Core/Atlas/TextureCoordinates.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace surfsynth
{

/// Orthonormal frame at a place of a surface.
struct SurfaceFrame
{
  Eigen::Vector3d Tangent;   ///< along u
  Eigen::Vector3d Normal;    ///< interpolated, unit length
  Eigen::Vector3d Bitangent; ///< cross product of normal and tangent, turned to the side to which v grows
};

/// Normals of vertices, interpolated in triangles, and tangents as renderers make them of texture coordinates.
///
/// The normal of a vertex is the area-weighted mean of the normals of triangles, over all points at the same place: seams of
/// texture coordinates do not show. The tangent of a point is the mean of the directions of u in the triangles around,
/// projected to the plane of the normal and weighted by their angles, without triangles whose texture is mirrored the other
/// way [Mikkelsen2008]; interpolated, and orthogonalized at each place.
class SurfaceFrames
{
public:
  /// @param mesh finite, of about unit size; must outlive the object
  /// @param classes of its points that lie at one place: see WeldPoints()
  /// @param coordinates [3 F, 2], finite
  SurfaceFrames(const TriangleMesh& mesh, const std::vector<Index>& classes, const TextureCoordinates& coordinates);

  /// Returns the unit normal at a place. Where normals of vertices cancel, it is that of the triangle.
  Eigen::Vector3d NormalAt(const SurfacePlace& place) const;
  /// Returns the frame at a place. A triangle without area in the texture has any tangent.
  SurfaceFrame FrameAt(const SurfacePlace& place) const;

private:
  void ComputeNormals(const std::vector<Index>& classes);
  void ComputeTangents(const TextureCoordinates& coordinates);

  const TriangleMesh& Mesh;
  PointMatrix Normals;                ///< [V], unit length or zero
  PointMatrix Tangents[2];            ///< [V], of triangles as they are and mirrored
  std::vector<unsigned char> Flipped; ///< [F], 1 for triangles whose texture is mirrored
};

} // namespace surfsynth
