// SPDX-License-Identifier: BSD-3-Clause
// Textures from examples: nearest patches, features, directions, sizes, threads, errors.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/SurfacePlace.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Core/Statistics/GeometricTextureFeatures.h"
#include "Inference/GeometricTexture/ExampleBlend.h"
#include "Inference/GeometricTexture/ExampleSynthesis.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/NearestPatches.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::HasSubstr;

namespace
{
/// Returns a mesh whose points are moved along the normals of its vertices by @p height(point).
TriangleMesh Raised(TriangleMesh mesh, const std::function<double(const Eigen::Vector3d& point)>& height)
{
  const PointMatrix normals = TangentFrames(mesh, MeshTopology(mesh)).Normal;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    mesh.Points.row(v) += height(mesh.Points.row(v).transpose()) * normals.row(v);
  }
  return mesh;
}

/// Centers of 92 bumps on the unit sphere: the vertices and the middles of the triangles of two geodesic balls.
std::vector<Eigen::Vector3d> BumpCenters()
{
  std::vector<Eigen::Vector3d> centers;
  const TriangleMesh ball = test::Icosphere(1);
  for (Index v = 0; v < 12; ++v)
  {
    centers.emplace_back(ball.Points.row(v).transpose());
  }
  for (Index f = 0; f < ball.NumberOfTriangles(); ++f)
  {
    centers.push_back(PositionOf(ball, { f, Eigen::Vector3d::Constant(1.0 / 3.0) }).normalized());
  }
  return centers;
}

double Bump(const Eigen::Vector3d& point)
{
  static const std::vector<Eigen::Vector3d> centers = BumpCenters();
  double height = 0.0;
  for (const Eigen::Vector3d& center : centers)
  {
    height = std::max(height, 0.18 * (1.0 - (point - center).norm() / 0.16));
  }
  return height;
}

const TriangleMesh& Plain()
{
  static const TriangleMesh mesh = test::Icosphere(4);
  return mesh;
}

const TriangleMesh& Bumpy()
{
  static const TriangleMesh mesh = Raised(Plain(), Bump);
  return mesh;
}

const GeometricTextureExample& Bumps()
{
  static const GeometricTextureExample example(Bumpy(), Plain());
  return example;
}

ExampleSynthesisRequest OnceDivided(std::uint64_t seed = 1)
{
  ExampleSynthesisRequest request;
  request.Subdivisions = 1;
  request.Seed = seed;
  return request;
}

/// Returns the root of the mean square of displacements along the normals.
double RootMeanSquareOfHeights(const PointMatrix& displacement, const TriangleMesh& mesh)
{
  const PointMatrix normals = TangentFrames(mesh, MeshTopology(mesh)).Normal;
  return std::sqrt(
    displacement.cwiseProduct(normals).rowwise().sum().squaredNorm() / static_cast<double>(displacement.rows()));
}

/// A plane of waves along x, the example of a texture with a direction.
double Wave(const Eigen::Vector3d& point) { return 0.03 * std::sin(40.0 * point.x()); }
} // namespace

TEST(ExampleSynthesis, NearestPatchesAreThoseOfAllPairs)
{
  constexpr Index dimension = 12, patches = 1300, rows = 300; // several tiles of both
  ExamplePatches scale;
  scale.Values.resize(patches, 0);
  Eigen::MatrixXd numbers(dimension, patches);
  FillNormals({ 1 }, 0, numbers.size(), numbers.data());
  scale.Coordinates = numbers.cast<float>();
  scale.Squares = scale.Coordinates.colwise().squaredNorm().transpose();
  const ExamplePatches::Rows coordinates = scale.Coordinates.leftCols(rows).transpose() +
    0.05F * scale.Coordinates.middleCols(500, rows).transpose();
  const float completeness = 0.01F;
  NearestPatches search(scale);
  const std::vector<Index> nearest = search.Find(coordinates);
  search.Prefer(coordinates, completeness);
  const std::vector<Index> found = search.Find(coordinates);
  Eigen::ArrayXXd distances(rows, patches);
  for (Index r = 0; r < rows; ++r)
  {
    distances.row(r) = (scale.Coordinates.cast<double>().colwise() - coordinates.row(r).transpose().cast<double>())
                         .colwise()
                         .squaredNorm();
  }
  const Eigen::ArrayXd least = distances.colwise().minCoeff().transpose();
  for (Index r = 0; r < rows; ++r)
  {
    const Eigen::ArrayXd scores = distances.row(r).transpose() / (least + static_cast<double>(completeness));
    EXPECT_NEAR(scores(found[static_cast<std::size_t>(r)]), scores.minCoeff(), 1e-3 * scores.minCoeff() + 1e-4) << r;
    EXPECT_NEAR(distances(r, nearest[static_cast<std::size_t>(r)]), distances.row(r).minCoeff(), 1e-4) << r;
  }
}

