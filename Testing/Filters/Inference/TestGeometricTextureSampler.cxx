// SPDX-License-Identifier: BSD-3-Clause
// Geometric textures synthesized on meshes: invariances, levels, noise, masks, errors.
#include "ExampleMeshes.h"
#include "InstructionSets.h"
#include "RandomGeometricTexture.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::AllOf;
using testing::HasSubstr;

namespace
{
const TriangleMesh& Surface()
{
  static const TriangleMesh mesh = test::BumpySurface(1);
  return mesh;
}

std::shared_ptr<const GeometricTextureModel> Model()
{
  return std::make_shared<const GeometricTextureModel>(test::RandomGeometricTexture());
}

const GeometricTextureSampler& Sampler()
{
  static const GeometricTextureSampler sampler(Model());
  return sampler;
}

GeometricTextureLevel Synthesized(const TriangleMesh& mesh, const GeometricTextureRequest& request = {})
{
  return Sampler().Synthesize(mesh, request);
}

GeometricTextureRequest Seeded(std::uint64_t seed)
{
  GeometricTextureRequest request;
  request.Seed = seed;
  return request;
}

GeometricTextureRequest WithoutNoise()
{
  GeometricTextureRequest request;
  request.NoiseAmplitude = 0.0;
  return request;
}

/// A sampler whose channels are normalized by the statistics of the template.
GeometricTextureSampler WithStatistics(std::int64_t flowSteps)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Options.FlowSteps = flowSteps;
  model.Statistics = MeasureStatistics(model, 2);
  return GeometricTextureSampler(std::make_shared<const GeometricTextureModel>(model));
}

const GeometricTextureSampler& NormalizedSampler()
{
  static const GeometricTextureSampler sampler = WithStatistics(0);
  return sampler;
}

/// The same of a flow.
const GeometricTextureSampler& NormalizedFlow()
{
  static const GeometricTextureSampler sampler = WithStatistics(3);
  return sampler;
}

TriangleMesh Finer(TriangleMesh mesh, int times)
{
  for (int k = 0; k < times; ++k)
  {
    mesh = SubdivideAtMidpoints(mesh).Mesh;
  }
  return mesh;
}

} // namespace

TEST(GeometricTextureSampler, InstructionSetsAgree)
{
  PointMatrix points;
  test::ForEachInstructionSet([&](InstructionSet set) {
    const GeometricTextureLevel found = GeometricTextureSampler(Model()).Synthesize(Surface(), Seeded(3));
    points = set == InstructionSet::Generic ? found.Mesh.Points : points;
    const double moved = (points - found.Base).norm();
    EXPECT_GT(moved, 0.0);
    EXPECT_LE((found.Mesh.Points - points).norm(), 1e-5 * moved) << static_cast<int>(set);
  });
}

