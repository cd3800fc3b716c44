// SPDX-License-Identifier: BSD-3-Clause
//
// SurfaceOfVolume() and SurfaceOfMesh(), and the level sets of meshes behind them, by volumes and distances that are
// known.
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"
#include "MeshProcessing/LevelSets/LevelSets.h"
#include "MeshProcessing/LevelSets/VolumeSurface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

namespace
{
const double Pi = std::acos(-1.0);
const StopFlag GoOn{ false };

double BallVolume(double radius) { return 4.0 / 3.0 * Pi * radius * radius * radius; }

/// Volume of a thin shell: the error of a ball whose radius is wrong by @p thickness.
double ShellVolume(double radius, double thickness) { return 4.0 * Pi * radius * radius * thickness; }

using Function = std::function<double(const Eigen::Vector3d&)>;

/// Samples of a distance, cut off at -1 and 1.
VolumeSamples SamplesOf(const std::array<int, 3>& dimensions, const Eigen::Vector3d& spacing, const Function& distance)
{
  VolumeSamples samples;
  samples.Dimensions = dimensions;
  samples.Spacing = spacing;
  for (int k = 0; k < dimensions[2]; ++k)
  {
    for (int j = 0; j < dimensions[1]; ++j)
    {
      for (int i = 0; i < dimensions[0]; ++i)
      {
        const double value = distance(spacing.cwiseProduct(Eigen::Vector3d(i, j, k)));
        samples.Values.push_back(static_cast<float>(std::clamp(value, -1.0, 1.0)));
      }
    }
  }
  return samples;
}

Function Ball(const Eigen::Vector3d& center, double radius)
{
  return [=](const Eigen::Vector3d& point) { return (point - center).norm() - radius; };
}

LevelSetOptions WithVoxels(double size)
{
  LevelSetOptions options;
  options.VoxelSize = size;
  return options;
}

std::int64_t ComponentsOf(const TriangleMesh& mesh)
{
  return static_cast<std::int64_t>(ComputeMeshStatistics(mesh).Components.size());
}

TriangleMesh Turned(TriangleMesh mesh)
{
  mesh.Triangles.col(1).swap(mesh.Triangles.col(2));
  return mesh;
}
} // namespace

// ---- VolumeSurface.h ------------------------------------------------------------------------------------------------

TEST(SurfaceOfVolume, BallHasItsVolumeAndArea)
{
  const double radius = 10.3;
  const VolumeSamples samples = SamplesOf({ 27, 27, 27 }, Eigen::Vector3d::Ones(), Ball({ 13, 13, 13 }, radius));
  const TriangleMesh surface = SurfaceOfVolume(samples, {}, GoOn);
  EXPECT_EQ(DefectsOf(surface), "");
  EXPECT_EQ(EulerCharacteristicOf(surface), 2);
  EXPECT_NEAR(VolumeOf(surface), BallVolume(radius), ShellVolume(radius, 0.05));
  EXPECT_NEAR(AreaOf(surface), 4.0 * Pi * radius * radius, 0.02 * 4.0 * Pi * radius * radius);
  for (const auto& point : surface.Points.rowwise())
  {
    EXPECT_NEAR((point - Eigen::RowVector3d(13, 13, 13)).norm(), radius, 0.1);
  }
}

TEST(SurfaceOfVolume, SpacingIsWorldUnits)
{
  const Eigen::Vector3d spacing(0.5, 1.0, 0.25);
  const VolumeSamples samples = SamplesOf({ 40, 20, 80 }, spacing, Ball({ 10, 10, 10 }, 7.0));
  for (const double voxels : { 0.0, 0.4 }) // of the samples, and resampled
  {
    const TriangleMesh surface = SurfaceOfVolume(samples, WithVoxels(voxels), GoOn);
    EXPECT_EQ(DefectsOf(surface), "");
    EXPECT_NEAR(VolumeOf(surface), BallVolume(7.0), 0.02 * BallVolume(7.0)) << voxels;
  }
}

