// SPDX-License-Identifier: BSD-3-Clause
// The distance of the edge features of two meshes: shifts by hand, invariances, growth with roughness, refusals.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Statistics/GeometricTextureDistance.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{
EdgeFeatureMatrix RandomFeatures(Eigen::Index rows, std::uint64_t seed)
{
  EdgeFeatureMatrix features(rows, 12);
  for (Eigen::Index k = 0; k < features.size(); ++k)
  {
    features.data()[k] = static_cast<float>(test::Uniform(seed, static_cast<std::uint64_t>(k)));
  }
  return features;
}

/// @p mesh with its points moved off by up to @p amplitude along each axis.
TriangleMesh Roughened(TriangleMesh mesh, double amplitude, std::uint64_t seed)
{
  for (Eigen::Index k = 0; k < mesh.Points.size(); ++k)
  {
    mesh.Points.data()[k] += amplitude * (2.0 * test::Uniform(seed, static_cast<std::uint64_t>(k)) - 1.0);
  }
  return mesh;
}

/// Each triangle begins with another corner than before, and they come in the opposite order.
TriangleMesh Renumbered(TriangleMesh mesh)
{
  const TriangleMatrix given = mesh.Triangles;
  for (Eigen::Index f = 0; f < given.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      mesh.Triangles(f, k) = given(given.rows() - 1 - f, (k + 1 + f % 2) % 3);
    }
  }
  return mesh;
}

double Distance(const TriangleMesh& a, const TriangleMesh& b, const GeometricTextureDistanceOptions& options = {})
{
  return CompareGeometricTextures(a, b, options).Distance;
}

std::string MessageOf(const TriangleMesh& a, const TriangleMesh& b, const GeometricTextureDistanceOptions& options = {})
{
  try
  {
    CompareGeometricTextures(a, b, options);
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "";
}
} // namespace

TEST(TextureDistance, OfAShiftIsItsLengthAlongEachDirection)
{
  // The same shift for all three edges, so that the order of the edges does not matter; half as many triangles twice.
  const EdgeFeatureMatrix features = RandomFeatures(200, 1);
  Eigen::RowVector4f ofEdge(0.5F, -0.25F, 1.0F, 2.0F);
  Eigen::Matrix<float, 1, 12> shift;
  shift << ofEdge, ofEdge, ofEdge;
  EdgeFeatureMatrix shifted(400, 12);
  shifted << features, features;
  shifted.rowwise() += shift;
  const int directions = 20000;
  const Eigen::VectorXd distances = SlicedDistances(shifted, features, directions, 3);
  // Gamma(6) / (sqrt(pi) Gamma(6.5)) is the mean of |x_1| on the unit sphere of R^12, 1 / 12 that of x_1^2.
  const double mean = std::tgamma(6.0) / (std::sqrt(M_PI) * std::tgamma(6.5)) * shift.norm();
  const double deviation = std::sqrt(shift.squaredNorm() / 12.0 - mean * mean);
  EXPECT_NEAR(distances.mean(), mean, 4.0 * deviation / std::sqrt(directions));
  const double found = std::sqrt((distances.array() - distances.mean()).square().mean());
  EXPECT_NEAR(found, deviation, 0.02 * deviation);
}

