// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Synthesis of a geometric texture on one mesh, level by level, with given noise. Private to the sampler.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Operators/EdgeFeatures.h"
#include "Inference/GeometricTexture/FaceNetwork.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Core>

namespace surfsynth
{

/// Map from the caller's coordinates to the network's: (point - Center) / Unit.
struct GeometricTextureFrame
{
  Eigen::RowVector3d Center = Eigen::RowVector3d::Zero(); ///< mean of the vertices that triangles use
  double Unit = 1.0;                                      ///< mean length of the edges
};

/// Computes the frame of a mesh.
/// @throws InvalidInput when the mean length of the edges is 0 or not finite.
GeometricTextureFrame FrameOf(const TriangleMesh& mesh, const MeshTopology& topology);

/// Noise of a level, [V, 3] each in its units: one, of a flow also one for each restart; none for a level without noise.
using LevelNoise = std::vector<SinglePoints>;

/// Mesh that the levels of a generator displace and refine in turn.
class GeometricTextureSynthesis
{
public:
  /// Begins with @p mesh.
  /// @param mask [V], or empty for 1
  /// @param statistics see GeometricTextureRequest
  GeometricTextureSynthesis(const GeometricTextureModel& model, const TriangleMesh& mesh, const MeshTopology& topology,
    const GeometricTextureFrame& frame, Eigen::VectorXf mask = {}, NormStatistics statistics = NormStatistics::Target);

  /// Mixes the displacements of each level with those of another model.
  /// @param blend [V], share of @p second, 0 to 1; at 0 and 1 the displacement is that of one model to the last bit
  void SetBlend(const GeometricTextureModel& second, Eigen::VectorXf blend);

  /// Lets the networks see each place in a unit of its own, in place of the mean edge length.
  /// @param sizes [V], in proportion to the edges around each vertex, above 0
  void SetSizes(const TriangleMesh& mesh, const MeshTopology& topology, const Eigen::VectorXf& sizes);

  /// Number of vertices, V, of the present level.
  Index NumberOfPoints() const { return this->Base.NumberOfPoints(); }
  /// Displaces the mesh by generator level @p level.
  /// @throws InvalidInput when a displacement is not finite.
  /// @param found see FaceNetwork::Run(); of the first model
  /// @param secondNoise that of the second model of SetBlend()
  void Displace(int level, const LevelNoise& noise, const Progress& progress = {}, NetworkStatistics* found = nullptr,
    const LevelNoise& secondNoise = {});
  /// Cuts triangles into four and doubles all coordinates.
  void Refine();

  /// Vertices in units of the level, [V, 3]: the input of the network.
  SinglePoints LevelPoints() const;
  /// Displacements of the triangles in the frames of their edges, [F, 3], by the last Displace(), without mask; with
  /// SetBlend() those of the second model alone.
  const SinglePoints& LocalDisplacement() const { return this->Local; }
  /// Mesh after generator level @p level, in the caller's units.
  GeometricTextureLevel Result(int level) const;

private:
  /// The mask fades the result alone, so that no network sees it.
  bool FadesResult() const { return this->Mask.size() > 0 && this->Statistics == NormStatistics::Reference; }
  PointMatrix OffsetBy(const GeometricTextureModel& model, int level, const LevelNoise& noise, const Progress& progress,
    NetworkStatistics* found);
  PointMatrix FlowOffset(const GeometricTextureModel& model, int level, const LevelNoise& noise,
    const Progress& progress, NetworkStatistics* found);
  FaceNetwork NetworkOf(const GeometricTextureModel& model, int level, std::int64_t step) const;
  PointMatrix LocalOffset(const FaceNetwork& network, const SinglePoints& points, const SinglePoints& noise,
    const Progress& progress, NetworkStatistics* found);

  const GeometricTextureModel& Model;
  const GeometricTextureModel* SecondModel = nullptr;
  Eigen::VectorXf Blend; ///< [V], share of the second model
  Eigen::VectorXf Sizes; ///< [V], local unit over the unit of the level; empty for 1
  GeometricTextureFrame Frame;
  double Doubling = 1.0; ///< 2 to the number of refinements
  TriangleMesh Base;     ///< without any displacement, in the caller's units: exact where nothing moves
  PointMatrix Offset;    ///< [V, 3], all displacements so far, in units of the level; without the mask if FadesResult()
  PointMatrix LastOffset; ///< [V, 3], displacement of the last Displace(), as Offset
  SinglePoints Local;
  Eigen::VectorXf Mask;
  NormStatistics Statistics;
  FaceNeighbors Neighbors;
};

} // namespace surfsynth
