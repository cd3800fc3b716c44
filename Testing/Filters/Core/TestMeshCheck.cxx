// SPDX-License-Identifier: BSD-3-Clause
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshCheck.h"

#include <gtest/gtest.h>

#include <limits>
#include <regex>

using namespace surfsynth;

namespace
{

const double NaN = std::numeric_limits<double>::quiet_NaN();
const double Infinity = std::numeric_limits<double>::infinity();

MeshRequirements Everything()
{
  MeshRequirements all;
  all.ManifoldEdges = all.ManifoldVertices = all.ConsistentWinding = all.Closed = all.SingleComponent = true;
  return all;
}

MeshRequirements Nothing()
{
  MeshRequirements none;
  none.ManifoldEdges = false;
  return none;
}

/// Asserts that @p findings is exactly one finding with that count and first id, and that its text holds both and
/// names the VTK filter that repairs it.
void ExpectOnly(const std::vector<MeshFinding>& findings, MeshDefect defect, std::int64_t count, std::int64_t first)
{
  ASSERT_EQ(findings.size(), 1U) << DescribeFindings(findings);
  EXPECT_EQ(findings[0].Defect, defect);
  EXPECT_EQ(findings[0].Count, count);
  EXPECT_EQ(findings[0].First, first);
  const std::string text = DescribeFindings(findings);
  EXPECT_TRUE(std::regex_search(text, std::regex("\\b" + std::to_string(count) + "\\b"))) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("\\b" + std::to_string(first) + "\\b"))) << text;
  EXPECT_NE(text.find("vtkSurfaceRepairFilter"), std::string::npos) << text;
}

class CheckMeshOfSuite : public testing::TestWithParam<std::string>
{};

INSTANTIATE_TEST_SUITE_P(
  Suite, CheckMeshOfSuite, testing::ValuesIn(test::SuiteNames()), [](const auto& info) { return info.param; });

} // namespace

TEST_P(CheckMeshOfSuite, FindsNothingInValidMeshes)
{
  const test::SuiteMesh& sound = test::FromSuite(GetParam());
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = sound.ConsistentWinding;
  requirements.Closed = sound.Closed;
  requirements.SingleComponent = sound.Components == 1;
  const std::vector<MeshFinding> findings = CheckMesh(sound.Mesh, requirements);
  EXPECT_TRUE(findings.empty()) << DescribeFindings(findings);
  EXPECT_NO_THROW(RequireValidMesh(sound.Mesh, requirements));
}

TEST(CheckMesh, FindsNothingInAnEmptyMesh) { EXPECT_TRUE(CheckMesh(TriangleMesh(), Everything()).empty()); }

TEST(CheckMesh, FindsNothingAtExtremeScales)
{
  for (const double scale : { 1e-12, 1e12, 1e-60, 1e60 })
  {
    const auto findings = CheckMesh(test::Scaled(test::IrregularSphere(2), scale), Everything());
    EXPECT_TRUE(findings.empty()) << scale << ": " << DescribeFindings(findings);
  }
}

TEST(CheckMesh, FindsIndicesOutOfRange)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Triangles(3, 1) = -1;
  mesh.Triangles(7, 0) = mesh.NumberOfPoints();
  mesh.Triangles(7, 2) = std::numeric_limits<Index>::max();
  ExpectOnly(CheckMesh(mesh, Everything()), MeshDefect::IndexOutOfRange, 2, 3);
  ExpectOnly(CheckMesh(mesh, Nothing()), MeshDefect::IndexOutOfRange, 2, 3);
}

TEST(CheckMesh, FindsNonFinitePoints)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Points(5, 2) = NaN;
  mesh.Points(9, 0) = -Infinity;
  mesh.Points(20, 1) = Infinity;
  ExpectOnly(CheckMesh(mesh, Everything()), MeshDefect::NonFinitePoint, 3, 5);
  ExpectOnly(CheckMesh(mesh, Nothing()), MeshDefect::NonFinitePoint, 3, 5);
}

TEST(CheckMesh, AcceptsNonFinitePointsThatNoTriangleUses)
{
  TriangleMesh mesh = test::WithUnreferencedPoints(test::Icosphere(1));
  mesh.Points(0, 0) = NaN;
  mesh.Points(6, 1) = Infinity;
  EXPECT_TRUE(CheckMesh(mesh, Everything()).empty());
}

