// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/TexturePatches.h"

#include "Core/Common/Parallel.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace surfsynth
{

namespace
{
/// Patches of a task.
constexpr std::int64_t PatchesOfTask = 128;

/// Samples of the grid in one direction from its center, the nearest first: one geodesic leads through all of them.
struct GridDirection
{
  Eigen::Vector2d Turn; ///< unit vector
  std::vector<int> Samples;
  std::vector<double> Lengths; ///< in spacings
};

/// Directions of the grid of a patch; the center belongs to the first axis.
std::vector<GridDirection> GridDirections()
{
  constexpr int radius = TexturePatches::Radius, side = TexturePatches::Side;
  std::vector<GridDirection> directions;
  for (int j = -radius; j <= radius; ++j)
  {
    for (int i = -radius; i <= radius; ++i)
    {
      if (std::gcd(i, j) != 1)
      {
        continue; // the center, or behind another sample
      }
      const double length = std::hypot(i, j);
      GridDirection direction{ Eigen::Vector2d(i, j) / length, {}, {} };
      const int first = i == 1 && j == 0 ? 0 : 1;
      for (int k = first; k * std::max(std::abs(i), std::abs(j)) <= radius; ++k)
      {
        direction.Samples.push_back(side * (k * j + radius) + k * i + radius);
        direction.Lengths.push_back(k * length);
      }
      directions.push_back(std::move(direction));
    }
  }
  return directions;
}
} // namespace

PatchSurface::PatchSurface(const TriangleMesh& mesh)
  : Mesh(mesh)
  , Topology(mesh)
  , Adjacency(mesh, this->Topology)
  , Tracer(mesh, this->Adjacency)
  , VertexNormals(TangentFrames(mesh, this->Topology).Normal)
  , MeanEdgeLength(surfsynth::MeanEdgeLength(mesh, this->Topology))
{}

TexturePatches::TexturePatches(
  const PatchSurface& surface, const std::vector<PatchCenter>& centers, const Progress& progress)
  : Surface(surface)
  , Places(centers.size() * Samples)
  , Spacings(centers.size())
  , Complete(centers.size())
{
  const auto count = static_cast<std::int64_t>(centers.size());
  ParallelTasks((count + PatchesOfTask - 1) / PatchesOfTask,
    [&](std::int64_t task) {
      const std::int64_t end = std::min(count, (task + 1) * PatchesOfTask);
      for (auto p = static_cast<std::size_t>(task * PatchesOfTask); p < static_cast<std::size_t>(end); ++p)
      {
        Sample* samples = this->Places.data() + p * Samples;
        this->Trace(centers[p], samples);
        this->Spacings[p] = static_cast<float>(centers[p].Spacing);
        this->Complete[p] = std::all_of(samples, samples + Samples, [](const Sample& s) { return s.IsInside; }) ? 1 : 0;
      }
    },
    [&] { Report(progress, 0.0); });
}

/// Finds the samples of one patch.
void TexturePatches::Trace(const PatchCenter& center, Sample* samples) const
{
  static const std::vector<GridDirection> directions = GridDirections();
  const Eigen::Vector3d yAxis = this->Surface.Tracer.Normal(center.Place.Triangle).cross(center.XAxis);
  std::array<double, Radius + 1> lengths;
  std::array<GeodesicEnd, Radius + 1> ends;
  for (const GridDirection& direction : directions)
  {
    const auto count = static_cast<int>(direction.Samples.size());
    for (int k = 0; k < count; ++k)
    {
      lengths[k] = direction.Lengths[k] * center.Spacing;
    }
    const Eigen::Vector2d& turn = direction.Turn;
    this->Surface.Tracer.Trace(
      center.Place, turn.x() * center.XAxis + turn.y() * yAxis, count, lengths.data(), ends.data());
    for (int k = 0; k < count; ++k)
    {
      samples[direction.Samples[k]] = this->SampleAt(ends[k], turn);
    }
  }
}

/// Returns the sample at the end of a geodesic. @param turn cosine and sine of its direction in the axes of the patch
TexturePatches::Sample TexturePatches::SampleAt(const GeodesicEnd& end, const Eigen::Vector2d& turn) const
{
  const PatchSurface& surface = this->Surface;
  const auto corners = surface.Mesh.Triangles.row(end.Place.Triangle);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c)
  {
    normal += end.Place.Weights(c) * surface.VertexNormals.row(corners(c)).transpose();
  }
  const double size = normal.norm();
  normal = size > 0.1 ? Eigen::Vector3d(normal / size) : surface.Tracer.Normal(end.Place.Triangle);
  Eigen::Vector3d along = end.Direction - end.Direction.dot(normal) * normal;
  along = along.norm() > 1e-3 ? along.normalized() : normal.unitOrthogonal();
  const Eigen::Vector3d x = turn.x() * along - turn.y() * normal.cross(along);
  Sample sample{ end.Place.Triangle, {}, {}, {}, end.IsComplete };
  Eigen::Map<Eigen::Vector2f>(sample.Weights) = end.Place.Weights.head<2>().cast<float>();
  Eigen::Map<Eigen::Vector3f>(sample.X) = x.cast<float>();
  Eigen::Map<Eigen::Vector3f>(sample.Normal) = normal.cast<float>();
  return sample;
}

