// SPDX-License-Identifier: BSD-3-Clause
// Diffusion of field latents: the coarser level, field convolutions against their formula, model files, equivariance of
// pooling, network and sampler under turned frames, bending and renumbering, and the moments of sampled Gaussians.
#include "ExampleMeshes.h"
#include "InstructionSets.h"
#include "ModelFileChecks.h"
#include "RandomFieldLatents.h"
#include "RandomLatentDiffusion.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Tangent/RingSamples.h"
#include "Core/Tangent/TangentHierarchy.h"
#include "Core/Tangent/TangentVectors.h"
#include "IO/Weights/InstalledModels.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Inference/FieldLatents/FieldPooling.h"
#include "Inference/FieldLatents/LatentDiffusionKernels.h"
#include "Inference/FieldLatents/LatentDiffusionSampler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <cstdio>
#include <initializer_list>
#include <numeric>
#include <set>
#include <string>

using namespace surfsynth;
using namespace surfsynth::test;
using surfsynthtest::TextOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{
using Complex = std::complex<double>;

constexpr const char* Path = "LatentDiffusion.safetensors";

const ModelFileKind Kind{ Path, "field_latent_diffusion",
  [](const std::string& path) { WriteLatentDiffusion(path, RandomLatentDiffusion()); },
  [](const std::string& path) { ReadLatentDiffusion(path); } };

/// Plane patch with vertices at random heights in straight columns, bent about them by @p bend radians each.
TriangleMesh BentPatch(double bend)
{
  constexpr int columns = 17;
  TriangleMesh mesh = PlanePatch(columns, 19, columns, 19);
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
    mesh.Points.row(v) << x, mesh.Points(v, 1) + 0.3 * Uniform(3, static_cast<std::uint64_t>(v)), z;
  }
  return mesh;
}

/// Two surfaces with the same shape inside: vertex v of A is vertex Ids[v] of B, and a tangent vector z of A is Turns[v] z.
struct Pair
{
  OneRings A;
  OneRings B;
  std::vector<Index> Ids;
  std::vector<Complex> Turns;
};

std::vector<Index> Identity(const TriangleMesh& mesh)
{
  std::vector<Index> ids(static_cast<std::size_t>(mesh.NumberOfPoints()));
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

Pair TurnedPair()
{
  const TriangleMesh mesh = IrregularSphere(3);
  const MeshTopology topology(mesh);
  const VertexFrames frames = TangentFrames(mesh, topology);
  Pair pair{ OneRings(mesh), OneRings(mesh), Identity(mesh), {} };
  Eigen::VectorXd angles(mesh.NumberOfPoints());
  for (Index v = 0; v < angles.size(); ++v)
  {
    angles[v] = 3.0 * Uniform(7, static_cast<std::uint64_t>(v));
    pair.Turns.push_back(std::polar(1.0, -angles[v]));
  }
  pair.B = OneRings(mesh, topology, TurnedFrames(frames, angles));
  return pair;
}

Pair BentPair()
{
  const TriangleMesh mesh = BentPatch(0.0);
  Pair pair{ OneRings(mesh), OneRings(BentPatch(0.3)), Identity(mesh), {} };
  for (Index v = 0; v < mesh.NumberOfPoints(); ++v)
  {
    const Index k = pair.A.NeighborStart[v];
    const Complex turn = pair.B.NeighborLogarithms[k] / pair.A.NeighborLogarithms[k];
    pair.Turns.push_back(turn / std::abs(turn));
  }
  return pair;
}

Pair RenumberedPair()
{
  const TriangleMesh mesh = IrregularSphere(3);
  const auto count = static_cast<std::size_t>(mesh.NumberOfPoints());
  Pair pair{ OneRings(mesh), OneRings(mesh), Identity(mesh), std::vector<Complex>(count, 1.0) };
  std::size_t stride = count / 2 + 1;
  while (std::gcd(stride, count) != 1)
  {
    ++stride;
  }
  TriangleMesh other = mesh;
  VertexFrames frames = pair.A.Frames;
  for (std::size_t v = 0; v < count; ++v)
  {
    const auto id = static_cast<Index>((v * stride + 1) % count);
    pair.Ids[v] = id;
    const auto row = static_cast<Eigen::Index>(v);
    other.Points.row(id) = mesh.Points.row(row);
    frames.X.row(id) = pair.A.Frames.X.row(row);
    frames.Y.row(id) = pair.A.Frames.Y.row(row);
    frames.Normal.row(id) = pair.A.Frames.Normal.row(row);
  }
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      other.Triangles(mesh.NumberOfTriangles() - 1 - f, k) = pair.Ids[mesh.Triangles(f, (k + f) % 3)];
    }
  }
  pair.B = OneRings(other, MeshTopology(other), frames);
  return pair;
}

/// Rows of complex numbers in turn: row v, turned, becomes row ids[v].
FieldLatentMatrix Carried(
  const std::vector<Index>& ids, const std::vector<Complex>& turns, const FieldLatentMatrix& rows)
{
  FieldLatentMatrix carried(rows.rows(), rows.cols());
  for (Eigen::Index v = 0; v < rows.rows(); ++v)
  {
    for (Eigen::Index j = 0; j < rows.cols(); j += 2)
    {
      const auto k = static_cast<std::size_t>(v);
      const Complex turned = turns[k] * Complex(rows(v, j), rows(v, j + 1));
      carried(ids[k], j) = static_cast<float>(turned.real());
      carried(ids[k], j + 1) = static_cast<float>(turned.imag());
    }
  }
  return carried;
}

/// Rows of complex numbers in turn, carried from A to B.
FieldLatentMatrix Carried(const Pair& pair, const FieldLatentMatrix& rows)
{
  return Carried(pair.Ids, pair.Turns, rows);
}

/// Coarse vertices of B that are those of A, and the turns of their frames.
struct CoarseVertices
{
  std::vector<Index> Ids;
  std::vector<Complex> Turns;
};