TEST(TextureDistance, OfTwoAndThreeTrianglesIsAsByHand)
{
  // All features are 0 or u = (1, ..., 1) in any order of the edges. Quantiles of {0, u} and {0, 0, u} differ for t
  // from 1/2 to 2/3, by what u is long along the direction.
  EdgeFeatureMatrix two = EdgeFeatureMatrix::Zero(2, 12);
  EdgeFeatureMatrix three = EdgeFeatureMatrix::Zero(3, 12);
  EdgeFeatureMatrix none = EdgeFeatureMatrix::Zero(1, 12);
  two.row(1).setOnes();
  three.row(2).setOnes();
  const Eigen::VectorXd whole = SlicedDistances(EdgeFeatureMatrix::Ones(1, 12), none, 50, 7);
  const Eigen::VectorXd distances = SlicedDistances(two, three, 50, 7);
  ASSERT_GT(whole.minCoeff(), 0.0);
  EXPECT_LT((distances - whole / 6.0).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(TextureDistance, OfAMeshFromItselfIsZero)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  const TextureDistance distance = CompareGeometricTextures(mesh, mesh);
  EXPECT_EQ(distance.Distance, 0.0);
  EXPECT_EQ(distance.StandardError, 0.0);
}

TEST(TextureDistance, DoesNotChangeUnderMotionsAndScales)
{
  const TriangleMesh mesh = Roughened(test::Torus(40, 20), 0.03, 1);
  const TriangleMesh other = test::IrregularSphere(3);
  TriangleMesh moved = mesh;
  const auto rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  moved.Points = (1e3 * mesh.Points * rotation.transpose()).rowwise() + Eigen::RowVector3d(1e6, -2e6, 3e5);
  EXPECT_LT(Distance(mesh, moved), 1e-4); // 1e-10 of the offset is 1e-4 of an edge
  EXPECT_NEAR(Distance(moved, other), Distance(mesh, other), 1e-5);
}

TEST(TextureDistance, DoesNotDependOnNumbersOfTrianglesAndCorners)
{
  const TriangleMesh mesh = Roughened(test::Icosphere(3), 0.02, 2);
  EXPECT_LT(Distance(Renumbered(mesh), mesh), 1e-5);
  // A mesh twice has every quantile of the mesh.
  EXPECT_LT(Distance(test::Join(mesh, test::Translated(mesh, { 5.0, 0.0, 0.0 })), mesh), 1e-5);
}

TEST(TextureDistance, TrianglesOnABoundaryDoNotCount)
{
  // Inside, planes of equal triangles look alike, however much of them a boundary cuts.
  GeometricTextureDistanceOptions options;
  options.UnitLength = 1.0 / 12.0;
  options.ReferenceUnitLength = 1.0 / 4.0;
  EXPECT_NEAR(Distance(test::PlanePatch(12, 12), test::PlanePatch(4, 4), options), 0.0, 1e-5);
  options = {};
  const TriangleMesh triangle = test::SingleTriangle();
  EXPECT_EQ(Distance(triangle, triangle), 0.0) << "all lie on the boundary";
  EXPECT_GT(Distance(triangle, test::PlanePatch(4, 4)), 0.01) << "and count";
}

TEST(TextureDistance, IsSymmetricAndTellsAMirrorImage)
{
  const TriangleMesh mesh = Roughened(test::Icosphere(3), 0.05, 4);
  const TriangleMesh other = test::Torus(40, 20);
  EXPECT_NEAR(Distance(mesh, other), Distance(other, mesh), 1e-7);
  // Planks that overlap like shingles: each pair of triangles rises along x, in a mirror along -x.
  TriangleMesh shingles = test::PlanePatch(30, 30, 30.0, 30.0);
  for (Eigen::Index p = 0; p < shingles.Points.rows(); ++p)
  {
    shingles.Points(p, 2) = 0.3 * std::fmod(shingles.Points(p, 0) + 2.0 * shingles.Points(p, 1), 5.0);
  }
  TriangleMesh mirrored = shingles;
  mirrored.Points.col(0) *= -1.0;
  mirrored.Triangles.col(1).swap(mirrored.Triangles.col(2));
  EXPECT_GT(Distance(shingles, mirrored), 0.01);
}

TEST(TextureDistance, GrowsWithTheDifferenceInRoughness)
{
  const TriangleMesh smooth = SubdivideAtMidpoints(test::Icosphere(3)).Mesh;
  const TriangleMesh rough = Roughened(smooth, 0.02, 1);
  const double another = Distance(Roughened(smooth, 0.02, 2), rough);
  const double half = Distance(Roughened(smooth, 0.01, 3), rough);
  const double none = Distance(smooth, rough);
  EXPECT_LT(10.0 * another, half);
  EXPECT_LT(1.5 * half, none);
}

TEST(TextureDistance, UnitLengthsAreWhatLengthsAreMeasuredIn)
{
  const TriangleMesh mesh = test::IrregularSphere(3);
  const TextureDistance own = CompareGeometricTextures(mesh, test::Scaled(mesh, 2.0));
  EXPECT_LT(own.Distance, 1e-6);
  EXPECT_NEAR(own.ReferenceMeanEdgeLength, 2.0 * own.MeanEdgeLength, 1e-12);
  GeometricTextureDistanceOptions options;
  options.UnitLength = options.ReferenceUnitLength = own.MeanEdgeLength;
  const double doubled = Distance(mesh, test::Scaled(mesh, 2.0), options);
  options.ReferenceUnitLength = 2.0 * own.MeanEdgeLength;
  EXPECT_LT(Distance(mesh, test::Scaled(mesh, 2.0), options), 1e-6);
  // Features of the doubled mesh are twice those of the mesh; with half the unit both are twice as long.
  options.UnitLength = options.ReferenceUnitLength = 0.5 * own.MeanEdgeLength;
  EXPECT_NEAR(Distance(mesh, test::Scaled(mesh, 2.0), options), 2.0 * doubled, 1e-5 * doubled);
  EXPECT_GT(doubled, 0.1);
}

TEST(TextureDistance, MeanEdgeLengthCountsEachEdgeOnce)
{
  // A square with one diagonal: four sides of 1, and sqrt 2.
  const TextureDistance distance = CompareGeometricTextures(test::PlanePatch(1, 1), test::SingleTriangle());
  EXPECT_NEAR(distance.MeanEdgeLength, (4.0 + std::sqrt(2.0)) / 5.0, 1e-12);
  EXPECT_NEAR(distance.ReferenceMeanEdgeLength, (3.0 + std::sqrt(5.0)) / 3.0, 1e-12);
}

TEST(TextureDistance, StandardErrorIsThatOfTheDirections)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  const TriangleMesh other = test::Torus(20, 10);
  GeometricTextureDistanceOptions options;
  options.Projections = 4000;
  const TextureDistance many = CompareGeometricTextures(mesh, other, options);
  double squares = 0.0;
  options.Projections = 50;
  const int repeats = 40;
  double expected = 0.0;
  for (int k = 0; k < repeats; ++k)
  {
    options.Seed = static_cast<std::uint64_t>(k + 1);
    const TextureDistance few = CompareGeometricTextures(mesh, other, options);
    squares += std::pow(few.Distance - many.Distance, 2);
    expected += few.StandardError * few.StandardError;
  }
  EXPECT_NEAR(std::sqrt(squares / expected), 1.0, 0.4); // the relative error of a deviation of 40 numbers is 0.11
}