TEST(CheckMesh, FindsRepeatedVertices)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Triangles(4, 2) = mesh.Triangles(4, 0);
  mesh.Triangles.row(11).setConstant(3);
  ExpectOnly(CheckMesh(mesh, Nothing()), MeshDefect::RepeatedVertex, 2, 4);
}

TEST(CheckMesh, FindsDegenerateTriangles)
{
  TriangleMesh mesh = test::PlanePatch(4, 4);
  // Two more triangles, on three points in a row and on coincident points.
  mesh.Points.conservativeResize(mesh.Points.rows() + 3, 3);
  mesh.Points.bottomRows(3).setConstant(4.0);
  const Index triangles = mesh.NumberOfTriangles();
  mesh.Triangles.conservativeResize(triangles + 2, 3);
  mesh.Triangles.row(triangles) << 10, 11, 12;
  mesh.Triangles.row(triangles + 1) << 25, 26, 27;
  ExpectOnly(CheckMesh(mesh, Nothing()), MeshDefect::DegenerateTriangle, 2, triangles);
}

TEST(CheckMesh, JudgesDegeneracyRelativeToTheLongestEdge)
{
  for (const double scale : { 1e-9, 1.0, 1e9 })
  {
    TriangleMesh mesh = test::SingleTriangle();
    mesh.Points.row(2) << 1.0, 1e-10, 0.0; // area 1e-10 on edge 2: thin, but not degenerate
    EXPECT_TRUE(CheckMesh(test::Scaled(mesh, scale)).empty()) << scale;
    mesh.Points(2, 1) = 1e-13; // area 1e-13, threshold 4e-12
    ExpectOnly(CheckMesh(test::Scaled(mesh, scale)), MeshDefect::DegenerateTriangle, 1, 0);
  }
}

TEST(CheckMesh, FindsNonManifoldEdges)
{
  // A third triangle on the edges 6-7 and 12-13 of a grid of 5 x 5 points.
  TriangleMesh mesh = test::PlanePatch(4, 4);
  mesh.Points.conservativeResize(26, 3);
  mesh.Points.row(25) << 0.5, 0.5, 1.0;
  const Index triangles = mesh.NumberOfTriangles();
  mesh.Triangles.conservativeResize(triangles + 2, 3);
  mesh.Triangles.row(triangles) << 7, 6, 25;
  mesh.Triangles.row(triangles + 1) << 12, 13, 25;
  ExpectOnly(CheckMesh(mesh), MeshDefect::NonManifoldEdge, 2, 6);
  EXPECT_TRUE(CheckMesh(mesh, Nothing()).empty());
}

TEST(CheckMesh, FindsDuplicateTriangles)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Triangles.conservativeResize(mesh.Triangles.rows() + 1, 3);
  mesh.Triangles.bottomRows(1) = mesh.Triangles.row(0);
  const auto findings = CheckMesh(mesh);
  ExpectOnly(findings, MeshDefect::NonManifoldEdge, 3, mesh.Triangles.row(0).minCoeff());
}

TEST(CheckMesh, FindsNonManifoldVerticesOnlyWhenAsked)
{
  // Two spheres that share their vertex 3, and two that share vertex 60.
  const TriangleMesh ball = test::Icosphere(1); // 42 points
  TriangleMesh mesh = test::Join(
    test::Join(ball, test::Translated(ball, { 5.0, 0.0, 0.0 })), test::Translated(ball, { 10.0, 0.0, 0.0 }));
  mesh.Triangles = mesh.Triangles.unaryExpr([](Index v) { return v == 45 ? 3 : v == 102 ? 60 : v; }).eval();
  MeshRequirements requirements;
  EXPECT_TRUE(CheckMesh(mesh, requirements).empty());
  requirements.ManifoldVertices = true;
  ExpectOnly(CheckMesh(mesh, requirements), MeshDefect::NonManifoldVertex, 2, 3);
}

TEST(CheckMesh, TwoFansOnAnOpenSurfaceAreANonManifoldVertex)
{
  // A bow tie: two triangles that share vertex 2.
  TriangleMesh mesh;
  mesh.Points.resize(5, 3);
  mesh.Points << 0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0, 2, 0, 1, 2, 0;
  mesh.Triangles.resize(2, 3);
  mesh.Triangles << 0, 1, 2, 2, 4, 3;
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  ExpectOnly(CheckMesh(mesh, requirements), MeshDefect::NonManifoldVertex, 1, 2);
}

