// SPDX-License-Identifier: BSD-3-Clause
// The census of the features of a relief: bumps on grids and balls by hand, scales, orders of points, wrong controls.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Statistics/GeometricTextureFeatures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{
/// A cone or a cap.
struct Bump
{
  Eigen::RowVector3d Center;
  double Height;
  double Radius;
};

/// A bare surface and the same with bumps along its normals.
struct Relief
{
  TriangleMesh Bare;
  TriangleMesh Surface;
};

/// Moves the points of @p bare along @p normals by the highest of the bumps, cones that end at their radius.
Relief WithBumps(const TriangleMesh& bare, const PointMatrix& normals, const std::vector<Bump>& bumps)
{
  Relief relief{ bare, bare };
  for (Eigen::Index v = 0; v < bare.Points.rows(); ++v)
  {
    double height = 0.0;
    for (const Bump& bump : bumps)
    {
      const double distance = (bare.Points.row(v) - bump.Center).norm();
      height = std::max(height, bump.Height * (1.0 - distance / bump.Radius));
    }
    relief.Surface.Points.row(v) += height * normals.row(v);
  }
  return relief;
}

Relief OnPlane(const std::vector<Bump>& bumps, int cells = 120, double side = 12.0)
{
  const TriangleMesh plane = test::PlanePatch(cells, cells, side, side);
  PointMatrix normals(plane.Points.rows(), 3);
  normals.rowwise() = Eigen::RowVector3d(0.0, 0.0, 1.0);
  return WithBumps(plane, normals, bumps);
}

Relief OnBall(const std::vector<Bump>& bumps, int level = 5)
{
  const TriangleMesh ball = test::Icosphere(level);
  return WithBumps(ball, ball.Points, bumps);
}

/// Cones of radius .8 at the places (2, 2), (2, 5), ... of a grid, of heights 1, 1.1, 1 ...
std::vector<Bump> GridOfBumps(double height = 1.0, double alternate = 1.0)
{
  std::vector<Bump> bumps;
  for (int k = 0; k < 16; ++k)
  {
    const Eigen::RowVector3d center(1.5 + 3.0 * (k % 4), 1.5 + 3.0 * (k / 4), 0.0);
    bumps.push_back({ center, k % 2 == 0 ? height : height * alternate, 0.8 });
  }
  return bumps;
}

