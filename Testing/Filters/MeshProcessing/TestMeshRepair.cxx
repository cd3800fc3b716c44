// SPDX-License-Identifier: BSD-3-Clause
//
// The steps of repair by themselves (SoupRepair.h, HoleFilling.h), and RepairSurface().
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "MeshProcessing/Repair/DisplacementReduction.h"
#include "MeshProcessing/Repair/FlatTriangles.h"
#include "MeshProcessing/Repair/HoleFilling.h"
#include "MeshProcessing/Repair/SelfIntersections.h"
#include "MeshProcessing/Repair/SoupRepair.h"
#include "MeshProcessing/Repair/SurfaceRepair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::ThrowsMessage;

namespace
{
const double Infinity = std::numeric_limits<double>::infinity();
const double Pi = std::acos(-1.0);

Soup SoupOf(TriangleMesh mesh)
{
  Soup soup;
  soup.OriginOfTriangle.resize(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  std::iota(soup.OriginOfTriangle.begin(), soup.OriginOfTriangle.end(), 0);
  soup.Mesh = std::move(mesh);
  return soup;
}

/// A large triangle for each point (x, 0, 0), which is its corner 0; its other corners lie far from all other points.
Soup TrianglesAt(const std::vector<double>& places)
{
  TriangleMesh mesh;
  const auto count = static_cast<Index>(places.size());
  mesh.Points.resize(3 * count, 3);
  mesh.Triangles.resize(count, 3);
  for (Index k = 0; k < count; ++k)
  {
    // The corners at the places have the lowest ids.
    mesh.Points.row(k) << places[static_cast<std::size_t>(k)], 0.0, 0.0;
    mesh.Points.row(count + 2 * k) << 10.0 * k, 100.0, 0.0;
    mesh.Points.row(count + 2 * k + 1) << 10.0 * k, 100.0, 50.0;
    mesh.Triangles.row(k) << k, count + 2 * k, count + 2 * k + 1;
  }
  return SoupOf(mesh);
}

/// The points that the corners 0 have become.
std::vector<Index> FirstCorners(const Soup& soup)
{
  const auto corners = soup.Mesh.Triangles.col(0).eval();
  return { corners.data(), corners.data() + corners.size() };
}

/// Every triangle with three points of its own.
TriangleMesh TornApart(const TriangleMesh& mesh)
{
  TriangleMesh torn;
  torn.Points.resize(3 * mesh.NumberOfTriangles(), 3);
  torn.Triangles.resize(mesh.NumberOfTriangles(), 3);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      torn.Points.row(3 * f + k) = mesh.Points.row(mesh.Triangles(f, k));
      torn.Triangles(f, k) = 3 * f + k;
    }
  }
  return torn;
}

/// The mesh with these triangles wound the other way.
TriangleMesh WithTurned(TriangleMesh mesh, Index begin, Index end)
{
  for (Index f = begin; f < end; ++f)
  {
    std::swap(mesh.Triangles(f, 1), mesh.Triangles(f, 2));
  }
  return mesh;
}

/// A sphere in which the triangle 0 is cut by the middle of its first edge, which is a corner there only: a triangle
/// without area lies between.
TriangleMesh SphereWithFlatTriangle()
{
  TriangleMesh mesh = Icosphere(2);
  const Index points = mesh.NumberOfPoints();
  const Index triangles = mesh.NumberOfTriangles();
  const auto t = mesh.Triangles.row(0).eval();
  mesh.Points.conservativeResize(points + 1, 3);
  mesh.Points.row(points) = 0.5 * (mesh.Points.row(t(0)) + mesh.Points.row(t(1)));
  mesh.Triangles.conservativeResize(triangles + 2, 3);
  mesh.Triangles.row(0) << t(0), points, t(2);
  mesh.Triangles.row(triangles) << points, t(1), t(2);
  mesh.Triangles.row(triangles + 1) << t(0), t(1), points;
  return mesh;
}

CgalMesh::Property_map<CgalFace, bool> AddMarks(CgalMesh& mesh)
{
  return mesh.add_property_map<CgalFace, bool>("f:filling", false).first;
}