/// @throws InvalidInput when a center of A is none of B.
CoarseVertices CoarseOf(const Pair& pair, const TangentHierarchy& a, const TangentHierarchy& b)
{
  CoarseVertices coarse;
  for (const Index center : a.Centers)
  {
    const auto found = std::lower_bound(b.Centers.begin(), b.Centers.end(), pair.Ids[center]);
    if (found == b.Centers.end() || *found != pair.Ids[center])
    {
      throw InvalidInput("Vertex " + std::to_string(center) + " is a center of one surface only.");
    }
    coarse.Ids.push_back(static_cast<Index>(found - b.Centers.begin()));
    coarse.Turns.push_back(pair.Turns[center]);
  }
  return coarse;
}

LatentDiffusionConditions Guides(Index vertices)
{
  LatentDiffusionConditions conditions;
  for (Index v = 0; v < vertices; ++v)
  {
    conditions.Labels.push_back(v % 4 - 1);
  }
  conditions.Directions = RandomLatents(vertices, 1);
  return conditions;
}

LatentDiffusionConditions Carried(const Pair& pair, const LatentDiffusionConditions& conditions)
{
  LatentDiffusionConditions carried = conditions;
  carried.Directions = Carried(pair, conditions.Directions);
  for (std::size_t v = 0; v < conditions.Labels.size(); ++v)
  {
    carried.Labels[pair.Ids[v]] = conditions.Labels[v];
  }
  return carried;
}

