// SPDX-License-Identifier: BSD-3-Clause
//
// Distances by the heat method, and the mixtures of Gaussians that are made of them.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Noise/GaussianMixtures.h"
#include "Core/Random/CounterUniforms.h"
#include "Core/Solvers/HeatGeodesics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace surfsynth;

namespace
{
HeatGeodesics GeodesicsOf(const TriangleMesh& mesh) { return HeatGeodesics(mesh, RequireValidMesh(mesh)); }

/// The samples of a request, one column each.
Eigen::MatrixXd Samples(const GaussianMixtures& mixtures, const GaussianMixtureRequest& request, Index points)
{
  Eigen::MatrixXd values(points, request.NumberOfSamples);
  Eigen::Index column = 0;
  mixtures.SampleInto(request, [&](std::uint32_t) { return values.col(column++).data(); });
  return values;
}

GaussianMixtures MixturesOf(const TriangleMesh& mesh, const GaussianMixtureOptions& options = {})
{
  return GaussianMixtures(mesh, RequireValidMesh(mesh), options);
}
} // namespace

TEST(HeatGeodesics, DistancesOnASphereAreArcs)
{
  const double radius = 3.0;
  for (const int level : { 3, 4, 5 })
  {
    const TriangleMesh mesh = test::Icosphere(level, radius);
    const Eigen::VectorXd distances = GeodesicsOf(mesh).Distances({ 7 }).col(0);
    double worst = 0.0;
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      const double cosine = mesh.Points.row(v).dot(mesh.Points.row(7)) / (radius * radius);
      worst = std::max(worst, std::abs(distances[v] - radius * std::acos(std::clamp(cosine, -1.0, 1.0))));
    }
    const double edge = radius * 1.2 / (1 << level);
    EXPECT_LT(worst, edge) << "level " << level; // of the order of the edge length
    EXPECT_EQ(distances[7], 0.0);
  }
}

TEST(HeatGeodesics, DistancesInThePlaneAreEuclidean)
{
  const TriangleMesh mesh = test::PlanePatch(60, 60, 1.0, 1.0, 0.2);
  const Index center = 30 * 61 + 30;
  const Eigen::VectorXd distances = GeodesicsOf(mesh).Distances({ center }).col(0);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double exact = (mesh.Points.row(v) - mesh.Points.row(center)).norm();
    EXPECT_NEAR(distances[v], exact, 0.02 + 0.06 * exact) << "vertex " << v; // h = 1/60; the boundary attracts contours
  }
}

TEST(HeatGeodesics, DistancesScaleWithTheSurface)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const Eigen::VectorXd one = GeodesicsOf(mesh).Distances({ 0 }).col(0);
  for (const double factor : { 1e-9, 1e9 })
  {
    const Eigen::VectorXd scaled = GeodesicsOf(test::Scaled(mesh, factor)).Distances({ 0 }).col(0);
    EXPECT_LT((scaled / factor - one).norm(), 1e-8 * one.norm()) << factor;
  }
}

TEST(HeatGeodesics, FarFromTheSourceOfALongSurfaceDistancesAreStillRight)
{
  // 1,500 edge lengths long: the heat itself would be exp(-1500) at the end.
  const TriangleMesh mesh = test::OpenCylinder(12, 3000, 1.0, 1500.0);
  const Eigen::VectorXd distances = GeodesicsOf(mesh).Distances({ 0 }).col(0);
  Index farthest = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    farthest = distances[v] > distances[farthest] ? v : farthest;
  }
  EXPECT_NEAR(std::abs(mesh.Points(farthest, 2) - mesh.Points(0, 2)), 1500.0, 1e-9);
  EXPECT_NEAR(distances[farthest], 1500.0, 15.0);
}

TEST(HeatGeodesics, OtherComponentsAndUnusedPointsAreInfinitelyFar)
{
  const TriangleMesh sphere = test::Icosphere(2);
  const TriangleMesh both = test::WithUnreferencedPoints(
    test::Join(sphere, test::Translated(sphere, Eigen::Vector3d(5.0, 0.0, 0.0))));
  const HeatGeodesics geodesics = GeodesicsOf(both);
  const Index source = both.Triangles(0, 0);
  const Eigen::VectorXd distances = geodesics.Distances({ source }).col(0);
  for (Index v = 0; v < both.NumberOfPoints(); ++v)
  {
    const bool same = geodesics.Components().OfVertex[v] == geodesics.Components().OfVertex[source];
    EXPECT_EQ(std::isfinite(distances[v]), same) << v;
  }
}

