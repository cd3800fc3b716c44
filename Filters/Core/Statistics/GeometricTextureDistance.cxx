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
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr float LargestFeature = 1e30F; ///< so that sums over features stay finite in single precision
/// Direction in the space of the columns of @p Matrix.
template <typename Matrix>
using DirectionOf = Eigen::Matrix<float, Matrix::ColsAtCompileTime, 1>;

/// Uniform on the unit sphere of R^columns.
template <typename Matrix>
DirectionOf<Matrix> RandomDirection(std::uint64_t seed, int projection, Eigen::Index columns)
{
  NormalKey key;
  key.Seed = seed;
  key.Sample = static_cast<std::uint32_t>(projection);
  Eigen::Matrix<double, Matrix::ColsAtCompileTime, 1> normals(columns);
  FillNormals(key, 0, columns, normals.data());
  return normals.normalized().template cast<float>();
}

/// Number of cyclic orders of the groups of columns in which each row counts: those of the edges of a triangle.
constexpr int OrdersOf(const EdgeFeatureMatrix&) { return 3; }
constexpr int OrdersOf(const RingFeatureMatrix&) { return 1; }

/// Shifts the components of @p direction cyclically by @p shift.
template <typename Direction>
Direction Turned(const Direction& direction, Eigen::Index shift)
{
  Direction turned(direction.size());
  for (Eigen::Index k = 0; k < direction.size(); ++k)
  {
    turned((k + shift) % direction.size()) = direction(k);
  }
  return turned;
}