TEST(ExampleSynthesis, FoundPatchesOfManyAreHardlyFartherThanTheNearest)
{
  const ExamplePatches& scale = Bumps().Scales().front();
  ASSERT_GT(scale.Clusters.size(), 10 * NearestPatches::NearestClusters);
  EXPECT_TRUE(std::is_sorted(scale.Clusters.begin(), scale.Clusters.end(), std::less_equal<>()));
  EXPECT_EQ(scale.Clusters.front(), 0);
  EXPECT_EQ(scale.Clusters.back(), scale.Count());
  // Around a few patches of the example, each on the way to another one.
  const Eigen::Index rows = 60, around = 6, stride = scale.Count() / around;
  ExamplePatches::Rows coordinates(rows, scale.Coordinates.rows());
  using Scores = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Scores distances(rows, scale.Count());
  for (Eigen::Index r = 0; r < rows; ++r)
  {
    const auto other = scale.Coordinates.col((r * 7919 + 1) % scale.Count());
    coordinates.row(r) = (0.7F * scale.Coordinates.col(r % around * stride) + 0.3F * other).transpose();
    distances.row(r) = (scale.Coordinates.colwise() - coordinates.row(r).transpose()).colwise().squaredNorm();
  }
  const auto meanOf = [&](const Scores& scores, const std::vector<Index>& found) {
    double sum = 0.0;
    for (Eigen::Index r = 0; r < rows; ++r)
    {
      sum += std::sqrt(static_cast<double>(scores(r, found[static_cast<std::size_t>(r)])));
    }
    return sum / static_cast<double>(rows);
  };
  const SingleThreadedBlas blas;
  NearestPatches search(scale);
  const std::vector<Index> nearest = search.Find(coordinates);
  EXPECT_LT(meanOf(distances, nearest), 1.05 * static_cast<double>(distances.rowwise().minCoeff().sqrt().mean()));
  const float completeness = 1e-3F * distances.mean();
  search.Prefer(coordinates, completeness);
  const std::vector<Index> preferred = search.Find(coordinates);
  distances.rowwise() /= distances.colwise().minCoeff() + completeness;
  const double least = static_cast<double>(distances.rowwise().minCoeff().sqrt().mean());
  EXPECT_LT(meanOf(distances, preferred), 1.05 * least);
  EXPECT_GT(meanOf(distances, nearest), 1.1 * least) << "the nearest ones are not those that are preferred";
}

TEST(ExampleSynthesis, PatchesStandBesideTheirQuarterTurns)
{
  // Bumps that lean outwards: the second moments of the patches are those of all patches turned by a quarter.
  TriangleMesh swollen = Bumpy();
  const std::vector<Eigen::Vector3d> centers = BumpCenters();
  for (Index v = 0; v < swollen.NumberOfPoints(); ++v)
  {
    const Eigen::Vector3d point = Plain().Points.row(v).transpose();
    for (const Eigen::Vector3d& center : centers)
    {
      const Eigen::Vector3d away = point - center;
      swollen.Points.row(v) += 2.0 * std::max(0.0, 0.16 - away.norm()) * away.transpose();
    }
  }
  GeometricTextureExampleOptions options;
  options.Scales = 1;
  const GeometricTextureExample example(swollen, Plain(), options);
  const ExamplePatches::Rows& values = example.Scales().front().Values;
  constexpr int side = TexturePatches::Side, middle = 3 * (TexturePatches::Samples / 2);
  const auto moment = [&](
                        int component, int step) { // of a component at the center and the rise of heights along an axis
    const auto rise = values.col(middle + 3 * step + 2) - values.col(middle - 3 * step + 2);
    return values.col(middle + component).cast<double>().dot(rise.cast<double>()) / static_cast<double>(values.rows());
  };
  const double alongX = moment(0, 1), alongY = moment(1, side);
  EXPECT_LT(alongX, -1e-3) << "bumps lean to where the surface falls";
  EXPECT_NEAR(alongY, alongX, 1e-5 * std::abs(alongX));
  EXPECT_NEAR(moment(0, side), -moment(1, 1), 1e-5 * std::abs(alongX));
}

