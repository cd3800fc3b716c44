// SPDX-License-Identifier: BSD-3-Clause
// Logarithm maps of one-rings, parallel transport and samples of rings: on planes, cones, cylinders and spheres, at
// boundaries, under renumbering, turned frames and bending.
#include "ExampleMeshes.h"
#include "ThrownText.h"

#include "Core/Common/Parallel.h"
#include "Core/Tangent/OneRings.h"
#include "Core/Tangent/RingSamples.h"
#include "Core/Tangent/TangentNoise.h"
#include "Core/Tangent/TangentVectors.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::HasSubstr;

namespace
{
using Complex = std::complex<double>;
constexpr double Pi = 3.14159265358979323846;

VertexFrames Frames(const TriangleMesh& mesh) { return TangentFrames(mesh, MeshTopology(mesh)); }

Eigen::VectorXd RandomAngles(Index count)
{
  Eigen::VectorXd angles(count);
  for (Index v = 0; v < count; ++v)
  {
    angles[v] = Pi * test::Uniform(7, static_cast<std::uint64_t>(v));
  }
  return angles;
}

/// Place of the edge from @p v to @p w in the tables.
Index EdgeOf(const OneRings& rings, Index v, Index w)
{
  const auto row = rings.Neighbors.begin();
  const auto found = std::lower_bound(row + rings.NeighborStart[v], row + rings.NeighborStart[v + 1], w);
  return static_cast<Index>(found - row);
}

Complex TransportAlong(const OneRings& rings, const std::vector<Index>& walk)
{
  Complex product = 1.0;
  for (std::size_t k = 0; k < walk.size(); ++k)
  {
    product *= rings.Transport[EdgeOf(rings, walk[k], walk[(k + 1) % walk.size()])];
  }
  return product;
}

/// Transport around each triangle, counter-clockwise.
double LargestTriangleHolonomy(const OneRings& rings, const TriangleMesh& mesh)
{
  double largest = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    largest = std::max(largest, std::abs(std::arg(TransportAlong(rings, { t(0), t(1), t(2) }))));
  }
  return largest;
}

/// Cone of the total angle @p total at its apex, vertex 0, from flat faces: @p rings polygons of @p segments corners around
/// the apex. Vertices 1 + ring * segments + segment.
TriangleMesh Cone(double total, int segments, int rings)
{
  // The chord of a face at distance 1 from the apex is that of a polygon around the axis.
  const double radius = std::sin(0.5 * total / segments) / std::sin(Pi / segments);
  const double height = std::sqrt(1.0 - radius * radius);
  TriangleMesh mesh;
  mesh.Points = PointMatrix::Zero(1 + segments * rings, 3);
  std::vector<Index> ids;
  const auto id = [&](int ring, int segment) { return 1 + ring * segments + segment % segments; };
  for (int ring = 0; ring < rings; ++ring)
  {
    const double distance = 1.0 + 0.7 * ring;
    for (int s = 0; s < segments; ++s)
    {
      const double angle = 2.0 * Pi * s / segments;
      mesh.Points.row(id(ring, s)) << distance * radius * std::cos(angle), distance * radius * std::sin(angle),
        -distance * height;
      if (ring == 0)
      {
        ids.insert(ids.end(), { 0, id(0, s), id(0, s + 1) });
        continue;
      }
      ids.insert(ids.end(), { id(ring - 1, s), id(ring, s), id(ring, s + 1) });
      ids.insert(ids.end(), { id(ring - 1, s), id(ring, s + 1), id(ring - 1, s + 1) });
    }
  }
  mesh.Triangles = Eigen::Map<TriangleMatrix>(ids.data(), static_cast<Eigen::Index>(ids.size()) / 3, 3);
  return mesh;
}

/// Plane patch with rows of vertices at random heights; columns stay straight. Bent about them by @p bend radians each.
TriangleMesh BentPatch(int columns, int rows, double bend)
{
  TriangleMesh mesh = test::PlanePatch(columns, rows, columns, rows);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const int column = static_cast<int>(std::lround(mesh.Points(v, 0)));
    double x = 0.0;
    double z = 0.0;
    for (int k = 0; k < column; ++k)
    {
      x += std::cos(bend * k);
      z += std::sin(bend * k);
    }
    const double y = mesh.Points(v, 1) + 0.3 * test::Uniform(3, static_cast<std::uint64_t>(v));
    mesh.Points.row(v) << x, y, z;
  }
  return mesh;
}