TEST(TextureDistance, IsTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = Roughened(test::Icosphere(4), 0.01, 1);
  const TriangleMesh other = test::Torus(60, 30);
  const ThreadScope one(1);
  const double expected = Distance(mesh, other);
  for (const int threads : { 2, 3, 4 })
  {
    const ThreadScope scope(threads);
    EXPECT_EQ(Distance(mesh, other), expected);
  }
}

TEST(RingFeatures, OfARidgeAreAsByHand)
{
  // A plane grid whose row y = 3 is raised by 1: seen from the middle of that row, whose neighborhood is symmetric under
  // half a turn, the normal is z.
  TriangleMesh mesh = test::PlanePatch(6, 6, 6.0, 6.0);
  Index center = -1;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double y = mesh.Points(v, 1);
    center = mesh.Points(v, 0) == 3.0 && y == 3.0 ? v : center;
    mesh.Points(v, 2) = y == 3.0 ? 1.0 : 0.0;
  }
  ASSERT_GE(center, 0);
  const RingFeatureMatrix features = ComputeRingFeatures(mesh, MeshTopology(mesh), 3);
  ASSERT_EQ(features.rows(), 1) << "the rings of the middle alone are whole";
  // Ring 1, of eight vertices where diagonals alternate: (+-1, 0) at height 0, the others at height -1.
  Eigen::Matrix<float, 1, 6> expected;
  expected << -1.0F, -1.0F, -1.0F, -0.75F, 0.0F, (4.0F + 4.0F * std::sqrt(2.0F)) / 8.0F;
  EXPECT_LT((features.row(0).head(6) - expected).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(RingFeatures, OfSmallMeshesRepeatTheLastRing)
{
  const TriangleMesh mesh = test::Tetrahedron();
  const RingFeatureMatrix features = ComputeRingFeatures(mesh, MeshTopology(mesh), 3);
  ASSERT_EQ(features.rows(), 4);
  EXPECT_EQ(features.leftCols(6), features.rightCols(6));
  const TriangleMesh open = test::SingleTriangle();
  EXPECT_EQ(ComputeRingFeatures(open, MeshTopology(open), 2).rows(), 3) << "all are cut";
  const TriangleMesh unused = test::WithUnreferencedPoints(test::Icosphere(1));
  EXPECT_EQ(ComputeRingFeatures(unused, MeshTopology(unused), 2).rows(), 42);
}

namespace
{
/// Cones of @p height around @p count points of a spiral on the unit sphere; @p pairs moves them together two by two.
TriangleMesh Spikes(int count, double height, bool pairs)
{
  TriangleMesh mesh = test::Icosphere(5);
  std::vector<Eigen::RowVector3d> centers;
  for (int k = 0; k < count; ++k)
  {
    const double z = 1.0 - (2.0 * k + 1.0) / count, radius = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * k;
    Eigen::RowVector3d center(radius * std::cos(angle), radius * std::sin(angle), z);
    if (pairs && k % 2 == 1)
    {
      center = (center + 4.0 * centers.back()).normalized();
    }
    centers.push_back(center);
  }
  for (Eigen::Index v = 0; v < mesh.Points.rows(); ++v)
  {
    double angle = M_PI;
    for (const Eigen::RowVector3d& center : centers)
    {
      angle = std::min(angle, std::acos(std::clamp(center.dot(mesh.Points.row(v)), -1.0, 1.0)));
    }
    mesh.Points.row(v) *= 1.0 + height * std::max(0.0, 1.0 - angle / 0.17);
  }
  return mesh;
}
} // namespace

TEST(TextureDistance, OfRingsTellsWrongTexturesApart)
{
  const TriangleMesh reference = Spikes(90, 0.2, false);
  TriangleMesh turned = reference;
  turned.Points = reference.Points * Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  GeometricTextureDistanceOptions options;
  options.UnitLength = options.ReferenceUnitLength = CompareGeometricTextures(reference, reference).MeanEdgeLength;
  for (const int rings : { 3, 6 })
  {
    options.Rings = rings;
    EXPECT_LT(Distance(turned, reference, options), 1e-5);
    EXPECT_LT(Distance(Renumbered(reference), reference, options), 1e-5);
    const double floor = Distance(Spikes(91, 0.2, false), reference, options);
    const double bare = Distance(test::Icosphere(5), reference, options) - floor;
    ASSERT_GT(bare, 10.0 * floor);
    // Merged, sparse and stunted controls fail the bound of 0.15 that a good texture is to meet.
    EXPECT_GT((Distance(Spikes(90, 0.2, true), reference, options) - floor) / bare, 0.15);
    EXPECT_GT((Distance(Spikes(45, 0.2, false), reference, options) - floor) / bare, 0.15);
    EXPECT_GT((Distance(Spikes(90, 0.1, false), reference, options) - floor) / bare, 0.15);
    const double expected = Distance(Spikes(45, 0.2, false), reference, options);
    for (const int threads : { 1, 3 })
    {
      const ThreadScope scope(threads);
      EXPECT_EQ(Distance(Spikes(45, 0.2, false), reference, options), expected);
    }
  }
}

TEST(TextureDistance, RefusesWhatItCannotCompare)
{
  const TriangleMesh mesh = test::Icosphere(1);
  EXPECT_THAT(MessageOf({}, mesh), HasSubstr("the surface has no triangle"));
  EXPECT_THAT(MessageOf(mesh, {}), HasSubstr("the reference has no triangle"));
  GeometricTextureDistanceOptions options;
  options.Projections = 0;
  EXPECT_THAT(MessageOf(mesh, mesh, options), HasSubstr("there are 0 projections"));
  options = {};
  options.Rings = 17;
  EXPECT_THAT(MessageOf(mesh, mesh, options), HasSubstr("there are 17 rings; expected 1 to 16"));
  options = {};
  options.ReferenceUnitLength = -1.0;
  EXPECT_THAT(MessageOf(mesh, mesh, options), HasSubstr("the unit length of the reference is -1"));
  options.ReferenceUnitLength = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(MessageOf(mesh, mesh, options), HasSubstr("the unit length of the reference is nan"));
  options.ReferenceUnitLength = 1e-35;
  EXPECT_THAT(MessageOf(mesh, mesh, options), HasSubstr("features that are not finite or above 1e+30"));
  TriangleMesh broken = mesh;
  broken.Points(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(MessageOf(broken, mesh), HasSubstr("features that are not finite"));
  options = {};
  options.Rings = 3;
  EXPECT_THAT(MessageOf(broken, mesh, options), HasSubstr("features that are not finite"));
}

TEST(TextureDistance, StopsWhenAsked)
{
  const TriangleMesh mesh = test::Icosphere(2);
  EXPECT_THROW(CompareGeometricTextures(mesh, mesh, {}, [](double done) { return done < 0.5; }), Cancelled);
}