float Difference(const FieldLatentMatrix& a, const FieldLatentMatrix& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Largest difference of the tables of a level of A, carried to B, from those of B.
void ExpectSameLevel(const TangentNeighborhoods& a, const TangentNeighborhoods& b, const std::vector<Index>& ids,
  const std::vector<Complex>& turns)
{
  ASSERT_EQ(a.NumberOfVertices(), b.NumberOfVertices());
  EXPECT_NEAR(a.Radius, b.Radius, 1e-9 * a.Radius);
  for (Index v = 0; v < a.NumberOfVertices(); ++v)
  {
    const Index w = ids[v];
    ASSERT_EQ(a.Start[v + 1] - a.Start[v], b.Start[w + 1] - b.Start[w]) << v;
    EXPECT_LT(std::abs(turns[v] * Complex(a.Centroids[v]) - Complex(b.Centroids[w])), 1e-5) << v;
    for (Index e = a.Start[v]; e < a.Start[v + 1]; ++e)
    {
      const auto begin = b.Sources.begin() + b.Start[w];
      const auto end = b.Sources.begin() + b.Start[w + 1];
      const auto found = std::find(begin, end, ids[a.Sources[e]]);
      ASSERT_NE(found, end) << v;
      const auto k = found - b.Sources.begin();
      EXPECT_LT(std::abs(turns[v] * Complex(a.Logarithms[e]) - Complex(b.Logarithms[k])), 1e-5) << v;
      const Complex transport = turns[v] * std::conj(turns[a.Sources[e]]) * Complex(a.Transport[e]);
      EXPECT_LT(std::abs(transport - Complex(b.Transport[k])), 1e-5) << v;
      EXPECT_NEAR(a.Weights[e], b.Weights[k], 1e-6F);
    }
  }
}

/// What pooling and unpooling read is that of A, carried to B.
void ExpectSameHierarchy(const Pair& pair)
{
  const TangentHierarchy a(pair.A);
  const TangentHierarchy b(pair.B);
  ExpectSameLevel(a.Fine, b.Fine, pair.Ids, pair.Turns);
  ASSERT_EQ(a.Centers.size(), b.Centers.size());
  const auto [ids, turns] = CoarseOf(pair, a, b);
  ExpectSameLevel(a.Coarse, b.Coarse, ids, turns);
  for (std::size_t v = 0; v < a.Clusters.size(); ++v)
  {
    EXPECT_EQ(b.Clusters[pair.Ids[v]], ids[a.Clusters[v]]);
    const Complex expected = turns[a.Clusters[v]] * std::conj(pair.Turns[v]) * Complex(a.ToCenter[v]);
    EXPECT_LT(std::abs(expected - Complex(b.ToCenter[pair.Ids[v]])), 1e-5);
  }
}

/// Sums of GatherFields() for one channel, [V, 2 FilterChannels].
FieldLatentMatrix SumsOf(const OneRings& rings, const FieldLatentMatrix& field, const FieldLatentMatrix& directions)
{
  const TangentHierarchy levels(rings);
  const TangentNeighborhoods& at = levels.Fine;
  const FieldLatentMatrix numbers = RandomLatents(1, 108);
  const float* n = numbers.data();
  const FieldFilter filter = { n, n + 8, n + 16, n + 32, n + 48, n + 64, n + 128 };
  const FieldNeighborhoods neighborhoods = { at.Start.data(), at.Sources.data(),
    reinterpret_cast<const float*>(at.Logarithms.data()), reinterpret_cast<const float*>(at.Transport.data()),
    at.Weights.data(), reinterpret_cast<const float*>(at.Centroids.data()), directions.data(), nullptr };
  const LatentDiffusionKernels& kernels = BestLatentDiffusionKernels();
  FieldLatentMatrix units(field.rows(), field.cols());
  kernels.Units(field.data(), field.rows(), 1, units.data());
  FieldLatentMatrix sums(field.rows(), 2 * FilterChannels);
  kernels.GatherFields(neighborhoods, filter, field.data(), units.data(), 0, field.rows(), 1, sums.data());
  return sums;
}

/// The sums of a convolution, carried from A to B, are those of the field that is carried.
void ExpectEquivariantSums(const Pair& pair)
{
  const FieldLatentMatrix field = RandomLatents(pair.A.NumberOfPoints(), 2).rightCols(2);
  const FieldLatentMatrix directions = Guides(pair.A.NumberOfPoints()).Directions;
  const FieldLatentMatrix expected = Carried(pair, SumsOf(pair.A, field, directions));
  const FieldLatentMatrix found = SumsOf(pair.B, Carried(pair, field), Carried(pair, directions));
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_LT(Difference(found, expected), 1e-4F * expected.cwiseAbs().maxCoeff());
}

void ExpectEquivariantNetwork(const Pair& pair)
{
  const LatentDiffusionModel model = RandomLatentDiffusion();
  const LatentDiffusionNetwork a(model, std::make_shared<TangentHierarchy>(pair.A));
  const LatentDiffusionNetwork b(model, std::make_shared<TangentHierarchy>(pair.B));
  const FieldLatentMatrix state = 2.0F * RandomLatents(pair.A.NumberOfPoints(), 2);
  const LatentDiffusionConditions guides = Guides(pair.A.NumberOfPoints());
  const FieldLatentMatrix expected = Carried(pair, a.Evaluate(state, 30.0, guides));
  const FieldLatentMatrix found = b.Evaluate(Carried(pair, state), 30.0, Carried(pair, guides));
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_LT(Difference(found, expected), 1e-4F * expected.cwiseAbs().maxCoeff());
}

/// Real parts, then imaginary parts, of rows of complex numbers in turn.
FieldLatentMatrix Apart(const FieldLatentMatrix& rows)
{
  const Eigen::Index channels = rows.cols() / 2;
  FieldLatentMatrix apart(rows.rows(), rows.cols());
  for (Eigen::Index c = 0; c < channels; ++c)
  {
    apart.col(c) = rows.col(2 * c);
    apart.col(channels + c) = rows.col(2 * c + 1);
  }
  return apart;
}

FieldLatentMatrix Pooled(const TangentHierarchy& surface, const FieldLatentMatrix& fine)
{
  FieldLatentMatrix coarse(surface.Coarse.NumberOfVertices(), fine.cols());
  PoolFieldRows(surface, Apart(fine).data(), fine.cols() / 2, 0, coarse.rows(), coarse.data());
  return coarse;
}

FieldLatentMatrix Unpooled(const TangentHierarchy& surface, const FieldLatentMatrix& coarse)
{
  FieldLatentMatrix fine(surface.Fine.NumberOfVertices(), coarse.cols());
  UnpoolFieldRows(surface, Apart(coarse).data(), coarse.cols() / 2, 0, fine.rows(), fine.data());
  return fine;
}

/// One channel pooled, and unpooled, then carried from A to B is the channel carried, then pooled and unpooled. Parts of
/// one channel lie in turn.
void ExpectEquivariantPooling(const Pair& pair)
{
  const TangentHierarchy a(pair.A);
  const TangentHierarchy b(pair.B);
  const CoarseVertices coarse = CoarseOf(pair, a, b);
  ASSERT_LT(coarse.Ids.size(), pair.Ids.size());
  const FieldLatentMatrix fine = RandomLatents(pair.A.NumberOfPoints(), 1);
  const FieldLatentMatrix pooled = Carried(coarse.Ids, coarse.Turns, Pooled(a, fine));
  EXPECT_GT(pooled.cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_LT(Difference(Pooled(b, Carried(pair, fine)), pooled), 1e-4F);
  const FieldLatentMatrix centers = RandomLatents(static_cast<std::int64_t>(coarse.Ids.size()), 1);
  const FieldLatentMatrix unpooled = Carried(pair, Unpooled(a, centers));
  EXPECT_GT(unpooled.cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_LT(Difference(Unpooled(b, Carried(coarse.Ids, coarse.Turns, centers)), unpooled), 1e-4F);
}

/// A network whose predictions are about as large as the noise, as those of a trained one. Larger ones amplify rounding
/// errors from step to step.
LatentDiffusionModel CalmModel()
{
  LatentDiffusionModel model = RandomLatentDiffusion();
  for (float& value : model.Tensors["output.weight"].Values)
  {
    value *= 0.1F;
  }
  return model;
}

void ExpectEquivariantSampler(const Pair& pair, DiffusionMethod method)
{
  const LatentDiffusionModel model = CalmModel();
  const LatentDiffusionSampler a(model, pair.A);
  const LatentDiffusionSampler b(model, pair.B);
  LatentSampleRequest request;
  request.NumberOfSteps = 5;
  request.Method = method;
  const LatentDiffusionConditions guides = Guides(pair.A.NumberOfPoints());
  const DiffusionNoise noise = CounterNoise(request, pair.A.NumberOfPoints(), 4);
  const FieldLatentMatrix expected = Carried(pair, a.Sample(request, guides, {}, {}, {}, noise));
  const FieldLatentMatrix found = b.Sample(
    request, Carried(pair, guides), {}, {}, {}, [&](std::uint32_t draw) { return Carried(pair, noise(draw)); });
  EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_LT(Difference(found, expected), 1e-4F * expected.cwiseAbs().maxCoeff()) << int(method);
}

/// The reference of GatherFields(): the sums of LatentDiffusionNetwork's documentation in double precision.
Complex SumOf(const TangentNeighborhoods& at, const FieldFilter& filter, const FieldLatentMatrix& field,
  const FieldLatentMatrix& directions, Index p, Index c, int k)
{
  Complex sum = 0.0;
  const Index channels = static_cast<Index>(field.cols() / 2);
  for (Index e = at.Start[p]; e < at.Start[p + 1]; ++e)
  {
    const Index q = at.Sources[e];
    const Complex x = Complex(at.Transport[e]) * Complex(field(q, c), field(q, channels + c));
    const Complex direction = Complex(at.Transport[e]) * Complex(directions(q, 0), directions(q, 1));
    const Complex back = std::conj(x) / std::sqrt(std::norm(x) + 1e-6);
    const Complex centroid = back * Complex(at.Transport[e]) * Complex(at.Centroids[q]);
    const double radius = std::abs(Complex(at.Logarithms[e]));
    const Complex aligned = radius > 0.0 ? back * Complex(at.Logarithms[e]) / radius : 0.0;
    const Complex directed = back * direction;
    double hidden = filter.Bias[k];
    for (int j = 0; j < FilterChannels; ++j)
    {
      const double first = filter.Shares[j] + filter.Radius[j] * radius + filter.Aligned[j] * aligned.real() +
        filter.Aligned[FilterChannels + j] * aligned.imag() + filter.Centroids[j] * centroid.real() +
        filter.Centroids[FilterChannels + j] * centroid.imag() + filter.Directed[j] * directed.real() +
        filter.Directed[FilterChannels + j] * directed.imag();
      hidden += filter.Hidden[k * FilterChannels + j] * std::max(0.0, first);
    }
    sum += static_cast<double>(at.Weights[e]) * std::max(0.0, hidden) * x;
  }
  return sum;
}

FieldLatentMatrix Labelled(const LatentDiffusionNetwork& network, const FieldLatentMatrix& state, int label)
{
  LatentDiffusionConditions conditions;
  conditions.Labels.assign(static_cast<std::size_t>(state.rows()), label);
  return network.Evaluate(state, 3.0, conditions);
}
} // namespace

TEST(TangentHierarchy, ClustersAreStarsAndCentersAreApart)
{
  const OneRings rings(WithUnreferencedPoints(IrregularSphere(3)));
  const TangentHierarchy levels(rings);
  const std::set<Index> centers(levels.Centers.begin(), levels.Centers.end());
  EXPECT_LT(4 * centers.size(), 3U * static_cast<std::size_t>(rings.NumberOfPoints()));
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    bool joined = false;
    for (Index k = rings.NeighborStart[v]; k < rings.NeighborStart[v + 1]; ++k)
    {
      joined = joined || rings.Neighbors[k] == levels.Centers[levels.Clusters[v]];
      EXPECT_FALSE(centers.count(v) > 0 && centers.count(rings.Neighbors[k]) > 0);
    }
    EXPECT_EQ(joined, centers.count(v) == 0);
    EXPECT_NEAR(std::abs(levels.ToCenter[v]), 1.0F, 1e-6F);
  }
  ASSERT_EQ(levels.Members.size(), levels.Clusters.size());
  EXPECT_EQ(std::set<Index>(levels.Members.begin(), levels.Members.end()).size(), levels.Members.size());
}

TEST(TangentHierarchy, TransportTakesALogarithmToItsOpposite)
{
  const TangentHierarchy levels{ OneRings(IrregularSphere(3)) };
  const TangentNeighborhoods& at = levels.Coarse;
  for (Index a = 0; a < at.NumberOfVertices(); ++a)
  {
    EXPECT_EQ(at.Sources[at.Start[a]], a);
    float weights = at.Weights[at.Start[a]];
    for (Index e = at.Start[a] + 1; e < at.Start[a + 1]; ++e)
    {
      const Index b = at.Sources[e];
      const auto found = std::find(at.Sources.begin() + at.Start[b], at.Sources.begin() + at.Start[b + 1], a);
      ASSERT_NE(found, at.Sources.begin() + at.Start[b + 1]);
      const auto back = found - at.Sources.begin();
      EXPECT_LT(std::abs(at.Transport[e] * at.Logarithms[back] + at.Logarithms[e]), 1e-5F);
      EXPECT_LT(std::abs(at.Transport[e] * at.Transport[back] - 1.0F), 1e-5F);
      weights += at.Weights[e];
    }
    EXPECT_NEAR(weights, 1.0F, 1e-5F);
  }
}

TEST(TangentHierarchy, InAPlaneLogarithmsAreDifferences)
{
  const TriangleMesh mesh = PlanePatch(12, 10, 6.0, 5.0, 0.2);
  const OneRings rings(mesh);
  const TangentHierarchy levels(rings);
  const TangentNeighborhoods& at = levels.Coarse;
  for (Index a = 0; a < at.NumberOfVertices(); ++a)
  {
    const Index v = levels.Centers[a];
    for (Index e = at.Start[a]; e < at.Start[a + 1]; ++e)
    {
      const PointMatrix difference = mesh.Points.row(levels.Centers[at.Sources[e]]) - mesh.Points.row(v);
      const Complex expected(
        difference.row(0).dot(rings.Frames.X.row(v)), difference.row(0).dot(rings.Frames.Y.row(v)));
      EXPECT_LT(std::abs(expected / at.Radius - Complex(at.Logarithms[e])), 1e-5);
    }
  }
}

TEST(TangentHierarchy, InAPlaneCentroidsAreThoseOfTheRings)
{
  const TriangleMesh mesh = WithUnreferencedPoints(PlanePatch(12, 10, 6.0, 5.0, 0.2));
  const OneRings rings(mesh);
  const TangentHierarchy levels(rings);
  PointMatrix sums = PointMatrix::Zero(mesh.NumberOfPoints(), 3);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const auto point = [&](int k) -> Eigen::RowVector3d { return mesh.Points.row(mesh.Triangles(f, k)); };
    const double area = (point(1) - point(0)).cross(point(2) - point(0)).norm();
    for (int k = 0; k < 3; ++k)
    {
      sums.row(mesh.Triangles(f, k)) += area * ((point(0) + point(1) + point(2)) / 3.0 - point(k));
    }
  }
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    const double twice = 2.0 * rings.Areas[v];
    const Complex mean = twice > 0.0
      ? Complex(sums.row(v).dot(rings.Frames.X.row(v)), sums.row(v).dot(rings.Frames.Y.row(v))) / twice
      : 0.0;
    const double least = 1e-3 * levels.Fine.Radius;
    const Complex expected = mean / std::sqrt(std::norm(mean) + least * least);
    EXPECT_LT(std::abs(expected - Complex(levels.Fine.Centroids[v])), 1e-5) << v;
  }
  for (std::size_t a = 0; a < levels.Centers.size(); ++a)
  {
    EXPECT_EQ(levels.Coarse.Centroids[a], levels.Fine.Centroids[levels.Centers[a]]);
  }
}

