// SPDX-License-Identifier: BSD-3-Clause
//
// Tetrahedralize(), RunTetGen() and FindEnclosedRegions() on boxes inside boxes.
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleAdjacency.h"
#include "MeshProcessing/Tetrahedra/EnclosedRegions.h"
#include "MeshProcessing/Tetrahedra/TetGenClient.h"
#include "MeshProcessing/Tetrahedra/Tetrahedralizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

namespace
{
/// The surface of a cube of side @p side around the origin: 8 points, 12 triangles.
TriangleMesh Cube(double side)
{
  return Scaled(Translated(SurfaceOfCubes({ { 0, 0, 0 } }), { -0.5, -0.5, -0.5 }), side);
}

FilledSurface Filled(const TriangleMesh& surface, const TetrahedralizeOptions& options = {})
{
  return Tetrahedralize(surface, options, {}, {});
}

std::map<Index, double> RegionVolumes(const FilledSurface& mesh)
{
  std::map<Index, double> volumes;
  for (Index t = 0; t < static_cast<Index>(mesh.Tetrahedra.rows()); ++t)
  {
    const double volume = SixfoldVolume(mesh.Points, mesh.Tetrahedra, t) / 6.0;
    EXPECT_GT(volume, 0.0) << t;
    volumes[mesh.Regions[static_cast<std::size_t>(t)]] += volume;
  }
  return volumes;
}

SurfacePatches PatchesOf(const TriangleMesh& surface)
{
  return FindPatches(surface, TriangleAdjacency(surface, MeshTopology(surface)));
}

PointMatrix AllPoints(const TriangleMesh& surface, const TetGenMesh& mesh)
{
  PointMatrix points(surface.Points.rows() + mesh.NewPoints.rows(), 3);
  points << surface.Points, mesh.NewPoints;
  return points;
}

/// One tetrahedron whose faces are the surface.
TetGenMesh OneTetrahedron(const TriangleMesh& surface)
{
  TetGenMesh mesh;
  mesh.Tetrahedra.resize(1, 4);
  mesh.Tetrahedra << 0, 1, 2, 3;
  mesh.Regions = { 0 };
  mesh.Neighbors = TetrahedronMatrix::Constant(1, 4, -1);
  mesh.Faces = surface.Triangles;
  mesh.Triangles = { 0, 1, 2, 3 };
  return mesh;
}
} // namespace

// ---- Tetrahedralizer.h ----------------------------------------------------------------------------------------------

TEST(Tetrahedralizer, CubeHasItsVolumeAndKeepsItsSurface)
{
  const TriangleMesh cube = Cube(2.0);
  const FilledSurface mesh = Filled(cube);
  EXPECT_NEAR(RegionVolumes(mesh).at(0), 8.0, 1e-12);
  EXPECT_EQ(RegionVolumes(mesh).size(), 1U);
  EXPECT_EQ(mesh.Points.topRows(8), cube.Points);
  EXPECT_THAT(mesh.Patches, Each(0));
  ASSERT_EQ(mesh.Faces.rows(), 12); // no new points on the surface
  for (Index f = 0; f < 12; ++f)
  {
    auto face = mesh.Faces.row(f).eval();
    auto triangle = cube.Triangles.row(mesh.Triangles[static_cast<std::size_t>(f)]).eval();
    std::sort(face.data(), face.data() + 3);
    std::sort(triangle.data(), triangle.data() + 3);
    EXPECT_EQ(face, triangle) << f;
  }
}

TEST(Tetrahedralizer, LargestVolumeIsKept)
{
  TetrahedralizeOptions options;
  options.PreserveSurface = false;
  options.MaximumVolume = 0.05;
  const FilledSurface mesh = Filled(Cube(2.0), options);
  EXPECT_GE(mesh.Tetrahedra.rows(), 160);
  EXPECT_NEAR(RegionVolumes(mesh).at(0), 8.0, 1e-9);
  for (Index t = 0; t < static_cast<Index>(mesh.Tetrahedra.rows()); ++t)
  {
    EXPECT_LE(SixfoldVolume(mesh.Points, mesh.Tetrahedra, t) / 6.0, 0.05 * (1.0 + 1e-9));
  }
}

TEST(Tetrahedralizer, SphereIsFilledExactlyAnywhereAndAtAnyScale)
{
  for (const double scale : { 1.0, 1e-6, 1e6 })
  {
    const TriangleMesh sphere = Translated(Icosphere(2, scale), { 100.0 * scale, 0.0, 0.0 });
    const double volume = VolumeOf(Icosphere(2, scale));
    EXPECT_NEAR(RegionVolumes(Filled(sphere)).at(0), volume, 1e-9 * volume) << scale;
  }
}

TEST(Tetrahedralizer, NestedCubesAreRegionsOrHoles)
{
  const TriangleMesh nested = Join(Cube(3.0), Cube(1.0));
  const std::map<Index, double> volumes = RegionVolumes(Filled(nested));
  ASSERT_EQ(volumes.size(), 2U);
  EXPECT_NEAR(volumes.at(0), 26.0, 1e-9);
  EXPECT_NEAR(volumes.at(1), 1.0, 1e-9);
  TetrahedralizeOptions options;
  options.InnerSurfacesAreHoles = true;
  const std::map<Index, double> hollow = RegionVolumes(Filled(nested, options));
  ASSERT_EQ(hollow.size(), 1U);
  EXPECT_NEAR(hollow.at(0), 26.0, 1e-9);
}

