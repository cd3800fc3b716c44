// SPDX-License-Identifier: BSD-3-Clause
// Convolutions over triangles: the split and gathered form against the definition, in double.
#include "ExampleMeshes.h"
#include "RandomGeometricTexture.h"

#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/FaceKernels.h"
#include "Inference/GeometricTexture/FaceNetwork.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <string>

using namespace surfsynth;

namespace
{
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Rows WeightOf(const std::map<std::string, ModelTensor>& tensors, const GeometricTextureTensorNames& names)
{
  const ModelTensor& weight = tensors.at(names.Weight);
  return Eigen::Map<const FaceNetwork::Output>(weight.Values.data(), weight.Shape[0], weight.Shape[1]).cast<double>();
}

Eigen::RowVectorXd BiasOf(const std::map<std::string, ModelTensor>& tensors, const GeometricTextureTensorNames& names)
{
  const std::vector<float>& bias = tensors.at(names.Bias).Values;
  return Eigen::Map<const Eigen::RowVectorXf>(bias.data(), static_cast<Eigen::Index>(bias.size())).cast<double>();
}

/// Instance norm, or norm by given statistics, and leaky ReLU as their definitions say.
void NormalizeAsDefined(Rows& values, const ChannelStatistics* given)
{
  for (Eigen::Index c = 0; c < values.cols(); ++c)
  {
    const auto channel = static_cast<std::size_t>(c);
    const double mean = given ? given->Mean[channel] : values.col(c).mean();
    const double variance = given ? given->Variance[channel] : (values.col(c).array() - mean).square().mean();
    values.col(c) = ((values.col(c).array() - mean) / std::sqrt(variance + 1e-5)).eval();
  }
  values = values.unaryExpr([](double x) { return x > 0.0 ? x : 0.2 * x; }).eval();
}

/// The network as the paper writes it: one affine map of [neighbour, self], the largest over the neighbours.
Rows Defined(const std::map<std::string, ModelTensor>& tensors, std::int64_t level, std::int64_t layers,
  const EdgeFeatureMatrix& features, const TriangleMatrix& neighbors, const NetworkStatistics* given = nullptr)
{
  Rows values;
  for (std::int64_t j = 0; j < layers - 1; ++j)
  {
    const GeometricTextureTensorNames names = NamesOfConvolution(level, j, layers);
    const Rows weight = WeightOf(tensors, names);
    const Eigen::RowVectorXd bias = BiasOf(tensors, names);
    Rows out = Rows::Constant(features.rows(), weight.rows(), -std::numeric_limits<double>::infinity());
    for (Eigen::Index f = 0; f < features.rows(); ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        Eigen::RowVectorXd in(weight.cols());
        if (j == 0)
        {
          in = features.row(f).segment<4>(4 * k).cast<double>();
        }
        else
        {
          in << values.row(neighbors(f, k)), values.row(f);
        }
        out.row(f) = out.row(f).cwiseMax(in * weight.transpose() + bias);
      }
    }
    values = std::move(out);
    if (j < layers - 2)
    {
      NormalizeAsDefined(values, given ? &(*given)[static_cast<std::size_t>(j)] : nullptr);
    }
  }
  return values;
}

struct Case
{
  TriangleMesh Mesh;
  FaceNeighbors Neighbors;
  EdgeFeatureMatrix Features;

  explicit Case(const TriangleMesh& mesh)
    : Mesh(mesh)
    , Neighbors(ComputeFaceNeighbors(mesh))
    , Features(ComputeEdgeFeatures(mesh.Points.cast<float>(), mesh.Triangles, this->Neighbors))
  {}
};

FaceNetwork::Output OutputOf(const GeometricTextureModel& model, std::int64_t level, const Case& input, int threads = 1)
{
  const ThreadScope scope(threads);
  const SingleThreadedBlas blas;
  return FaceNetwork(model.Generator, level, model.Options.Layers).Run(input.Features, input.Neighbors.Faces);
}
} // namespace

TEST(FaceNetwork, IsWhatItsDefinitionSays)
{
  const GeometricTextureModel model = test::RandomGeometricTexture();
  // Closed and open, with poles of degree 30, of one triangle, and of more triangles than a tile has rows.
  for (const TriangleMesh& mesh : { test::BumpySurface(2), test::PlanePatch(5, 4, 1.0, 1.0, 0.2), test::UvSphere(6, 30),
         test::SingleTriangle(), test::BumpySurface(3) })
  {
    const Case input(mesh);
    for (const std::int64_t level : { 0, 1 })
    {
      const Rows expected = Defined(
        model.Generator, level, model.Options.Layers, input.Features, input.Neighbors.Faces);
      const Rows found = OutputOf(model, level, input).cast<double>();
      ASSERT_EQ(found.rows(), expected.rows());
      EXPECT_LE((found - expected).norm(), 1e-5 * expected.norm()) << mesh.NumberOfTriangles();
    }
  }
}