TEST(SurfaceOfVolume, SolidIsCappedHalfASampleBeyondTheLastOnes)
{
  const auto inside = [](const Eigen::Vector3d&) { return -1.0; };
  const TriangleMesh box = SurfaceOfVolume(SamplesOf({ 10, 12, 14 }, Eigen::Vector3d::Ones(), inside), {}, GoOn);
  EXPECT_EQ(DefectsOf(box), "");
  // The meshing cuts edges off, by a quarter of a square voxel, and corners by as much as a few of the cells around
  // them.
  EXPECT_NEAR(VolumeOf(box), 10.0 * 12.0 * 14.0 - 0.25 * 4.0 * (10.0 + 12.0 + 14.0), 3.0);
  const BoundingBox bounds = ComputeBoundingBox(box);
  EXPECT_NEAR((bounds.Lower - Eigen::Vector3d(-0.5, -0.5, -0.5)).norm(), 0.0, 1e-5);
  EXPECT_NEAR((bounds.Upper - Eigen::Vector3d(9.5, 11.5, 13.5)).norm(), 0.0, 1e-5);
}

TEST(SurfaceOfVolume, NothingInsideIsAnEmptyMesh)
{
  const auto outside = [](const Eigen::Vector3d&) { return 1.0; };
  const TriangleMesh surface = SurfaceOfVolume(SamplesOf({ 6, 6, 6 }, Eigen::Vector3d::Ones(), outside), {}, GoOn);
  EXPECT_EQ(surface.NumberOfTriangles(), 0);
}

TEST(SurfaceOfVolume, PartsAndCavitiesGoWhenAsked)
{
  const Function hollow = [](const Eigen::Vector3d& point) {
    const double shell = std::abs((point - Eigen::Vector3d(12, 12, 12)).norm() - 7.0) - 2.0;
    return std::min(shell, (point - Eigen::Vector3d(26, 12, 12)).norm() - 3.0);
  };
  const VolumeSamples samples = SamplesOf({ 32, 25, 25 }, Eigen::Vector3d::Ones(), hollow);
  EXPECT_EQ(ComponentsOf(SurfaceOfVolume(samples, {}, GoOn)), 3);
  LevelSetOptions options;
  options.FillCavities = true;
  EXPECT_EQ(ComponentsOf(SurfaceOfVolume(samples, options, GoOn)), 2);
  options.LargestComponent = true;
  const TriangleMesh ball = SurfaceOfVolume(samples, options, GoOn);
  EXPECT_EQ(ComponentsOf(ball), 1);
  EXPECT_NEAR(VolumeOf(ball), BallVolume(9.0), 0.02 * BallVolume(9.0));
}

TEST(SurfaceOfMesh, SphereKeepsItsVolume)
{
  const TriangleMesh sphere = Icosphere(4);
  for (const TriangleMesh& mesh : { sphere, Turned(sphere) })
  {
    const TriangleMesh surface = SurfaceOfMesh(mesh, WithVoxels(0.05), GoOn);
    EXPECT_EQ(DefectsOf(surface), "");
    EXPECT_EQ(EulerCharacteristicOf(surface), 2);
    EXPECT_NEAR(VolumeOf(surface), VolumeOf(sphere), 0.01 * VolumeOf(sphere)); // wound outwards
    EXPECT_LT((surface.Points.rowwise().norm().array() - 1.0).abs().maxCoeff(), 0.02);
  }
}

TEST(SurfaceOfMesh, OffsetMovesTheSurface)
{
  for (const double offset : { -0.2, 0.2 })
  {
    LevelSetOptions options = WithVoxels(0.05);
    options.Offset = offset;
    const TriangleMesh surface = SurfaceOfMesh(Icosphere(4), options, GoOn);
    EXPECT_EQ(DefectsOf(surface), "");
    EXPECT_NEAR(VolumeOf(surface), BallVolume(1.0 + offset), 0.03 * BallVolume(1.0 + offset)) << offset;
  }
}

TEST(SurfaceOfMesh, OpenMeshBecomesAPlateOfTwoVoxels)
{
  const TriangleMesh plate = SurfaceOfMesh(PlanePatch(4, 4, 2.0, 2.0), WithVoxels(0.05), GoOn);
  EXPECT_EQ(DefectsOf(plate), "");
  const double thickness = 2.0 * 0.05;
  // A round rim of half the thickness comes on top.
  const double rim = 8.0 * 0.5 * Pi * 0.25 * thickness * thickness;
  EXPECT_GT(VolumeOf(plate), 4.0 * thickness);
  EXPECT_LT(VolumeOf(plate), 4.0 * thickness + rim);
}