// --- Levels ---------------------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, EachLevelButTheFirstRefines)
{
  std::vector<GeometricTextureLevel> levels;
  const GeometricTextureLevel last = Sampler().Synthesize(
    Surface(), {}, [&](const GeometricTextureLevel& level) { levels.push_back(level); });
  ASSERT_EQ(levels.size(), 2U);
  for (int k = 0; k < 2; ++k)
  {
    const TriangleMesh base = Finer(Surface(), k);
    EXPECT_EQ(levels[k].Level, k);
    EXPECT_EQ(levels[k].Mesh.Triangles, base.Triangles);
    EXPECT_LE((levels[k].Base - base.Points).cwiseAbs().maxCoeff(), 1e-15);
  }
  // Points are the base and the displacements of all levels, of which earlier ones are interpolated.
  const TriangleMesh moved = Finer({ levels[0].Displacement, Surface().Triangles }, 1);
  EXPECT_LE((levels[0].Mesh.Points - levels[0].Base - levels[0].Displacement).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE(
    (levels[1].Mesh.Points - levels[1].Base - levels[1].Displacement - moved.Points).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(last.Mesh.Points, levels[1].Mesh.Points);
  EXPECT_GT(levels[0].Displacement.norm(), 1e-3) << "something has grown";
  EXPECT_GT(levels[1].Displacement.norm(), 1e-3);
}

TEST(GeometricTextureSampler, FirstAndLastLevelCanBeChosen)
{
  GeometricTextureRequest request;
  const auto levelsOf = [&](int start, int end) {
    request.StartLevel = start;
    request.EndLevel = end;
    std::vector<int> levels;
    Sampler().Synthesize(
      Surface(), request, [&](const GeometricTextureLevel& level) { levels.push_back(level.Level); });
    return levels;
  };
  EXPECT_EQ(levelsOf(0, -1), (std::vector<int>{ 0, 1 }));
  EXPECT_EQ(levelsOf(0, 99), (std::vector<int>{ 0, 1 }));
  EXPECT_EQ(levelsOf(0, 0), (std::vector<int>{ 0 }));
  EXPECT_EQ(levelsOf(1, 1), (std::vector<int>{ 1 }));
  request.StartLevel = 1;
  request.EndLevel = 1;
  EXPECT_EQ(Synthesized(Surface(), request).Mesh.Triangles, Surface().Triangles)
    << "the first level takes the mesh as it is";
}

// --- Invariances ----------------------------------------------------------------------------------------------------

// Noise is not rotated with the mesh, so the texture is only rotated with it when it is synthesized without noise.
TEST(GeometricTextureSampler, TurnsAndMovesWithTheMesh)
{
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::RowVector3d offset(3.0, -2.0, 5.0);
  for (const TriangleMesh& mesh : { Surface(), test::PlanePatch(6, 5, 1.0, 1.0, 0.2), test::UvSphere(6, 30) })
  {
    TriangleMesh moved = mesh;
    moved.Points = (mesh.Points * rotation.transpose()).rowwise() + offset;
    const PointMatrix expected = (Synthesized(mesh, WithoutNoise()).Mesh.Points * rotation.transpose()).rowwise() +
      offset;
    EXPECT_LE(
      (Synthesized(moved, WithoutNoise()).Mesh.Points - expected).cwiseAbs().maxCoeff(), 1e-4 * MeanSideLength(mesh));
  }
}

TEST(GeometricTextureSampler, GrowsWithTheMesh)
{
  const PointMatrix expected = Synthesized(Surface()).Mesh.Points;
  for (const double factor : { 1e-12, 0.25, 3.0, 1e12 })
  {
    const PointMatrix found = Synthesized(test::Scaled(Surface(), factor)).Mesh.Points / factor;
    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-4 * MeanSideLength(Surface())) << factor;
  }
}

TEST(GeometricTextureSampler, DoesNotDependOnTheOrderOfTriangles)
{
  TriangleMesh permuted = Surface();
  const Index faces = permuted.NumberOfTriangles();
  ASSERT_EQ(faces, 80);
  for (Index f = 0; f < faces; ++f)
  {
    const Index from = static_cast<Index>((7 * std::int64_t(f) + 3) % faces); // 7 and 80 have no common divisor
    const int turn = f % 3;
    for (int k = 0; k < 3; ++k)
    {
      permuted.Triangles(f, k) = Surface().Triangles(from, (k + turn) % 3);
    }
  }
  GeometricTextureRequest request;
  request.LevelsWithoutNoise = { false, true }; // new vertices are numbered in another order
  const GeometricTextureLevel expected = Synthesized(Surface(), request);
  const GeometricTextureLevel found = Synthesized(permuted, request);
  const Index old = Surface().NumberOfPoints();
  EXPECT_LE(
    (found.Mesh.Points - expected.Mesh.Points).topRows(old).cwiseAbs().maxCoeff(), 1e-4 * MeanSideLength(Surface()));
  EXPECT_NEAR(found.Mesh.Points.norm(), expected.Mesh.Points.norm(), 1e-4 * MeanSideLength(Surface()));
}

TEST(GeometricTextureSampler, HasTheSameBitsForEveryNumberOfThreads)
{
  const TriangleMesh mesh = test::BumpySurface(3);
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    return Synthesized(mesh, Seeded(4)).Mesh.Points;
  };
  const PointMatrix one = with(1);
  EXPECT_EQ(with(2), one);
  EXPECT_EQ(with(3), one);
}