/// @p mesh with vertex v renamed to (v stride + 1) mod V, triangles in reverse order, their corners rotated.
TriangleMesh Renumbered(const TriangleMesh& mesh, std::vector<Index>& newId)
{
  const Index points = mesh.NumberOfPoints();
  Index stride = points / 2 + 1;
  while (std::gcd(stride, points) != 1)
  {
    ++stride;
  }
  TriangleMesh renumbered = mesh;
  newId.resize(static_cast<std::size_t>(points));
  for (Index v = 0; v < points; ++v)
  {
    newId[v] = static_cast<Index>((std::int64_t(v) * stride + 1) % points);
    renumbered.Points.row(newId[v]) = mesh.Points.row(v);
  }
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      renumbered.Triangles(mesh.NumberOfTriangles() - 1 - f, k) = newId[mesh.Triangles(f, (k + f) % 3)];
    }
  }
  return renumbered;
}

/// @p frames under the ids of the renumbered mesh: at symmetric rings, rounding decides on the axis of TangentFrames().
VertexFrames Renumbered(const VertexFrames& frames, const std::vector<Index>& newId)
{
  VertexFrames renumbered = frames;
  for (std::size_t v = 0; v < newId.size(); ++v)
  {
    const auto row = static_cast<Eigen::Index>(v);
    renumbered.X.row(newId[v]) = frames.X.row(row);
    renumbered.Y.row(newId[v]) = frames.Y.row(row);
    renumbered.Normal.row(newId[v]) = frames.Normal.row(row);
  }
  return renumbered;
}

/// Largest difference of the neighbors' logarithms, each vertex of the second turned by the best angle.
double DifferenceUpToTurns(const OneRings& a, const OneRings& b, Eigen::VectorXcd& turns)
{
  turns = Eigen::VectorXcd::Ones(a.NumberOfPoints());
  double largest = 0.0;
  for (Index v = 0; v < a.NumberOfPoints(); ++v)
  {
    const Index first = a.NeighborStart[v];
    const Index count = a.NeighborStart[v + 1] - first;
    const auto one = a.NeighborLogarithms.segment(first, count);
    const auto other = b.NeighborLogarithms.segment(first, count);
    turns[v] = other.dot(one) / std::abs(other.dot(one));
    largest = std::max(largest, (one - turns[v] * other).cwiseAbs().maxCoeff());
  }
  return largest;
}
} // namespace

TEST(TangentVectors, ComplexNumbersAndVectorsAreInverse)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  const VertexFrames frames = Frames(mesh);
  const Eigen::VectorXcd z = Eigen::VectorXcd::Random(mesh.NumberOfPoints());
  const PointMatrix vectors = FromTangent(frames, z);
  EXPECT_LE((vectors.cwiseProduct(frames.Normal).rowwise().sum()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((ToTangent(frames, vectors) - z).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE(ToTangent(frames, frames.Normal).cwiseAbs().maxCoeff(), 1e-14);
  const Eigen::VectorXd angles = RandomAngles(mesh.NumberOfPoints());
  const Eigen::VectorXcd turned = ToTangent(TurnedFrames(frames, angles), vectors);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_LE(std::abs(turned[v] - std::polar(1.0, -angles[v]) * z[v]), 1e-14);
  }
  EXPECT_THAT(MessageOf([&] { ToTangent(frames, PointMatrix::Zero(3, 3)); }), HasSubstr("ToTangent: 3 rows"));
  EXPECT_THAT(MessageOf([&] { FromTangent(frames, z.head(2)); }), HasSubstr("FromTangent: 2 rows"));
}

TEST(OneRings, LogarithmsInAPlaneAreDifferencesAndTransportChangesNothing)
{
  const TriangleMesh mesh = test::PlanePatch(9, 7, 2.0, 1.5, 0.2);
  const OneRings rings(mesh);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
    {
      const Index w = rings.Neighbors[k];
      const Eigen::RowVector3d edge = mesh.Points.row(w) - mesh.Points.row(v);
      const Complex difference(edge.dot(rings.Frames.X.row(v)), edge.dot(rings.Frames.Y.row(v)));
      EXPECT_LE(std::abs(rings.NeighborLogarithms[k] - difference), 1e-14);
      // A vector of the plane has the same components in both frames, up to the turn between them.
      const Eigen::RowVector3d x = rings.Frames.X.row(v);
      const Complex carried(x.dot(rings.Frames.X.row(w)), x.dot(rings.Frames.Y.row(w)));
      EXPECT_LE(std::abs(rings.Transport[k] - carried), 1e-12);
    }
  }
  EXPECT_LE(LargestTriangleHolonomy(rings, mesh), 1e-12);
}