/// Features of a synthesis in units of the example.
struct FoundFeatures
{
  double PeakDensity = 0.0, MeanPeakHeight = 0.0, PeakHeightVariation = 0.0, MergedShare = 0.0;
};

/// Means over seeds: a count of merged features of one seed hangs on rounding.
FoundFeatures MeanFeatures(const TriangleMesh& target, const GeometricTextureExample& example, double prominence)
{
  FoundFeatures mean;
  constexpr int seeds = 3;
  for (int seed = 1; seed <= seeds; ++seed)
  {
    ExampleSynthesisRequest request;
    request.Seed = static_cast<std::uint64_t>(seed);
    const ExampleSynthesis result = SynthesizeFromExample(example, target, request);
    EXPECT_LT(result.Mismatch, 0.25);
    EXPECT_EQ(result.Level.Level, 2);
    EXPECT_EQ(result.Level.Base.topRows(target.NumberOfPoints()), target.Points);
    const TriangleMesh bare{ result.Level.Base, result.Level.Mesh.Triangles };
    GeometricTextureFeatureOptions options;
    options.MinimumProminence = prominence * result.Scale;
    const GeometricTextureFeatures found = MeasureGeometricTextureFeatures(result.Level.Mesh, &bare, options);
    mean.PeakDensity += found.PeakDensity * result.Scale * result.Scale / seeds;
    mean.MeanPeakHeight += found.MeanPeakHeight / result.Scale / seeds;
    mean.PeakHeightVariation += found.PeakHeightVariation / seeds;
    mean.MergedShare += found.MergedShare / seeds;
  }
  return mean;
}

TEST(ExampleSynthesis, FeaturesAreThoseOfTheExample)
{
  const TriangleMesh plain = test::Icosphere(5), bumpy = Raised(plain, Bump); // five edges from a top to its foot
  const GeometricTextureFeatures reference = MeasureGeometricTextureFeatures(bumpy, &plain);
  const FoundFeatures found = MeanFeatures(
    test::Torus(40, 17, 1.0, 0.4), GeometricTextureExample(bumpy, plain), reference.MinimumProminence);
  EXPECT_NEAR(found.PeakDensity / reference.PeakDensity, 1.0, 0.15);
  EXPECT_LE(found.MergedShare, 0.03);
  EXPECT_LE(found.PeakHeightVariation, 1.3 * reference.PeakHeightVariation);
  EXPECT_NEAR(found.MeanPeakHeight / reference.MeanPeakHeight, 1.0, 0.1);
}

TEST(ExampleSynthesis, HeightsDeviateAsWidelyWherePatchesDoNotAgree)
{
  // Waves in many directions: no two patches are alike, and the mean of overlapping ones is lower than each.
  Eigen::MatrixXd numbers(4, 24);
  FillNormals({ 3 }, 0, numbers.size(), numbers.data());
  const auto height = [&](const Eigen::Vector3d& point) {
    double sum = 0.0;
    for (Eigen::Index k = 0; k < numbers.cols(); ++k)
    {
      sum += 0.01 * std::sin(12.0 * numbers.col(k).head<3>().normalized().dot(point) + 3.0 * numbers(3, k));
    }
    return sum;
  };
  const TriangleMesh plain = test::Icosphere(4), wavy = Raised(plain, height);
  const double asked = RootMeanSquareOfHeights(wavy.Points - plain.Points, plain);
  ExampleSynthesisRequest request;
  request.Scale = 1.0;
  const TriangleMesh target = test::Torus(48, 24, 1.0, 0.45);
  const ExampleSynthesis found = SynthesizeFromExample(GeometricTextureExample(wavy, plain), target, request);
  const TriangleMesh bare{ found.Level.Base, found.Level.Mesh.Triangles };
  EXPECT_NEAR(RootMeanSquareOfHeights(found.Level.Displacement, bare) / asked, 1.0, 0.1);
}