TEST(HeatGeodesics, AColumnHasTheSameBitsAloneAndWithOthersAndForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const HeatGeodesics geodesics = GeodesicsOf(mesh);
  std::vector<Index> sources;
  for (Index v = 0; v < 70; ++v)
  {
    sources.push_back(3 * v);
  }
  const RowMatrix all = geodesics.Distances(sources);
  for (const int threads : { 1, 2, 5 })
  {
    const ThreadScope scope(threads);
    EXPECT_EQ(geodesics.Distances(sources), all) << threads;
    EXPECT_EQ(geodesics.Distances({ sources[41] }).col(0), all.col(41)) << threads;
  }
}

TEST(HeatGeodesics, RefusesSourcesThatAreNoVertices)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::Icosphere(1));
  const HeatGeodesics geodesics = GeodesicsOf(mesh);
  for (const Index source : { Index(-1), mesh.NumberOfPoints(), Index(0) }) // point 0 is not used
  {
    EXPECT_THROW(geodesics.Distances({ source }), InvalidInput) << source;
  }
}

TEST(GaussianMixtures, AMixtureOfOneIsAGaussianOfTheDistance)
{
  const TriangleMesh mesh = test::Icosphere(4);
  GaussianMixtureOptions options;
  options.NumberOfCenters = 1;
  const GaussianMixtures mixtures = MixturesOf(mesh, options);
  const Eigen::VectorXd values = Samples(mixtures, {}, mesh.NumberOfPoints()).col(0);
  Eigen::Index center = 0;
  EXPECT_EQ(values.maxCoeff(&center), 1.0);
  const Eigen::VectorXd distances = GeodesicsOf(mesh).Distances({ static_cast<Index>(center) }).col(0);
  const double sigma = mixtures.StandardDeviation();
  EXPECT_NEAR(sigma, 0.08 * std::sqrt(4.0 * std::acos(-1.0)), 2e-3);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_NEAR(values[v], std::exp(-0.5 * distances[v] * distances[v] / (sigma * sigma)), 1e-14);
  }
}

TEST(GaussianMixtures, CentersKeepTheirSeparation)
{
  const TriangleMesh mesh = test::BumpySurface(4);
  const GaussianMixtures mixtures = MixturesOf(mesh);
  GaussianMixtureRequest request;
  request.NumberOfSamples = 50;
  const Eigen::MatrixXd values = Samples(mixtures, request, mesh.NumberOfPoints());
  const HeatGeodesics geodesics = GeodesicsOf(mesh);
  for (Eigen::Index k = 0; k < values.cols(); ++k)
  {
    std::vector<Index> centers; // at least 1 there, and at four sigma the others add less than 1e-3 each
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      if (values(v, k) >= 1.0)
      {
        centers.push_back(v);
      }
    }
    ASSERT_EQ(centers.size(), 3u) << "sample " << k;
    const RowMatrix distances = geodesics.Distances(centers);
    for (int i = 0; i < 3; ++i)
    {
      // The distance from the later centre to the earlier one may differ a little from that in the other direction.
      const double other = distances(centers[i], (i + 1) % 3);
      const double back = distances(centers[(i + 1) % 3], i);
      EXPECT_GE(std::max(other, back), 4.0 * mixtures.StandardDeviation()) << "sample " << k;
    }
  }
}

TEST(GaussianMixtures, CentersAreUniformOnTheSurfaceWhateverTheTriangulation)
{
  // A sphere with most of its points near the north pole: the mean height of centres is still 0.
  const TriangleMesh mesh = test::LocallyRefinedSphere(3);
  GaussianMixtureOptions options;
  options.NumberOfCenters = 1;
  options.Width = 0.005;
  const GaussianMixtures mixtures = MixturesOf(mesh, options);
  GaussianMixtureRequest request;
  request.NumberOfSamples = 2000;
  const Eigen::MatrixXd values = Samples(mixtures, request, mesh.NumberOfPoints());
  double height = 0.0;
  double northern = 0.0;
  for (Eigen::Index k = 0; k < values.cols(); ++k)
  {
    Eigen::Index center = 0;
    values.col(k).maxCoeff(&center);
    height += mesh.Points(center, 2) / 2000.0;
    northern += mesh.Points(center, 2) > 0.8 ? 1.0 / 2000.0 : 0.0;
  }
  EXPECT_NEAR(height, 0.0, 0.04);   // deviation of the mean 0.577 / sqrt(2000) = 0.013, and coarse triangles
  EXPECT_NEAR(northern, 0.1, 0.02); // the cap has a tenth of the area and most of the points
  EXPECT_GT((mesh.Points.col(2).array() > 0.8).count(), mesh.NumberOfPoints() / 2);
}