/// The coordinates of all points along a direction, in ascending order: one for each order of each row.
template <typename Matrix>
void Project(const Matrix& features, const DirectionOf<Matrix>& direction, Eigen::VectorXf& sorted)
{
  const Eigen::Index rows = features.rows();
  const int orders = OrdersOf(features);
  sorted.resize(orders * rows);
  for (int first = 0; first < orders; ++first)
  {
    sorted.segment(first * rows, rows).noalias() = features.lazyProduct(
      Turned(direction, first * (direction.size() / orders)));
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

/// A mesh in unit lengths.
struct SeenMesh
{
  /// @param name "surface" or "reference": begins messages
  SeenMesh(const TriangleMesh& mesh, double unitLength, std::string name)
    : Name(std::move(name))
    , Topology(mesh)
  {
    if (!(unitLength >= 0.0) || !std::isfinite(unitLength))
    {
      throw InvalidInput("CompareGeometricTextures: the unit length of the " + this->Name + " is " +
        FormatNumber(unitLength) + "; expected 0 or more.");
    }
    if (mesh.NumberOfTriangles() == 0)
    {
      throw InvalidInput("CompareGeometricTextures: the " + this->Name + " has no triangle; expected at least one.");
    }
    this->Neighbors = ComputeFaceNeighbors(mesh, this->Topology);
    this->MeanEdgeLength = MeanLength(mesh, this->Neighbors);
    this->Unit = unitLength > 0.0 ? unitLength : this->MeanEdgeLength;
    // Around the origin first: single precision far from it would see steps instead of a surface.
    const BoundingBox box = ComputeBoundingBox(mesh);
    this->Mesh.Points = (mesh.Points.rowwise() - 0.5 * (box.Lower + box.Upper).transpose()) / this->Unit;
    this->Mesh.Triangles = mesh.Triangles;
  }

  /// Features of the triangles that have three neighbors, as the network gets them; of all where no triangle has.
  EdgeFeatureMatrix EdgeFeatures() const
  {
    const EdgeFeatureMatrix features = this->Checked(
      ComputeEdgeFeatures(this->Mesh.Points.cast<float>(), this->Mesh.Triangles, this->Neighbors));
    std::vector<Eigen::Index> inside;
    for (Eigen::Index f = 0; f < features.rows(); ++f)
    {
      const auto faces = this->Neighbors.Faces.row(f);
      if (faces(0) != f && faces(1) != f && faces(2) != f)
      {
        inside.push_back(f);
      }
    }
    return inside.empty() ? features : EdgeFeatureMatrix(features(inside, Eigen::all));
  }

  /// Features of the vertices.
  RingFeatureMatrix RingFeatures(int rings, const Progress& progress) const
  {
    return this->Checked(ComputeRingFeatures(this->Mesh, this->Topology, rings, progress));
  }

  std::string Name;
  MeshTopology Topology;
  FaceNeighbors Neighbors;
  TriangleMesh Mesh;
  double MeanEdgeLength = 0.0;
  double Unit = 0.0;

private:
  template <typename Matrix>
  Matrix Checked(Matrix features) const
  {
    if (!(features.array().abs() < LargestFeature).all())
    {
      throw InvalidInput("CompareGeometricTextures: in a unit length of " + FormatNumber(this->Unit) + " the " +
        this->Name + " has features that are not finite or above " + FormatNumber(LargestFeature) +
        "; expected finite points and edges.");
    }
    return features;
  }

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

template <typename Matrix>
Eigen::VectorXd DistancesAlongDirections(
  const Matrix& features, const Matrix& reference, int projections, std::uint64_t seed, const Progress& progress)
{
  Eigen::VectorXd distances(projections);
  std::atomic<std::int64_t> done{ 0 };
  ParallelTasks(
    projections,
    [&](std::int64_t k) {
      const DirectionOf<Matrix> direction = RandomDirection<Matrix>(seed, static_cast<int>(k), features.cols());
      Eigen::VectorXf along, alongReference;
      Project(features, direction, along);
      Project(reference, direction, alongReference);
      distances[k] = Wasserstein(along, alongReference);
      ++done;
    },
    [&] { Report(progress, static_cast<double>(done) / projections); });
  return distances;
}

/// Throws when an option is out of its range.
void CheckOptions(const GeometricTextureDistanceOptions& options)
{
  if (options.Projections < 1)
  {
    throw InvalidInput("CompareGeometricTextures: there are " + std::to_string(options.Projections) +
      " projections; expected at least one.");
  }
  if (options.Rings < 1 || options.Rings > MaximumRings)
  {
    throw InvalidInput("CompareGeometricTextures: there are " + std::to_string(options.Rings) +
      " rings; expected 1 to " + std::to_string(MaximumRings) + ".");
  }
}

/// Distances along all directions.
Eigen::VectorXd Compare(const SeenMesh& seen, const SeenMesh& seenReference,
  const GeometricTextureDistanceOptions& options, const Progress& progress)
{
  const int projections = options.Projections;
  if (options.Rings == 1)
  {
    return SlicedDistances(seen.EdgeFeatures(), seenReference.EdgeFeatures(), projections, options.Seed, progress);
  }
  const RingFeatureMatrix features = seen.RingFeatures(options.Rings, SubProgress(progress, 0.0, 0.1));
  const RingFeatureMatrix reference = seenReference.RingFeatures(options.Rings, SubProgress(progress, 0.1, 0.2));
  return SlicedDistances(features, reference, projections, options.Seed, SubProgress(progress, 0.2, 1.0));
}
} // namespace

Eigen::VectorXd SlicedDistances(const EdgeFeatureMatrix& features, const EdgeFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress)
{
  return DistancesAlongDirections(features, reference, projections, seed, progress);
}

Eigen::VectorXd SlicedDistances(const RingFeatureMatrix& features, const RingFeatureMatrix& reference, int projections,
  std::uint64_t seed, const Progress& progress)
{
  return DistancesAlongDirections(features, reference, projections, seed, progress);
}

TextureDistance CompareGeometricTextures(const TriangleMesh& surface, const TriangleMesh& reference,
  const GeometricTextureDistanceOptions& options, const Progress& progress)
{
  CheckOptions(options);
  const SeenMesh seen(surface, options.UnitLength, "surface");
  const SeenMesh seenReference(reference, options.ReferenceUnitLength, "reference");
  Report(progress, 0.1);
  const Eigen::VectorXd distances = Compare(seen, seenReference, options, SubProgress(progress, 0.1, 1.0));
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