RepairedSurface Repaired(const TriangleMesh& mesh, RepairOptions options = {}, const ConversionLosses& losses = {})
{
  options.Finder = NearestPlaces;
  return RepairSurface(mesh, losses, options);
}
} // namespace

// ---- SoupRepair.h ---------------------------------------------------------------------------------------------------

TEST(MergePoints, EqualCoordinatesBecomeTheLowestId)
{
  Soup soup = TrianglesAt({ 1.0, 0.0, 1.0, -0.0, 1.0 });
  EXPECT_EQ(MergePoints(soup, 0.0), 3);
  EXPECT_THAT(FirstCorners(soup), ElementsAre(0, 1, 0, 1, 0));
  EXPECT_EQ(soup.Mesh.NumberOfPoints(), 15); // the points themselves stay
}

TEST(MergePoints, WithoutToleranceTheNearestNumberIsAnotherPoint)
{
  Soup soup = TrianglesAt({ 1.0, std::nextafter(1.0, 2.0) });
  EXPECT_EQ(MergePoints(soup, 0.0), 0);
  EXPECT_THAT(FirstCorners(soup), ElementsAre(0, 1));
}

TEST(MergePoints, ToleranceIsIncluded)
{
  Soup soup = TrianglesAt({ 0.0, 0.25, -0.25, 0.2501 });
  EXPECT_EQ(MergePoints(soup, 0.25), 2);
  EXPECT_THAT(FirstCorners(soup), ElementsAre(0, 0, 0, 3));
}

TEST(MergePoints, ExactDuplicatesMergeWithinATolerance)
{
  Soup soup = TrianglesAt({ 3.0, 3.0, 3.0 });
  EXPECT_EQ(MergePoints(soup, 0.1), 2);
  EXPECT_THAT(FirstCorners(soup), ElementsAre(0, 0, 0));
}

TEST(MergePoints, ChainsAreCutInTheOrderOfIds)
{
  // Point 0 takes its neighbour only; point 2, too far from point 0, takes point 3.
  Soup chain = TrianglesAt({ 0.0, 0.9, 1.8, 2.7 });
  EXPECT_EQ(MergePoints(chain, 1.0), 2);
  EXPECT_THAT(FirstCorners(chain), ElementsAre(0, 0, 2, 2));
  // From the middle of the chain both neighbours are taken.
  Soup middle = TrianglesAt({ 0.9, 0.0, 1.8 });
  EXPECT_EQ(MergePoints(middle, 1.0), 2);
  EXPECT_THAT(FirstCorners(middle), ElementsAre(0, 0, 0));
}

TEST(MergePoints, TrianglesThatLoseACornerAreDropped)
{
  TriangleMesh mesh = PlanePatch(2, 1, 2.0, 1.0);
  const Index triangles = mesh.NumberOfTriangles();
  mesh.Points.row(1) = mesh.Points.row(0); // the first cell becomes one triangle
  Soup soup = SoupOf(mesh);
  EXPECT_EQ(MergePoints(soup, 0.0), 1);
  EXPECT_LT(soup.Mesh.NumberOfTriangles(), triangles);
  ASSERT_EQ(soup.OriginOfTriangle.size(), static_cast<std::size_t>(soup.Mesh.NumberOfTriangles()));
  for (Index f = 0; f < soup.Mesh.NumberOfTriangles(); ++f)
  {
    const auto t = soup.Mesh.Triangles.row(f);
    EXPECT_TRUE(t(0) != t(1) && t(1) != t(2) && t(2) != t(0)) << f;
    auto before = mesh.Triangles.row(soup.OriginOfTriangle[static_cast<std::size_t>(f)]).eval();
    before = (before.array() == 1).select(0, before);
    EXPECT_EQ(t, before) << f;
  }
}