TEST(OneRings, LogarithmsOfPlacesInAPlaneAreDifferences)
{
  const TriangleMesh mesh = test::PlanePatch(6, 5, 2.0, 1.5, 0.2);
  const OneRings rings(mesh);
  std::vector<SurfacePlace> places;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    places.push_back({ f, Eigen::Vector3d(0.2, 0.5, 0.3) });
    places.push_back({ f, Eigen::Vector3d(0.0, 1.0, 0.0) });
    places.push_back({ f, Eigen::Vector3d(1.2, -0.3, 0.1) });
  }
  places.emplace_back();
  std::vector<Complex> logs(3 * places.size());
  rings.CornerLogarithms(places.data(), static_cast<std::int64_t>(places.size()), logs.data());
  for (std::size_t q = 0; q + 1 < places.size(); ++q)
  {
    const auto t = mesh.Triangles.row(places[q].Triangle);
    Eigen::RowVector3d at = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k)
    {
      at += places[q].Weights[k] * mesh.Points.row(t(k));
    }
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::RowVector3d from = at - mesh.Points.row(t(k));
      const Complex difference(from.dot(rings.Frames.X.row(t(k))), from.dot(rings.Frames.Y.row(t(k))));
      EXPECT_LE(std::abs(logs[3 * q + k] - difference), 1e-13);
    }
  }
  EXPECT_EQ(logs.back(), Complex(0.0));
  places[4].Triangle = 100000;
  EXPECT_THAT(MessageOf([&] { rings.CornerLogarithms(places.data(), 5, logs.data()); }), HasSubstr("place 4 lies in"));
}

TEST(OneRings, AConeIsFlatAwayFromItsApexAndTurnsVectorsAroundIt)
{
  for (const double total : { 1.4 * Pi, 1.9 * Pi, 0.5 * Pi })
  {
    const int segments = 7;
    const TriangleMesh cone = Cone(total, segments, 3);
    const OneRings rings(cone);
    ASSERT_NEAR(rings.TotalAngles[0], total, 1e-12);
    for (Index f = segments; f < cone.NumberOfTriangles(); ++f)
    {
      const auto t = cone.Triangles.row(f);
      EXPECT_NEAR(std::arg(TransportAlong(rings, { t(0), t(1), t(2) })), 0.0, 1e-12);
    }
    // Around the apex vectors turn by its curvature, 2 pi - total, along each loop; its triangles have equal parts.
    for (const Index first : { 1, 1 + segments })
    {
      std::vector<Index> loop(segments);
      std::iota(loop.begin(), loop.end(), first);
      EXPECT_LE(std::abs(TransportAlong(rings, loop) - std::polar(1.0, 2.0 * Pi - total)), 1e-12);
    }
    EXPECT_NEAR(std::arg(TransportAlong(rings, { 0, 1, 2 })), (2.0 * Pi - total) / segments, 1e-12);
    // The logarithms of the apex are a regular polygon: rescaled angles are equal.
    for (Index k = 0; k < segments; ++k)
    {
      const Complex ratio = rings.NeighborLogarithms[(k + 1) % segments] / rings.NeighborLogarithms[k];
      EXPECT_LE(std::abs(ratio - std::polar(1.0, 2.0 * Pi / segments)), 1e-12);
    }
  }
}

TEST(OneRings, PlacesOfAConeHaveItsPolarCoordinates)
{
  const double total = 1.3 * Pi;
  const int segments = 5;
  const OneRings rings(Cone(total, segments, 2));
  for (const double share : { 0.1, 0.5, 0.8 })
  {
    // The point of the unit-chord a-b at this share, in the plane of the face.
    const double angle = total / segments;
    const Complex a = 1.0;
    const Complex b = std::polar(1.0, angle);
    const Complex q = 0.6 * ((1.0 - share) * a + share * b);
    const SurfacePlace place{ 0, Eigen::Vector3d(0.4, 0.6 * (1.0 - share), 0.6 * share) };
    Complex logs[3];
    rings.CornerLogarithms(&place, 1, logs);
    const Complex expected = std::polar(std::abs(q), std::arg(q) * 2.0 * Pi / total);
    EXPECT_LE(std::abs(logs[0] / rings.NeighborLogarithms[0] - expected), 1e-12);
    const SurfacePlace atB{ 0, Eigen::Vector3d(0.0, 0.0, 1.0) };
    rings.CornerLogarithms(&atB, 1, logs);
    EXPECT_LE(std::abs(logs[0] - rings.NeighborLogarithms[1]), 1e-14);
    EXPECT_EQ(logs[2], Complex(0.0));
  }
}