// --- Noise ----------------------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, SeedAndStreamGiveOtherNoise)
{
  const PointMatrix first = Synthesized(Surface(), Seeded(1)).Mesh.Points;
  EXPECT_EQ(Synthesized(Surface(), Seeded(1)).Mesh.Points, first);
  EXPECT_GT((Synthesized(Surface(), Seeded(2)).Mesh.Points - first).norm(), 1e-3);
  GeometricTextureRequest stream = Seeded(1);
  stream.Stream = 1;
  EXPECT_GT((Synthesized(Surface(), stream).Mesh.Points - first).norm(), 1e-3);
}

TEST(GeometricTextureSampler, InterpolationEndsAtBothSeeds)
{
  GeometricTextureRequest request = Seeded(1);
  request.SecondSeed = 2;
  const PointMatrix first = Synthesized(Surface(), Seeded(1)).Mesh.Points;
  const PointMatrix second = Synthesized(Surface(), Seeded(2)).Mesh.Points;
  EXPECT_EQ(Synthesized(Surface(), request).Mesh.Points, first);
  request.Interpolation = 1.0;
  EXPECT_EQ(Synthesized(Surface(), request).Mesh.Points, second);
  request.Interpolation = 0.5;
  const PointMatrix between = Synthesized(Surface(), request).Mesh.Points;
  EXPECT_GT((between - first).norm(), 1e-4);
  EXPECT_GT((between - second).norm(), 1e-4);
}

TEST(GeometricTextureSampler, LevelsWithoutNoiseDoNotDependOnTheSeed)
{
  const auto levelsOf = [](std::uint64_t seed, const std::vector<bool>& without) {
    GeometricTextureRequest request = Seeded(seed);
    request.LevelsWithoutNoise = without;
    std::vector<PointMatrix> points;
    Sampler().Synthesize(
      Surface(), request, [&](const GeometricTextureLevel& level) { points.push_back(level.Mesh.Points); });
    return points;
  };
  EXPECT_EQ(levelsOf(1, { true, true }), levelsOf(2, { true, true }));
  EXPECT_EQ(levelsOf(1, { true })[0], levelsOf(2, { true })[0]);
  EXPECT_NE(levelsOf(1, { true })[1], levelsOf(2, { true })[1]) << "later levels have noise";
  EXPECT_NE(levelsOf(1, { false, true })[0], levelsOf(2, { false, true })[0]);
  EXPECT_EQ(levelsOf(1, { true, true, true, true }).back(), Synthesized(Surface(), WithoutNoise()).Mesh.Points);
}

TEST(GeometricTextureSampler, TheAmplitudeIsThatOfTheModelUnlessGiven)
{
  GeometricTextureRequest request = Seeded(1);
  const PointMatrix own = Synthesized(Surface(), request).Mesh.Points;
  request.NoiseAmplitude = 0.1;
  EXPECT_EQ(Synthesized(Surface(), request).Mesh.Points, own);
  request.NoiseAmplitude = 0.2;
  EXPECT_GT((Synthesized(Surface(), request).Mesh.Points - own).norm(), 1e-4);
}

// --- Masks ----------------------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, AMaskOfZeroLeavesTheMeshAndOneChangesNothing)
{
  GeometricTextureRequest request = Seeded(1);
  const TriangleMesh far = test::Translated(Surface(), { 1e5, 0.1, -0.3 });
  request.Mask = Eigen::VectorXf::Zero(far.NumberOfPoints());
  EXPECT_EQ(Synthesized(far, request).Mesh.Points, Finer(far, 1).Points);
  request.Mask.setOnes();
  EXPECT_EQ(Synthesized(far, request).Mesh.Points, Synthesized(far, Seeded(1)).Mesh.Points);
}

TEST(GeometricTextureSampler, AMaskIsInterpolatedOnFinerLevels)
{
  GeometricTextureRequest request = Seeded(1);
  request.Mask = Eigen::VectorXf::Ones(Surface().NumberOfPoints());
  request.Mask[0] = 0.0F;
  const GeometricTextureLevel grown = Synthesized(Surface(), request);
  EXPECT_EQ(grown.Mesh.Points.row(0), Surface().Points.row(0));
  const SubdividedMesh fine = SubdivideAtMidpoints(Surface());
  for (std::size_t e = 0; e < fine.Parents.size(); ++e)
  {
    const Index v = Surface().NumberOfPoints() + static_cast<Index>(e);
    EXPECT_GT(grown.Displacement.row(v).norm(), 0.0) << "beside the vertex it is a half";
  }
}

