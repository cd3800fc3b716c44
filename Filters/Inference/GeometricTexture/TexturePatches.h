// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Patches of a surface: square grids of places along geodesics, with tangent frames. Private to the inference.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/GeodesicTracing.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Operators/EdgeFeatures.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// Row-major float32 matrix: one patch in a row.
using PatchRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Center of a patch.
struct PatchCenter
{
  SurfacePlace Place;    ///< where it lies
  Eigen::Vector3d XAxis; ///< unit vector in the plane of the triangle: the first axis of the grid
  double Spacing = 1.0;  ///< of the grid, world units
};

/// Surface that patches lie on; the parts refer to each other, so that it is neither copied nor moved.
class PatchSurface
{
public:
  /// Builds the tables of a valid mesh, and keeps a reference to it.
  explicit PatchSurface(const TriangleMesh& mesh);
  PatchSurface(const PatchSurface&) = delete;
  PatchSurface& operator=(const PatchSurface&) = delete;

  const TriangleMesh& Mesh;
  MeshTopology Topology;
  TriangleAdjacency Adjacency;
  GeodesicTracer Tracer;
  PointMatrix VertexNormals; ///< [V, 3], area-weighted means
  double MeanEdgeLength;     ///< world units
};

/// Places of the grids of patches of one size. Sample k = Side j + i of a patch lies at the end of the geodesic from its
/// center in direction (i - Radius, j - Radius) of its axes, as long as that vector times the spacing. Values there have
/// components along the axes, transported along the geodesic, and along the normal, in units of the spacing.
class TexturePatches
{
public:
  static constexpr int Radius = 4;                        ///< samples on each side of the center
  static constexpr int Side = 2 * Radius + 1;             ///< samples in a row
  static constexpr int Samples = Side * Side;             ///< of a patch
  static constexpr std::int64_t Components = 3 * Samples; ///< numbers of a patch

  /// Traces the geodesics of all patches, in parallel. Keeps a reference to @p surface.
  /// @throws Cancelled
  TexturePatches(const PatchSurface& surface, const std::vector<PatchCenter>& centers, const Progress& progress = {});

  /// Number of patches.
  std::int64_t Count() const { return static_cast<std::int64_t>(this->Spacings.size()); }
  /// Returns true when no geodesic of a patch ends at a boundary.
  bool IsComplete(std::int64_t patch) const { return this->Complete[static_cast<std::size_t>(patch)] != 0; }
  /// Returns true when the geodesic of a sample has not ended at a boundary.
  bool IsInside(std::int64_t patch, int sample) const { return this->At(patch, sample).IsInside; }

  /// Reads the values of one patch.
  /// @param displacement [V, 3], world units @param values [Components]
  void Read(std::int64_t patch, const SinglePoints& displacement, float* values) const;
  /// Adds the transpose of Read() at one patch: the gradient at the vertices of a function of the values.
  void AddTransposed(std::int64_t patch, const float* values, SinglePoints& gradient) const;

  /// Sums over samples for the fit of displacements to values: for each triangle the weighted products of the barycentric
  /// coordinates (00, 11, 22, 01, 12, 20).
  using TriangleProducts = Eigen::Matrix<float, Eigen::Dynamic, 6, Eigen::RowMajor>;
  /// Returns these sums over all samples inside. @param weights [Samples] @param factors [Count()], of the weights
  TriangleProducts Products(const Eigen::VectorXf& weights, const Eigen::VectorXf& factors) const;
  /// Adds the right-hand side of the fit: weight times barycentric coordinate times the values as vectors in space, world
  /// units, of all samples of a patch inside. @param factor of the weights
  void AddWeighted(std::int64_t patch, const float* values, const Eigen::VectorXf& weights, float factor,
    SinglePoints& rightHandSide) const;

private:
  struct Sample
  {
    Index Triangle;
    float Weights[2]; ///< of the first two corners
    float X[3];       ///< first axis, unit
    float Normal[3];  ///< unit
    bool IsInside;
  };
  const Sample& At(std::int64_t patch, int sample) const
  {
    return this->Places[static_cast<std::size_t>(patch) * Samples + static_cast<std::size_t>(sample)];
  }
  void Trace(const PatchCenter& center, Sample* samples) const;
  Sample SampleAt(const GeodesicEnd& end, const Eigen::Vector2d& turn) const;
  static Eigen::Matrix3f FrameOf(const Sample& sample);
  void AddAtCorners(const Sample& sample, float factor, const float* value, SinglePoints& rows) const;

  const PatchSurface& Surface;
  std::vector<Sample> Places; ///< [count, Samples]
  std::vector<float> Spacings;
  std::vector<std::uint8_t> Complete;
};

/// Returns the weights of the samples of a patch, [Samples]: a Gaussian of standard deviation Radius / sqrt(2) around the center.
Eigen::VectorXf PatchWeights();

} // namespace surfsynth