TEST(RemoveDuplicateTriangles, KeepsTheFirstOfEveryRotationAndWinding)
{
  TriangleMesh mesh = Tetrahedron();
  mesh.Triangles.conservativeResize(7, 3);
  const auto t = mesh.Triangles.row(1).eval();
  mesh.Triangles.row(4) << t(1), t(2), t(0);
  mesh.Triangles.row(5) << t(0), t(2), t(1);
  mesh.Triangles.row(6) = mesh.Triangles.row(3).eval();
  Soup soup = SoupOf(mesh);
  EXPECT_EQ(RemoveDuplicateTriangles(soup), 3);
  EXPECT_EQ(soup.Mesh.Triangles, Tetrahedron().Triangles);
  EXPECT_THAT(soup.OriginOfTriangle, ElementsAre(0, 1, 2, 3));
}

TEST(MakeManifold, TurnedTrianglesAreTurnedBack)
{
  Soup soup = SoupOf(WithTurned(Icosphere(2), 10, 15));
  const ManifoldChanges changes = MakeManifold(soup);
  EXPECT_EQ(changes.FlippedTriangles, 5);
  EXPECT_EQ(changes.AddedPoints, 0);
  EXPECT_TRUE(SameTriangles(soup.Mesh.Triangles, Icosphere(2).Triangles));
}

TEST(MakeManifold, WindingIsThatOfMostOfTheArea)
{
  const TriangleMesh sphere = Icosphere(2);
  Soup soup = SoupOf(WithTurned(sphere, 5, sphere.NumberOfTriangles()));
  EXPECT_EQ(MakeManifold(soup).FlippedTriangles, 5);
  EXPECT_NEAR(VolumeOf(soup.Mesh), -VolumeOf(sphere), 1e-12);
}

TEST(MakeManifold, SheetsOnOneEdgeOrPointComeApart)
{
  TriangleMesh book; // three pages on the edge 0 - 1
  book.Points.resize(5, 3);
  book.Points << 0, 0, 0, 0, 0, 1, 1, 0, 0, -1, 1, 0, -1, -1, 0;
  book.Triangles.resize(3, 3);
  book.Triangles << 0, 1, 2, 0, 1, 3, 0, 1, 4;
  Soup soup = SoupOf(book);
  EXPECT_GT(MakeManifold(soup).AddedPoints, 0);
  EXPECT_EQ(DefectsOf(soup.Mesh, false), "");
  EXPECT_NEAR(AreaOf(soup.Mesh), AreaOf(book), 1e-15);

  Soup cubes = SoupOf(SurfaceOfCubes({ { 0, 0, 0 }, { 1, 1, 1 } })); // with a corner in common
  EXPECT_EQ(MakeManifold(cubes).AddedPoints, 1);
  EXPECT_EQ(DefectsOf(cubes.Mesh), "");
  EXPECT_NEAR(VolumeOf(cubes.Mesh), 2.0, 1e-15);
}

// ---- HoleFilling.h --------------------------------------------------------------------------------------------------

TEST(FillHoles, MissingCapOfASphereIsClosedWithItsCurvature)
{
  const TriangleMesh open = SphereWithoutCap(3, 0.75);
  CgalMesh mesh = ToCgalMesh(open);
  auto marks = AddMarks(mesh);
  const FilledHoles holes = FillHoles(mesh, Infinity, marks, nullptr);
  EXPECT_EQ(holes.Closed, 1);
  EXPECT_EQ(holes.LeftOpen, 0);
  Index marked = 0;
  for (const CgalFace f : mesh.faces())
  {
    EXPECT_EQ(marks[f], static_cast<Index>(f.idx()) >= open.NumberOfTriangles());
    marked += marks[f] ? 1 : 0;
  }
  EXPECT_GT(marked, 10);
  const TriangleMesh closed = FromCgalMesh(mesh);
  EXPECT_EQ(DefectsOf(closed), "");
  EXPECT_EQ(EulerCharacteristicOf(closed), 2);
  // The area and the volume are those of the sphere: with a flat lid the area would lack 1.6 per cent.
  const TriangleMesh sphere = Icosphere(3);
  EXPECT_NEAR(AreaOf(closed), AreaOf(sphere), 0.01 * AreaOf(sphere));
  EXPECT_NEAR(VolumeOf(closed), VolumeOf(sphere), 0.01 * VolumeOf(sphere));
}