TEST(CheckMesh, FindsInconsistentWindingOnlyWhenAsked)
{
  TriangleMesh mesh = test::Icosphere(2);
  const Eigen::Matrix<Index, 1, 3> turned = mesh.Triangles.row(50);
  std::swap(mesh.Triangles(50, 0), mesh.Triangles(50, 1));
  EXPECT_TRUE(CheckMesh(mesh).empty());
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  ExpectOnly(CheckMesh(mesh, requirements), MeshDefect::InconsistentWinding, 3, turned.minCoeff());
}

TEST(CheckMesh, FindsThatAMoebiusStripCannotBeOriented)
{
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  const auto findings = CheckMesh(test::MoebiusStrip(40, 5), requirements);
  ExpectOnly(findings, MeshDefect::InconsistentWinding, 5, 0); // the five edges of the seam
}

TEST(CheckMesh, FindsBoundaryEdgesOnlyWhenAsked)
{
  const TriangleMesh mesh = test::PlanePatch(7, 4);
  EXPECT_TRUE(CheckMesh(mesh).empty());
  MeshRequirements requirements;
  requirements.Closed = true;
  ExpectOnly(CheckMesh(mesh, requirements), MeshDefect::BoundaryEdge, 22, 0);
}

TEST(CheckMesh, FindsSeveralComponentsOnlyWhenAsked)
{
  const TriangleMesh ball = test::Icosphere(1);
  const TriangleMesh mesh = test::Join(
    test::Join(ball, test::Translated(ball, { 5.0, 0.0, 0.0 })), test::Translated(ball, { 10.0, 0.0, 0.0 }));
  EXPECT_TRUE(CheckMesh(mesh).empty());
  MeshRequirements requirements;
  requirements.SingleComponent = true;
  ExpectOnly(CheckMesh(mesh, requirements), MeshDefect::SeveralComponents, 3, 42);
}

TEST(CheckMesh, ReportsSeveralKindsInTheirOrder)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Points(5, 2) = NaN;
  mesh.Triangles(70, 2) = mesh.Triangles(70, 0);
  const auto findings = CheckMesh(mesh, Everything());
  ASSERT_EQ(findings.size(), 2U) << DescribeFindings(findings);
  EXPECT_EQ(findings[0].Defect, MeshDefect::NonFinitePoint);
  EXPECT_EQ(findings[1].Defect, MeshDefect::RepeatedVertex);
  const std::string text = DescribeFindings(findings);
  EXPECT_LT(text.find("point 5"), text.find("cell 70")) << text;
}

TEST(CheckMesh, TextUsesTheCallersCellIds)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Triangles(4, 2) = mesh.Triangles(4, 0);
  const auto findings = CheckMesh(mesh, Nothing());
  const std::string text = DescribeFindings(findings, [](std::int64_t f) { return 1000 + f; });
  EXPECT_NE(text.find("1004"), std::string::npos) << text;
  EXPECT_EQ(findings[0].First, 4);
}

TEST(CheckMesh, CountsAreTheSameForEveryNumberOfThreads)
{
  TriangleMesh mesh = test::Icosphere(6); // 81,920 triangles: above any sensible grain
  std::vector<Index> spoilt;
  for (Index f = 100; f < mesh.NumberOfTriangles(); f += 997)
  {
    mesh.Triangles(f, 2) = mesh.Triangles(f, 0);
    spoilt.push_back(f);
  }
  for (const int threads : { 1, 2, 3 })
  {
    const ThreadScope scope(threads);
    ExpectOnly(CheckMesh(mesh, Nothing()), MeshDefect::RepeatedVertex, static_cast<std::int64_t>(spoilt.size()), 100);
  }
}

TEST(RequireValidMesh, ThrowsInvalidInputWithTheDescription)
{
  TriangleMesh mesh = test::Icosphere(1);
  mesh.Points(5, 2) = NaN;
  try
  {
    RequireValidMesh(mesh);
    FAIL() << "no exception";
  }
  catch (const InvalidInput& error)
  {
    EXPECT_NE(std::string(error.what()).find(DescribeFindings(CheckMesh(mesh))), std::string::npos) << error.what();
  }
}