/// Returns the axes of a sample as columns.
Eigen::Matrix3f TexturePatches::FrameOf(const Sample& sample)
{
  Eigen::Matrix3f frame;
  frame.col(0) = Eigen::Map<const Eigen::Vector3f>(sample.X);
  frame.col(2) = Eigen::Map<const Eigen::Vector3f>(sample.Normal);
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

void TexturePatches::Read(std::int64_t patch, const SinglePoints& displacement, float* values) const
{
  const float scale = 1.0F / this->Spacings[static_cast<std::size_t>(patch)];
  for (int k = 0; k < Samples; ++k)
  {
    const Sample& sample = this->At(patch, k);
    const auto corners = this->Surface.Mesh.Triangles.row(sample.Triangle);
    const Eigen::RowVector3f vector = sample.Weights[0] * displacement.row(corners(0)) +
      sample.Weights[1] * displacement.row(corners(1)) +
      (1.0F - sample.Weights[0] - sample.Weights[1]) * displacement.row(corners(2));
    Eigen::Map<Eigen::RowVector3f>(values + 3 * k) = scale * vector * FrameOf(sample);
  }
}

/// Adds the vector of a value, with a factor, to the rows of the corners of its triangle.
void TexturePatches::AddAtCorners(const Sample& sample, float factor, const float* value, SinglePoints& rows) const
{
  const Eigen::RowVector3f vector = factor * (FrameOf(sample) * Eigen::Map<const Eigen::Vector3f>(value)).transpose();
  const auto corners = this->Surface.Mesh.Triangles.row(sample.Triangle);
  rows.row(corners(0)) += sample.Weights[0] * vector;
  rows.row(corners(1)) += sample.Weights[1] * vector;
  rows.row(corners(2)) += (1.0F - sample.Weights[0] - sample.Weights[1]) * vector;
}

void TexturePatches::AddTransposed(std::int64_t patch, const float* values, SinglePoints& gradient) const
{
  const float scale = 1.0F / this->Spacings[static_cast<std::size_t>(patch)];
  for (int k = 0; k < Samples; ++k)
  {
    this->AddAtCorners(this->At(patch, k), scale, values + 3 * k, gradient);
  }
}

TexturePatches::TriangleProducts TexturePatches::Products(
  const Eigen::VectorXf& weights, const Eigen::VectorXf& factors) const
{
  TriangleProducts products = TriangleProducts::Zero(this->Surface.Mesh.NumberOfTriangles(), 6);
  for (std::size_t s = 0; s < this->Places.size(); ++s)
  {
    const Sample& sample = this->Places[s];
    if (sample.IsInside)
    {
      const Eigen::Vector3f b(sample.Weights[0], sample.Weights[1], 1.0F - sample.Weights[0] - sample.Weights[1]);
      const float weight = factors(static_cast<Eigen::Index>(s / Samples)) *
        weights(static_cast<Eigen::Index>(s % Samples));
      auto row = products.row(sample.Triangle);
      row.head<3>() += weight * b.cwiseAbs2().transpose();
      row.tail<3>() += weight * Eigen::RowVector3f(b(0) * b(1), b(1) * b(2), b(2) * b(0));
    }
  }
  return products;
}

void TexturePatches::AddWeighted(std::int64_t patch, const float* values, const Eigen::VectorXf& weights, float factor,
  SinglePoints& rightHandSide) const
{
  const float ofValues = factor * this->Spacings[static_cast<std::size_t>(patch)];
  for (int k = 0; k < Samples; ++k)
  {
    const Sample& sample = this->At(patch, k);
    if (sample.IsInside)
    {
      this->AddAtCorners(sample, weights(k) * ofValues, values + 3 * k, rightHandSide);
    }
  }
}

Eigen::VectorXf PatchWeights()
{
  constexpr int side = TexturePatches::Side, radius = TexturePatches::Radius;
  Eigen::VectorXf weights(TexturePatches::Samples);
  for (int k = 0; k < TexturePatches::Samples; ++k)
  {
    const float i = static_cast<float>(k % side - radius), j = static_cast<float>(k / side - radius);
    weights(k) = std::exp(-(i * i + j * j) / static_cast<float>(radius * radius));
  }
  return weights;
}

} // namespace surfsynth