TEST(ExampleSynthesis, SeedsDecideAndThreadsDoNot)
{
  const TriangleMesh target = test::Icosphere(2), plain = test::Icosphere(3), bumpy = Raised(plain, Bump);
  GeometricTextureExampleOptions options;
  options.Scales = 2;
  std::vector<PointMatrix> results;
  for (const int threads : { 1, 3 })
  {
    const ThreadScope scope(threads);
    const GeometricTextureExample example(bumpy, plain, options);
    results.push_back(SynthesizeFromExample(example, target, OnceDivided(7)).Level.Displacement);
  }
  EXPECT_EQ(results[0], results[1]);
  const GeometricTextureExample example(bumpy, plain, options);
  const PointMatrix other = SynthesizeFromExample(example, target, OnceDivided(8)).Level.Displacement;
  EXPECT_GT((other - results[0]).norm(), 0.1 * other.norm());
}

TEST(ExampleSynthesis, UnitsDoNotMatter)
{
  const TriangleMesh target = test::Icosphere(2);
  const PointMatrix displacement = SynthesizeFromExample(Bumps(), target, OnceDivided()).Level.Displacement;
  const PointMatrix larger =
    SynthesizeFromExample(Bumps(), test::Scaled(target, 1024.0), OnceDivided()).Level.Displacement;
  EXPECT_LT((larger / 1024.0 - displacement).norm(), 1e-6 * displacement.norm());
  ExampleSynthesisRequest request = OnceDivided();
  const ExampleSynthesis automatic = SynthesizeFromExample(Bumps(), target, request);
  request.Scale = automatic.Scale;
  EXPECT_LT((SynthesizeFromExample(Bumps(), target, request).Level.Displacement - displacement).norm(),
    1e-3 * displacement.norm())
    << "the scale that is used by itself";
}

TEST(ExampleSynthesis, TexturesFollowDirections)
{
  const TriangleMesh plain = test::PlanePatch(60, 60, 2.0, 2.0, 0.0);
  GeometricTextureExampleOptions options;
  options.Directions = Eigen::RowVector3d::UnitX().replicate(plain.NumberOfPoints(), 1);
  const GeometricTextureExample example(Raised(plain, Wave), plain, options);
  ExampleSynthesisRequest request;
  request.Subdivisions = 0;
  request.Scale = 1.0;
  // A disk of directions around the middle of the plane: waves become rings.
  const Eigen::RowVector3d middle = plain.Points.colwise().mean();
  request.Directions = plain.Points.rowwise() - middle;
  const ExampleSynthesis result = SynthesizeFromExample(example, plain, request);
  const Eigen::VectorXd gradient = IntrinsicGradient(plain) * result.Level.Displacement.col(2);
  std::vector<double> errors;
  for (Index f = 0; f < plain.NumberOfTriangles(); ++f)
  {
    const auto corners = plain.Triangles.row(f);
    const Eigen::RowVector3d x = (plain.Points.row(corners(1)) - plain.Points.row(corners(0))).normalized();
    const Eigen::RowVector3d y = Eigen::RowVector3d::UnitZ().cross(x);
    const Eigen::RowVector3d slope = gradient(2 * f) * x + gradient(2 * f + 1) * y;
    const Eigen::RowVector3d outwards = (plain.Points.row(corners(0)) - middle).normalized();
    if (slope.norm() > 0.3 && (plain.Points.row(corners(0)) - middle).norm() > 0.25)
    {
      errors.push_back(std::acos(std::min(1.0, std::abs(slope.normalized().dot(outwards)))) * 180.0 / 3.14159265);
    }
  }
  ASSERT_GT(errors.size(), 1000U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 15.0) << "degrees, the median";
}