TEST(FillHoles, LargerHolesStayOpen)
{
  const TriangleMesh open = SphereWithoutCap(2, 0.5);
  CgalMesh mesh = ToCgalMesh(open);
  auto marks = AddMarks(mesh);
  const FilledHoles holes = FillHoles(mesh, 0.5, marks, nullptr);
  EXPECT_EQ(holes.Closed, 0);
  EXPECT_EQ(holes.LeftOpen, 1);
  EXPECT_EQ(FromCgalMesh(mesh).Triangles.rows(), open.Triangles.rows());
}

TEST(FillHoles, OutlineOfAPieceIsNoHole)
{
  for (const double largest : { 10.0, Infinity })
  {
    CgalMesh mesh = ToCgalMesh(PlanePatch(4, 4));
    auto marks = AddMarks(mesh);
    const FilledHoles holes = FillHoles(mesh, largest, marks, nullptr);
    EXPECT_EQ(holes.Closed, 0);
    EXPECT_EQ(holes.LeftOpen, std::isfinite(largest) ? 1 : 0);
    EXPECT_EQ(holes.FlatOutlines, std::isfinite(largest) ? 0 : 1);
  }
}

/// Two open boxes, one upside down over the other, so that lids of both would cross the walls of the other.
TriangleMesh InterlockedBoxes()
{
  TriangleMesh mesh;
  mesh.Points.resize(16, 3);
  mesh.Triangles.resize(20, 3);
  const int walls[10][3] = { { 0, 2, 1 }, { 0, 3, 2 }, { 0, 1, 5 }, { 0, 5, 4 }, { 1, 2, 6 }, { 1, 6, 5 }, { 2, 3, 7 },
    { 2, 7, 6 }, { 3, 0, 4 }, { 3, 4, 7 } };
  for (Index box = 0; box < 2; ++box)
  {
    for (Index k = 0; k < 8; ++k)
    {
      // The second box is narrower, and its opening lies inside the first one.
      const double x = k % 4 == 1 || k % 4 == 2 ? 1.0 : -1.0;
      const double y = k % 4 >= 2 ? 1.0 : -1.0;
      const double width = box == 0 ? 1.0 : 0.5;
      const double z = box == 0 ? (k < 4 ? 0.0 : 2.0) : (k < 4 ? 3.0 : 1.0);
      mesh.Points.row(8 * box + k) << width * x, width * y, z;
    }
    for (Index f = 0; f < 10; ++f)
    {
      const auto& t = walls[f];
      mesh.Triangles.row(10 * box + f) << 8 * box + t[0], 8 * box + t[box == 0 ? 1 : 2], 8 * box + t[box == 0 ? 2 : 1];
    }
  }
  return mesh;
}

TEST(FindIntersectingPairs, NamesEachPairOnce)
{
  // Two upright triangles in a third one, which touch neither each other nor its border.
  TriangleMesh mesh;
  mesh.Points.resize(9, 3);
  mesh.Points << -9, -9, 0, 9, -9, 0, 0, 9, 0, 1, -1, -1, 1, 1, -1, 1, 0, 1, -1, -1, -1, -1, 1, -1, -1, 0, 1;
  mesh.Triangles.resize(3, 3);
  mesh.Triangles << 3, 4, 5, 0, 1, 2, 6, 7, 8;
  const std::vector<std::array<Index, 2>> expected = { { 0, 1 }, { 1, 2 } };
  EXPECT_EQ(FindIntersectingPairs(mesh), expected);
  EXPECT_EQ(FindIntersectingTriangles(mesh), (std::vector<Index>{ 0, 1, 2 }));
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(FindIntersectingPairs(mesh, &stop), Cancelled);
}