TEST(OneRings, BendingTurnsTheLogarithmsOfAVertexAlike)
{
  const OneRings flat(BentPatch(8, 6, 0.0));
  const OneRings bent(BentPatch(8, 6, 0.4));
  Eigen::VectorXcd turns;
  EXPECT_LE(DifferenceUpToTurns(flat, bent, turns), 1e-13);
  for (Index v = 0; v < flat.NumberOfPoints(); ++v)
  {
    for (Index k = flat.NeighborStart[v]; k < flat.NeighborStart[v + 1]; ++k)
    {
      const Complex turned = turns[flat.Neighbors[k]] * bent.Transport[k] * std::conj(turns[v]);
      EXPECT_LE(std::abs(flat.Transport[k] - turned), 1e-12);
    }
  }
  EXPECT_LE((flat.Areas - bent.Areas).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(OneRings, FramesTurnTheLogarithmsTheOppositeWay)
{
  for (const TriangleMesh& mesh : { test::IrregularSphere(2), test::PlanePatch(5, 5, 1.0, 1.0, 0.2), Cone(4.0, 6, 2) })
  {
    const MeshTopology topology(mesh);
    const VertexFrames frames = TangentFrames(mesh, topology);
    const Eigen::VectorXd angles = RandomAngles(mesh.NumberOfPoints());
    const OneRings rings(mesh, topology, frames);
    const OneRings turned(mesh, topology, TurnedFrames(frames, angles));
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
      {
        const Index w = rings.Neighbors[k];
        EXPECT_LE(
          std::abs(turned.NeighborLogarithms[k] - std::polar(1.0, -angles[v]) * rings.NeighborLogarithms[k]), 1e-12);
        EXPECT_LE(std::abs(turned.Transport[k] - std::polar(1.0, angles[v] - angles[w]) * rings.Transport[k]), 1e-11);
        EXPECT_LE(std::abs(rings.Transport[k] * rings.Transport[EdgeOf(rings, w, v)] - 1.0), 1e-14);
      }
    }
  }
}

TEST(OneRings, NumbersOfVerticesAndTrianglesDoNotMatter)
{
  for (const TriangleMesh& mesh :
    { test::IrregularSphere(2), test::SphereWithoutCap(2, 0.4), test::UvSphere(6, 40), Cone(9.0 * Pi / 8.0, 9, 3) })
  {
    std::vector<Index> id;
    const TriangleMesh other = Renumbered(mesh, id);
    const OneRings a(mesh);
    const OneRings b(other, MeshTopology(other), Renumbered(a.Frames, id));
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      for (Index k = a.NeighborStart[v]; k < a.NeighborStart[v + 1]; ++k)
      {
        const Index m = EdgeOf(b, id[v], id[a.Neighbors[k]]);
        EXPECT_LE(std::abs(a.NeighborLogarithms[k] - b.NeighborLogarithms[m]), 1e-12);
        EXPECT_LE(std::abs(a.Transport[k] - b.Transport[m]), 1e-11);
      }
    }
  }
}

TEST(OneRings, BoundariesKeepTheirAngles)
{
  const TriangleMesh mesh = test::PlanePatch(4, 3);
  const OneRings rings(mesh);
  int corners = 0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const double x = mesh.Points(v, 0);
    const double y = mesh.Points(v, 1);
    const int sides = (x == 0.0 || x == 1.0 ? 1 : 0) + (y == 0.0 || y == 1.0 ? 1 : 0);
    corners += sides == 2 ? 1 : 0;
    EXPECT_EQ(rings.OnBoundary[v], sides > 0 ? 1 : 0);
    EXPECT_NEAR(rings.TotalAngles[v], 2.0 * Pi / (1 << sides), 1e-12);
    for (Index r = rings.RingStart[v]; r < rings.RingStart[v + 1]; ++r)
    {
      EXPECT_NEAR(rings.Corners[rings.RingCorners[r]].Scale, 1.0, 1e-12);
    }
  }
  EXPECT_EQ(corners, 4);
}

TEST(OneRings, WideBoundaryRingsAreRescaledToAFullTurn)
{
  // Two full turns around the axis: a boundary vertex whose triangles fan out over 3.5 pi, as a spiral staircase.
  const int steps = 14;
  TriangleMesh stairs;
  stairs.Points = PointMatrix::Zero(steps + 2, 3);
  stairs.Triangles.resize(steps, 3);
  for (int k = 0; k <= steps; ++k)
  {
    stairs.Points.row(k + 1) << std::cos(0.25 * Pi * k), std::sin(0.25 * Pi * k), 0.05 * k;
  }
  for (int k = 0; k < steps; ++k)
  {
    stairs.Triangles.row(k) << 0, k + 1, k + 2;
  }
  const OneRings rings(stairs);
  ASSERT_GT(rings.TotalAngles[0], 3.0 * Pi);
  double sum = 0.0;
  for (Index r = rings.RingStart[0]; r < rings.RingStart[1]; ++r)
  {
    const RingCorner& corner = rings.Corners[rings.RingCorners[r]];
    sum += corner.Scale * std::atan2(corner.OtherY, corner.OtherX);
  }
  EXPECT_NEAR(sum, 2.0 * Pi, 1e-12);
}

