// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A mesh on which a geometric texture grows, level by level, with noise that is given. Private to the sampler.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Where the network's coordinates lie in the caller's: (point - Centre) / Unit.
struct GeometricTextureFrame
{
  Eigen::RowVector3d Centre = Eigen::RowVector3d::Zero();
  double Unit = 1.0;
};

/// The mean of the vertices that triangles use, and the mean length of the edges.
/// @throws InvalidInput when that is 0 or not finite.
GeometricTextureFrame FrameOf(const TriangleMesh& mesh, const MeshTopology& topology);

class GeometricTextureSynthesis
{
public:
  /// @param mask [V], or empty for 1
  GeometricTextureSynthesis(const GeometricTextureModel& model, const TriangleMesh& mesh, const MeshTopology& topology,
    const GeometricTextureFrame& frame, Eigen::VectorXf mask = {});

  Index NumberOfPoints() const { return this->Base.NumberOfPoints(); }
  /// Displaces the mesh by generator level @p level. @param noise [V, 3] in the level's units, or empty for none
  /// @throws InvalidInput when a displacement is not finite.
  void Displace(int level, const SinglePoints& noise, const Progress& progress = {});
  /// Cuts triangles into four and doubles all.
  void Refine();

  /// The vertices as the network sees them: in units of the level, [V, 3].
  SinglePoints LevelPoints() const;
  /// [F, 3], in the frames of edges, of the last Displace().
  const SinglePoints& LocalDisplacement() const { return this->Local; }
  GeometricTextureLevel Result(int level) const;

private:
  const GeometricTextureModel& Model;
  GeometricTextureFrame Frame;
  double Doubling = 1.0;  ///< 2 to the number of refinements
  TriangleMesh Base;      ///< without any displacement, in the caller's units: exact where nothing moves
  PointMatrix Offset;     ///< [V, 3], all displacements so far, in units of the level
  PointMatrix LastOffset; ///< that of the last Displace()
  SinglePoints Local;
  Eigen::VectorXf Mask;
  FaceNeighbours Neighbours;
};

} // namespace surfsynth