TEST(FindIntersectingPairs, OfASubsetAreThoseThatHaveATriangleOfIt)
{
  const TriangleMesh mesh = Join(Icosphere(3), Translated(Icosphere(3), { 0.7, 0.1, 0.2 }));
  std::vector<std::array<Index, 2>> expected = FindIntersectingPairs(mesh);
  ASSERT_GT(expected.size(), 50U);
  std::vector<Index> subset;
  for (Index f = 1; f < mesh.NumberOfTriangles(); f += 3)
  {
    subset.push_back(f);
  }
  const auto isOther = [](const std::array<Index, 2>& pair) { return pair[0] % 3 != 1 && pair[1] % 3 != 1; };
  expected.erase(std::remove_if(expected.begin(), expected.end(), isOther), expected.end());
  EXPECT_EQ(FindIntersectingPairsOf(mesh, subset), expected);
  EXPECT_THAT(FindIntersectingPairsOf(mesh, {}), IsEmpty());
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(FindIntersectingPairsOf(mesh, subset, &stop), Cancelled);
}

// ---- DisplacementReduction.h ----------------------------------------------------------------------------------------

namespace
{
/// A bump of height @p normal and radius 0.2 on the patch around (x, y), whose top is moved to the side by @p sideways.
PointMatrix Bump(const TriangleMesh& patch, double x, double y, double normal, double sideways)
{
  PointMatrix displacement = PointMatrix::Zero(patch.NumberOfPoints(), 3);
  for (Index v = 0; v < patch.NumberOfPoints(); ++v)
  {
    const double distance = std::hypot(patch.Points(v, 0) - x, patch.Points(v, 1) - y);
    if (distance < 0.2)
    {
      displacement.row(v) << sideways, 0.0, normal;
      displacement.row(v) *= std::pow(std::cos(0.5 * Pi * distance / 0.2), 2);
    }
  }
  return displacement;
}

/// Two bumps around (x, 0.5) that lean into one another.
PointMatrix LeaningBumps(const TriangleMesh& patch, double x)
{
  return Bump(patch, x - 0.2, 0.5, 0.3, 0.25) + Bump(patch, x + 0.2, 0.5, 0.25, -0.25);
}

/// No pairs intersect, neither of the points as they are nor in single precision.
void ExpectNoIntersections(const TriangleMesh& base, const PointMatrix& displacement)
{
  TriangleMesh mesh = { base.Points + displacement, base.Triangles };
  EXPECT_THAT(FindIntersectingPairs(mesh), IsEmpty());
  mesh.Points = mesh.Points.cast<float>().cast<double>().eval();
  EXPECT_THAT(FindIntersectingPairs(mesh), IsEmpty()) << "in single precision";
}
} // namespace

TEST(ReduceDisplacement, BumpsThatLeanIntoOneAnotherBecomeUprightAndKeepTheirHeight)
{
  const TriangleMesh base = PlanePatch(60, 60);
  const PointMatrix full = LeaningBumps(base, 0.5);
  const ReducedDisplacement reduced = ReduceDisplacement(base, full);
  EXPECT_GT(reduced.NumberOfPairsBefore, 100);
  EXPECT_EQ(reduced.NumberOfPairsLeft, 0);
  ExpectNoIntersections(base, reduced.Displacement);
  EXPECT_NEAR(reduced.Height / reduced.HeightBefore, 1.0, 1e-12) << "only the tangential part is reduced";
  EXPECT_TRUE(reduced.Displacement.col(2).isApprox(full.col(2), 1e-12));
  EXPECT_TRUE((reduced.Displacement.col(0).array().abs() <= full.col(0).array().abs() + 1e-12).all());
  EXPECT_GT(reduced.Displacement.col(0).norm(), 0.2 * full.col(0).norm()) << "not more than is needed";
  EXPECT_TRUE((reduced.Displacement.array() == ReduceDisplacement(base, full).Displacement.array()).all());
}

TEST(ReduceDisplacement, ABumpThatIntersectsNothingKeepsItsBits)
{
  const TriangleMesh base = PlanePatch(60, 30, 2.0);
  const PointMatrix gentle = Bump(base, 1.78, 0.5, 0.2, 0.1);
  const ReducedDisplacement unchanged = ReduceDisplacement(base, gentle);
  EXPECT_EQ(unchanged.NumberOfRounds, 0);
  EXPECT_EQ(unchanged.NumberOfPairsBefore, 0);
  EXPECT_TRUE((unchanged.Displacement.array() == gentle.array()).all());
  // Nor do its neighbors, when another one is reduced.
  const PointMatrix both = gentle + LeaningBumps(base, 0.4);
  const ReducedDisplacement reduced = ReduceDisplacement(base, both);
  EXPECT_GT(reduced.NumberOfRounds, 0);
  for (Index v = 0; v < base.NumberOfPoints(); ++v)
  {
    EXPECT_TRUE(gentle.row(v).isZero(0.0) || (reduced.Displacement.row(v).array() == gentle.row(v).array()).all()) << v;
  }
}