TEST(ExampleSynthesis, SizesChangeTheNumberOfFeatures)
{
  const TriangleMesh target = test::PlanePatch(60, 60, 3.0, 3.0, 0.0);
  ExampleSynthesisRequest request;
  request.Subdivisions = 1;
  request.Scale = 1.0;
  const auto peaks = [&](float size) {
    request.Sizes = Eigen::VectorXf::Constant(target.NumberOfPoints(), size);
    const ExampleSynthesis result = SynthesizeFromExample(Bumps(), target, request);
    const TriangleMesh bare{ result.Level.Base, result.Level.Mesh.Triangles };
    GeometricTextureFeatureOptions options;
    options.MinimumProminence = 0.06 * static_cast<double>(size);
    return static_cast<double>(MeasureGeometricTextureFeatures(result.Level.Mesh, &bare, options).NumberOfPeaks);
  };
  const double ratio = peaks(0.8F) / peaks(1.2F);
  EXPECT_NEAR(std::sqrt(ratio), 1.5, 0.15 * 1.5);
}

TEST(ExampleSynthesis, ThresholdsOfABlendAreEvenlyDistributed)
{
  // The same on a mesh that is coarse on one half: white noise of the surface, not of the vertices.
  const TriangleMesh ball = test::Icosphere(5);
  const TriangleMesh uneven = test::RefineWhere(test::Icosphere(4), [](Index f) { return f % 20 < 10; });
  TriangleMesh crumbs = test::Icosphere(4);
  for (int k = 0; k < 50; ++k)
  {
    const Eigen::Vector3d place(2.0 + 0.1 * k, 0.0, 0.0);
    crumbs = test::Join(crumbs, test::Translated(test::Scaled(test::Tetrahedron(), 1e-3), place));
  }
  for (const TriangleMesh* mesh : std::initializer_list<const TriangleMesh*>{ &ball, &uneven, &crumbs })
  {
    const Eigen::VectorXf thresholds = BlendThresholds(PatchSurface(*mesh), 0.3, { 5 });
    const Eigen::VectorXd mass = LumpedMass(*mesh) / LumpedMass(*mesh).sum();
    EXPECT_GT(thresholds.minCoeff(), 0.0F);
    EXPECT_LT(thresholds.maxCoeff(), 1.0F);
    for (const float share : { 0.25F, 0.5F, 0.75F })
    {
      const double found = (thresholds.array() < share).cast<double>().matrix().dot(mass);
      EXPECT_NEAR(found, static_cast<double>(share), 0.01);
    }
  }
}

TEST(ExampleSynthesis, ThresholdsOfABlendFormIslands)
{
  const TriangleMesh ball = test::Icosphere(5);
  const auto borderOf = [&](double length) {
    const Eigen::VectorXf thresholds = BlendThresholds(PatchSurface(ball), length, { 5 });
    Index border = 0;
    for (Index f = 0; f < ball.NumberOfTriangles(); ++f)
    {
      int below = 0;
      for (int k = 0; k < 3; ++k)
      {
        below += thresholds(ball.Triangles(f, k)) < 0.5F ? 1 : 0;
      }
      border += below % 3 != 0 ? 1 : 0;
    }
    return static_cast<double>(border);
  };
  EXPECT_NEAR(borderOf(0.2) / borderOf(0.6), 3.0, 1.0) << "three times as long where islands are a third as wide";
}