TEST(TangentHierarchy, CodesOfAFlatColorPointAlongTheCentroids)
{
  // The claim of LatentDiffusionNetwork, of the shipped encoder and one gray: an agreement of 0.995 on other triangulations.
  const OneRings rings(IrregularSphere(3));
  const TangentHierarchy levels(rings);
  const RingSamples samples = SampleRingsUniformly(rings, 256);
  FieldLatentRings flat;
  flat.Offsets = samples.Offsets;
  flat.Logarithms.resize(static_cast<Eigen::Index>(samples.Logarithms.size()), 2);
  flat.Colors = FieldLatentMatrix::Constant(flat.Logarithms.rows(), 3, 0.1F);
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    for (std::int64_t s = samples.Offsets[v]; s < samples.Offsets[v + 1]; ++s)
    {
      const Complex place = samples.Logarithms[s] / rings.RingRadius(v);
      flat.Logarithms.row(s) << static_cast<float>(place.real()), static_cast<float>(place.imag());
    }
  }
  const FieldLatentModel model = ReadFieldLatents(ExistingModelPath("field_latents"));
  const FieldLatentMatrix codes = FieldLatentEncoder(model).Encode(flat).Mean;
  for (Eigen::Index k : { 2, 4, 7 }) // the longest for a gray
  {
    Complex sum = 0.0;
    for (Index v = 0; v < rings.NumberOfPoints(); ++v)
    {
      const Complex code(codes(v, 2 * k), codes(v, 2 * k + 1));
      sum += code / std::abs(code) * std::conj(Complex(levels.Fine.Centroids[v]));
    }
    EXPECT_GT(std::abs(sum) / rings.NumberOfPoints(), 0.97) << k;
  }
}