TEST(ReduceDisplacement, BumpsOfFacingSheetsLoseHeightUntilTheyFit)
{
  // Two sheets at a distance of 0.5, whose bumps of height 0.3 meet, and others beside them, which do not.
  TriangleMesh lower = PlanePatch(60, 30, 2.0);
  TriangleMesh upper = Translated(lower, { 0.0, 0.0, 0.5 });
  std::swap_ranges(upper.Triangles.col(1).begin(), upper.Triangles.col(1).end(), upper.Triangles.col(2).begin());
  const PointMatrix below = Bump(lower, 0.4, 0.5, 0.3, 0.0) + Bump(lower, 1.5, 0.5, 0.2, 0.0);
  const TriangleMesh base = Join(lower, upper);
  PointMatrix full(base.NumberOfPoints(), 3);
  full << below, -below;
  const ReducedDisplacement reduced = ReduceDisplacement(base, full);
  EXPECT_GT(reduced.NumberOfPairsBefore, 20);
  EXPECT_EQ(reduced.NumberOfPairsLeft, 0);
  ExpectNoIntersections(base, reduced.Displacement);
  EXPECT_LT(reduced.Height, reduced.HeightBefore);
  EXPECT_GT(reduced.Height, 0.7 * reduced.HeightBefore) << "a sixth of the higher bumps has to go";
  EXPECT_GT(reduced.Displacement.col(2).maxCoeff(), 0.15);
}

TEST(ReduceDisplacement, IntersectionsOfTheBaseStayAndAreCounted)
{
  TriangleMesh crossing = PlanePatch(30, 30);
  crossing.Points.col(2) = crossing.Points.col(0).array() - 0.51; // cuts the other patch in a line at x = 0.51
  crossing.Points.col(0).setConstant(0.503);
  const TriangleMesh base = Join(PlanePatch(31, 29), crossing);
  const auto pairs = static_cast<std::int64_t>(FindIntersectingPairs(base).size());
  ASSERT_GT(pairs, 30);
  PointMatrix full(base.NumberOfPoints(), 3);
  full << Bump(PlanePatch(31, 29), 0.45, 0.5, 0.1, 0.0), PointMatrix::Zero(crossing.NumberOfPoints(), 3);
  const ReducedDisplacement reduced = ReduceDisplacement(base, full);
  EXPECT_EQ(reduced.NumberOfPairsLeft, pairs) << "of the base, and no others";
  EXPECT_GT(reduced.Height, 0.0);
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(ReduceDisplacement(base, full, &stop), Cancelled);
}

TEST(FillHoles, TrianglesThatWouldIntersectAreLeftOutWhereRequired)
{
  const TriangleMesh boxes = InterlockedBoxes();
  ASSERT_THAT(FindIntersectingTriangles(boxes), IsEmpty());
  for (const bool required : { false, true })
  {
    CgalMesh mesh = ToCgalMesh(boxes);
    auto marks = AddMarks(mesh);
    FillingRequirements requirements;
    requirements.NoIntersections = required;
    const FilledHoles holes = FillHoles(mesh, Infinity, marks, nullptr, requirements);
    EXPECT_EQ(holes.Closed, required ? 1 : 2) << "the opening of the inner box can be closed";
    EXPECT_EQ(holes.Unsuitable, required ? 1 : 0);
    EXPECT_EQ(FindIntersectingTriangles(FromCgalMesh(mesh)).empty(), required);
  }
}

TEST(FillHoles, StopIsCancelled)
{
  CgalMesh mesh = ToCgalMesh(SphereWithoutCap(2, 0.5));
  auto marks = AddMarks(mesh);
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(FillHoles(mesh, Infinity, marks, &stop), Cancelled);
}