// --- Statistics -----------------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, ATextureDependsOnTheTargetNearbyAlone)
{
  // A mask of a tenth of a plane, which is far wider than what the convolutions of both levels reach.
  const TriangleMesh plane = test::PlanePatch(120, 120, 120.0, 120.0, 0.3);
  GeometricTextureRequest request = Seeded(3);
  GeometricTextureRequest whole = Seeded(3);
  const auto within = [&](Index v, double half) {
    return (plane.Points.row(v).head<2>().array() - 60.0).abs().maxCoeff() <= half;
  };
  request.Mask.resize(plane.NumberOfPoints());
  for (Index v = 0; v < plane.NumberOfPoints(); ++v)
  {
    request.Mask[v] = within(v, 19.0) ? 1.0F : 0.0F;
  }
  const auto difference = [&](const GeometricTextureSampler& sampler, NormStatistics statistics) {
    request.Statistics = whole.Statistics = statistics;
    const PointMatrix masked = sampler.Synthesize(plane, request).Mesh.Points;
    const PointMatrix unmasked = sampler.Synthesize(plane, whole).Mesh.Points;
    double largest = 0.0;
    for (Index v = 0; v < plane.NumberOfPoints(); ++v)
    {
      largest = within(v, 12.0) ? std::max(largest, (masked.row(v) - unmasked.row(v)).cwiseAbs().maxCoeff()) : largest;
    }
    return largest;
  };
  for (const GeometricTextureSampler* sampler : { &NormalizedSampler(), &NormalizedFlow() })
  {
    EXPECT_EQ(difference(*sampler, NormStatistics::Reference), 0.0) << "the mask fades the result alone";
    EXPECT_GT(difference(*sampler, NormStatistics::Target), 1e-5) << "instance norms see the whole";
  }
  // Another shape far away changes nothing either.
  TriangleMesh one = plane, other = plane; // waves there that are upside down: edges keep their mean length
  for (Index v = 0; v < plane.NumberOfPoints(); ++v)
  {
    one.Points(v, 2) = within(v, 50.0) ? 0.0 : 0.3 * std::sin(plane.Points(v, 0));
    other.Points(v, 2) = -one.Points(v, 2);
  }
  whole.Statistics = NormStatistics::Reference;
  for (const GeometricTextureSampler* sampler : { &NormalizedSampler(), &NormalizedFlow() })
  {
    const auto movedOn = [&](const TriangleMesh& mesh) {
      const GeometricTextureLevel level = sampler->Synthesize(mesh, whole);
      return PointMatrix(level.Mesh.Points - level.Base);
    };
    const PointMatrix difference = (movedOn(one) - movedOn(other)).cwiseAbs();
    double inside = 0.0, outside = 0.0;
    for (Index v = 0; v < plane.NumberOfPoints(); ++v)
    {
      double& largest = within(v, 12.0) ? inside : outside;
      largest = std::max(largest, difference.row(v).maxCoeff());
    }
    EXPECT_LE(inside, 0.01 * outside) << "what is left is the unit of length";
    EXPECT_GT(outside, 1e-3);
  }
}

