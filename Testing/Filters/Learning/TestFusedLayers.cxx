// SPDX-License-Identifier: BSD-3-Clause
// The single steps of float32 layers against the plain expressions in float64, forward and backward; the dense Poisson
// inverse; the loss of flow matching.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Learning/Layers/ComplexMlp.h"
#include "Learning/Layers/DensePoisson.h"
#include "Learning/Layers/MeshTensors.h"
#include "Learning/Losses/FlowMatchingLoss.h"
#include "Learning/Networks/InitialWeights.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace surfsynth
{
namespace
{

class FusedLayers : public testing::Test
{
protected:
  static MeshTensors Mesh(torch::Dtype type)
  {
    const TriangleMesh mesh = test::Scaled(test::IrregularSphere(2), 0.28); // about unit area
    return MeshTensors(BuildPoissonOperators(mesh, MeshTopology(mesh)), type);
  }

  /// Numbers in [-1, 1), of double precision.
  torch::Tensor Numbers(std::vector<std::int64_t> shape)
  {
    const torch::Tensor values = torch::empty(shape, torch::kFloat64);
    ++this->Calls;
    for (std::int64_t k = 0; k < values.numel(); ++k)
    {
      values.data_ptr<double>()[k] = test::Uniform(this->Calls, static_cast<std::uint64_t>(k));
    }
    return values;
  }

  using Layer =
    std::function<std::vector<torch::Tensor>(const MeshTensors& mesh, const std::vector<torch::Tensor>& in)>;

  /// Outputs and derivatives of a weighted sum of them, one after the other.
  static std::vector<torch::Tensor> Evaluate(const Layer& layer, const std::vector<torch::Tensor>& inputs,
    const std::vector<torch::Tensor>& weights, const MeshTensors& mesh, torch::Dtype type)
  {
    std::vector<torch::Tensor> typed;
    for (const torch::Tensor& input : inputs)
    {
      typed.push_back(input.to(type).clone().requires_grad_(true));
    }
    std::vector<torch::Tensor> results = layer(mesh, typed);
    torch::Tensor sum = torch::zeros({}, type);
    for (std::size_t k = 0; k < results.size(); ++k)
    {
      sum = sum + (results[k] * weights[k].to(type)).sum();
    }
    for (const torch::Tensor& derivative : torch::autograd::grad({ sum }, typed))
    {
      results.push_back(derivative);
    }
    return results;
  }

  void ExpectAgreement(const Layer& layer, const std::vector<torch::Tensor>& inputs, double limit)
  {
    const MeshTensors exact = Mesh(torch::kFloat64);
    const MeshTensors single = Mesh(torch::kFloat32);
    ASSERT_EQ(exact.Incidence, nullptr) << "the plain expressions are compared with themselves";
    ASSERT_NE(single.Incidence, nullptr) << "the plain expressions are compared with themselves";
    std::vector<torch::Tensor> weights;
    for (const torch::Tensor& output : layer(exact, inputs))
    {
      weights.push_back(this->Numbers(output.sizes().vec()));
    }
    const std::vector<torch::Tensor> expected = Evaluate(layer, inputs, weights, exact, torch::kFloat64);
    const std::vector<torch::Tensor> found = Evaluate(layer, inputs, weights, single, torch::kFloat32);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k)
    {
      ASSERT_EQ(found[k].sizes(), expected[k].sizes());
      const double difference =
        ((found[k].to(torch::kFloat64) - expected[k]).norm() / expected[k].norm()).item<double>();
      EXPECT_LT(difference, limit) << "output or derivative " << k;
    }
  }

  std::int64_t Vertices = test::IrregularSphere(2).NumberOfPoints();
  std::int64_t Faces = test::IrregularSphere(2).NumberOfTriangles();
  std::uint64_t Calls = 500;
};

TEST_F(FusedLayers, GradientAndMeanAtFacesAgreeWithThePlainExpressions)
{
  const Layer layer = [](const MeshTensors& mesh, const std::vector<torch::Tensor>& in) -> std::vector<torch::Tensor> {
    const FaceSignal faces = AtFaces(mesh, in[0]);
    return { faces.Gradient.Real, faces.Gradient.Imaginary, faces.Mean };
  };
  this->ExpectAgreement(layer, { this->Numbers({ 2, this->Vertices, 5 }) }, 1e-6);
  this->ExpectAgreement(layer, { this->Numbers({ this->Vertices, 1 }) }, 1e-6);
}

TEST_F(FusedLayers, DivergenceAgreesWithThePlainExpression)
{
  const Layer layer = [](const MeshTensors& mesh, const std::vector<torch::Tensor>& in) -> std::vector<torch::Tensor> {
    return { IntegratedDivergence(mesh, { in[0], in[1] }) };
  };
  this->ExpectAgreement(layer, { this->Numbers({ 3, this->Faces, 4 }), this->Numbers({ 3, this->Faces, 4 }) }, 1e-6);
}

TEST_F(FusedLayers, MeanAroundVerticesAgreesWithThePlainExpression)
{
  const Layer layer = [](const MeshTensors& mesh, const std::vector<torch::Tensor>& in) -> std::vector<torch::Tensor> {
    return { VertexMean(mesh, in[0]) };
  };
  this->ExpectAgreement(layer, { this->Numbers({ 2, 2, this->Faces, 3 }) }, 1e-6);
}

TEST_F(FusedLayers, ComplexLayersAgreeWithThePlainExpressions)
{
  ComplexLinear layer(ComplexLinearOptions(6, 7).nonlinear(true));
  const std::vector<torch::Tensor> parameters = layer->parameters();
  ASSERT_EQ(parameters.size(), 3U); // bias, real and imaginary weights
  ASSERT_EQ(parameters[0].dim(), 1);
  const Layer evaluate = [&](const MeshTensors&, const std::vector<torch::Tensor>& in) -> std::vector<torch::Tensor> {
    // The parameters are inputs too, so that derivatives by the bias are compared.
    for (std::size_t k = 0; k < parameters.size(); ++k)
    {
      torch::Tensor parameter = parameters[k];
      parameter.set_data(in[k + 2].detach().clone());
    }
    const ComplexTensor out = layer->forward({ in[0], in[1] });
    std::vector<torch::Tensor> results = { out.Real, out.Imaginary };
    if (in[0].requires_grad())
    {
      const torch::Tensor loss = (out.Real * out.Real.detach() + out.Imaginary * out.Imaginary.detach()).sum();
      for (const torch::Tensor& derivative : torch::autograd::grad({ loss }, parameters, {}, true))
      {
        results.push_back(derivative.detach());
      }
    }
    else
    {
      results.insert(results.end(), parameters.begin(), parameters.end()); // of the right shapes
    }
    for (std::size_t k = 2; k < 5; ++k)
    {
      results.push_back(in[k].sum().reshape({ 1 })); // each input must be used
    }
    return results;
  };
  this->ExpectAgreement(evaluate,
    { this->Numbers({ 2, 700, 6 }), this->Numbers({ 2, 700, 6 }), this->Numbers({ 7 }), this->Numbers({ 7, 6 }),
      this->Numbers({ 7, 6 }) },
    1e-5);
}

TEST_F(FusedLayers, ModulationAgreesWithThePlainExpression)
{
  Modulator modulator(4);
  const Layer layer = [&](const MeshTensors&, const std::vector<torch::Tensor>& in) -> std::vector<torch::Tensor> {
    modulator->to(in[0].scalar_type());
    const ComplexTensor out = modulator->forward({ in[0], in[1] }, in[2]);
    return { out.Real, out.Imaginary };
  };
  this->ExpectAgreement(
    layer, { this->Numbers({ 2, 600, 4 }), this->Numbers({ 2, 600, 4 }), 3.0 * this->Numbers({ 2, 600, 4 }) }, 1e-5);
}

TEST_F(FusedLayers, HaveTheSameBitsForEveryNumberOfThreads)
{
  const MeshTensors mesh = Mesh(torch::kFloat32);
  PoissonNetOptions options;
  options.Width = 8;
  options.Blocks = 2;
  options.InnerProducts = true;
  const torch::Tensor x = this->Numbers({ 3, this->Vertices, 3 }).to(torch::kFloat32);
  const auto derivatives = [&](int threads) {
    const int before = torch::get_num_threads();
    torch::set_num_threads(threads);
    PoissonNet network = MakePoissonNet(InitialPoissonNet(options, 5));
    network->forward(mesh, x).Values.square().sum().backward();
    torch::set_num_threads(before);
    std::vector<torch::Tensor> gradients;
    for (const auto& parameter : network->named_parameters())
    {
      if (parameter.key().find("mag_bias") != std::string::npos)
      {
        gradients.push_back(parameter.value().grad());
      }
    }
    return torch::cat(gradients);
  };
  EXPECT_TRUE(torch::equal(derivatives(1), derivatives(2)));
}

TEST_F(FusedLayers, RefuseSecondDerivatives)
{
  const MeshTensors mesh = Mesh(torch::kFloat32);
  const torch::Tensor x = this->Numbers({ this->Vertices, 2 }).to(torch::kFloat32).requires_grad_(true);
  const torch::Tensor sum = AtFaces(mesh, x).Gradient.Real.square().sum();
  EXPECT_THROW(torch::autograd::grad({ sum }, { x }, {}, true, true), std::exception);
}

TEST_F(FusedLayers, TheDenseInverseSolvesThePoissonEquation)
{
  const MeshTensors sparse = Mesh(torch::kFloat32);
  MeshTensors dense = sparse;
  UseDenseInverse(dense);
  ASSERT_EQ(dense.DenseInverse.size(0), this->Vertices);
  const torch::Tensor gradients = this->Numbers({ 2, this->Faces, 6 }).to(torch::kFloat32);
  const auto solve = [&](const MeshTensors& mesh, const torch::Tensor& right) {
    return WithoutMean(mesh, SolvePoisson(mesh, right));
  };
  torch::Tensor right = IntegratedDivergence(sparse, { gradients, gradients }).detach().requires_grad_(true);
  const torch::Tensor expected = solve(sparse, right);
  const torch::Tensor found = solve(dense, right);
  EXPECT_LT(((found - expected).norm() / expected.norm()).item<double>(), 1e-5);
  const torch::Tensor weights = this->Numbers(expected.sizes().vec()).to(torch::kFloat32);
  const torch::Tensor byHand = torch::autograd::grad({ (expected * weights).sum() }, { right })[0];
  const torch::Tensor byProduct = torch::autograd::grad({ (found * weights).sum() }, { right })[0];
  // Derivatives along a constant are those by a right-hand side that is no divergence.
  const auto centered = [](const torch::Tensor& values) { return values - values.mean(-2, true); };
  EXPECT_LT(((centered(byProduct) - centered(byHand)).norm() / centered(byHand).norm()).item<double>(), 1e-4);
}

TEST_F(FusedLayers, TheFlowMatchingLossOfAConstantErrorIsItsSquare)
{
  const MeshTensors mesh = Mesh(torch::kFloat64);
  const torch::Tensor delta = this->Numbers({ 4, this->Vertices, 2 });
  const FlowMatchingLoss loss = ComputeFlowMatchingLoss(mesh, { delta + 0.5, {} }, delta);
  EXPECT_NEAR(loss.Vertex.item<double>(), 0.25, 1e-6);
  EXPECT_NEAR(loss.Jacobian.item<double>(), 0.0, 1e-12);
}

TEST_F(FusedLayers, TheFlowMatchingLossOfGradientsIsTheirDirichletEnergy)
{
  // The energy of x on the unit sphere is the integral of 1 - x^2, two thirds of the area; halved for two components.
  const auto energy = [](int level) {
    const TriangleMesh sphere = test::IrregularSphere(level);
    const MeshTensors mesh(BuildPoissonOperators(sphere, MeshTopology(sphere)), torch::kFloat64);
    const PointMatrix points = sphere.Points;
    const torch::Tensor x = torch::from_blob(const_cast<double*>(points.data()), { points.rows(), 3 }, torch::kFloat64)
                              .clone()
                              .slice(1, 0, 1);
    const torch::Tensor gradients = torch::zeros({ 2 * sphere.NumberOfTriangles(), 1 }, torch::kFloat64);
    const FlowMatchingLoss byHead = ComputeFlowMatchingLoss(mesh, { torch::zeros_like(x), gradients }, x);
    const FlowMatchingLoss byValues = ComputeFlowMatchingLoss(mesh, { torch::zeros_like(x), {} }, x);
    EXPECT_NEAR(byHead.Jacobian.item<double>(), byValues.Jacobian.item<double>(), 1e-12);
    return byHead.Jacobian.item<double>();
  };
  EXPECT_NEAR(energy(3), 1.0 / 3.0, 0.01);
  EXPECT_LT(std::abs(energy(3) - 1.0 / 3.0), std::abs(energy(1) - 1.0 / 3.0))
    << "another triangulation, the same limit";
}

} // namespace
} // namespace surfsynth