TEST(TangentHierarchy, IsThatOfTheSurfaceInOtherFramesBentAndRenumbered)
{
  ExpectSameHierarchy(TurnedPair());
  ExpectSameHierarchy(BentPair());
  ExpectSameHierarchy(RenumberedPair());
}

TEST(TangentHierarchy, RegularVerticesAreAtTheCentroidsOfTheirRings)
{
  const TriangleMesh regular = PlanePatch(12, 10, 6.0, 5.0);
  EXPECT_EQ(RegularVertices(OneRings(WithUnreferencedPoints(regular))).size(), 11U * 9U) << "all inner ones";
  TriangleMesh mesh = PlanePatch(12, 10, 6.0, 5.0, 0.2);
  EXPECT_THAT(RegularVertices(OneRings(mesh)), IsEmpty());
  // One ring of equal triangles may be by chance. Two are a regular part.
  const Index v = 5 * 13 + 5;
  const auto restore = [&](std::initializer_list<Index> rows) {
    for (const Index row : rows)
    {
      mesh.Points.middleRows(row * 13 + 4, 3) = regular.Points.middleRows(row * 13 + 4, 3);
    }
  };
  restore({ 4, 5, 6 });
  EXPECT_THAT(RegularVertices(OneRings(mesh)), IsEmpty());
  restore({ 7 });
  EXPECT_THAT(RegularVertices(OneRings(mesh)), ElementsAre(v, v + 13));
}

TEST(FieldPooling, TurnsWithTheFrames) { ExpectEquivariantPooling(TurnedPair()); }

TEST(FieldPooling, BendsWithTheSurface) { ExpectEquivariantPooling(BentPair()); }

TEST(FieldPooling, NumbersOfVerticesDoNotMatter) { ExpectEquivariantPooling(RenumberedPair()); }

TEST(FieldPooling, ChannelsAndTilesAreIndependent)
{
  const TangentHierarchy surface{ OneRings(IrregularSphere(2)) };
  const FieldLatentMatrix fine = RandomLatents(surface.Fine.NumberOfVertices(), 3);
  const FieldLatentMatrix all = Pooled(surface, fine);
  const FieldLatentMatrix back = Unpooled(surface, fine.topRows(all.rows()));
  for (Eigen::Index c = 0; c < 3; ++c)
  {
    FieldLatentMatrix both(all.rows(), 2);
    both << all.col(c), all.col(3 + c);
    EXPECT_EQ(both, Pooled(surface, fine.middleCols(2 * c, 2)));
  }
  FieldLatentMatrix rows(5, 6);
  PoolFieldRows(surface, Apart(fine).data(), 3, 7, 5, rows.data());
  EXPECT_EQ(rows, all.middleRows(7, 5));
  UnpoolFieldRows(surface, Apart(fine).data(), 3, 11, 5, rows.data());
  EXPECT_EQ(rows, back.middleRows(11, 5));
}

TEST(LatentDiffusionKernels, SumsAreThoseOfTheFormula)
{
  // The poles have more neighbors than are prepared at once; 18 channels are no whole number of registers.
  const TangentHierarchy levels{ OneRings(UvSphere(5, 20)) };
  const TangentNeighborhoods& at = levels.Fine;
  const Index vertices = at.NumberOfVertices();
  constexpr Index channels = 18;
  FieldLatentMatrix field = RandomLatents(vertices, channels);
  field.row(3).setZero();
  const FieldLatentMatrix directions = RandomLatents(vertices, 1);
  const FieldLatentMatrix numbers = RandomLatents(1, 108);
  const float* n = numbers.data();
  const FieldFilter filter = { n, n + 8, n + 16, n + 32, n + 48, n + 64, n + 128 };
  const FieldNeighborhoods neighborhoods = { at.Start.data(), at.Sources.data(),
    reinterpret_cast<const float*>(at.Logarithms.data()), reinterpret_cast<const float*>(at.Transport.data()),
    at.Weights.data(), reinterpret_cast<const float*>(at.Centroids.data()), directions.data(), nullptr };
  ForEachInstructionSet([&](InstructionSet) {
    const LatentDiffusionKernels& kernels = BestLatentDiffusionKernels();
    FieldLatentMatrix units(vertices, 2 * channels);
    kernels.Units(field.data(), vertices, channels, units.data());
    FieldLatentMatrix sums(vertices, FilterChannels * 2 * channels);
    kernels.GatherFields(neighborhoods, filter, field.data(), units.data(), 0, vertices, channels, sums.data());
    for (Index p = 0; p < vertices; ++p)
    {
      for (Index c = 0; c < channels; ++c)
      {
        for (int k = 0; k < FilterChannels; ++k)
        {
          const Complex expected = SumOf(at, filter, field, directions, p, c, k);
          const Complex found(sums(p, 2 * k * channels + c), sums(p, (2 * k + 1) * channels + c));
          ASSERT_LT(std::abs(found - expected), 1e-5) << p << " " << c << " " << k;
        }
      }
    }
  });
}

