// SPDX-License-Identifier: BSD-3-Clause
//
// PoseHandles and SurfacePoses on a cross of cubes: four arms of different length.
#include "ExampleMeshes.h"
#include "MeshChecks.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/MeshTopology.h"
#include "MeshProcessing/Poses/PoseHandles.h"
#include "MeshProcessing/Poses/SurfacePoses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <set>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

namespace
{
/// Lengths of the arms along +x, -x, +y, -y.
constexpr std::array<int, 4> Arms = { 12, 9, 7, 6 };

/// Arms of unit cubes around the cube [-0.5, 0.5]^3, each face of a cube with eight triangles.
TriangleMesh Cross()
{
  std::set<UnitCube> cubes = { { 0, 0, 0 } };
  for (int arm = 0; arm < 4; ++arm)
  {
    for (int k = 1; k <= Arms[arm]; ++k)
    {
      UnitCube cube = { 0, 0, 0 };
      cube[arm / 2] = arm % 2 == 0 ? k : -k;
      cubes.insert(cube);
    }
  }
  return Translated(Subdivide(SurfaceOfCubes(cubes)), { -0.5, -0.5, -0.5 });
}

PoseHandleOptions FourHandles()
{
  PoseHandleOptions options;
  options.NumberOfHandles = 4;
  return options;
}

PoseHandles HandlesOf(const TriangleMesh& shape, const PoseHandleOptions& options = FourHandles())
{
  return PoseHandles(shape, MeshTopology(shape), options, NearestPlaces);
}

/// The poses by sample.
std::map<std::uint32_t, PointMatrix> Sampled(const SurfacePoses& poses, const PoseRequest& request)
{
  std::map<std::uint32_t, PointMatrix> samples;
  std::mutex mutex;
  poses.Sample(request, [&](std::uint32_t sample, PointMatrix points) {
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_TRUE(samples.emplace(sample, std::move(points)).second) << sample;
  });
  return samples;
}

PoseOptions Gentle()
{
  PoseOptions options;
  options.MaximumAngle = 40.0;
  options.NumberOfIterations = 8;
  return options;
}

PoseRequest Request(std::uint64_t seed, std::uint32_t first, std::uint32_t count)
{
  PoseRequest request;
  request.Seed = seed;
  request.FirstSample = first;
  request.NumberOfSamples = count;
  return request;
}
} // namespace

TEST(PoseHandles, ExtremitiesOfACrossAreTheEndsOfItsArms)
{
  const PoseHandles handles = HandlesOf(Cross());
  ASSERT_EQ(handles.Handles().size(), 4U);
  std::set<int> arms;
  for (const PoseHandle& handle : handles.Handles())
  {
    int axis = 0;
    handle.Center.cwiseAbs().maxCoeff(&axis);
    const int arm = 2 * axis + (handle.Center[axis] > 0.0 ? 0 : 1);
    arms.insert(arm);
    EXPECT_EQ(std::abs(handle.Center[axis]), Arms[arm] + 0.5); // on the face at the end
    // The joint lies on the axis of the arm, nearer to the middle than to the end.
    EXPECT_GT(handle.Pivot[axis] * handle.Center[axis], 0.0);
    EXPECT_LT(std::abs(handle.Pivot[axis]), 0.5 * Arms[arm]);
    for (int other = 0; other < 3; ++other)
    {
      EXPECT_LT(other == axis ? 0.0 : std::abs(handle.Pivot[other]), 0.1);
    }
  }
  EXPECT_EQ(arms, (std::set<int>{ 0, 1, 2, 3 }));
  // The longest arm comes first.
  EXPECT_EQ(handles.Handles()[0].Center[0], Arms[0] + 0.5);
}

TEST(PoseHandles, SizeIsTheRootOfTheArea)
{
  const int cubes = 1 + Arms[0] + Arms[1] + Arms[2] + Arms[3];
  EXPECT_NEAR(HandlesOf(Cross()).Size(), std::sqrt(4.0 * cubes + 2.0), 1e-9);
}

TEST(PoseHandles, RegionsAreTheEndsAndTheMiddle)
{
  const PoseHandles handles = HandlesOf(Cross());
  const TriangleMesh other = WithUnreferencedPoints(Subdivide(Cross())); // another triangulation
  const std::vector<int> regions = handles.Regions(other);
  ASSERT_EQ(regions.size(), static_cast<std::size_t>(other.NumberOfPoints()));
  std::vector<bool> isUsed(regions.size(), false);
  for (Eigen::Index corner = 0; corner < other.Triangles.size(); ++corner)
  {
    isUsed[other.Triangles.data()[corner]] = true;
  }
  std::map<int, int> counts;
  const double radius = FourHandles().HandleRadius * handles.Size();
  for (std::size_t v = 0; v < regions.size(); ++v)
  {
    const Eigen::Vector3d point = other.Points.row(static_cast<Eigen::Index>(v)).transpose();
    ++counts[regions[v]];
    if (!isUsed[v])
    {
      EXPECT_EQ(regions[v], PoseHandles::Free) << v;
    }
    else if (regions[v] == 4)
    {
      EXPECT_LT(point.norm(), 4.0) << v; // what stays
    }
    else if (regions[v] != PoseHandles::Free)
    {
      EXPECT_LT((point - handles.Handles()[regions[v]].Center).norm(), 1.05 * radius) << v;
    }
  }
  EXPECT_EQ(counts.size(), 6U); // four ends, what stays, and what lies between
}