TEST(GeometricTextureSampler, ComponentsDoNotChangeEachOther)
{
  GeometricTextureRequest request;
  request.Statistics = NormStatistics::Reference;
  request.LevelsWithoutNoise = { false, true }; // numbers of finer vertices are others, and so is their noise
  const TriangleMesh& first = Surface();
  TriangleMesh two = first;
  const TriangleMesh second = test::Translated(first, { 50.0, 0.0, 0.0 });
  two.Points.conservativeResize(2 * first.NumberOfPoints(), 3);
  two.Points.bottomRows(first.NumberOfPoints()) = second.Points;
  two.Triangles.conservativeResize(2 * first.NumberOfTriangles(), 3);
  two.Triangles.bottomRows(first.NumberOfTriangles()) = second.Triangles.array() + first.NumberOfPoints();
  const Index coarse = first.NumberOfPoints();
  for (const GeometricTextureSampler* sampler : { &NormalizedSampler(), &NormalizedFlow() })
  {
    const auto alone = sampler->Synthesize(first, request).Mesh.Points;
    const auto beside = sampler->Synthesize(two, request).Mesh.Points;
    EXPECT_LE((beside.topRows(coarse) - alone.topRows(coarse)).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(GeometricTextureSampler, SizesGiveEachPlaceAUnitOfItsOwn)
{
  // A surface, and the same three times as large, become the same three times as large.
  const TriangleMesh small = Surface();
  const Eigen::Vector3d offset(20.0, 0.0, 0.0);
  const TriangleMesh both = test::Join(small, test::Translated(test::Scaled(small, 3.0), offset));
  const Index points = small.NumberOfPoints();
  GeometricTextureRequest request;
  request.NoiseAmplitude = 0.0;
  request.Sizes = Eigen::VectorXf::Ones(2 * points);
  const GeometricTextureLevel plain = Sampler().Synthesize(both, request);
  request.Sizes.tail(points).setConstant(3.0F);
  const GeometricTextureLevel sized = Sampler().Synthesize(both, request);
  const auto differenceOf = [&](const GeometricTextureLevel& level) {
    const PointMatrix way = level.Mesh.Points - level.Base;
    // Points of the target come first: those of the small surface, then those of the large one.
    return (way.middleRows(points, points) - 3.0 * way.topRows(points)).norm() / way.middleRows(points, points).norm();
  };
  EXPECT_LT(differenceOf(sized), 1e-4);
  EXPECT_GT(differenceOf(plain), 0.1) << "in one unit";
  // Equal sizes, whatever they are, change nothing but rounding.
  GeometricTextureRequest without;
  GeometricTextureRequest equal;
  equal.Sizes = Eigen::VectorXf::Constant(points, 7.0F);
  const PointMatrix expected = Sampler().Synthesize(small, without).Mesh.Points;
  EXPECT_LT((Sampler().Synthesize(small, equal).Mesh.Points - expected).cwiseAbs().maxCoeff(), 1e-5);
  equal.Sizes[0] = 0.0F;
  EXPECT_THAT(MessageOf([&] { Sampler().Synthesize(small, equal); }), HasSubstr("sizes"));
}

TEST(GeometricTextureSampler, AFlowIntegratesItsNetworkFromTheNoise)
{
  const auto flow = [](std::int64_t steps) {
    GeometricTextureModel model = test::RandomGeometricTexture();
    model.Options.FlowSteps = steps;
    return GeometricTextureSampler(std::make_shared<const GeometricTextureModel>(model));
  };
  GeometricTextureRequest request = Seeded(4);
  request.EndLevel = 0;
  request.Restarts = 0;
  // One step without noise is the network on the mesh itself.
  GeometricTextureRequest bare = WithoutNoise();
  bare.EndLevel = 0;
  EXPECT_TRUE(flow(1).Synthesize(Surface(), bare).Mesh.Points == Synthesized(Surface(), bare).Mesh.Points);
  // One step with noise moves by it as well: the displacement of the network that is no flow, and the noise.
  const PointMatrix once = flow(1).Synthesize(Surface(), request).Displacement;
  const PointMatrix noise = once - Synthesized(Surface(), request).Displacement;
  const double amplitude = Model()->Options.NoiseAmplitude * MeanEdgeLength(Surface(), MeshTopology(Surface()));
  EXPECT_NEAR(noise.norm() / std::sqrt(static_cast<double>(noise.size())), amplitude, 0.1 * amplitude);
  // More steps converge, at first order.
  const auto moved = [&](std::int64_t steps) { return flow(steps).Synthesize(Surface(), request).Displacement; };
  const PointMatrix exact = moved(400);
  const double coarse = (moved(10) - exact).norm(), fine = (moved(40) - exact).norm();
  EXPECT_LT(fine, 0.4 * coarse);
  EXPECT_GT(coarse, 1e-3 * exact.norm());
  EXPECT_NO_THROW(flow(2).Generate(0, request));
  EXPECT_THAT(MessageOf([&] { flow(2).Generate(1, request); }), HasSubstr("expected 0 (RandomFromLevel)"));
}

TEST(GeometricTextureSampler, ARestartGoesOnFromTheMiddleOfAFlowWithFreshNoise)
{
  const auto moved = [](std::int64_t steps, int restarts, double amplitude = -1.0) {
    GeometricTextureModel model = test::RandomGeometricTexture();
    model.Options.FlowSteps = steps;
    GeometricTextureRequest request = Seeded(4);
    request.EndLevel = 0;
    request.Restarts = restarts;
    request.NoiseAmplitude = amplitude;
    const GeometricTextureSampler sampler(std::make_shared<const GeometricTextureModel>(model));
    return sampler.Synthesize(Surface(), request).Displacement;
  };
  // With one step it begins with its noise alone: another sample, as large as the first.
  const PointMatrix first = moved(1, 0), second = moved(1, 1);
  EXPECT_LT(std::abs(first.cwiseProduct(second).sum()), 0.2 * first.norm() * second.norm());
  EXPECT_NEAR(second.norm() / first.norm(), 1.0, 0.1);
  // With many, the middle of a sample that is nearly its noise is half of it and half of fresh noise.
  const PointMatrix before = moved(8, 0), after = moved(8, 1);
  const double kept = before.cwiseProduct(after).sum() / before.squaredNorm();
  EXPECT_NEAR(kept, 0.5, 0.1);
  EXPECT_NEAR(after.norm() / before.norm(), std::sqrt(0.5), 0.1);
  EXPECT_TRUE(moved(8, -1) == moved(8, 3));
  EXPECT_FALSE(moved(8, 2) == moved(8, 3));
  EXPECT_TRUE(moved(8, 0, 0.0) == moved(8, 3, 0.0)) << "without noise there is nothing to draw again";
  EXPECT_TRUE(moved(0, 0) == moved(0, 3)) << "no flow";
  EXPECT_THAT(MessageOf([&] { moved(8, 21); }), HasSubstr("21 restarts"));
}

TEST(GeometricTextureSampler, AFlowHasStatisticsOfEachStep)
{
  // On the template itself, with the seed that they were measured with, they are those of the target: the same texture.
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Options.FlowSteps = 3;
  model.Statistics = MeasureStatistics(model, 1);
  const auto generated = [&](NormStatistics statistics) {
    GeometricTextureRequest request;
    request.Statistics = statistics;
    request.Restarts = 0;
    return GeometricTextureSampler(std::make_shared<const GeometricTextureModel>(model))
      .Generate(0, request)
      .Mesh.Points;
  };
  const PointMatrix own = generated(NormStatistics::Target);
  const double unit = MeanEdgeLength(model.Template, MeshTopology(model.Template));
  const double right = (generated(NormStatistics::Reference) - own).cwiseAbs().maxCoeff();
  EXPECT_LE(right, 1e-6 * unit);
  // Those of one step are not those of another.
  std::vector<float>& means = model.Statistics.at("levels.0.layers.1.mean").Values;
  std::rotate(means.begin(), means.begin() + 6, means.end());
  const double wrong = (generated(NormStatistics::Reference) - own).cwiseAbs().maxCoeff();
  EXPECT_GT(wrong, 100.0 * std::max(right, 1e-7 * unit));
}

TEST(GeometricTextureSampler, StatisticsAreThoseOfTheTargetUnlessTheReferencesAreAskedFor)
{
  GeometricTextureRequest request = Seeded(1);
  const PointMatrix own = Synthesized(Surface(), request).Mesh.Points;
  EXPECT_EQ(NormalizedSampler().Synthesize(Surface(), request).Mesh.Points, own);
  request.Statistics = NormStatistics::Reference;
  EXPECT_GT((NormalizedSampler().Synthesize(Surface(), request).Mesh.Points - own).norm(), 1e-3);
  EXPECT_THAT(MessageOf([&] { Synthesized(Surface(), request); }),
    AllOf(HasSubstr("has no statistics"), HasSubstr("texture-statistics")));
  EXPECT_THAT(MessageOf([&] { Sampler().Generate(0, request); }), HasSubstr("has no statistics"));
}

TEST(GeometricTextureSampler, StatisticsAreMeanAndVarianceOverSamples)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  const auto one = MeasureStatistics(model, 1);
  const auto two = MeasureStatistics(model, 2);
  model.Statistics = two;
  EXPECT_NO_THROW(CheckModel(model));
  EXPECT_EQ(MeasureStatistics(model, 2).at("levels.1.layers.2.mean").Values, two.at("levels.1.layers.2.mean").Values)
    << "those that the model has are of no account";
  EXPECT_NE(one.at("levels.0.layers.0.mean").Values, two.at("levels.0.layers.0.mean").Values);
  // The last norm has inputs of many triangles: the same within their scatter.
  const float first = one.at("levels.1.layers.2.variance").Values[0];
  EXPECT_NEAR(two.at("levels.1.layers.2.variance").Values[0], first, 0.5F * first);
  EXPECT_THAT(MessageOf([&] { MeasureStatistics(model, 0); }), HasSubstr("of 0 samples"));
  model.Template = {};
  model.ReconstructionNoise.resize(0, 3);
  EXPECT_THAT(MessageOf([&] { MeasureStatistics(model); }), HasSubstr("no template"));
  EXPECT_THROW(MeasureStatistics(test::RandomGeometricTexture(), 2, [](double) { return false; }), Cancelled);
}

// --- The template ---------------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, ReconstructionDoesNotDependOnTheSeed)
{
  const int levels = 2;
  const PointMatrix reconstruction = Sampler().Generate(levels, Seeded(1)).Mesh.Points;
  EXPECT_EQ(Sampler().Generate(levels, Seeded(2)).Mesh.Points, reconstruction);
  GeometricTextureModel other = test::RandomGeometricTexture();
  other.ReconstructionNoise *= 2.0F;
  const GeometricTextureSampler noisier(std::make_shared<const GeometricTextureModel>(other));
  EXPECT_GT((noisier.Generate(levels, Seeded(1)).Mesh.Points - reconstruction).norm(), 1e-4)
    << "depends on the stored noise";
}

TEST(GeometricTextureSampler, GenerationIsRandomFromTheLevelAskedFor)
{
  const auto levelsOf = [](int from, std::uint64_t seed) {
    std::vector<PointMatrix> points;
    Sampler().Generate(
      from, Seeded(seed), [&](const GeometricTextureLevel& level) { points.push_back(level.Mesh.Points); });
    return points;
  };
  const auto reconstruction = levelsOf(2, 1);
  EXPECT_EQ(levelsOf(1, 1)[0], reconstruction[0]);
  EXPECT_NE(levelsOf(1, 1)[1], reconstruction[1]);
  EXPECT_NE(levelsOf(1, 1)[1], levelsOf(1, 2)[1]);
  EXPECT_NE(levelsOf(0, 1)[0], levelsOf(0, 2)[0]);
}

TEST(GeometricTextureSampler, AModelWithoutATemplateCannotGenerate)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Template = {};
  model.ReconstructionNoise.resize(0, 3);
  const GeometricTextureSampler sampler(std::make_shared<const GeometricTextureModel>(model));
  EXPECT_THAT(MessageOf([&] { sampler.Generate(0, {}); }), HasSubstr("no template"));
  EXPECT_THAT(MessageOf([] { Sampler().Generate(-1, {}); }), HasSubstr("from level -1"));
  EXPECT_THAT(MessageOf([] { Sampler().Generate(3, {}); }), HasSubstr("expected 0 to 2"));
}

// --- Meshes and errors ----------------------------------------------------------------------------------------------

TEST(GeometricTextureSampler, SynthesizesOnEveryMeshOfTheSuiteThatIsWoundConsistently)
{
  GeometricTextureRequest request;
  request.EndLevel = 0;
  int grown = 0;
  for (const std::string& name : test::SuiteNames())
  {
    const test::SuiteMesh& suite = test::FromSuite(name);
    if (suite.ConsistentWinding)
    {
      EXPECT_TRUE(Synthesized(suite.Mesh, request).Mesh.Points.allFinite()) << name;
      ++grown;
    }
    else
    {
      EXPECT_THAT(MessageOf([&] { Synthesized(suite.Mesh, request); }), HasSubstr("opposite senses")) << name;
    }
  }
  EXPECT_GT(grown, 5);
}

TEST(GeometricTextureSampler, UnusedVerticesStayEvenWhereTheyAreNoNumbers)
{
  TriangleMesh mesh = Surface();
  const Index count = mesh.NumberOfPoints();
  mesh.Points.conservativeResize(count + 1, 3);
  mesh.Points.row(count).setConstant(std::numeric_limits<double>::quiet_NaN());
  GeometricTextureRequest request = WithoutNoise();
  request.EndLevel = 0;
  EXPECT_EQ(Synthesized(mesh, request).Mesh.Points.topRows(count), Synthesized(Surface(), request).Mesh.Points);
}

TEST(GeometricTextureSampler, RequestsOutOfTheirRangeAreNamed)
{
  const auto message = [](const std::function<void(GeometricTextureRequest&)>& change) {
    GeometricTextureRequest request;
    change(request);
    return MessageOf([&] { Synthesized(Surface(), request); });
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message([](GeometricTextureRequest& r) { r.StartLevel = -1; }),
    HasSubstr("StartLevel is -1; expected 0 to 1, the levels of the model."));
  EXPECT_THAT(message([](GeometricTextureRequest& r) { r.StartLevel = 2; }),
    HasSubstr("StartLevel is 2; expected 0 to 1, the levels of the model."));
  EXPECT_THAT(message([](GeometricTextureRequest& r) {
    r.StartLevel = 1;
    r.EndLevel = 0;
  }),
    HasSubstr("StartLevel is 1; expected 0 to 0 (EndLevel); the model has the levels 0 to 1."));
  EXPECT_THAT(
    message([](GeometricTextureRequest& r) { r.Interpolation = 1.5; }), HasSubstr("the interpolation is 1.5"));
  EXPECT_THAT(
    message([](GeometricTextureRequest& r) { r.Interpolation = nan; }), HasSubstr("the interpolation is nan"));
  EXPECT_THAT(message([](GeometricTextureRequest& r) { r.NoiseAmplitude = nan; }), HasSubstr("amplitude of the noise"));
  EXPECT_THAT(message([](GeometricTextureRequest& r) { r.Mask = Eigen::VectorXf::Ones(3); }),
    HasSubstr("the mask has 3 values; expected 42"));
  for (const float bad : { -0.5F, 1.5F, std::numeric_limits<float>::quiet_NaN() })
  {
    EXPECT_THAT(message([bad](GeometricTextureRequest& r) { r.Mask = Eigen::VectorXf::Constant(42, bad); }),
      HasSubstr("below 0 or above 1"));
  }
}

TEST(GeometricTextureSampler, MeshesThatCannotBeUsedAreNamed)
{
  EXPECT_THAT(MessageOf([] { Synthesized({}); }), HasSubstr("no triangle"));
  TriangleMesh mesh = Surface();
  std::swap(mesh.Triangles(0, 0), mesh.Triangles(0, 1));
  EXPECT_NE(MessageOf([&] { Synthesized(mesh); }), "accepted");
  mesh = Surface();
  mesh.Points(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_NE(MessageOf([&] { Synthesized(mesh); }), "accepted");
}

TEST(GeometricTextureSampler, ADisplacementThatIsNotFiniteIsAnError)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Generator.at("levels.0.layers.3.conv.weight").Values.assign(36, 3e38F);
  const GeometricTextureSampler sampler(std::make_shared<const GeometricTextureModel>(model));
  EXPECT_THAT(MessageOf([&] { sampler.Synthesize(Surface(), {}); }), HasSubstr("not finite"));
}

TEST(GeometricTextureSampler, AModelThatDoesNotFitIsRefused)
{
  GeometricTextureModel model = test::RandomGeometricTexture();
  model.Options.Levels = 3;
  EXPECT_THROW(GeometricTextureSampler(std::make_shared<const GeometricTextureModel>(model)), InvalidInput);
}

TEST(GeometricTextureSampler, ProgressRisesAndCanStop)
{
  std::vector<double> reports;
  Sampler().Synthesize(Surface(), {}, {}, [&](double fraction) {
    reports.push_back(fraction);
    return true;
  });
  EXPECT_GE(reports.size(), 20U);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_NEAR(reports.back(), 1.0, 1e-12);
  for (const double stop : { 0.0, 0.4, 0.9 })
  {
    EXPECT_THROW(
      Sampler().Synthesize(Surface(), {}, {}, [stop](double fraction) { return fraction < stop; }), Cancelled);
  }
}