TEST(LatentDiffusionKernels, SumsTurnBendAndAreRenumberedWithTheSurface)
{
  ExpectEquivariantSums(TurnedPair());
  ExpectEquivariantSums(BentPair());
  ExpectEquivariantSums(RenumberedPair());
}

TEST(LatentDiffusionOptions, ShapesFollowTheSizes)
{
  const auto paper = ExpectedLatentDiffusionTensors(LatentDiffusionOptions::Paper());
  EXPECT_THAT(paper.at("input.weight"), ElementsAre(2, 96, 9));
  EXPECT_THAT(paper.at("coarse.0.mlp1.0.key.weight"), ElementsAre(2, 192, 96));
  EXPECT_THAT(paper.at("output.0.residual.weight"), ElementsAre(2, 96, 288));
  EXPECT_THAT(paper.at("output.3.convolution2.weight"), ElementsAre(2, 96, 8, 96));
  EXPECT_EQ(paper.count("labels.weight"), 0U);
  EXPECT_EQ(paper.count("input.1.residual.weight"), 0U);
  LatentDiffusionOptions options;
  options.EmbeddingDimension = 7;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr("EmbeddingDimension is 7"));
  options = {};
  options.LastVariance = 1.0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr("FirstVariance <= LastVariance < 1"));
  options.FirstVariance = 0.5;
  options.LastVariance = 0.9;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(options); }),
    AllOf(HasSubstr("variances of 0.5 to 0.9"), HasSubstr("after 1000 steps"), HasSubstr("at least exp(-300)")));
  options = {};
  options.CoarseBlocks = 0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr("CoarseBlocks is 0; expected 1 to 64"));
}

TEST(LatentDiffusionModel, WhatIsWrittenIsRead)
{
  LatentDiffusionModel model = RandomLatentDiffusion();
  model.Metadata["note"] = "kept";
  model.Autoencoder = "0123456789abcdef";
  model.TrainingPoints = 3000;
  WriteLatentDiffusion(Path, model);
  const LatentDiffusionModel read = ReadLatentDiffusion(Path);
  EXPECT_TRUE(read.Options == model.Options);
  EXPECT_EQ(read.Iterations, 7);
  EXPECT_EQ(read.Metadata.at("note"), "kept");
  EXPECT_EQ(read.Autoencoder, "0123456789abcdef");
  EXPECT_EQ(read.TrainingPoints, 3000);
  ASSERT_EQ(read.Tensors.size(), model.Tensors.size());
  for (const auto& [name, tensor] : model.Tensors)
  {
    EXPECT_EQ(read.Tensors.at(name).Shape, tensor.Shape) << name;
    EXPECT_EQ(read.Tensors.at(name).Values, tensor.Values) << name;
  }
  EXPECT_EQ(read.Description(),
    "diffusion of field latents of dimension 2: 1 + 2 + 1 blocks with 5 and 18 channels, 3 labels, directed, noise "
    "predicted in 100 time steps; 7 iterations");
}

TEST(LatentDiffusionModel, FilesThatDoNotFitAreNamed)
{
  ExpectMetadataAreChecked(Kind);
  ExpectKeysAreNeeded(Kind,
    { "latent_dimension", "channels", "coarse_channels", "input_blocks", "coarse_blocks", "output_blocks",
      "embedding_dimension", "labels", "directed", "time_steps", "first_variance", "last_variance", "iterations",
      "target" });
  EXPECT_THAT(MessageWith(Kind, "\"noise\"", "\"score\""), HasSubstr("\"noise\", \"data\" or \"velocity\""));
  EXPECT_THAT(MessageWith(Kind, "\"directed\":1", "\"directed\":2"), HasSubstr("0 or 1"));
  EXPECT_THAT(MessageWith(Kind, "\"labels\":3", "\"labels\":4"), HasSubstr("the tensors are not those"));
  EXPECT_THAT(MessageAfter(Kind,
                [](Tensors& tensors, Metadata&) {
                  tensors["latent_scale"] = TensorData::FromFloat32({ 2 }, { 1.0F, 0.0F });
                }),
    HasSubstr("latent_scale has a number that is not larger than 0"));
  std::remove(Path);
}

TEST(LatentDiffusionNetwork, TurnsWithTheFrames) { ExpectEquivariantNetwork(TurnedPair()); }

TEST(LatentDiffusionNetwork, BendsWithTheSurface) { ExpectEquivariantNetwork(BentPair()); }

TEST(LatentDiffusionNetwork, NumbersOfVerticesDoNotMatter) { ExpectEquivariantNetwork(RenumberedPair()); }

TEST(LatentDiffusionNetwork, TimeLabelsAndDirectionsGuideIt)
{
  const TriangleMesh mesh = IrregularSphere(2);
  const LatentDiffusionNetwork network(RandomLatentDiffusion(), std::make_shared<TangentHierarchy>(OneRings(mesh)));
  const FieldLatentMatrix state = RandomLatents(mesh.NumberOfPoints(), 2);
  const FieldLatentMatrix plain = network.Evaluate(state, 3.0);
  EXPECT_GT(Difference(network.Evaluate(state, 60.0), plain), 1e-3F);
  EXPECT_GT(Difference(Labelled(network, state, 0), plain), 1e-3F);
  EXPECT_GT(Difference(Labelled(network, state, 0), Labelled(network, state, 1)), 1e-3F);
  EXPECT_EQ(Difference(Labelled(network, state, -1), plain), 0.0F);
  LatentDiffusionConditions directed;
  directed.Directions = RandomLatents(mesh.NumberOfPoints(), 1);
  EXPECT_GT(Difference(network.Evaluate(state, 3.0, directed), plain), 1e-3F);
}