TEST(OneRings, OfASphereApproachItsLogarithmMap)
{
  // The logarithm of q on the unit sphere: length of the arc, direction of q projected to the tangent plane of p.
  std::vector<double> errors;
  for (const int level : { 2, 3, 4 })
  {
    const TriangleMesh mesh = test::Icosphere(level);
    const OneRings rings(mesh);
    double largest = 0.0;
    for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
    {
      const Eigen::RowVector3d p = mesh.Points.row(v);
      for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
      {
        const Eigen::RowVector3d q = mesh.Points.row(rings.Neighbors[k]);
        const Eigen::RowVector3d tangent = q - p.dot(q) * p;
        const Complex along(tangent.dot(rings.Frames.X.row(v)), tangent.dot(rings.Frames.Y.row(v)));
        const Complex exact = along / std::abs(along) * std::acos(p.dot(q));
        largest = std::max(largest, std::abs(rings.NeighborLogarithms[k] - exact) / std::abs(exact));
      }
    }
    errors.push_back(largest);
  }
  EXPECT_LE(errors[0], 0.02);
  EXPECT_LE(errors[1], 0.3 * errors[0]);
  EXPECT_LE(errors[2], 0.3 * errors[1]);
}

TEST(OneRings, TransportAroundALoopOfASphereTurnsByItsArea)
{
  const int segments = 60;
  const TriangleMesh mesh = test::UvSphere(30, segments);
  const OneRings rings(mesh);
  for (const int ring : { 3, 6, 10 })
  {
    std::vector<Index> loop(segments);
    std::iota(loop.begin(), loop.end(), 1 + (ring - 1) * segments);
    const double area = 2.0 * Pi * (1.0 - std::cos(Pi * ring / 30));
    const double turned = std::remainder(std::arg(TransportAlong(rings, loop)) - area, 2.0 * Pi);
    EXPECT_NEAR(turned, 0.0, 0.02 * area);
  }
  // Summed over all triangles, the turns are the total curvature, 4 pi.
  double sum = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto t = mesh.Triangles.row(f);
    sum += std::arg(TransportAlong(rings, { t(0), t(1), t(2) }));
  }
  EXPECT_NEAR(sum, 4.0 * Pi, 1e-9);
}

TEST(OneRings, RadiiAreThoseOfDisks)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::Icosphere(3));
  const OneRings rings(mesh);
  const double area = FaceAreas(mesh).sum();
  EXPECT_NEAR(rings.Areas.sum(), 3.0 * area, 1e-12);
  EXPECT_EQ(rings.Areas[0], 0.0);
  EXPECT_EQ(rings.RingRadius(0), 0.0);
  EXPECT_NEAR(rings.RingRadius(1), std::sqrt(rings.Areas[1] / Pi), 1e-15);
  EXPECT_NEAR(MeanRingRadius(rings), std::sqrt(area / (Pi * test::Icosphere(3).NumberOfPoints())), 1e-14);
  EXPECT_EQ(MeanRingRadius(OneRings(TriangleMesh())), 0.0);
}

TEST(OneRings, OtherMeshesAreRefused)
{
  EXPECT_THAT(MessageOf([] { OneRings(test::MoebiusStrip(12, 3)); }), HasSubstr("wound in opposite senses"));
  const TriangleMesh cubes = test::SurfaceOfCubes({ { 0, 0, 0 }, { 1, 1, 0 } });
  EXPECT_THAT(MessageOf([&] { OneRings{ cubes }; }), HasSubstr("non-manifold edge"));
  const TriangleMesh touching = test::SurfaceOfCubes({ { 0, 0, 0 }, { 1, 1, 1 } });
  EXPECT_THAT(MessageOf([&] { OneRings{ touching }; }), HasSubstr("non-manifold point"));
  // With tables, only the rings are looked at.
  EXPECT_THAT(
    MessageOf([&] { OneRings(touching, MeshTopology(touching), Frames(touching)); }), HasSubstr("form several fans"));
  EXPECT_THAT(MessageOf([&] { OneRings(touching, MeshTopology(touching), VertexFrames()); }), HasSubstr("0 frames"));
  TriangleMesh broken = test::Icosphere(1);
  broken.Points(3, 1) = std::nan("");
  EXPECT_THAT(MessageOf([&] { OneRings{ broken }; }), HasSubstr("NaN or infinite"));
}