TEST(RemoveFlatTriangles, LeavesNone)
{
  CgalMesh mesh = ToCgalMesh(SphereWithFlatTriangle());
  EXPECT_EQ(CountFlatTriangles(mesh), 1);
  RemoveFlatTriangles(mesh);
  EXPECT_EQ(CountFlatTriangles(mesh), 0);
  const TriangleMesh result = FromCgalMesh(mesh);
  EXPECT_EQ(DefectsOf(result), "");
  EXPECT_NEAR(VolumeOf(result), VolumeOf(Icosphere(2)), 0.01 * VolumeOf(Icosphere(2)));
  EXPECT_EQ(CountFlatTriangles(ToCgalMesh(Icosphere(2))), 0);
}

// ---- SurfaceRepair.h ------------------------------------------------------------------------------------------------

TEST(RepairSurface, ValidSurfacesStayAsTheyAre)
{
  for (const TriangleMesh& mesh : { Icosphere(2), PlanePatch(5, 5) })
  {
    RepairOptions options;
    options.LargestHole = 0.5;
    const RepairedSurface made = Repaired(mesh, options);
    EXPECT_EQ(made.Mesh.Points, mesh.Points);
    EXPECT_TRUE(SameTriangles(made.Mesh.Triangles, mesh.Triangles));
    EXPECT_EQ(std::count(made.IsFilling.begin(), made.IsFilling.end(), true), 0);
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      EXPECT_EQ(made.OriginOfTriangle[static_cast<std::size_t>(f)], f);
    }
  }
  EXPECT_THAT(Repaired(Icosphere(2)).Report, IsEmpty());
}

TEST(RepairSurface, TriangleSoupBecomesASphere)
{
  const TriangleMesh sphere = Icosphere(2);
  const RepairedSurface made = Repaired(TornApart(sphere));
  EXPECT_EQ(DefectsOf(made.Mesh), "");
  EXPECT_EQ(made.Mesh.NumberOfPoints(), sphere.NumberOfPoints());
  EXPECT_NEAR(VolumeOf(made.Mesh), VolumeOf(sphere), 1e-12);
  EXPECT_THAT(
    made.Report, ElementsAre(Pair("points merged", 3 * sphere.NumberOfTriangles() - sphere.NumberOfPoints())));
}

TEST(RepairSurface, GapsWithinTheToleranceAreClosed)
{
  TriangleMesh torn = TornApart(Icosphere(2));
  for (Index v = 0; v < torn.NumberOfPoints(); ++v)
  {
    torn.Points(v, v % 3) += 1e-4 * Uniform(3, static_cast<std::uint64_t>(v));
  }
  RepairOptions options;
  options.MergeTolerance = 1e-3;
  EXPECT_EQ(DefectsOf(Repaired(torn, options).Mesh), "");
  options.MergeTolerance = 0.0;
  EXPECT_NE(DefectsOf(Repaired(torn, options).Mesh), "");
}

TEST(RepairSurface, MissingCapIsClosedAndMarked)
{
  const TriangleMesh open = SphereWithoutCap(3, 0.75);
  RepairOptions options;
  options.LargestHole = 2.5; // the diagonal of the box around the rim is about 2
  const RepairedSurface made = Repaired(open, options);
  EXPECT_EQ(DefectsOf(made.Mesh), "");
  EXPECT_THAT(made.Report, ElementsAre(Pair("holes closed", 1)));
  EXPECT_NEAR(AreaOf(made.Mesh), 4.0 * Pi, 0.02 * 4.0 * Pi);
  EXPECT_NEAR(VolumeOf(made.Mesh), 4.0 / 3.0 * Pi, 0.03 * 4.0 / 3.0 * Pi);
  ASSERT_EQ(made.IsFilling.size(), static_cast<std::size_t>(made.Mesh.NumberOfTriangles()));
  EXPECT_EQ(std::count(made.IsFilling.begin(), made.IsFilling.end(), false), open.NumberOfTriangles());
  for (Index f = 0; f < made.Mesh.NumberOfTriangles(); ++f)
  {
    const double height = made.Mesh.Points(made.Mesh.Triangles(f, 0), 2);
    EXPECT_TRUE(!made.IsFilling[static_cast<std::size_t>(f)] || height > 0.5) << f;
  }
  ASSERT_EQ(made.PlaceOfPoint.size(), static_cast<std::size_t>(made.Mesh.NumberOfPoints()));
  ASSERT_EQ(made.OriginOfTriangle.size(), static_cast<std::size_t>(made.Mesh.NumberOfTriangles()));

  options.LargestHole = 0.5;
  EXPECT_THAT(Repaired(open, options).Report,
    ElementsAre(Pair("boundaries left open because they are larger than the limit", 1)));
}

