// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random rings of planar meshes laid over images. Private to the training; no torch.
#pragma once

#include "Core/Random/CounterNormals.h"
#include "IO/Datasets/TextureDataset.h"

#include <array>
#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Sizes of a batch of rings.
struct TextureRingSizes
{
  std::int64_t Rings = 16;      ///< rings, R; with triangles a multiple of 3
  std::int64_t Samples = 64;    ///< points of a ring, N
  double MinimumTexels = 10.0;  ///< least number of pixels for a vertex
  double MaximumTexels = 150.0; ///< largest number of pixels for a vertex; drawn log-uniformly
  /// Power k >= 0: points of the loss have a density proportional to b^k in the ring, where b is the barycentric
  /// coordinate of the ring's vertex; 0: uniform. Those of triangles are uniform.
  double TargetPower = 0.0;
  /// Part of the rings, or of the triangles, from 0 to 1, whose colors are changed: the channels are permuted, and the
  /// range of each becomes a random one, which may be reversed.
  double ColorAugmentation = 0.0;
  bool InTriangles = false; ///< rings of the corners of triangles, with targets in these
};

/// Points and colors of the rings of one iteration. Logarithms are divided by r_p, colors from -1 to 1.
struct TextureRingBatch
{
  std::vector<float> Logarithms;       ///< [R, N, 2], of the encoder
  std::vector<float> Colors;           ///< [R, N, 3], of the encoder
  std::vector<float> TargetLogarithms; ///< [R, N, 2], of the loss; empty with triangles
  std::vector<float> TargetColors;     ///< [R, N, 3], of the loss; [R / 3, 3 N, 3] with triangles
  std::vector<float> Barycentric;      ///< [R / 3, 3 N, 3], of the targets; empty without triangles
};

/// Rings of the interior vertices of planar meshes, each laid over a random image at a random place, angle and scale.
/// All is a pure function of seed, iteration and number of the ring.
class TextureRings
{
public:
  /// Finds the rings. @param inTriangles true when batches will be TextureRingSizes::InTriangles
  /// @throws InvalidInput as CheckDataset(), and, for batches in triangles, when no triangle of a mesh has three interior
  /// corners.
  explicit TextureRings(TextureDataset dataset, bool inTriangles = false);

  /// Draws the rings of an iteration.
  TextureRingBatch Draw(const TextureRingSizes& sizes, std::uint64_t seed, std::int64_t iteration) const;

  /// Hash of the dataset.
  std::uint64_t Hash() const { return this->DatasetHash; }

private:
  struct Mesh
  {
    PlanarMesh Planar;
    std::vector<std::vector<Index>> Incident; ///< triangles of each vertex
    std::vector<Index> Interior;              ///< interior vertices
    std::vector<Index> Triangles;             ///< triangles whose corners are interior
    double AreaOfVertex = 0.0;                ///< mean over the vertices of triangles
  };
  /// Similarity from a mesh to an image: pixel = Offset + Linear (point - Center); colors are
  /// Shift + Scale image(pixel, Channel).
  struct Placement
  {
    const TextureImage* Image;
    Eigen::RowVector2d Center;
    Eigen::Matrix2d Linear;
    Eigen::RowVector2d Offset;
    std::array<std::size_t, 3> Channel = { 0, 1, 2 };
    Eigen::RowVector3d Scale = Eigen::RowVector3d::Ones();
    Eigen::RowVector3d Shift = Eigen::RowVector3d::Zero();

    void AugmentColors(const NormalKey& key);
    void ReadColor(const Eigen::RowVector2d& point, float* color) const;
  };

  static Mesh Prepare(PlanarMesh planar);
  const Mesh& ChooseMesh(const NormalKey& key) const;
  void DrawRings(
    const TextureRingSizes& sizes, const NormalKey& key, std::int64_t first, TextureRingBatch& batch) const;
  Placement Place(
    const Mesh& mesh, const std::vector<Index>& vertices, const TextureRingSizes& sizes, NormalKey key) const;
  static void SampleRing(const Mesh& mesh, Index vertex, const Placement& placement, const NormalKey& key, double power,
    std::int64_t count, float* logarithms, float* colors);
  static void SampleTriangle(const Mesh& mesh, Index triangle, const Placement& placement, const NormalKey& key,
    std::int64_t count, float* barycentric, float* colors);

  TextureDataset Dataset; ///< its meshes are in Meshes
  std::uint64_t DatasetHash;
  std::vector<Mesh> Meshes;
};

} // namespace surfsynth