TEST(FaceNetwork, GivenStatisticsTakeThePlaceOfThoseOfTheMesh)
{
  const GeometricTextureModel model = test::RandomGeometricTexture();
  const SingleThreadedBlas blas;
  const Case input(test::BumpySurface(3));
  const Case other(test::PlanePatch(5, 4, 1.0, 1.0, 0.2));
  NetworkStatistics found;
  const FaceNetwork plain(model.Generator, 1, model.Options.Layers);
  const FaceNetwork::Output output = plain.Run(input.Features, input.Neighbors.Faces, {}, &found);
  ASSERT_EQ(found.size(), 3U) << "after each convolution but the last";
  EXPECT_EQ(output, OutputOf(model, 1, input)) << "looking changes nothing";
  std::map<std::string, ModelTensor> statistics;
  for (std::size_t j = 0; j < found.size(); ++j)
  {
    const GeometricTextureStatisticsNames names = NamesOfStatistics(1, static_cast<std::int64_t>(j));
    const auto width = static_cast<std::int64_t>(found[j].Mean.size());
    statistics[names.Mean] = { { width }, { found[j].Mean.begin(), found[j].Mean.end() } };
    statistics[names.Variance] = { { width }, { found[j].Variance.begin(), found[j].Variance.end() } };
  }
  const FaceNetwork given(model.Generator, 1, model.Options.Layers, statistics);
  const Rows same = given.Run(input.Features, input.Neighbors.Faces).cast<double>();
  EXPECT_LE((same - output.cast<double>()).norm(), 1e-5 * same.norm()) << "on the mesh that they were measured on";
  const Rows elsewhere = given.Run(other.Features, other.Neighbors.Faces).cast<double>();
  const Rows expected = Defined(
    model.Generator, 1, model.Options.Layers, other.Features, other.Neighbors.Faces, &found);
  EXPECT_LE((elsewhere - expected).norm(), 1e-5 * expected.norm());
  EXPECT_GT((elsewhere - OutputOf(model, 1, other).cast<double>()).norm(), 1e-2 * expected.norm());
}

TEST(FaceNetwork, DiscriminatorsHaveOneOutput)
{
  const GeometricTextureModel model = test::RandomGeometricTexture();
  const Case input(test::BumpySurface(1));
  const FaceNetwork network(model.Discriminator, 1, model.Options.Layers);
  const Rows found = network.Run(input.Features, input.Neighbors.Faces).cast<double>();
  const Rows expected = Defined(model.Discriminator, 1, model.Options.Layers, input.Features, input.Neighbors.Faces);
  ASSERT_EQ(found.cols(), 1);
  EXPECT_LE((found - expected).norm(), 1e-5 * expected.norm());
}

TEST(FaceNetwork, TwoConvolutionsAreTheShortest)
{
  GeometricTextureOptions options = test::SmallGeometricTexture();
  options.Layers = 3;
  const GeometricTextureModel model = test::RandomGeometricTexture(options);
  const Case input(test::BumpySurface(1));
  const Rows expected = Defined(model.Generator, 0, 3, input.Features, input.Neighbors.Faces);
  EXPECT_LE((OutputOf(model, 0, input).cast<double>() - expected).norm(), 1e-5 * expected.norm());
}

TEST(FaceNetwork, HasTheSameBitsForEveryNumberOfThreads)
{
  const GeometricTextureModel model = test::RandomGeometricTexture();
  const Case input(test::BumpySurface(4)); // several tiles
  const FaceNetwork::Output one = OutputOf(model, 1, input, 1);
  EXPECT_EQ(one, OutputOf(model, 1, input, 2));
  EXPECT_EQ(one, OutputOf(model, 1, input, 3));
}

TEST(FaceKernels, AllInstructionSetsAgree)
{
  std::vector<const FaceKernels*> variants = { &BestFaceKernels() };
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
  {
    variants.push_back(&Avx2FaceKernels);
  }
#endif
  constexpr std::int64_t rows = 37;
  constexpr std::int64_t width = 21; // no multiple of any vector
  const auto numbers = [](std::int64_t count, std::uint64_t seed) {
    FaceNetwork::Output values(1, count);
    for (std::int64_t k = 0; k < count; ++k)
    {
      values(0, k) = static_cast<float>(test::Uniform(seed, static_cast<std::uint64_t>(k)));
    }
    return values;
  };
  std::vector<std::int32_t> neighbors;
  for (std::int32_t k = 0; k < 3 * rows; ++k)
  {
    neighbors.push_back(static_cast<std::int32_t>(test::Mix(9, static_cast<std::uint64_t>(k)) % rows));
  }
  const auto results = [&](const FaceKernels& kernels) {
    FaceNetwork::Output out = FaceNetwork::Output::Zero(4, rows * 2 * width);
    const FaceNetwork::Output bias = numbers(width, 2);
    kernels.EdgeMaps(numbers(12 * rows, 1).data(), numbers(4 * width, 3).data(), bias.data(), rows, width, &out(0, 0));
    out.row(1) = numbers(2 * width * rows, 4);
    kernels.GatherMax(neighbors.data(), bias.data(), 0, rows, width, &out(1, 0));
    kernels.Normalize(&out(1, 0), 2 * width, bias.data(), numbers(width, 5).data(), rows, width, &out(2, 0));
    std::vector<double> moments(2 * width, 0.0);
    kernels.AddMoments(&out(1, 0), 2 * width, rows, width, moments.data(), moments.data() + width);
    out.row(3).head(2 * width) = Eigen::Map<Eigen::RowVectorXd>(moments.data(), 2 * width).cast<float>();
    return out;
  };
  const FaceNetwork::Output generic = results(GenericFaceKernels);
  for (const FaceKernels* kernels : variants)
  {
    EXPECT_LE((results(*kernels) - generic).cwiseAbs().maxCoeff(), 2e-5F);
  }
}