TEST(GaussianMixtures, ASampleIsTheSameAloneAndInABatch)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const GaussianMixtures mixtures = MixturesOf(mesh);
  GaussianMixtureRequest request;
  request.Seed = 11;
  request.NumberOfSamples = 100;
  const Eigen::MatrixXd all = Samples(mixtures, request, mesh.NumberOfPoints());
  EXPECT_NE(all.col(0), all.col(1));
  for (const int threads : { 1, 3 })
  {
    const ThreadScope scope(threads);
    EXPECT_EQ(Samples(mixtures, request, mesh.NumberOfPoints()), all);
    GaussianMixtureRequest one = request;
    one.FirstSample = 77;
    one.NumberOfSamples = 1;
    EXPECT_EQ(Samples(mixtures, one, mesh.NumberOfPoints()).col(0), all.col(77));
  }
  request.Seed = 12;
  EXPECT_NE(Samples(mixtures, request, mesh.NumberOfPoints()).col(0), all.col(0));
}

TEST(GaussianMixtures, OtherComponentsAndUnusedPointsGet0)
{
  const TriangleMesh sphere = test::Icosphere(2);
  const TriangleMesh both = test::WithUnreferencedPoints(
    test::Join(sphere, test::Translated(sphere, Eigen::Vector3d(5.0, 0.0, 0.0))));
  GaussianMixtureOptions options;
  options.NumberOfCenters = 1;
  const Eigen::VectorXd values = Samples(MixturesOf(both, options), {}, both.NumberOfPoints()).col(0);
  Eigen::Index center = 0;
  values.maxCoeff(&center);
  const bool first = both.Points(center, 0) < 2.5;
  for (Index v = 0; v < both.NumberOfPoints(); ++v)
  {
    const bool same = (both.Points(v, 0) < 2.5) == first;
    EXPECT_TRUE(same || values[v] == 0.0) << v;
  }
  const MeshComponents parts = GeodesicsOf(both).Components();
  EXPECT_EQ(parts.OfVertex[0], -1);
  EXPECT_EQ(values[0], 0.0);
}

TEST(GaussianMixtures, ATinyWidthGivesASingleValueOfOne)
{
  const TriangleMesh mesh = test::Icosphere(2);
  GaussianMixtureOptions options;
  options.NumberOfCenters = 1;
  options.Width = 1e-160; // its square is 0 in double precision
  const Eigen::VectorXd values = Samples(MixturesOf(mesh, options), {}, mesh.NumberOfPoints()).col(0);
  EXPECT_EQ(values.maxCoeff(), 1.0);
  EXPECT_EQ(values.sum(), 1.0) << "NaN, or values beside the center";
}

TEST(GaussianMixtures, SaysWhenThereIsNoRoomForTheCenters)
{
  const TriangleMesh mesh = test::Icosphere(2);
  GaussianMixtureOptions options;
  options.Width = 1.0;
  const GaussianMixtures mixtures = MixturesOf(mesh, options);
  try
  {
    Samples(mixtures, {}, mesh.NumberOfPoints());
    FAIL() << "no exception";
  }
  catch (const InvalidInput& error)
  {
    EXPECT_NE(std::string(error.what()).find("no vertex is left"), std::string::npos) << error.what();
  }
  options.NumberOfCenters = 0;
  EXPECT_THROW(MixturesOf(mesh, options), InvalidInput);
  options = {};
  options.Width = std::numeric_limits<double>::infinity();
  EXPECT_THROW(MixturesOf(mesh, options), InvalidInput);
  options = {};
  options.Separation = -1.0;
  EXPECT_THROW(MixturesOf(mesh, options), InvalidInput);
}

TEST(GaussianMixtures, StopsOnRequest)
{
  const TriangleMesh mesh = test::Icosphere(3);
  const GaussianMixtures mixtures = MixturesOf(mesh);
  GaussianMixtureRequest request;
  request.NumberOfSamples = 1000;
  Eigen::MatrixXd values(mesh.NumberOfPoints(), 1000);
  Eigen::Index column = 0;
  EXPECT_THROW(mixtures.SampleInto(
                 request, [&](std::uint32_t) { return values.col(column++).data(); },
                 [](double fraction) { return fraction < 0.3; }),
    Cancelled);
  EXPECT_LT(column, 1000);
}