/// Places on the unit sphere that keep a distance, of a spiral whose turn depends on @p seed.
std::vector<Bump> BumpsOnBall(int count, double height, double radius, double turn = 0.0)
{
  std::vector<Bump> bumps;
  for (int k = 0; k < count; ++k)
  {
    const double z = 1.0 - (2.0 * k + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const double angle = 2.399963229728653 * k + turn;
    bumps.push_back({ Eigen::RowVector3d(r * std::cos(angle), r * std::sin(angle), z), height, radius });
  }
  return bumps;
}

GeometricTextureFeatures Measure(const Relief& relief, const GeometricTextureFeatureOptions& options = {})
{
  return MeasureGeometricTextureFeatures(relief.Surface, &relief.Bare, options);
}

/// The mesh with its points in another order.
TriangleMesh Permuted(const TriangleMesh& mesh)
{
  std::vector<Index> order(static_cast<std::size_t>(mesh.NumberOfPoints()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [](Index a, Index b) { return test::Mix(3, a) < test::Mix(3, b); });
  TriangleMesh permuted = mesh;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    permuted.Points.row(order[v]) = mesh.Points.row(v);
  }
  for (Eigen::Index k = 0; k < mesh.Triangles.size(); ++k)
  {
    permuted.Triangles.data()[k] = order[mesh.Triangles.data()[k]];
  }
  return permuted;
}

std::string MessageOf(const Relief& relief, const GeometricTextureFeatureOptions& options = {})
{
  try
  {
    Measure(relief, options);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "";
}
} // namespace

TEST(HeightPeaks, OfAPathAreAsByHand)
{
  // A strip of two rows, the second of which lies below everything: heights 1 3 2 5 4 4.5 0 along it. 5 is the highest; 3
  // meets it at 2, 4.5 at 4.
  TriangleMesh strip = test::PlanePatch(6, 1, 6.0, 1.0);
  const std::vector<double> along = { 1.0, 3.0, 2.0, 5.0, 4.0, 4.5, 0.0 };
  Eigen::VectorXd heights(strip.NumberOfPoints());
  std::vector<Index> vertex(along.size());
  for (Index v = 0; v < strip.NumberOfPoints(); ++v)
  {
    const auto x = static_cast<std::size_t>(std::lround(strip.Points(v, 0)));
    const bool first = strip.Points(v, 1) < 0.5;
    heights[v] = first ? along[x] : -1.0 - static_cast<double>(x);
    vertex[x] = first ? v : vertex[x];
  }
  const HeightPeaks peaks = FindHeightPeaks(MeshTopology(strip), heights, 0.1, 0.0);
  ASSERT_EQ(peaks.Peaks.size(), 3u);
  EXPECT_EQ(peaks.Prominences[vertex[1]], 1.0);
  EXPECT_EQ(peaks.Prominences[vertex[3]], 5.0 + 7.0);
  EXPECT_EQ(peaks.Prominences[vertex[5]], 0.5);
  EXPECT_EQ(peaks.Regions[vertex[0]], peaks.Regions[vertex[1]]);
  EXPECT_EQ(peaks.Regions[vertex[2]], peaks.Regions[vertex[3]]);
  EXPECT_EQ(peaks.Regions[vertex[6]], peaks.Regions[vertex[5]]);
  const Index highest = peaks.Regions[vertex[3]];
  EXPECT_EQ(peaks.Saddles[highest], 4.0);
  EXPECT_NEAR(peaks.SaddleRatios[highest], 4.0 / 4.5, 1e-15);
  EXPECT_NEAR(peaks.SaddleRatios[peaks.Regions[vertex[1]]], 2.0 / 3.0, 1e-15);
  // Above 0.5 the last one is no peak, and its vertices go to its neighbor.
  const HeightPeaks fewer = FindHeightPeaks(MeshTopology(strip), heights, 0.5, 0.0);
  ASSERT_EQ(fewer.Peaks.size(), 2u);
  EXPECT_EQ(fewer.Regions[vertex[6]], fewer.Regions[vertex[3]]);
  EXPECT_EQ(fewer.Prominences.sum(), 13.0);
  EXPECT_EQ(FindHeightPeaks(MeshTopology(strip), Eigen::VectorXd::Zero(14), 0.0, 0.0).Peaks.size(), 0u);
}

TEST(GeometricTextureFeatures, OfBumpsOnAPlaneAreAsByHand)
{
  const GeometricTextureFeatures found = Measure(OnPlane(GridOfBumps(1.0, 0.5)));
  EXPECT_EQ(found.NumberOfPeaks, 16);
  EXPECT_NEAR(found.Area, 144.0, 1e-9);
  EXPECT_NEAR(found.PeakDensity, 16.0 / 144.0, 1e-12);
  EXPECT_NEAR(found.RelativePeakDensity, found.PeakDensity * found.UnitLength * found.UnitLength, 1e-15);
  EXPECT_EQ(found.BaseLevel, 0.0);
  EXPECT_NEAR(found.MeanPeakHeight, 0.75, 1e-12);
  EXPECT_NEAR(found.PeakHeightVariation, std::sqrt(0.0625 * 16.0 / 15.0) / 0.75, 1e-12);
  EXPECT_EQ(found.NumberOfMergedPeaks, 0);
  EXPECT_EQ(found.MergedShare, 0.0);
  for (const Index peak : found.Peaks.Peaks)
  {
    EXPECT_NEAR(found.Peaks.Prominences[peak], found.Heights[peak], 1e-12) << "bare ground all around";
  }
  // Each vertex of a cone belongs to its peak.
  const TriangleMesh& plane = OnPlane({}).Bare;
  for (Index v = 0; v < plane.NumberOfPoints(); ++v)
  {
    if (found.Heights[v] > 1e-9)
    {
      const Index peak = found.Peaks.Peaks[static_cast<std::size_t>(found.Peaks.Regions[v])];
      EXPECT_LT((plane.Points.row(v) - plane.Points.row(peak)).norm(), 0.8);
    }
  }
}

TEST(GeometricTextureFeatures, WallsAreIsolinesByHand)
{
  // Of a cone of height 1 and radius 0.8 the isoline at t is a circle of radius 0.8 (1 - t); the quantiles are 0 and that of
  // 5 percent of the area, 7.2 = 16 pi r^2 at height 1 - r / 0.8.
  GeometricTextureFeatureOptions options;
  options.WallLevel = 0.5;
  const GeometricTextureFeatures found = Measure(OnPlane(GridOfBumps(), 240), options);
  const double high = 1.0 - std::sqrt(7.2 / 16.0 / M_PI) / 0.8;
  EXPECT_NEAR(found.WallHeight, 0.5 * high, 0.01 * high);
  const double expected = 16.0 * M_PI * 0.8 * (1.0 - found.WallHeight);
  EXPECT_NEAR(found.WallLength, expected, 0.02 * expected);
  EXPECT_NEAR(found.WallDensity, found.WallLength / 144.0, 1e-12);
  // Ridges along y, four waves: the mean height is crossed eight times.
  Relief ridges = OnPlane({}, 120);
  for (Index v = 0; v < ridges.Bare.NumberOfPoints(); ++v)
  {
    ridges.Surface.Points(v, 2) = std::cos(2.0 * M_PI * ridges.Bare.Points(v, 0) / 3.0);
  }
  const GeometricTextureFeatures walls = Measure(ridges);
  EXPECT_NEAR(walls.WallHeight, 0.0, 1e-3);
  EXPECT_NEAR(walls.WallLength, 4.0 * 12.0, 0.02 * 48.0);
  EXPECT_NEAR(walls.RelativeWallDensity, walls.WallDensity * walls.UnitLength, 1e-15);
}

TEST(GeometricTextureFeatures, MergedPeaksArePairsWithAHighSaddle)
{
  // Two cones of height 1 at a distance of 0.4 meet at height 0.75; at a distance of 1.2 at 0.25. Sixteen, four of them with
  // a partner that is near, four with one that is farther.
  std::vector<Bump> bumps = GridOfBumps();
  for (int k = 0; k < 4; ++k)
  {
    bumps.push_back({ bumps[k].Center + Eigen::RowVector3d(0.4, 0.0, 0.0), 1.0, 0.8 });
    bumps.push_back({ bumps[k + 8].Center + Eigen::RowVector3d(1.2, 0.0, 0.0), 1.0, 0.8 });
  }
  const Relief relief = OnPlane(bumps);
  const GeometricTextureFeatures found = Measure(relief);
  EXPECT_EQ(found.NumberOfPeaks, 24);
  EXPECT_EQ(found.NumberOfMergedPeaks, 8);
  EXPECT_NEAR(found.MergedShare, 8.0 / 24.0, 1e-15);
  GeometricTextureFeatureOptions options;
  options.MergedSaddle = 0.2;
  EXPECT_EQ(Measure(relief, options).NumberOfMergedPeaks, 16);
  options.MergedSaddle = 0.8;
  EXPECT_EQ(Measure(relief, options).NumberOfMergedPeaks, 0);
  options.MinimumProminence = 0.3; // the near partners rise 0.25 over their saddles
  EXPECT_EQ(Measure(relief, options).NumberOfPeaks, 20);
}

TEST(GeometricTextureFeatures, OfABallWithBumpsNeedNoBareSurface)
{
  const Relief relief = OnBall(BumpsOnBall(60, 0.2, 0.2));
  const GeometricTextureFeatures over = Measure(relief);
  EXPECT_EQ(over.NumberOfPeaks, 60);
  EXPECT_NEAR(over.MeanPeakHeight, 0.2, 0.02) << "no vertex lies at the very top";
  EXPECT_NEAR(over.Area, 4.0 * M_PI, 0.02);
  const GeometricTextureFeatures alone = MeasureGeometricTextureFeatures(relief.Surface);
  EXPECT_EQ(alone.NumberOfPeaks, 60);
  EXPECT_NEAR(alone.Area, over.Area, 0.1 * over.Area);
  // The smoothed form follows cones a little: of their height 15 % is its.
  EXPECT_NEAR(alone.MeanPeakHeight, 0.85 * over.MeanPeakHeight, 0.05 * over.MeanPeakHeight);
  EXPECT_NEAR(alone.WallLength, over.WallLength, 0.1 * over.WallLength);
  EXPECT_EQ(alone.NumberOfMergedPeaks, 0);
}

TEST(GeometricTextureFeatures, SmoothedFormIsAsTheFormulaSays)
{
  // Cosines of wavelength w along x on a flat strip whose ends are crests, where the discrete operator is that of the plane.
  TriangleMesh strip = test::PlanePatch(200, 4, 20.0, 0.4);
  for (const double wavelength : { 2.0, 10.0 })
  {
    TriangleMesh waves = strip;
    const double amplitude = 1e-4 * wavelength;
    for (Index v = 0; v < strip.NumberOfPoints(); ++v)
    {
      waves.Points(v, 2) = amplitude * std::cos(2.0 * M_PI * strip.Points(v, 0) / wavelength);
    }
    const TriangleMesh form = SmoothedForm(waves, MeshTopology(waves), 1.0);
    const double q = std::pow(2.0 * M_PI / wavelength, 2.0), share = 1.0 - std::pow(q / (1.0 + q), 2.0);
    for (Index v = 0; v < strip.NumberOfPoints(); ++v)
    {
      if (std::abs(strip.Points(v, 0) - 10.0) < 2.0)
      {
        EXPECT_NEAR(form.Points(v, 2), share * waves.Points(v, 2), 0.02 * amplitude);
      }
    }
  }
}

TEST(GeometricTextureFeatures, OfAFlatSurfaceAreNone)
{
  const Relief flat = OnPlane({});
  for (const GeometricTextureFeatures& found : { Measure(flat), MeasureGeometricTextureFeatures(flat.Surface) })
  {
    EXPECT_EQ(found.NumberOfPeaks, 0);
    EXPECT_EQ(found.MeanPeakHeight, 0.0);
    EXPECT_EQ(found.PeakHeightVariation, 0.0);
    EXPECT_EQ(found.MergedShare, 0.0);
    EXPECT_EQ(found.WallLength, 0.0);
    EXPECT_TRUE(std::all_of(found.Peaks.Regions.begin(), found.Peaks.Regions.end(), [](Index r) { return r < 0; }));
  }
  // The facets of a ball are a relief of their own, of less than a thousandth of its radius.
  GeometricTextureFeatureOptions options;
  options.MinimumProminence = 1e-3;
  const GeometricTextureFeatures ball = MeasureGeometricTextureFeatures(test::Icosphere(4), nullptr, options);
  EXPECT_EQ(ball.NumberOfPeaks, 0);
  EXPECT_LT(ball.HeightDeviation, 1e-3);
}

TEST(GeometricTextureFeatures, NoiseBelowTheProminenceGivesNoPeaks)
{
  Relief relief = OnPlane(GridOfBumps());
  Relief noise = OnPlane({});
  for (Index v = 0; v < noise.Bare.NumberOfPoints(); ++v)
  {
    const double height = 0.02 * test::Uniform(1, static_cast<std::uint64_t>(v));
    relief.Surface.Points(v, 2) += height;
    noise.Surface.Points(v, 2) += height;
  }
  const GeometricTextureFeatures bumps = Measure(relief);
  EXPECT_EQ(bumps.NumberOfPeaks, 16) << "the default lies above the noise";
  EXPECT_GT(bumps.MinimumProminence, 0.05);
  GeometricTextureFeatureOptions options;
  options.MinimumProminence = bumps.MinimumProminence;
  EXPECT_EQ(Measure(noise, options).NumberOfPeaks, 0);
  EXPECT_GT(Measure(noise).NumberOfPeaks, 100) << "noise alone is relief";
}

TEST(GeometricTextureFeatures, DoNotDependOnScale)
{
  const Relief relief = OnBall(BumpsOnBall(40, 0.2, 0.25), 4);
  const GeometricTextureFeatures one = Measure(relief), alone = MeasureGeometricTextureFeatures(relief.Surface);
  for (const double scale : { 1e-3, 1e3 })
  {
    const Relief scaled{ test::Scaled(relief.Bare, scale), test::Scaled(relief.Surface, scale) };
    const GeometricTextureFeatures found[] = { Measure(scaled), MeasureGeometricTextureFeatures(scaled.Surface) };
    const GeometricTextureFeatures* expected[] = { &one, &alone };
    for (int k = 0; k < 2; ++k)
    {
      EXPECT_EQ(found[k].NumberOfPeaks, expected[k]->NumberOfPeaks);
      EXPECT_EQ(found[k].NumberOfMergedPeaks, expected[k]->NumberOfMergedPeaks);
      EXPECT_NEAR(found[k].RelativePeakDensity / expected[k]->RelativePeakDensity, 1.0, 1e-9);
      EXPECT_NEAR(found[k].RelativeWallDensity / expected[k]->RelativeWallDensity, 1.0, 1e-6);
      EXPECT_NEAR(found[k].PeakHeightVariation, expected[k]->PeakHeightVariation, 1e-9);
      EXPECT_NEAR(found[k].MeanPeakHeight / scale, expected[k]->MeanPeakHeight, 1e-9);
      EXPECT_NEAR(found[k].PeakDensity * scale * scale / expected[k]->PeakDensity, 1.0, 1e-9);
    }
  }
}

TEST(GeometricTextureFeatures, DoNotDependOnTheOrderOfPoints)
{
  Relief relief = OnBall(BumpsOnBall(40, 0.2, 0.25), 4);
  for (const bool isPlateau : { false, true })
  {
    if (isPlateau) // equal heights, of tops and ground
    {
      const Eigen::VectorXd heights = Measure(relief).Heights.cwiseMin(0.1);
      relief.Surface.Points = relief.Bare.Points + heights.asDiagonal() * relief.Bare.Points;
    }
    const GeometricTextureFeatures one = Measure(relief);
    const GeometricTextureFeatures other = Measure({ Permuted(relief.Bare), Permuted(relief.Surface) });
    EXPECT_EQ(one.NumberOfPeaks, 40);
    EXPECT_EQ(other.NumberOfPeaks, one.NumberOfPeaks);
    EXPECT_EQ(other.NumberOfMergedPeaks, one.NumberOfMergedPeaks);
    EXPECT_NEAR(other.MeanPeakHeight, one.MeanPeakHeight, 1e-12);
    EXPECT_NEAR(other.PeakHeightVariation, one.PeakHeightVariation, 1e-10);
    EXPECT_NEAR(other.WallLength, one.WallLength, 1e-9);
    EXPECT_NEAR(other.Peaks.Prominences.sum(), one.Peaks.Prominences.sum(), 1e-10);
  }
}

TEST(GeometricTextureFeatures, AreTheSameForEveryNumberOfThreads)
{
  const Relief relief = OnBall(BumpsOnBall(40, 0.2, 0.25), 4);
  const ThreadScope one(1);
  const GeometricTextureFeatures expected = MeasureGeometricTextureFeatures(relief.Surface);
  for (const int threads : { 2, 3 })
  {
    const ThreadScope scope(threads);
    const GeometricTextureFeatures found = MeasureGeometricTextureFeatures(relief.Surface);
    EXPECT_EQ(found.Heights, expected.Heights);
    EXPECT_EQ(found.Peaks.Regions, expected.Peaks.Regions);
    EXPECT_EQ(found.WallLength, expected.WallLength);
    EXPECT_EQ(found.PeakHeightVariation, expected.PeakHeightVariation);
  }
}

namespace
{
/// The limits on a texture against its reference: count per area, variation of height and merged peaks.
std::string FaultsOf(const GeometricTextureFeatures& found, const GeometricTextureFeatures& reference)
{
  std::string faults;
  faults += std::abs(found.RelativePeakDensity / reference.RelativePeakDensity - 1.0) > 0.15 ? "count " : "";
  faults += found.PeakHeightVariation > 1.3 * reference.PeakHeightVariation ? "variation " : "";
  faults += found.MergedShare > 0.03 ? "merged " : "";
  return faults;
}

/// Spikes whose heights differ by up to a tenth, in an order that @p seed chooses.
std::vector<Bump> Spikes(std::uint64_t seed, int count = 90)
{
  std::vector<Bump> bumps = BumpsOnBall(count, 0.25, 0.17, 0.7 * static_cast<double>(seed));
  for (std::size_t k = 0; k < bumps.size(); ++k)
  {
    bumps[k].Height *= 1.0 + 0.1 * test::Uniform(seed, k);
  }
  return bumps;
}
} // namespace

TEST(GeometricTextureFeatures, TellWrongTexturesApart)
{
  const Relief right = OnBall(Spikes(1));
  const GeometricTextureFeatures reference = Measure(right);
  ASSERT_EQ(reference.NumberOfPeaks, 90);
  EXPECT_EQ(FaultsOf(reference, reference), "");
  EXPECT_EQ(FaultsOf(Measure(OnBall(Spikes(2))), reference), "") << "other places and heights of the same texture";
  std::vector<Bump> merged = Spikes(1);
  for (std::size_t k = 1; k < merged.size(); k += 2) // each second one is drawn to the nearest
  {
    const auto nearer = [&](const Bump& a, const Bump& b) {
      const auto distance = [&](
                              const Bump& c) { return &c == &merged[k] ? 9.0 : (c.Center - merged[k].Center).norm(); };
      return distance(a) < distance(b);
    };
    const Bump& nearest = *std::min_element(merged.begin(), merged.end(), nearer);
    merged[k].Center = (merged[k].Center + 3.0 * nearest.Center).normalized();
  }
  EXPECT_THAT(FaultsOf(Measure(OnBall(merged)), reference), HasSubstr("merged"));
  std::vector<Bump> sparse = Spikes(1);
  sparse.resize(60); // the third below is bare
  EXPECT_THAT(FaultsOf(Measure(OnBall(sparse)), reference), HasSubstr("count"));
  // Heights of vertices in another order: peaks everywhere.
  Relief shuffled = right;
  std::vector<Index> order(static_cast<std::size_t>(right.Bare.NumberOfPoints()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [](Index a, Index b) { return test::Mix(5, a) < test::Mix(5, b); });
  for (Index v = 0; v < right.Bare.NumberOfPoints(); ++v)
  {
    shuffled.Surface.Points.row(v) = (1.0 + reference.Heights[order[v]]) * right.Bare.Points.row(v);
  }
  EXPECT_THAT(FaultsOf(Measure(shuffled), reference), HasSubstr("count"));
  EXPECT_THAT(FaultsOf(Measure(shuffled), reference), HasSubstr("merged"));
}

TEST(GeometricTextureFeatures, LeaveUnusedPointsOut)
{
  const Relief relief = OnBall(BumpsOnBall(20, 0.2, 0.3), 4);
  Relief unused{ test::WithUnreferencedPoints(relief.Bare), test::WithUnreferencedPoints(relief.Surface) };
  const MeshTopology topology(unused.Surface);
  for (Index v = 0; v < unused.Surface.NumberOfPoints(); ++v)
  {
    if (topology.VertexTriangleStart[v] == topology.VertexTriangleStart[v + 1])
    {
      unused.Surface.Points(v, 0) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const GeometricTextureFeatures expected = Measure(relief), found = Measure(unused);
  EXPECT_EQ(found.NumberOfPeaks, expected.NumberOfPeaks);
  EXPECT_EQ(found.WallLength, expected.WallLength);
  EXPECT_TRUE(found.Heights.allFinite());
  const GeometricTextureFeatures alone = MeasureGeometricTextureFeatures(unused.Surface);
  EXPECT_EQ(alone.NumberOfPeaks, 20);
  EXPECT_TRUE(alone.Heights.allFinite());
}

TEST(GeometricTextureFeatures, RefuseWhatTheyCannotMeasure)
{
  const Relief relief = OnPlane({}, 4);
  EXPECT_THAT(MessageOf({}), HasSubstr("the surface has no triangle"));
  EXPECT_THAT(MessageOf({ test::PlanePatch(5, 4), relief.Surface }),
    HasSubstr(
      "the bare surface has 30 points and 40 triangles; expected those of the surface, 25 points and 32 triangles"));
  Relief turned = relief;
  turned.Bare.Triangles.row(0).swap(turned.Bare.Triangles.row(1));
  EXPECT_THAT(MessageOf(turned), HasSubstr("other triangles"));
  GeometricTextureFeatureOptions options;
  options.MergedSaddle = 1.5;
  EXPECT_THAT(MessageOf(relief, options), HasSubstr("the merged saddle is 1.5; expected from 0 to 1."));
  options = {};
  options.WallLevel = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(MessageOf(relief, options), HasSubstr("the wall level is nan"));
  options = {};
  options.MinimumProminence = -1.0;
  EXPECT_THAT(MessageOf(relief, options), HasSubstr("the minimum prominence is -1; expected 0 or more."));
  EXPECT_THAT(MessageOf({ test::Scaled(relief.Bare, 1e100), relief.Surface }), HasSubstr("the area is inf"));
  EXPECT_THROW(
    MeasureGeometricTextureFeatures(relief.Surface, nullptr, {}, [](double done) { return done < 0.4; }), Cancelled);
}