TEST(Tetrahedralizer, ParametersOutOfRangeAreInvalid)
{
  const auto with = [](const std::function<void(TetrahedralizeOptions&)>& change) {
    return [change] {
      TetrahedralizeOptions options;
      change(options);
      Filled(Cube(1.0), options);
    };
  };
  EXPECT_THAT(with([](TetrahedralizeOptions& o) { o.QualityRatio = 0.5; }),
    ThrowsMessage<InvalidInput>("QualityRatio is 0.5; 0 for no bound, or a finite number of at least 1, is needed."));
  EXPECT_THAT(with([](TetrahedralizeOptions& o) { o.MinimumDihedralAngle = 61.0; }),
    ThrowsMessage<InvalidInput>("MinimumDihedralAngle is 61; an angle from 0 to 60 degrees is needed."));
  EXPECT_THAT(with([](TetrahedralizeOptions& o) { o.MaximumVolume = -1.0; }),
    ThrowsMessage<InvalidInput>("MaximumVolume is -1; a number of at least 0 is needed."));
  EXPECT_THAT(with([](TetrahedralizeOptions& o) { o.Seconds = -2.0; }),
    ThrowsMessage<InvalidInput>("TimeLimit is -2; a number of at least 0 is needed."));
}

TEST(Tetrahedralizer, CrossingSurfacesAreAFailureThatNamesCells)
{
  const TriangleMesh crossing = Join(Cube(2.0), Translated(Cube(2.0), { 0.9, 0.8, 0.7 }));
  EXPECT_THAT([&] { Tetrahedralize(crossing, {}, [](std::int64_t f) { return 1000 + f; }, {}); },
    ThrowsMessage<SolverFailure>(AllOf(HasSubstr("intersects or touches itself"), HasSubstr("first cell 10"))));
}

TEST(Tetrahedralizer, ProgressCanCancel)
{
  EXPECT_THROW(Tetrahedralize(Cube(1.0), {}, {}, [](double) { return false; }), Cancelled);
}

// ---- TetGenClient.h -------------------------------------------------------------------------------------------------

TEST(TetGenClient, ProgramOfTheEnvironmentIsTaken)
{
  setenv("SURFACE_SYNTHESIS_TETGEN", "/bin/sh", 1);
  EXPECT_EQ(FindTetGenProgram(), "/bin/sh");
  setenv("SURFACE_SYNTHESIS_TETGEN", "/nonexistent/tetgen", 1);
  EXPECT_THAT([] { FindTetGenProgram(); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("SURFACE_SYNTHESIS_TETGEN names /nonexistent/tetgen"),
      HasSubstr("the path of surfacesynthesis-tetgen"))));
  unsetenv("SURFACE_SYNTHESIS_TETGEN");
  EXPECT_THAT(FindTetGenProgram(), HasSubstr("/surfacesynthesis-tetgen"));
}