TEST(ExampleSynthesis, ABlendIsEachExampleWhereItsShareIsAll)
{
  const TriangleMesh target = test::Icosphere(2);
  const TriangleMesh plain = test::Icosphere(3);
  GeometricTextureExampleOptions options;
  options.Scales = 1;
  const GeometricTextureExample bumps(Raised(plain, Bump), plain, options);
  const GeometricTextureExample low(Raised(plain, [](const auto& p) { return 0.25 * Bump(p); }), plain, options);
  ExampleSynthesisRequest request = OnceDivided();
  const PointMatrix first = SynthesizeFromExample(bumps, target, request).Level.Displacement;
  const PointMatrix second = SynthesizeFromExample(low, target, request).Level.Displacement;
  request.Second = &low;
  request.Blend = Eigen::VectorXf::Zero(target.NumberOfPoints());
  EXPECT_EQ(SynthesizeFromExample(bumps, target, request).Level.Displacement, first) << "to the last bit";
  request.Blend.setOnes();
  EXPECT_EQ(SynthesizeFromExample(bumps, target, request).Level.Displacement, second) << "to the last bit";
  for (Index v = 0; v < target.NumberOfPoints(); ++v)
  {
    request.Blend(v) = target.Points(v, 2) > 0.0 ? 1.0F : 0.0F;
  }
  const ExampleSynthesis halves = SynthesizeFromExample(bumps, target, request);
  double high = 0.0, flat = 0.0;
  for (Index v = 0; v < halves.Level.Base.rows(); ++v)
  {
    const double z = halves.Level.Base(v, 2);
    (z < 0.0 ? high : flat) += std::abs(z) > 0.4 ? halves.Level.Displacement.row(v).squaredNorm() : 0.0;
  }
  EXPECT_NEAR(std::sqrt(flat / high), 0.25, 0.08) << "bumps of the second are a quarter as high";
}

TEST(ExampleSynthesis, FaultsAreNamed)
{
  const TriangleMesh target = test::Icosphere(2);
  ExampleSynthesisRequest request = OnceDivided();
  request.Directions = target.Points;
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }),
    HasSubstr("only one of the target and the example has directions"));
  request = OnceDivided();
  request.Scale = 1e-9;
  request.Subdivisions = 0;
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }),
    HasSubstr("a larger scale, or a smaller target, is needed"));
  request.Scale = 1.0;
  request.Subdivisions = 8;
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), test::Icosphere(5), request); }),
    HasSubstr("Fewer subdivisions, a larger scale or a coarser target are needed"))
    << "before any work";
  request = OnceDivided();
  request.Blend = Eigen::VectorXf::Zero(target.NumberOfPoints());
  EXPECT_THAT(
    MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }), HasSubstr("both or none are needed"));
  request.Second = &Bumps();
  request.Blend(3) = 1.5F;
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }), HasSubstr("is not in [0, 1]"));
  request.Blend(3) = 1.0F;
  const TriangleMesh small = test::Icosphere(3);
  GeometricTextureExampleOptions more;
  more.Scales = static_cast<int>(Bumps().Scales().size()) + 1;
  const GeometricTextureExample coarser(small, small, more);
  request.Second = &coarser;
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }),
    HasSubstr("and " + std::to_string(more.Scales) + " scales"));
  request = OnceDivided();
  request.Sizes = Eigen::VectorXf::Zero(target.NumberOfPoints());
  EXPECT_THAT(MessageOf([&] { SynthesizeFromExample(Bumps(), target, request); }), HasSubstr("sizes"));
  EXPECT_THAT(MessageOf([&] { GeometricTextureExample(Bumpy(), test::Icosphere(3)); }), HasSubstr("other triangles"));
  GeometricTextureExampleOptions options;
  options.Scales = 6;
  const TriangleMesh patch = test::PlanePatch(20, 20);
  EXPECT_THAT(MessageOf([&] { GeometricTextureExample(Raised(patch, Wave), patch, options); }),
    HasSubstr("lie inside the example"));
  EXPECT_THROW(SynthesizeFromExample(Bumps(), target, OnceDivided(), [](double) { return false; }), Cancelled);
}

TEST(ExampleSynthesis, AFlatExampleMovesNothing)
{
  const TriangleMesh plain = test::Icosphere(3);
  const GeometricTextureExample example(plain, plain);
  const ExampleSynthesis result = SynthesizeFromExample(example, test::Icosphere(2), OnceDivided());
  EXPECT_LT(result.Level.Displacement.cwiseAbs().maxCoeff(), 1e-6);
}