TEST(PoseHandles, TooManyHandlesAndOtherShapesAreInvalid)
{
  PoseHandleOptions options = FourHandles();
  options.NumberOfHandles = 200;
  EXPECT_THAT([&] { HandlesOf(Cross(), options); },
    ThrowsMessage<InvalidInput>(AllOf(HasSubstr("There is no room for handle"), HasSubstr("of 200"))));
  options = FourHandles();
  options.HandleRadius = 0.35;
  options.NumberOfHandles = 2;
  EXPECT_THAT(
    [&] { HandlesOf(Cross(), options); }, ThrowsMessage<InvalidInput>(HasSubstr("Nothing of the shape stays")));
  const PoseHandles handles = HandlesOf(Cross());
  EXPECT_THAT([&] { handles.Regions(Scaled(Tetrahedron(), 0.1)); },
    ThrowsMessage<InvalidInput>(HasSubstr("Handle 0 has no point of the surface")));
}

TEST(PoseHandles, ProgressCanCancel)
{
  const TriangleMesh cross = Cross();
  EXPECT_THROW(
    PoseHandles(cross, MeshTopology(cross), FourHandles(), NearestPlaces, [](double) { return false; }), Cancelled);
}

TEST(SurfacePoses, AngleZeroIsTheShapeItself)
{
  // Rounding errors grow from one of the fourteen solves to the next; an edge is 0.5 long.
  constexpr double rounding = 1e-7;
  const TriangleMesh cross = Cross();
  PoseOptions options = Gentle();
  options.MaximumAngle = options.MaximumTwist = 0.0;
  const SurfacePoses poses(cross, HandlesOf(cross), options);
  for (const auto& [sample, points] : Sampled(poses, Request(1, 0, 2)))
  {
    EXPECT_LT((points - cross.Points).cwiseAbs().maxCoeff(), rounding) << sample;
  }
}

TEST(SurfacePoses, HandlesTurnRigidlyAndTheMiddleStays)
{
  const TriangleMesh cross = Cross();
  const SurfacePoses poses(cross, HandlesOf(cross), Gentle());
  for (const auto& [sample, points] : Sampled(poses, Request(7, 0, 3)))
  {
    ASSERT_TRUE(points.allFinite());
    std::array<Index, 4> first = { -1, -1, -1, -1 };
    double largestMove = 0.0;
    for (Index v = 0; v < cross.NumberOfPoints(); ++v)
    {
      const int region = poses.Regions()[v];
      largestMove = std::max(largestMove, (points.row(v) - cross.Points.row(v)).norm());
      if (region == 4)
      {
        EXPECT_LT((points.row(v) - cross.Points.row(v)).norm(), 1e-12) << v;
      }
      else if (region != PoseHandles::Free)
      {
        first[region] = first[region] < 0 ? v : first[region];
        const Index p = first[region];
        const double before = (cross.Points.row(v) - cross.Points.row(p)).norm();
        EXPECT_NEAR((points.row(v) - points.row(p)).norm(), before, 1e-9) << v;
      }
    }
    EXPECT_GT(largestMove, 0.5) << sample;
  }
}

TEST(SurfacePoses, SampleIsAFunctionOfSeedAndNumberOnly)
{
  const TriangleMesh cross = Cross();
  const SurfacePoses poses(cross, HandlesOf(cross), Gentle());
  const auto batch = Sampled(poses, Request(7, 0, 3));
  ASSERT_EQ(batch.size(), 3U);
  const auto alone = Sampled(poses, Request(7, 2, 1));
  ASSERT_EQ(alone.size(), 1U);
  EXPECT_EQ(alone.at(2), batch.at(2));
  {
    const ThreadScope one(1);
    EXPECT_EQ(Sampled(poses, Request(7, 0, 3)), batch);
  }
  EXPECT_NE(batch.at(0), batch.at(1));
  EXPECT_NE(Sampled(poses, Request(8, 0, 1)).at(0), batch.at(0));
  PoseRequest stream = Request(7, 0, 1);
  stream.Stream = 1;
  EXPECT_NE(Sampled(poses, stream).at(0), batch.at(0));
}

TEST(SurfacePoses, ProgressIsMonotoneAndCanCancel)
{
  const TriangleMesh cross = Cross();
  const SurfacePoses poses(cross, HandlesOf(cross), Gentle());
  std::vector<double> fractions;
  poses.Sample(
    Request(1, 0, 2), [](std::uint32_t, const PointMatrix&) {},
    [&](double fraction) {
      fractions.push_back(fraction);
      return true;
    });
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_THROW(poses.Sample(
                 Request(1, 0, 2), [](std::uint32_t, const PointMatrix&) {}, [](double) { return false; }),
    Cancelled);
}
