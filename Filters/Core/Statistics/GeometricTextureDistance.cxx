// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/GeometricTextureDistance.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/CounterNormals.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr int Features = 12;
constexpr float LargestFeature = 1e30F; ///< so that sums of twelve stay finite in single precision
using Direction = Eigen::Matrix<float, Features, 1>;

/// Uniform on the unit sphere of R^12.
Direction RandomDirection(std::uint64_t seed, int projection)
{
  NormalKey key;
  key.Seed = seed;
  key.Sample = static_cast<std::uint32_t>(projection);
  Eigen::Matrix<double, Features, 1> normals;
  FillNormals(key, 0, Features, normals.data());
  return normals.normalized().cast<float>();
}

/// Shifts the components of @p direction cyclically, for triangles whose edges are counted from edge @p first on.
Direction Turned(const Direction& direction, int first)
{
  Direction turned;
  for (int k = 0; k < Features; ++k)
  {
    turned((k + 4 * first) % Features) = direction(k);
  }
  return turned;
}

/// The coordinates of all points along a direction, in ascending order: three for each triangle.
void Project(const EdgeFeatureMatrix& features, const Direction& direction, Eigen::VectorXf& sorted)
{
  const Eigen::Index triangles = features.rows();
  sorted.resize(3 * triangles);
  for (int first = 0; first < 3; ++first)
  {
    sorted.segment(first * triangles, triangles).noalias() = features.lazyProduct(Turned(direction, first));
  }
  std::sort(sorted.data(), sorted.data() + sorted.size());
}

/// The integral of |A(t) - B(t)| over t from 0 to 1, where A and B are the quantiles of @p a and @p b, which are steps
/// of width 1 / n and 1 / m: ascending numbers of any count.
double Wasserstein(const Eigen::VectorXf& a, const Eigen::VectorXf& b)
{
  const std::int64_t n = a.size();
  const std::int64_t m = b.size();
  double sum = 0.0;
  std::int64_t at = 0; // t in steps of 1 / (n m)
  for (std::int64_t i = 0, j = 0; i < n && j < m;)
  {
    const std::int64_t endOfA = (i + 1) * m;
    const std::int64_t endOfB = (j + 1) * n;
    const std::int64_t next = std::min(endOfA, endOfB);
    sum += static_cast<double>(next - at) * std::abs(static_cast<double>(a[i]) - static_cast<double>(b[j]));
    at = next;
    i += next == endOfA ? 1 : 0;
    j += next == endOfB ? 1 : 0;
  }
  return sum / static_cast<double>(n) / static_cast<double>(m);
}

/// Edge features of a mesh, as the network gets them.
struct SeenMesh
{
  /// @param name "surface" or "reference": begins messages
  SeenMesh(const TriangleMesh& mesh, double unitLength, const std::string& name)
  {
    if (!(unitLength >= 0.0) || !std::isfinite(unitLength))
    {
      throw InvalidInput("CompareGeometricTextures: the unit length of the " + name + " is " +
        FormatNumber(unitLength) + "; expected 0 or more.");
    }
    if (mesh.NumberOfTriangles() == 0)
    {
      throw InvalidInput("CompareGeometricTextures: the " + name + " has no triangle; expected at least one.");
    }
    const FaceNeighbors neighbors = ComputeFaceNeighbors(mesh);
    this->MeanEdgeLength = MeanLength(mesh, neighbors);
    const double unit = unitLength > 0.0 ? unitLength : this->MeanEdgeLength;
    // Around the origin first: single precision far from it would see steps instead of a surface.
    const BoundingBox box = ComputeBoundingBox(mesh);
    const PointMatrix points = (mesh.Points.rowwise() - 0.5 * (box.Lower + box.Upper).transpose()) / unit;
    this->Features = ComputeEdgeFeatures(points.cast<float>(), mesh.Triangles, neighbors);
    if (!(this->Features.array().abs() < LargestFeature).all())
    {
      throw InvalidInput("CompareGeometricTextures: in a unit length of " + FormatNumber(unit) + " the " + name +
        " has features that are not finite or above " + FormatNumber(LargestFeature) +
        "; expected finite points and edges.");
    }
  }

  EdgeFeatureMatrix Features;
  double MeanEdgeLength = 0.0;

private:
  /// An edge of two triangles counts with the one of the lower number.
  static double MeanLength(const TriangleMesh& mesh, const FaceNeighbors& neighbors)
  {
    double sum = 0.0;
    std::int64_t edges = 0;
    for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        if (neighbors.Faces(f, k) >= f)
        {
          sum += (mesh.Points.row(mesh.Triangles(f, (k + 1) % 3)) - mesh.Points.row(mesh.Triangles(f, k))).stableNorm();
          ++edges;
        }
      }
    }
    return sum / static_cast<double>(std::max<std::int64_t>(edges, 1));
  }
};
} // namespace

Eigen::VectorXd SlicedDistances(const EdgeFeatureMatrix& features, const EdgeFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress)
{
  Eigen::VectorXd distances(projections);
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    projections,
    [&](std::int64_t k) {
      const Direction direction = RandomDirection(seed, static_cast<int>(k));
      Eigen::VectorXf along, alongReference;
      Project(features, direction, along);
      Project(reference, direction, alongReference);
      distances[k] = Wasserstein(along, alongReference);
      ++done;
    },
    [&] { Report(progress, static_cast<double>(done) / projections); });
  return distances;
}

TextureDistance CompareGeometricTextures(const TriangleMesh& surface, const TriangleMesh& reference,
  const GeometricTextureDistanceOptions& options, const Progress& progress)
{
  if (options.Projections < 1)
  {
    throw InvalidInput("CompareGeometricTextures: there are " + std::to_string(options.Projections) +
      " projections; expected at least one.");
  }
  const SeenMesh seen(surface, options.UnitLength, "surface");
  const SeenMesh seenReference(reference, options.ReferenceUnitLength, "reference");
  Report(progress, 0.1);
  const Eigen::VectorXd distances = SlicedDistances(
    seen.Features, seenReference.Features, options.Projections, options.Seed, SubProgress(progress, 0.1, 1.0));
  TextureDistance result;
  result.Distance = distances.mean();
  if (options.Projections > 1)
  {
    const auto count = static_cast<double>(options.Projections);
    result.StandardError = std::sqrt((distances.array() - result.Distance).square().sum() / (count * (count - 1.0)));
  }
  result.MeanEdgeLength = seen.MeanEdgeLength;
  result.ReferenceMeanEdgeLength = seenReference.MeanEdgeLength;
  return result;
}

} // namespace surfsynth