TEST(SurfaceOfMesh, ClosingBridgesAHole)
{
  const TriangleMesh open = SphereWithoutCap(4, 0.97);
  LevelSetOptions options = WithVoxels(0.05);
  const double leaking = VolumeOf(SurfaceOfMesh(open, options, GoOn));
  EXPECT_LT(leaking, 0.5 * BallVolume(1.0)); // a thin shell
  options.Closing = 0.3;
  const TriangleMesh closed = SurfaceOfMesh(open, options, GoOn);
  EXPECT_EQ(DefectsOf(closed), "");
  EXPECT_NEAR(VolumeOf(closed), BallVolume(1.0), 0.05 * BallVolume(1.0));
}

TEST(SurfaceOfMesh, SinglePrecisionRoundsThePoints)
{
  LevelSetOptions options = WithVoxels(0.1);
  options.SinglePrecision = true;
  const TriangleMesh surface = SurfaceOfMesh(Translated(Icosphere(3), { 0.1, 0.2, 0.3 }), options, GoOn);
  EXPECT_EQ(DefectsOf(surface), "");
  EXPECT_EQ(surface.Points, PointMatrix(surface.Points.cast<float>().cast<double>()));
}

TEST(SurfaceOfMesh, UnusableMeshesAndTooManyVoxelsAreInvalid)
{
  TriangleMesh point = SingleTriangle();
  point.Points.setZero();
  EXPECT_THAT([&] { SurfaceOfMesh(point, {}, GoOn); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("span a box of longest side 0"), HasSubstr("are needed"))));
  TriangleMesh needle = SingleTriangle();
  needle.Points.row(2) = needle.Points.row(1);
  EXPECT_THAT([&] { SurfaceOfMesh(needle, {}, GoOn); },
    ThrowsMessage<InvalidInput>(HasSubstr("No triangle of the surface has an area")));
  LevelSetOptions options = WithVoxels(0.001);
  options.MaximumNumberOfVoxels = 1e6;
  EXPECT_THAT([&] { SurfaceOfMesh(Icosphere(3), options, GoOn); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("voxels of size 0.001"), HasSubstr("at most 1e+06"),
      HasSubstr("MaximumNumberOfVoxels raises the limit"))));
}

TEST(SurfaceOfMesh, AVoxelLargerThanTheSurfaceIsInvalid)
{
  const auto larger = [](double size) {
    return AllOf(HasSubstr("VoxelSize is " + FormatNumber(size) + ", larger than the surface"),
      HasSubstr("spans a box of longest side "));
  };
  const TriangleMesh sphere = Icosphere(3);
  for (const double size : { 2.001, 1e30, 1e300 })
  {
    EXPECT_THAT([&] { SurfaceOfMesh(sphere, WithVoxels(size), GoOn); }, ThrowsMessage<InvalidInput>(larger(size)));
  }
  EXPECT_GT(SurfaceOfMesh(sphere, WithVoxels(1.0), GoOn).NumberOfTriangles(), 0);
  LevelSetOptions moved = WithVoxels(4.0);
  moved.Offset = 20.0;
  EXPECT_GT(SurfaceOfMesh(sphere, moved, GoOn).NumberOfTriangles(), 100) << "the sphere of radius 21";
  const VolumeSamples samples = SamplesOf({ 20, 20, 20 }, Eigen::Vector3d::Ones(), Ball({ 10, 10, 10 }, 7.0));
  EXPECT_THAT([&] { SurfaceOfVolume(samples, WithVoxels(16.0), GoOn); }, ThrowsMessage<InvalidInput>(larger(16.0)));
  EXPECT_GT(SurfaceOfVolume(samples, WithVoxels(3.0), GoOn).NumberOfTriangles(), 0);
}

TEST(SurfaceOfMesh, StopIsCancelled)
{
  const StopFlag stop{ true };
  EXPECT_THROW(SurfaceOfMesh(Icosphere(3), WithVoxels(0.05), stop), Cancelled);
  const VolumeSamples samples = SamplesOf({ 20, 20, 20 }, Eigen::Vector3d::Ones(), Ball({ 10, 10, 10 }, 7.0));
  EXPECT_THROW(SurfaceOfVolume(samples, {}, stop), Cancelled);
}

// ---- MeshDistances.cxx ----------------------------------------------------------------------------------------------