TEST(LatentDiffusionNetwork, InputThatDoesNotFitIsNamed)
{
  const TriangleMesh mesh = IrregularSphere(1);
  const auto surface = std::make_shared<TangentHierarchy>(OneRings(mesh));
  const LatentDiffusionNetwork network(RandomLatentDiffusion(), surface);
  FieldLatentMatrix state = RandomLatents(mesh.NumberOfPoints(), 2);
  const auto message = [&](const LatentDiffusionConditions& conditions, double time = 1.0) {
    return TextOf<InvalidInput>([&] { network.Evaluate(state, time, conditions); });
  };
  LatentDiffusionConditions conditions;
  EXPECT_THAT(message(conditions, 101.0), HasSubstr("the time is 101"));
  conditions.Labels.assign(static_cast<std::size_t>(mesh.NumberOfPoints()), 3);
  EXPECT_THAT(message(conditions), HasSubstr("label 3; expected -1 (none) to 2"));
  conditions.Labels.resize(5);
  EXPECT_THAT(message(conditions), HasSubstr("there are 5 labels"));
  conditions.Labels.clear();
  conditions.Directions = RandomLatents(3, 1);
  EXPECT_THAT(message(conditions), HasSubstr("the directions are [3, 2]"));
  conditions.Directions.resize(0, 0);
  state(2, 1) = std::numeric_limits<float>::infinity();
  EXPECT_THAT(message(conditions), HasSubstr("not finite"));
  state = RandomLatents(4, 2);
  EXPECT_THAT(message(conditions), HasSubstr("the state is [4, 4]"));
  LatentDiffusionOptions plain = TinyLatentDiffusion();
  plain.NumberOfLabels = 0;
  plain.Directed = false;
  const LatentDiffusionNetwork unguided(RandomLatentDiffusion(plain), surface);
  conditions.Labels.assign(static_cast<std::size_t>(mesh.NumberOfPoints()), 0);
  state = RandomLatents(mesh.NumberOfPoints(), 2);
  EXPECT_THAT(TextOf<InvalidInput>([&] { unguided.Evaluate(state, 1.0, conditions); }), HasSubstr("without labels"));
}

TEST(ReverseStep, HasTheCoefficientsOfThePosterior)
{
  const DiffusionSchedule schedule(1000, 1e-4, 0.02);
  EXPECT_EQ(schedule.Alpha(0), 1.0);
  EXPECT_NEAR(schedule.Alpha(1), 1.0 - 1e-4, 1e-12);
  EXPECT_NEAR(schedule.Alpha(1000), 4.0e-5, 0.1e-5);
  for (const int t : { 1, 2, 400, 1000 })
  {
    const ReverseStep step(schedule, t, t - 1, 1.0);
    const double now = schedule.Alpha(t);
    const double next = schedule.Alpha(t - 1);
    EXPECT_NEAR(step.State, std::sqrt(next / now), 1e-12);
    EXPECT_NEAR(step.Noise, -(1.0 - now / next) * step.State / std::sqrt(1.0 - now), 1e-9);
    EXPECT_NEAR(step.Fresh, std::sqrt((1.0 - next) / (1.0 - now) * (1.0 - now / next)), 1e-12);
  }
  EXPECT_THAT(schedule.Times(4), ElementsAre(1000, 750, 500, 250));
  EXPECT_THROW(schedule.Times(1001), InvalidInput);
  EXPECT_THROW(DiffusionSchedule(10, 0.0, 0.5), InvalidInput);
}

/// Data with mean 0.7 and deviation 0.4, and a denoiser that knows it.
struct GaussianData
{
  static constexpr double Mean = 0.7;
  static constexpr double Deviation = 0.4;

  static Denoiser For(const DiffusionSchedule& schedule, DiffusionTarget target)
  {
    return [&schedule, target](const FieldLatentMatrix& state, int time, const Progress&) -> FieldLatentMatrix {
      const double alpha = schedule.Alpha(time);
      const auto root = static_cast<float>(std::sqrt(alpha));
      const auto noise = static_cast<float>(std::sqrt(1.0 - alpha));
      const double variance = Deviation * Deviation;
      const auto gain = static_cast<float>(std::sqrt(alpha) * variance / (alpha * variance + 1.0 - alpha));
      const auto mean = static_cast<float>(Mean);
      const FieldLatentMatrix data = mean + gain * (state.array() - root * mean);
      const FieldLatentMatrix epsilon = (state - root * data) / noise;
      return target == DiffusionTarget::Data ? data
        : target == DiffusionTarget::Noise   ? epsilon
                                             : FieldLatentMatrix(root * epsilon - noise * data);
    };
  }
};

TEST(ReverseDiffusion, RecoversTheMomentsOfAGaussian)
{
  const DiffusionSchedule schedule(1000, 1e-4, 0.02);
  for (const DiffusionMethod method : { DiffusionMethod::Ddpm, DiffusionMethod::Ddim })
  {
    LatentSampleRequest request;
    request.Method = method;
    request.NumberOfSteps = method == DiffusionMethod::Ddpm ? 1000 : 100;
    const Denoiser denoiser = GaussianData::For(schedule, DiffusionTarget::Noise);
    const FieldLatentMatrix sample = ReverseDiffusion(
      schedule, DiffusionTarget::Noise, denoiser, CounterNoise(request, 8000, 2), request);
    const double mean = sample.cast<double>().mean();
    const double deviation = std::sqrt((sample.cast<double>().array() - mean).square().mean());
    // Five standard deviations of the mean and the deviation of 16,000 numbers, and 1 % for the steps.
    EXPECT_NEAR(mean, GaussianData::Mean, 5.0 * 0.4 / std::sqrt(16000.0) + 0.004);
    EXPECT_NEAR(deviation, GaussianData::Deviation, 5.0 * 0.4 / std::sqrt(32000.0) + 0.004);
  }
}

TEST(ReverseDiffusion, AllTargetsGiveTheSameSample)
{
  const DiffusionSchedule schedule(1000, 1e-4, 0.02);
  LatentSampleRequest request;
  request.NumberOfSteps = 20;
  std::vector<FieldLatentMatrix> samples;
  for (const DiffusionTarget target : { DiffusionTarget::Noise, DiffusionTarget::Data, DiffusionTarget::Velocity })
  {
    samples.push_back(
      ReverseDiffusion(schedule, target, GaussianData::For(schedule, target), CounterNoise(request, 100, 2), request));
  }
  EXPECT_LT(Difference(samples[1], samples[0]), 1e-4F);
  EXPECT_LT(Difference(samples[2], samples[0]), 1e-4F);
}