TEST(RingSamples, FollowTheAreasOfTriangles)
{
  const TriangleMesh mesh = test::LocallyRefinedSphere(1);
  const OneRings rings(mesh);
  const RingSamples samples = SampleRingsUniformly(rings);
  const Eigen::VectorXd areas = FaceAreas(mesh);
  ASSERT_EQ(samples.Offsets.size(), static_cast<std::size_t>(mesh.NumberOfPoints()) + 1);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const auto valence = rings.RingStart[v + 1] - rings.RingStart[v];
    EXPECT_NEAR(samples.Offsets[v + 1] - samples.Offsets[v], 64, 0.5 * valence + 1.0);
    std::map<Index, int> counts;
    for (auto s = samples.Offsets[v]; s < samples.Offsets[v + 1]; ++s)
    {
      const SurfacePlace& place = samples.Places[s];
      ++counts[place.Triangle];
      EXPECT_TRUE((mesh.Triangles.row(place.Triangle).array() == v).any());
      EXPECT_GE(place.Weights.minCoeff(), 0.0);
      EXPECT_NEAR(place.Weights.sum(), 1.0, 1e-14);
    }
    EXPECT_EQ(counts.size(), static_cast<std::size_t>(valence));
    for (const auto& [f, count] : counts)
    {
      EXPECT_NEAR(count, std::max(1.0, 64.0 * areas[f] / rings.Areas[v]), 0.5 + 1e-5);
    }
  }
}

TEST(RingSamples, HaveTheLogarithmsOfTheirPlaces)
{
  const TriangleMesh mesh = test::SphereWithoutCap(2, 0.3);
  const OneRings rings(mesh);
  const std::vector<Index> some = { 5, 0, 17, 5 };
  for (const RingSamples& samples : { SampleRingsUniformly(rings, some, 20), SampleRingsAtRandom(rings, some, 20, 3) })
  {
    std::vector<Complex> logs(3 * samples.Places.size());
    rings.CornerLogarithms(samples.Places.data(), static_cast<std::int64_t>(samples.Places.size()), logs.data());
    for (std::size_t k = 0; k < some.size(); ++k)
    {
      for (auto s = samples.Offsets[k]; s < samples.Offsets[k + 1]; ++s)
      {
        for (int corner = 0; corner < 3; ++corner)
        {
          if (mesh.Triangles(samples.Places[s].Triangle, corner) == some[k])
          {
            EXPECT_LE(std::abs(logs[3 * s + corner] - samples.Logarithms[s]), 1e-14);
          }
        }
      }
    }
  }
}

TEST(RingSamples, HaveTheMomentsOfTheUniformDistribution)
{
  // Of a triangle p, a, b: mean (p + a + b) / 3, and mean product of two different barycentric coordinates 1 / 12.
  TriangleMesh hexagon = Cone(1.9999 * Pi, 6, 1);
  const OneRings rings(hexagon);
  const auto check = [&](const RingSamples& samples, double tolerance) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (auto s = samples.Offsets[0]; s < samples.Offsets[1]; ++s)
    {
      mean += samples.Places[s].Weights;
      products += samples.Places[s].Weights * samples.Places[s].Weights.transpose();
    }
    const auto count = static_cast<double>(samples.Offsets[1] - samples.Offsets[0]);
    EXPECT_LE((mean / count - Eigen::Vector3d::Constant(1.0 / 3.0)).cwiseAbs().maxCoeff(), tolerance);
    const Eigen::Matrix3d expected = (Eigen::Matrix3d::Ones() + Eigen::Matrix3d::Identity()) / 12.0;
    EXPECT_LE((products / count - expected).cwiseAbs().maxCoeff(), tolerance);
  };
  check(SampleRingsUniformly(rings, { 0 }, 64), 0.02);
  check(SampleRingsUniformly(rings, { 0 }, 6000), 2e-3);
  check(SampleRingsAtRandom(rings, { 0 }, 65536, 1), 4e-3);
}

TEST(RingSamples, RingsOfVeryManyTrianglesHaveABoundedNumber)
{
  const TriangleMesh cone = Cone(1.9 * Pi, 5000, 1);
  const OneRings rings(cone);
  ASSERT_EQ(rings.RingStart[1], 5000);
  for (const int asked : { 32, 3000 })
  {
    const RingSamples samples = SampleRingsUniformly(rings, { 0 }, asked);
    const int count = std::max(1024, asked);
    ASSERT_EQ(samples.Offsets[1], count);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Complex turns = 0.0;
    for (int s = 0; s < count; ++s)
    {
      EXPECT_EQ(cone.Triangles(samples.Places[s].Triangle, 0), 0);
      EXPECT_NEAR(samples.Places[s].Weights.sum(), 1.0, 1e-14);
      EXPECT_GE(samples.Places[s].Weights.minCoeff(), 0.0);
      mean += samples.Places[s].Weights / count;
      turns += samples.Logarithms[s] / std::abs(samples.Logarithms[s]) / static_cast<double>(count);
    }
    EXPECT_NEAR(mean[0], 1.0 / 3.0, 5e-3) << "uniform along the radius";
    EXPECT_LE(std::abs(turns), 5e-3) << "uniform around the vertex";
  }
}

