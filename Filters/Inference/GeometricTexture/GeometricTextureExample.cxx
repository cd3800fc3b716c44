// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/GeometricTextureExample.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Core/Solvers/SurfaceSmoothing.h"
#include "Core/Statistics/GeometricTextureFeatures.h"
#include "Inference/Common/MatrixProduct.h"
#include "Inference/GeometricTexture/PatchCenters.h"
#include "Inference/GeometricTexture/PatchClusters.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Fraction of the spacing over which the displacement is smoothed twice, as by SmoothedForm().
constexpr double SmoothingOfSpacing = 0.2;
/// Patches for a square of the spacing; bounds of their number, with those that are turned.
constexpr double PatchesOfSquare = 18.0;
constexpr std::int64_t FewestPatches = 1024, MostPatches = 131072;
/// Quarter turns of a patch whose axes are at random, the one without a turn included.
constexpr std::int64_t QuarterTurns = 4;
/// Most principal components, and the share of the variance that is enough.
constexpr Eigen::Index MostComponents = 40;
constexpr float EnoughVariance = 0.98F;
/// Widest patch over the mean distance of peaks.
constexpr double WidthOfPeaks = 2.5;
constexpr int MostAutomaticScales = 6;
constexpr std::uint32_t ClusterNumbers = 1; ///< component of the key of the clusters

[[noreturn]] void Refuse(const std::string& problem) { throw InvalidInput("GeometricTextureExample: " + problem); }

/// Returns the number of scales whose widest patches are about so wide, mean edge lengths.
int ScalesFor(double width)
{
  const double doublings = std::round(std::log2(std::max(1.0, width / TexturePatches::Side)));
  return std::clamp(1 + static_cast<int>(doublings), 1, MostAutomaticScales);
}

/// Smooths displacements over a length, twice.
SinglePoints Smoothed(const PatchSurface& surface, const PointMatrix& displacement, double length)
{
  const SurfaceSmoothing smoothing(surface.Mesh, surface.Topology, length);
  return smoothing.Apply(smoothing.Apply(displacement)).cast<float>();
}

/// Returns the centers whose triangles lie farther from the boundary than @p margin.
std::vector<PatchCenter> WithoutMargin(
  const PatchSurface& surface, const std::vector<PatchCenter>& centers, double margin)
{
  std::vector<Index> boundary;
  for (Index v = 0; v < surface.Mesh.NumberOfPoints() && margin > 0.0; ++v)
  {
    if (surface.Topology.IsOnBoundary(v))
    {
      boundary.push_back(v);
    }
  }
  if (boundary.empty())
  {
    return centers;
  }
  const Eigen::VectorXd distances = EdgeDistances(surface.Mesh, surface.Topology, boundary);
  std::vector<PatchCenter> kept;
  std::copy_if(centers.begin(), centers.end(), std::back_inserter(kept), [&](const PatchCenter& center) {
    const auto corners = surface.Mesh.Triangles.row(center.Place.Triangle);
    return std::min({ distances(corners(0)), distances(corners(1)), distances(corners(2)) }) > margin;
  });
  return kept;
}

/// Writes the values of a patch as another one with the same center has them, whose axes are turned by a quarter.
void Turn(const float* values, float* turned)
{
  constexpr int radius = TexturePatches::Radius, side = TexturePatches::Side;
  for (int j = -radius; j <= radius; ++j)
  {
    for (int i = -radius; i <= radius; ++i)
    {
      // Its axes are y and -x: i y - j x.
      const float* value = values + 3 * (side * (i + radius) + radius - j);
      float* to = turned + 3 * (side * (j + radius) + i + radius);
      to[0] = value[1];
      to[1] = -value[0];
      to[2] = value[2];
    }
  }
}

/// Reads the patches that lie inside, and turns them.
/// @param turns number of quarter turns of each @param count number of patches with those in the margin @param scale its
/// number; both for messages
ExamplePatches::Rows ReadPatches(
  const TexturePatches& patches, std::int64_t turns, std::int64_t count, int scale, const SinglePoints& displacement)
{
  std::vector<std::int64_t> inside;
  for (std::int64_t p = 0; p < patches.Count(); ++p)
  {
    if (patches.IsComplete(p))
    {
      inside.push_back(p);
    }
  }
  const auto found = static_cast<std::int64_t>(inside.size());
  if (found * turns < 64) // a sixteenth of the fewest patches
  {
    Refuse("only " + std::to_string(found) + " of " + std::to_string(count) + " patches of scale " +
      std::to_string(scale + 1) +
      " lie inside the example; a larger example, fewer scales or a smaller SmoothingLength are needed.");
  }
  ExamplePatches::Rows rows(turns * found, TexturePatches::Components);
  ParallelFor(found, 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p)
    {
      patches.Read(inside[static_cast<std::size_t>(p)], displacement, rows.row(turns * p).data());
      for (std::int64_t row = turns * p + 1; row < turns * (p + 1); ++row)
      {
        Turn(rows.row(row - 1).data(), rows.row(row).data());
      }
    }
  });
  return rows;
}

/// Measures the displacements at the centers.
void Measure(ExamplePatches& scale)
{
  constexpr int center = TexturePatches::Samples / 2;
  const Eigen::MatrixXd values = scale.Values.middleCols<3>(3 * center).cast<double>();
  scale.Mean = scale.Values.colwise().mean().transpose();
  scale.MeanHeight = values.col(2).mean();
  scale.HeightDeviation = std::sqrt((values.col(2).array() - scale.MeanHeight).square().mean());
  scale.Amplitude = std::sqrt(values.rowwise().squaredNorm().mean());
}