TEST(ReverseDiffusion, KeepsLatentsUnderTheMask)
{
  const DiffusionSchedule schedule(100, 1e-4, 0.05);
  LatentSampleRequest request;
  request.NumberOfSteps = 10;
  LatentInpainting kept;
  kept.Latents = RandomLatents(50, 1);
  kept.Mask.assign(50, 0.0F);
  std::fill(kept.Mask.begin(), kept.Mask.begin() + 20, 1.0F);
  kept.Latents(30, 0) = std::numeric_limits<float>::quiet_NaN();
  const Denoiser denoiser = GaussianData::For(schedule, DiffusionTarget::Noise);
  const DiffusionNoise noise = CounterNoise(request, 50, 2);
  std::vector<int> times;
  const auto observe = [&](int time, const FieldLatentMatrix& state) {
    times.push_back(time);
    const auto root = static_cast<float>(std::sqrt(schedule.Alpha(time)));
    const auto deviation = static_cast<float>(std::sqrt(1.0 - schedule.Alpha(time)));
    const FieldLatentMatrix expected = root * kept.Latents.topRows(20) +
      deviation * noise(2 * static_cast<std::uint32_t>(time) + 1).topRows(20);
    EXPECT_LT(Difference(state.topRows(20), expected), 1e-5F) << time;
  };
  const FieldLatentMatrix free = ReverseDiffusion(schedule, DiffusionTarget::Noise, denoiser, noise, request);
  const FieldLatentMatrix made = ReverseDiffusion(
    schedule, DiffusionTarget::Noise, denoiser, noise, request, kept, observe);
  EXPECT_EQ(made.topRows(20), kept.Latents.topRows(20));
  EXPECT_EQ(made.bottomRows(30), free.bottomRows(30)); // this denoiser sees no neighbors
  EXPECT_THAT(times, ElementsAre(100, 90, 80, 70, 60, 50, 40, 30, 20, 10, 0));
  kept.Mask[3] = 2.0F;
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { ReverseDiffusion(schedule, DiffusionTarget::Noise, denoiser, noise, request, kept); }),
    HasSubstr("the mask is 2.000000 at vertex 3"));
}

TEST(LatentScale, GivesTheMeanLengthOfNoise)
{
  const FieldLatentMatrix latents = 0.2F * RandomLatents(200, 2);
  const std::vector<float> scale = LatentScale(latents);
  ASSERT_EQ(scale.size(), 2U);
  for (Eigen::Index j = 0; j < 2; ++j)
  {
    const double mean = latents.middleCols(2 * j, 2).rowwise().norm().mean();
    EXPECT_NEAR(scale[static_cast<std::size_t>(j)] * mean, 1.2533141, 1e-5);
  }
}

TEST(LatentDiffusionSampler, TurnsWithTheFrames)
{
  ExpectEquivariantSampler(TurnedPair(), DiffusionMethod::Ddim);
  ExpectEquivariantSampler(TurnedPair(), DiffusionMethod::Ddpm);
}

TEST(LatentDiffusionSampler, BendsWithTheSurface) { ExpectEquivariantSampler(BentPair(), DiffusionMethod::Ddpm); }

TEST(LatentDiffusionSampler, NumbersOfVerticesDoNotMatter)
{
  ExpectEquivariantSampler(RenumberedPair(), DiffusionMethod::Ddpm);
}

TEST(LatentDiffusionSampler, SamplesAreFunctionsOfTheirNumbers)
{
  const LatentDiffusionSampler sampler(RandomLatentDiffusion(), OneRings(IrregularSphere(3)));
  LatentSampleRequest request;
  request.NumberOfSteps = 3;
  request.Method = DiffusionMethod::Ddpm;
  const FieldLatentMatrix first = sampler.Sample(request);
  {
    const ThreadScope threads(3);
    EXPECT_EQ(sampler.Sample(request), first);
  }
  {
    const ThreadScope threads(1);
    EXPECT_EQ(sampler.Sample(request), first);
  }
  request.Sample = 1;
  EXPECT_GT(Difference(sampler.Sample(request), first), 0.1F);
  request.Sample = 0;
  request.Seed = 1;
  EXPECT_GT(Difference(sampler.Sample(request), first), 0.1F);
}

TEST(LatentDiffusionSampler, KeepsLatentsInTheirOwnUnits)
{
  const LatentDiffusionSampler sampler(RandomLatentDiffusion(), OneRings(IrregularSphere(2)));
  LatentSampleRequest request;
  request.NumberOfSteps = 3;
  const Index vertices = sampler.Network().Surface().Fine.NumberOfVertices();
  LatentInpainting kept;
  kept.Latents = RandomLatents(vertices, 2);
  kept.Mask.assign(static_cast<std::size_t>(vertices), 0.0F);
  kept.Mask[5] = 1.0F;
  const FieldLatentMatrix sample = sampler.Sample(request, {}, kept);
  EXPECT_LT(Difference(sample.row(5), kept.Latents.row(5)), 1e-6F);
  EXPECT_GT(Difference(sample.row(6), kept.Latents.row(6)), 1e-3F);
}

TEST(LatentDiffusionSampler, ReportsProgressAndStops)
{
  const LatentDiffusionSampler sampler(RandomLatentDiffusion(), OneRings(IrregularSphere(2)));
  LatentSampleRequest request;
  request.NumberOfSteps = 3;
  std::vector<double> fractions;
  sampler.Sample(request, {}, {}, {}, [&](double fraction) {
    fractions.push_back(fraction);
    return true;
  });
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_GT(fractions.size(), 30U);
  EXPECT_THROW(sampler.Sample(request, {}, {}, {}, [](double fraction) { return fraction < 0.2; }), Cancelled);
}