TEST(RingSamples, AreTheSameForEveryNumberingAndFrame)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  std::vector<Index> id;
  const TriangleMesh other = Renumbered(mesh, id);
  const OneRings a(mesh);
  const OneRings b(other, MeshTopology(other), Renumbered(a.Frames, id));
  const RingSamples one = SampleRingsUniformly(a, 32);
  const RingSamples two = SampleRingsUniformly(b, 32);
  const auto byAngle = [](const Complex& x, const Complex& y) {
    return std::make_pair(std::arg(x), std::abs(x)) < std::make_pair(std::arg(y), std::abs(y));
  };
  const auto sorted = [&](const RingSamples& samples, Index v) {
    std::vector<Complex> logs(
      samples.Logarithms.begin() + samples.Offsets[v], samples.Logarithms.begin() + samples.Offsets[v + 1]);
    std::sort(logs.begin(), logs.end(), byAngle);
    return logs;
  };
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const std::vector<Complex> first = sorted(one, v);
    const std::vector<Complex> second = sorted(two, id[v]);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t k = 0; k < first.size(); ++k)
    {
      EXPECT_LE(std::abs(first[k] - second[k]), 1e-12);
    }
  }
  const OneRings turned(mesh, MeshTopology(mesh), TurnedFrames(a.Frames, RandomAngles(mesh.NumberOfPoints())));
  const RingSamples three = SampleRingsUniformly(turned, 32);
  ASSERT_EQ(one.Offsets, three.Offsets);
  for (std::size_t s = 0; s < one.Places.size(); ++s)
  {
    EXPECT_EQ(one.Places[s].Weights, three.Places[s].Weights);
  }
}

TEST(RingSamples, RandomOnesAreFunctionsOfSeedSampleAndVertex)
{
  const TriangleMesh mesh = test::WithUnreferencedPoints(test::IrregularSphere(1));
  const OneRings rings(mesh);
  const RingSamples alone = SampleRingsAtRandom(rings, { 7 }, 16, 5, 2);
  const RingSamples among = SampleRingsAtRandom(rings, { 3, 0, 7 }, 16, 5, 2);
  EXPECT_EQ(among.Offsets, (std::vector<std::int64_t>{ 0, 16, 16, 32 })); // vertex 0 has no triangle
  for (int s = 0; s < 16; ++s)
  {
    EXPECT_EQ(alone.Places[s].Weights, among.Places[16 + s].Weights);
    EXPECT_EQ(alone.Logarithms[s], among.Logarithms[16 + s]);
  }
  EXPECT_NE(SampleRingsAtRandom(rings, { 7 }, 16, 6, 2).Logarithms, alone.Logarithms);
  EXPECT_NE(SampleRingsAtRandom(rings, { 7 }, 16, 5, 3).Logarithms, alone.Logarithms);
  // Expected numbers of samples go with areas: each triangle has its number within one.
  std::map<Index, int> counts;
  for (const SurfacePlace& place : alone.Places)
  {
    ++counts[place.Triangle];
  }
  const Eigen::VectorXd areas = FaceAreas(mesh);
  for (const auto& [f, count] : counts)
  {
    EXPECT_NEAR(count, 16.0 * areas[f] / rings.Areas[7], 2.0);
  }
}

TEST(RingSamples, NumbersOutOfRangeAreRefused)
{
  const OneRings rings(test::Tetrahedron());
  EXPECT_THAT(MessageOf([&] { SampleRingsUniformly(rings, 0); }), HasSubstr("0 samples of a ring"));
  EXPECT_THAT(MessageOf([&] { SampleRingsAtRandom(rings, { 0 }, 100000, 1); }), HasSubstr("expected 1 to 65536"));
  EXPECT_THAT(MessageOf([&] { SampleRingsAtRandom(rings, { 4 }, 8, 1); }), HasSubstr("vertex 4"));
}

namespace
{
/// Sums of the noise of one vector over the octants of a sphere in world axes, each vertex with the root of its area.
Eigen::MatrixXd OctantSums(const TriangleMesh& mesh, const NormalKey& key)
{
  const OneRings rings(mesh);
  const auto noise = TangentNoise(mesh, rings).Draw(key, 1);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(8, 3);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const Eigen::RowVector3d point = mesh.Points.row(v);
    const int octant = (point[0] > 0.0 ? 1 : 0) + (point[1] > 0.0 ? 2 : 0) + (point[2] > 0.0 ? 4 : 0);
    sums.row(octant) += std::sqrt(rings.Areas[v]) *
      (noise(v, 0) * rings.Frames.X.row(v) + noise(v, 1) * rings.Frames.Y.row(v));
  }
  return sums;
}
} // namespace