TEST(TetGenClient, ForgedRepliesAreFailuresThatNameTheProgram)
{
  const std::string real = FindTetGenProgram();
  const std::string forger = std::filesystem::absolute("forger.sh").string();
  setenv("SURFACE_SYNTHESIS_TETGEN", forger.c_str(), 1);
  const auto failureOf = [&](const std::string& change) {
    std::ofstream(forger) << "#!/bin/sh\n\"" << real << "\" " << change << "\n";
    std::filesystem::permissions(forger, std::filesystem::perms::owner_all);
    try
    {
      RunTetGen(Icosphere(1), {}, {});
    }
    catch (const SolverFailure& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(failureOf("| cat"), "accepted");
  EXPECT_THAT(
    failureOf("; head -c 65536 /dev/zero; sleep 5"), HasSubstr("answered with more than its header announces"));
  EXPECT_THAT(failureOf("| head -c 1000"), HasSubstr("without a complete mesh"));
  EXPECT_THAT(failureOf("| head -c 20"), HasSubstr("without a complete mesh"));
  EXPECT_THAT(failureOf("| tr '\\000' '\\377'"), HasSubstr("forger.sh answered with"));
  EXPECT_THAT(failureOf("| tr S T"), HasSubstr("answered with something that is no reply"));
  std::filesystem::remove(forger);
  unsetenv("SURFACE_SYNTHESIS_TETGEN");
}

TEST(TetGenClient, NeighborsShareAFace)
{
  const TriangleMesh sphere = Icosphere(2);
  TetGenCall call;
  call.WantNeighbors = true;
  const TetGenMesh mesh = RunTetGen(sphere, call, {});
  ASSERT_EQ(mesh.Neighbors.rows(), mesh.Tetrahedra.rows());
  Index outer = 0;
  for (Index t = 0; t < static_cast<Index>(mesh.Tetrahedra.rows()); ++t)
  {
    for (int k = 0; k < 4; ++k)
    {
      const Index other = mesh.Neighbors(t, k);
      outer += other < 0 ? 1 : 0;
      if (other >= 0)
      {
        const auto corners = mesh.Tetrahedra.row(other);
        int shared = 0;
        for (int c = 0; c < 4; ++c)
        {
          shared += c != k && (corners.array() == mesh.Tetrahedra(t, c)).any() ? 1 : 0;
        }
        EXPECT_EQ(shared, 3) << t; // the corners other than k
      }
    }
  }
  EXPECT_EQ(outer, sphere.NumberOfTriangles());
  call.WantNeighbors = false;
  EXPECT_EQ(RunTetGen(sphere, call, {}).Neighbors.size(), 0);
}

TEST(TetGenClient, SeedsNameRegions)
{
  TetGenCall call;
  tetgen::Seed between{};
  between.Place[0] = 0.6;
  between.Region = 5;
  tetgen::Seed inner{};
  inner.Region = -1; // left empty
  call.Seeds = { between, inner };
  const TriangleMesh nested = Join(Cube(1.5), Cube(1.0));
  const TetGenMesh mesh = RunTetGen(nested, call, {});
  EXPECT_THAT(mesh.Regions, Each(5));
  double volume = 0.0;
  const PointMatrix points = AllPoints(nested, mesh);
  for (Index t = 0; t < static_cast<Index>(mesh.Tetrahedra.rows()); ++t)
  {
    volume += SixfoldVolume(points, mesh.Tetrahedra, t) / 6.0;
  }
  EXPECT_NEAR(volume, 1.5 * 1.5 * 1.5 - 1.0, 1e-12);
}

// ---- EnclosedRegions.h ----------------------------------------------------------------------------------------------

TEST(EnclosedRegions, DepthCountsTheSurfacesAround)
{
  // A cube with a cavity, in which an island lies; and one beside it.
  TriangleMesh surface = Join(Join(Cube(0.9), Cube(0.6)), Cube(0.3));
  surface = Join(surface, Translated(Cube(0.5), { 1.0, 0.0, 0.0 }));
  TetGenCall call;
  call.WantNeighbors = true;
  const TetGenMesh mesh = RunTetGen(surface, call, {});
  const PointMatrix points = AllPoints(surface, mesh);
  const std::vector<EnclosedRegion> regions = FindEnclosedRegions(PatchesOf(surface), mesh, points);
  ASSERT_EQ(regions.size(), 4U);
  EXPECT_EQ(regions[0].Depth, 0);
  EXPECT_EQ(regions[1].Depth, 1);
  EXPECT_EQ(regions[2].Depth, 2);
  EXPECT_EQ(regions[3].Depth, 0);
  // The middle of the largest tetrahedron lies inside: largest coordinate of a cube between those around and within.
  const double halfSides[4][2] = { { 0.3, 0.45 }, { 0.15, 0.3 }, { 0.0, 0.15 }, { 0.0, 0.25 } };
  for (std::size_t r = 0; r < 4; ++r)
  {
    ASSERT_GE(regions[r].LargestTetrahedron, 0);
    Eigen::RowVector3d middle = r == 3 ? Eigen::RowVector3d(-1.0, 0.0, 0.0) : Eigen::RowVector3d::Zero();
    for (int k = 0; k < 4; ++k)
    {
      middle += 0.25 * points.row(mesh.Tetrahedra(regions[r].LargestTetrahedron, k));
    }
    EXPECT_GE(middle.cwiseAbs().maxCoeff(), halfSides[r][0]) << r;
    EXPECT_LT(middle.cwiseAbs().maxCoeff(), halfSides[r][1]) << r;
  }
}

TEST(EnclosedRegions, OfOneTetrahedronIsItself)
{
  const TriangleMesh surface = Tetrahedron();
  const std::vector<EnclosedRegion> regions = FindEnclosedRegions(
    PatchesOf(surface), OneTetrahedron(surface), surface.Points);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].Depth, 0);
  EXPECT_EQ(regions[0].LargestTetrahedron, 0);
}

TEST(EnclosedRegions, MissingFacesAreAFailure)
{
  const TriangleMesh surface = Tetrahedron();
  TetGenMesh mesh = OneTetrahedron(surface);
  mesh.Faces.resize(0, 3);
  mesh.Triangles.clear();
  EXPECT_THAT([&] { FindEnclosedRegions(PatchesOf(surface), mesh, surface.Points); },
    ThrowsMessage<SolverFailure>(
      AllOf(HasSubstr("do not keep the parts of the surface apart"), HasSubstr("vtkVDBSurfaceFilter"))));
}

TEST(SixfoldVolume, IsPositiveForTheWindingOfVtk)
{
  PointMatrix points(4, 3);
  points << 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4;
  TetrahedronMatrix tetrahedra(2, 4);
  tetrahedra << 0, 1, 2, 3, 0, 2, 1, 3;
  EXPECT_EQ(SixfoldVolume(points, tetrahedra, 0), 24.0);
  EXPECT_EQ(SixfoldVolume(points, tetrahedra, 1), -24.0);
}