/// Computes the coordinates of the patches in their principal components.
void Project(ExamplePatches& scale)
{
  Eigen::VectorXf weights(TexturePatches::Components);
  const Eigen::VectorXf ofSamples = PatchWeights().cwiseSqrt();
  for (Eigen::Index k = 0; k < weights.size(); ++k)
  {
    weights(k) = ofSamples(k / 3);
  }
  const ExamplePatches::Rows centered = (scale.Values.rowwise() - scale.Mean.transpose()) * weights.asDiagonal();
  ExamplePatches::Rows covariance(weights.size(), weights.size());
  MultiplyBlocks({ centered.data(), centered.cols(), true }, { centered.data(), centered.cols() }, covariance.data(),
    covariance.cols(), covariance.rows(), centered.rows(), covariance.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(
    Eigen::MatrixXf(covariance / static_cast<float>(centered.rows())));
  const Eigen::VectorXf variances = solver.eigenvalues().reverse().cwiseMax(0.0F);
  Eigen::Index used = 0;
  for (float reached = 0.0F; used < MostComponents && (used == 0 || reached < EnoughVariance * variances.sum()); ++used)
  {
    reached += variances(used);
  }
  scale.Basis = weights.asDiagonal() * solver.eigenvectors().rightCols(used);
  ExamplePatches::Rows coordinates(scale.Count(), used);
  Multiply(scale.Values.data(), scale.Basis.data(), coordinates.data(), scale.Count(), weights.size(), used);
  scale.Squares = coordinates.rowwise().squaredNorm();
  scale.Coordinates = coordinates.transpose();
}
} // namespace

MeshRequirements GeometricTextureExample::Requirements()
{
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  return requirements;
}

ExampleScaleCounts CountExampleScales(const TriangleMesh& textured, const TriangleMesh& plain)
{
  const GeometricTextureFeatures found = MeasureGeometricTextureFeatures(textured, &plain);
  const double peaks = found.RelativePeakDensity > 0.0 ? 1.0 / std::sqrt(found.RelativePeakDensity) : 10.0;
  const double widest = 0.5 * std::sqrt(found.Area) / MeanEdgeLength(plain, MeshTopology(plain));
  return { ScalesFor(std::min(WidthOfPeaks * peaks, widest)), ScalesFor(widest) };
}

GeometricTextureExample::GeometricTextureExample(const TriangleMesh& textured, const TriangleMesh& plain,
  const GeometricTextureExampleOptions& options, const Progress& progress)
  : Oriented(options.Directions.rows() > 0)
{
  RequireValidMesh(textured, Requirements());
  RequireValidMesh(plain, Requirements());
  if (textured.Triangles.rows() != plain.Triangles.rows() || textured.Triangles != plain.Triangles ||
    textured.Points.rows() != plain.Points.rows())
  {
    Refuse("the example and the one without texture have other triangles; the same ones are needed.");
  }
  if (options.Scales < 0 || options.Scales > 8)
  {
    Refuse("there are " + std::to_string(options.Scales) + " scales; 0 to 8 are needed.");
  }
  if (!(options.Margin >= 0.0) ||
    (options.Directions.rows() > 0 &&
      (options.Directions.rows() != plain.Points.rows() || !options.Directions.allFinite())))
  {
    Refuse("the margin is below 0, or the directions are not one finite vector for each of " +
      std::to_string(plain.NumberOfPoints()) + " points.");
  }
  const SingleThreadedBlas limit;
  const PatchSurface surface(plain);
  this->EdgeLength = surface.MeanEdgeLength;
  const PointMatrix displacement = textured.Points - plain.Points;
  const int scales = options.Scales > 0 ? options.Scales : CountExampleScales(textured, plain).Automatic;
  for (int s = 0; s < scales; ++s)
  {
    const Progress part = SubProgress(progress, static_cast<double>(s) / scales, (s + 1.0) / scales);
    ExamplePatches scale;
    scale.Spacing = std::ldexp(1.0, s);
    PatchDistribution distribution;
    distribution.Spacing = scale.Spacing * this->EdgeLength;
    distribution.Directions = this->Oriented ? &options.Directions : nullptr;
    distribution.Key.Seed = options.Seed;
    distribution.Key.Sample = static_cast<std::uint32_t>(s);
    const double squares = AreaInSquares(surface, distribution);
    const std::int64_t turns = this->Oriented ? 1 : QuarterTurns;
    const auto count = static_cast<std::int64_t>(std::clamp(
      PatchesOfSquare * squares, static_cast<double>(FewestPatches / turns), static_cast<double>(MostPatches / turns)));
    const TexturePatches patches(
      surface, WithoutMargin(surface, DrawPatchCenters(surface, distribution, count), options.Margin), part);
    scale.Values = ReadPatches(patches, turns, count, s,
      s == 0 ? SinglePoints(displacement.cast<float>())
             : Smoothed(surface, displacement, SmoothingOfSpacing * distribution.Spacing));
    Measure(scale);
    Project(scale);
    SortIntoClusters(scale, { options.Seed, static_cast<std::uint32_t>(s), ClusterNumbers }, part);
    this->Patches.push_back(std::move(scale));
    Report(part, 1.0);
  }
}

} // namespace surfsynth