TEST(TangentNoise, IsWhiteWithUnitVariance)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  const OneRings rings(mesh);
  const TangentNoise noise(mesh, rings);
  const auto values = noise.Draw({ 5, 0, 0, 0 }, 8);
  const auto count = static_cast<double>(values.size());
  EXPECT_NEAR(values.cast<double>().mean(), 0.0, 4.0 / std::sqrt(count));
  EXPECT_NEAR(values.cast<double>().squaredNorm() / count, 1.0, 4.0 * std::sqrt(2.0 / count));
  double products = 0.0;
  double edges = 0.0;
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
    {
      const Index w = rings.Neighbors[k];
      for (int j = 0; j < 8; ++j)
      {
        const Complex here(values(v, 2 * j), values(v, 2 * j + 1));
        const Complex there(values(w, 2 * j), values(w, 2 * j + 1));
        products += (std::conj(there) * rings.Transport[k] * here).real() / 2.0;
        edges += 1.0;
      }
    }
  }
  EXPECT_NEAR(products / edges, 0.03, 0.03);
  EXPECT_GT((noise.Draw({ 5, 1, 0, 0 }, 8) - values).cwiseAbs().maxCoeff(), 1.0F);
  EXPECT_GT((noise.Draw({ 5, 0, 0, 0 }, 8, 1) - values).cwiseAbs().maxCoeff(), 1.0F);
  EXPECT_EQ(noise.Draw({ 5, 0, 0, 0 }, 8), values);
}

TEST(TangentNoise, TurnsWithTheFramesAndDoesNotDependOnNumbers)
{
  const TriangleMesh mesh = test::IrregularSphere(2);
  std::vector<Index> id;
  const TriangleMesh other = Renumbered(mesh, id);
  const OneRings a(mesh);
  const OneRings b(other, MeshTopology(other), Renumbered(a.Frames, id));
  const Eigen::VectorXd angles = RandomAngles(mesh.NumberOfPoints());
  const OneRings turned(mesh, MeshTopology(mesh), TurnedFrames(a.Frames, angles));
  const NormalKey key{ 3, 2, 0, 1 };
  const auto first = TangentNoise(mesh, a).Draw(key, 2);
  const auto second = TangentNoise(other, b).Draw(key, 2);
  const auto third = TangentNoise(mesh, turned).Draw(key, 2);
  const auto fourth = TangentNoise(mesh, a).DrawAtVertices(key, 2);
  const auto fifth = TangentNoise(other, b).DrawAtVertices(key, 2);
  EXPECT_NEAR(fourth.cast<double>().squaredNorm() / static_cast<double>(fourth.size()), 1.0, 0.25);
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    EXPECT_LE((first.row(v) - second.row(id[v])).cwiseAbs().maxCoeff(), 1e-5F);
    EXPECT_EQ(fourth.row(v), fifth.row(id[v]));
    const Complex here(first(v, 2), first(v, 3));
    EXPECT_LE(std::abs(std::polar(1.0, -angles[v]) * here - Complex(third(v, 2), third(v, 3))), 1e-5);
  }
}

TEST(TangentNoise, CoarsePartsAreThoseOfOtherTriangulations)
{
  double same = 0.0;
  double squares = 0.0;
  double others = 0.0;
  for (std::uint64_t seed = 0; seed < 2; ++seed)
  {
    const Eigen::MatrixXd a = OctantSums(test::IrregularSphere(3, 1), { seed, 0, 0, 0 });
    const Eigen::MatrixXd b = OctantSums(test::IrregularSphere(3, 2), { seed, 0, 0, 0 });
    const Eigen::MatrixXd c = OctantSums(test::IrregularSphere(3, 2), { seed + 100, 0, 0, 0 });
    same += a.cwiseProduct(b).sum();
    others += a.cwiseProduct(c).sum();
    squares += std::sqrt(a.squaredNorm() * b.squaredNorm());
  }
  EXPECT_GT(same / squares, 0.7);
  EXPECT_LT(std::abs(others / squares), 0.3);
}

TEST(OneRings, AreTheSameForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(5); // more vertices than a range of the loops
  std::vector<Index> some(800);
  std::iota(some.begin(), some.end(), 0);
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    const OneRings rings(mesh);
    const RingSamples samples = SampleRingsUniformly(rings, some, 8);
    const RingSamples random = SampleRingsAtRandom(rings, some, 8, 1);
    std::vector<Complex> logs(3 * samples.Places.size());
    rings.CornerLogarithms(samples.Places.data(), static_cast<std::int64_t>(samples.Places.size()), logs.data());
    return std::make_tuple(Eigen::VectorXcd(rings.NeighborLogarithms), Eigen::VectorXcd(rings.Transport),
      samples.Logarithms, random.Logarithms, logs);
  };
  const auto one = with(1);
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(3));
}