class MeshDistances : public ::testing::Test
{
protected:
  void SetUp() override { openvdb::initialize(); }

  /// The largest error of the distances of at most @p within to a sphere of this radius around the origin.
  static double LargestError(const openvdb::FloatGrid& grid, double radius, double within)
  {
    double largest = 0.0;
    for (auto value = grid.cbeginValueOn(); value; ++value)
    {
      const openvdb::Vec3d at = value.getCoord().asVec3d();
      const double distance = at.length() - radius;
      largest = std::max(largest, std::abs(distance) <= within ? std::abs(*value - distance) : 0.0);
    }
    return largest;
  }
  static float At(const openvdb::FloatGrid& grid, int x)
  {
    return grid.getConstAccessor().getValue(openvdb::Coord(x, 0, 0));
  }

  StopInterrupter Interrupter{ GoOn };
};

TEST_F(MeshDistances, OfASphereAreSignedAndExact)
{
  // The triangles lie up to 0.02 below the sphere of radius 12.
  const auto grid = LevelSetOfOrientedMesh(Icosphere(4, 12.0), this->Interrupter);
  EXPECT_GT(grid->activeVoxelCount(), 5000U);
  EXPECT_LT(LargestError(*grid, 12.0, 1.0), 0.05);
  EXPECT_LT(LargestError(*grid, 12.0, HalfWidth), 0.4); // OpenVDB's err by a few tenths three voxels away
  EXPECT_EQ(At(*grid, 0), -HalfWidth);
  EXPECT_EQ(At(*grid, 40), HalfWidth);
  EXPECT_TRUE(IsConsistent(*grid));
}

TEST_F(MeshDistances, CavityIsOutside)
{
  const TriangleMesh shell = Join(Icosphere(4, 20.0), Turned(Icosphere(3, 10.0)));
  const auto grid = LevelSetOfOrientedMesh(shell, this->Interrupter);
  EXPECT_TRUE(IsConsistent(*grid));
  EXPECT_GT(At(*grid, 0), 0.0F);
  EXPECT_LT(At(*grid, 15), 0.0F);
  EXPECT_GT(At(*grid, 25), 0.0F);
}

TEST_F(MeshDistances, NestedPartsOfTheSameWindingAreNotConsistent)
{
  const TriangleMesh nested = Join(Icosphere(4, 20.0), Icosphere(3, 10.0));
  EXPECT_FALSE(IsConsistent(*LevelSetOfOrientedMesh(nested, this->Interrupter)));
}

TEST_F(MeshDistances, OfASoupNeedNoWinding)
{
  TriangleMesh mixed = Icosphere(4, 12.0);
  for (Index f = 0; f < mixed.NumberOfTriangles(); f += 3)
  {
    std::swap(mixed.Triangles(f, 1), mixed.Triangles(f, 2));
  }
  const auto grid = LevelSetOfSoup(mixed, 0.0, this->Interrupter);
  EXPECT_LT(LargestError(*grid, 12.0, 1.0), 0.05);
  EXPECT_LT(LargestError(*grid, 12.0, HalfWidth), 0.4);
  EXPECT_EQ(At(*grid, 0), -HalfWidth);
  EXPECT_EQ(At(*grid, 40), HalfWidth);
}

TEST_F(MeshDistances, MoveSurfaceAddsToTheRadius)
{
  for (const double distance : { -4.0, 2.5 })
  {
    const auto grid = LevelSetOfOrientedMesh(Icosphere(4, 12.0), this->Interrupter);
    MoveSurface(*grid, distance, this->Interrupter);
    const TriangleMesh moved = MeshOfGrid(*grid, 0.0, 0.0);
    EXPECT_NEAR(VolumeOf(moved), BallVolume(12.0 + distance), ShellVolume(12.0 + distance, 0.1)) << distance;
  }
}

TEST_F(MeshDistances, MeshOfGridIsTheIsosurfaceWoundOutwards)
{
  const auto grid = LevelSetOfOrientedMesh(Icosphere(4, 12.0), this->Interrupter);
  for (const double isoValue : { -1.0, 0.0, 1.0 })
  {
    const double radius = 12.0 + isoValue;
    EXPECT_NEAR(VolumeOf(MeshOfGrid(*grid, isoValue, 0.0)), BallVolume(radius), ShellVolume(radius, 0.1)) << isoValue;
  }
}