TEST(RepairSurface, StepsAreReportedInOrder)
{
  TriangleMesh mesh = WithTurned(SphereWithFlatTriangle(), 20, 22);
  const Index triangles = mesh.NumberOfTriangles();
  mesh.Triangles.conservativeResize(triangles + 1, 3);
  mesh.Triangles.row(triangles) = mesh.Triangles.row(30).eval();
  ConversionLosses losses;
  losses.CellsOutOfRange = 3;
  const RepairedSurface made = Repaired(mesh, {}, losses);
  EXPECT_EQ(DefectsOf(made.Mesh), "");
  EXPECT_THAT(made.Report,
    ElementsAre(Pair(HasSubstr("a point which does not exist"), 3), Pair("duplicate triangles removed", 1),
      Pair("triangles turned around", 2), Pair("triangles without area removed", 1)));
}

TEST(RepairSurface, ClosedSurfacesFaceOutward)
{
  const TriangleMesh sphere = Icosphere(2);
  const TriangleMesh inward = WithTurned(sphere, 0, sphere.NumberOfTriangles());
  const RepairedSurface made = Repaired(inward);
  EXPECT_NEAR(VolumeOf(made.Mesh), VolumeOf(sphere), 1e-12);
  EXPECT_THAT(made.Report, ElementsAre(Pair("triangles turned to face outward", sphere.NumberOfTriangles())));
  RepairOptions options;
  options.OrientOutward = false;
  EXPECT_NEAR(VolumeOf(Repaired(inward, options).Mesh), -VolumeOf(sphere), 1e-12);
}

TEST(RepairSurface, SmallComponentsGo)
{
  // 0.09 of the area of the largest one.
  const TriangleMesh two = Join(Icosphere(2), Translated(Icosphere(1, 0.3), { 3.0, 0.0, 0.0 }));
  RepairOptions options;
  options.SmallestComponent = 0.05;
  EXPECT_EQ(EulerCharacteristicOf(Repaired(two, options).Mesh), 4);
  options.SmallestComponent = 0.1;
  const RepairedSurface made = Repaired(two, options);
  EXPECT_EQ(EulerCharacteristicOf(made.Mesh), 2);
  EXPECT_THAT(made.Report, ElementsAre(Pair("components removed", 1)));
  options.SmallestComponent = 0.0;
  options.KeepLargestComponent = true;
  EXPECT_EQ(Repaired(two, options).Mesh.NumberOfPoints(), Icosphere(2).NumberOfPoints());
}

TEST(RepairSurface, MeshesWithoutTrianglesAndHugeCoordinatesAreInvalid)
{
  TriangleMesh needle = SingleTriangle();
  needle.Points.row(2) = needle.Points.row(1);
  EXPECT_THAT([&] { Repaired(needle); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("is left of the 1 triangles of the input"),
      HasSubstr("polygons with three different, finite points"))));
  EXPECT_THAT([] { Repaired(Scaled(Icosphere(1), 1e91)); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("at most 1e+90 is allowed"), HasSubstr("vtkTransformPolyDataFilter"))));
}

TEST(RepairSurface, StopIsCancelled)
{
  RepairOptions options;
  options.Finder = NearestPlaces;
  const std::atomic<bool> stop{ true };
  EXPECT_THROW(RepairSurface(TornApart(Icosphere(2)), {}, options, &stop), Cancelled);
}
