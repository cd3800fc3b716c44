// SPDX-License-Identifier: BSD-3-Clause
// The layers of PoissonNet: hand-computed cases, finite differences, and what the architecture promises.
#include "ExampleMeshes.h"

#include "Core/Common/Errors.h"
#include "Learning/Networks/PoissonNet.h"

#include <gtest/gtest.h>

#include <functional>

using namespace surfsynth;

namespace
{

const TriangleMesh& Sphere()
{
  static const TriangleMesh mesh = test::Scaled(test::IrregularSphere(1), 0.28); // about unit area
  return mesh;
}

PoissonOperators Operators(const TriangleMesh& mesh) { return BuildPoissonOperators(mesh, MeshTopology(mesh)); }

torch::Tensor Random(std::vector<std::int64_t> shape)
{
  static std::uint64_t calls = 0;
  ++calls;
  torch::Tensor values = torch::empty(shape, torch::kFloat64);
  for (std::int64_t k = 0; k < values.numel(); ++k)
  {
    values.data_ptr<double>()[k] = test::Uniform(calls, static_cast<std::uint64_t>(k));
  }
  return values;
}

/// Derivatives of a random weighted sum of f along random directions, against central differences.
void ExpectGradient(const std::function<torch::Tensor()>& f, std::vector<torch::Tensor> inputs, double limit = 1e-6)
{
  for (torch::Tensor& input : inputs)
  {
    input.requires_grad_(true);
  }
  const torch::Tensor weights = Random(f().sizes().vec());
  const auto loss = [&] { return (f() * weights).sum(); };
  const std::vector<torch::Tensor> gradients = torch::autograd::grad({ loss() }, inputs);
  const torch::NoGradGuard noGradients;
  for (std::size_t k = 0; k < inputs.size(); ++k)
  {
    const torch::Tensor direction = Random(inputs[k].sizes().vec());
    const double step = 1e-5;
    inputs[k].add_(direction, step);
    const double above = loss().item<double>();
    inputs[k].add_(direction, -2.0 * step);
    const double below = loss().item<double>();
    inputs[k].add_(direction, step);
    const double expected = (gradients[k] * direction).sum().item<double>();
    const double scale = std::max(std::abs(expected), gradients[k].norm().item<double>());
    EXPECT_NEAR((above - below) / (2.0 * step), expected, limit * scale) << "input " << k;
  }
}

std::vector<torch::Tensor> With(std::vector<torch::Tensor> inputs, const torch::nn::Module& module)
{
  for (const torch::Tensor& parameter : module.parameters())
  {
    inputs.push_back(parameter);
  }
  return inputs;
}

double Difference(const torch::Tensor& a, const torch::Tensor& b) { return ((a - b).norm() / b.norm()).item<double>(); }

class OnSphere : public testing::Test
{
protected:
  const PoissonOperators Own = Operators(Sphere());
  const MeshTensors Mesh = MeshTensors(Own, torch::kFloat64);
  const std::int64_t Vertices = Sphere().NumberOfPoints();
  const std::int64_t Faces = Sphere().NumberOfTriangles();
};

} // namespace

// --- Operators ------------------------------------------------------------------------------------------------------

TEST(PoissonOperators, OfATriangleAreThoseComputedByHand)
{
  // (0,0,0), (2,0,0), (0,1,0): area 1, mass 1/3 each.
  const MeshTensors mesh(Operators(test::SingleTriangle()), torch::kFloat64);
  const torch::Tensor x = torch::tensor({ 1.0, 5.0, 4.0 }, torch::kFloat64).reshape({ 3, 1 });
  const ComplexTensor gradient = FaceGradient(mesh, x);
  EXPECT_NEAR(gradient.Real.item<double>(), 2.0, 1e-6);
  EXPECT_NEAR(gradient.Imaginary.item<double>(), 3.0, 1e-6);
  EXPECT_NEAR(FaceMean(mesh, x).item<double>(), 10.0 / 3.0, 1e-6);
  EXPECT_NEAR(MassMean(mesh, x).item<double>(), 10.0 / 3.0, 1e-6);
  EXPECT_NEAR(mesh.FaceAreas.item<double>(), 1.0, 1e-7);
  EXPECT_NEAR(mesh.VertexMass.sum().item<double>(), 1.0, 1e-6);
  EXPECT_TRUE(torch::allclose(
    VertexMean(mesh, torch::full({ 1, 1 }, 7.0, torch::kFloat64)), torch::full({ 3, 1 }, 7.0, torch::kFloat64)));
  // G^T A g with g = (2, 3): basis gradients are (-1/2, -1), (1/2, 0), (0, 1).
  const torch::Tensor expected = torch::tensor({ -4.0, 1.0, 3.0 }, torch::kFloat64).reshape({ 3, 1 });
  EXPECT_LE(Difference(IntegratedDivergence(mesh, gradient), expected), 1e-6);
}

TEST_F(OnSphere, IntegratingTheGradientGivesTheSignalBack)
{
  const torch::Tensor x = Random({ this->Vertices, 4 });
  const torch::Tensor solution = SolvePoisson(
    this->Mesh, IntegratedDivergence(this->Mesh, FaceGradient(this->Mesh, x)));
  EXPECT_LE(Difference(solution - MassMean(this->Mesh, solution), x - MassMean(this->Mesh, x)), 1e-5);
}

TEST_F(OnSphere, SolvesOfABatchAreThoseOfItsParts)
{
  const torch::Tensor batch = Random({ 2, 3, this->Vertices, 4 });
  const torch::Tensor solved = SolvePoisson(this->Mesh, batch);
  EXPECT_TRUE(torch::equal(solved[1][2], SolvePoisson(this->Mesh, batch[1][2])));
  EXPECT_EQ(SolvePoisson(this->Mesh, batch.to(torch::kFloat32)).scalar_type(), torch::kFloat32);
}

TEST_F(OnSphere, NumbersThatAreNotFiniteAreRefused)
{
  torch::Tensor x = Random({ this->Vertices, 2 });
  x[3][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SolvePoisson(this->Mesh, x), InvalidInput);
}

// --- Gradients ------------------------------------------------------------------------------------------------------

TEST_F(OnSphere, GradientOfTheOperators)
{
  const torch::Tensor x = Random({ 2, this->Vertices, 3 });
  ExpectGradient([&] { return Interleaved(FaceGradient(this->Mesh, x)); }, { x });
  ExpectGradient([&] { return FaceMean(this->Mesh, x); }, { x });
  ExpectGradient([&] { return MassMean(this->Mesh, x); }, { x });
  const ComplexTensor z = { Random({ 2, this->Faces, 3 }), Random({ 2, this->Faces, 3 }) };
  ExpectGradient([&] { return IntegratedDivergence(this->Mesh, z); }, { z.Real, z.Imaginary });
  ExpectGradient([&] { return VertexMean(this->Mesh, z.Real); }, { z.Real });
}

TEST_F(OnSphere, GradientOfThePoissonSolve)
{
  const torch::Tensor x = Random({ 2, this->Vertices, 3 });
  const auto centered = [&](const torch::Tensor& y) { return y - MassMean(this->Mesh, y); };
  ExpectGradient([&] { return centered(SolvePoisson(this->Mesh, centered(x) * this->Mesh.VertexMass)); }, { x });
}

TEST_F(OnSphere, SecondGradientOfThePoissonSolve)
{
  const torch::Tensor x = Random({ this->Vertices, 2 });
  const auto first = [&] {
    const torch::Tensor solved = SolvePoisson(this->Mesh, (x - x.mean(-2, true)) * this->Mesh.VertexMass);
    return torch::autograd::grad({ solved.pow(3).sum() }, { x }, {}, true, true)[0];
  };
  x.requires_grad_(true);
  const torch::Tensor weights = Random({ this->Vertices, 2 });
  const torch::Tensor second = torch::autograd::grad({ (first() * weights).sum() }, { x })[0];
  const torch::Tensor direction = Random({ this->Vertices, 2 });
  const auto shifted = [&](double step) {
    {
      const torch::NoGradGuard noGradients;
      x.add_(direction, step);
    }
    return (first() * weights).sum().item<double>();
  };
  const double above = shifted(1e-5);
  const double below = shifted(-2e-5);
  const double expected = (second * direction).sum().item<double>();
  EXPECT_NEAR((above - below) / 2e-5, expected, 1e-6 * second.norm().item<double>());
}

TEST_F(OnSphere, GradientOfTheComplexLayers)
{
  const ComplexTensor z = { Random({ this->Faces, 4 }), Random({ this->Faces, 4 }) };
  const torch::Tensor features = Random({ this->Faces, 4 });
  const auto joined = [](const ComplexTensor& y) { return torch::cat({ y.Real, y.Imaginary }, -1); };
  torch::manual_seed(1);
  ComplexLinear nonlinear(ComplexLinearOptions(4, 5).nonlinear(true));
  nonlinear->to(torch::kFloat64);
  ExpectGradient([&] { return joined(nonlinear(z)); }, With({ z.Real, z.Imaginary }, *nonlinear));
  Modulator modulator(4);
  modulator->to(torch::kFloat64);
  ExpectGradient([&] { return joined(modulator(z, features)); }, With({ z.Real, z.Imaginary, features }, *modulator));
  ComplexMlp mlp(ComplexMlpOptions(4, 3).layers(3));
  mlp->to(torch::kFloat64);
  ExpectGradient([&] { return joined(mlp(z, features)); }, With({ z.Real, z.Imaginary, features }, *mlp));
}

TEST_F(OnSphere, GradientOfTheVertexLayers)
{
  torch::manual_seed(2);
  const torch::Tensor x = Random({ this->Vertices, 4 });
  for (const bool weighted : { false, true })
  {
    VertexNorm norm(VertexNormOptions(4).mass_weighted(weighted));
    norm->to(torch::kFloat64);
    ExpectGradient([&] { return norm(this->Mesh, x); }, With({ x }, *norm));
  }
  const torch::Tensor u = Random({ this->Vertices, 4 });
  const torch::Tensor extra = Random({ this->Vertices, 4 });
  const torch::Tensor products = Random({ this->Vertices, 4 });
  VertexMlp mlp(VertexMlpOptions(4, 16).normalize(true).inner_products(true));
  mlp->to(torch::kFloat64);
  ExpectGradient([&] { return mlp(this->Mesh, x, u, extra, products); }, With({ x, u, extra, products }, *mlp));
}

TEST_F(OnSphere, GradientOfWholeNetworks)
{
  torch::manual_seed(3);
  PoissonNetOptions options;
  options.Width = 6;
  options.Blocks = 2;
  options.ComplexLayers = 2;
  options.ExtraFeatures = 2;
  options.InnerProducts = true;
  options.ModulateHead = true;
  const torch::Tensor x = Random({ this->Vertices, 3 });
  const torch::Tensor extra = Random({ 2 });
  PoissonNet integrating(options);
  integrating->to(torch::kFloat64);
  // The head does not differentiate through the positions that it adds: only the parameters and the condition are
  // asked.
  ExpectGradient(
    [&] { return integrating->forward(this->Mesh, x, extra).Values; }, With({ extra }, *integrating), 1e-5);
  options.Head = PoissonNetHead::Linear;
  options.Activation = LastActivation::LogSoftmax;
  options.OutputChannels = 5;
  for (const PoissonNetDomain domain :
    { PoissonNetDomain::Vertices, PoissonNetDomain::Faces, PoissonNetDomain::Global })
  {
    options.Domain = domain;
    PoissonNet network(options);
    network->to(torch::kFloat64);
    ExpectGradient([&] { return network->forward(this->Mesh, x, extra).Values; }, With({ x, extra }, *network), 1e-5);
  }
}

// --- Promises -------------------------------------------------------------------------------------------------------

TEST_F(OnSphere, ComplexLayersCommuteWithTheTurnOfFrames)
{
  torch::manual_seed(4);
  ComplexMlp mlp(ComplexMlpOptions(6, 6).layers(3));
  mlp->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  const ComplexTensor z = { Random({ this->Faces, 6 }), Random({ this->Faces, 6 }) };
  const torch::Tensor features = Random({ this->Faces, 6 });
  const torch::Tensor angle = 3.0 * Random({ this->Faces, 1 });
  const auto turned = [&](const ComplexTensor& y) {
    return ComplexTensor{ y.Real * torch::cos(angle) - y.Imaginary * torch::sin(angle),
      y.Real * torch::sin(angle) + y.Imaginary * torch::cos(angle) };
  };
  const ComplexTensor before = mlp(turned(z), features);
  const ComplexTensor after = turned(mlp(z, features));
  EXPECT_LE(Difference(before.Real, after.Real), 1e-12);
  EXPECT_LE(Difference(before.Imaginary, after.Imaginary), 1e-12);
}

TEST_F(OnSphere, TheOrderOfVerticesAndTheFirstCornerDoNotMatter)
{
  torch::manual_seed(5);
  PoissonNetOptions options;
  options.Width = 8;
  options.Blocks = 2;
  options.InnerProducts = true;
  options.Head = PoissonNetHead::Linear;
  PoissonNet network(options);
  network->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  TriangleMesh renamed = Sphere();
  for (Index v = 0; v < renamed.NumberOfPoints(); ++v)
  {
    renamed.Points.row(renamed.NumberOfPoints() - 1 - v) = Sphere().Points.row(v);
  }
  for (Index f = 0; f < renamed.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      renamed.Triangles(f, k) = renamed.NumberOfPoints() - 1 - Sphere().Triangles(f, (k + f) % 3);
    }
  }
  const torch::Tensor x = Random({ this->Vertices, 3 });
  const torch::Tensor there =
    network->forward(MeshTensors(Operators(renamed), torch::kFloat64), x.flip(0)).Values.flip(0);
  EXPECT_LE(Difference(there, network->forward(this->Mesh, x).Values), 1e-4);
}

TEST(PoissonNet, ParametersAreThoseThatFilesMustHold)
{
  for (int variant = 0; variant < 64; ++variant)
  {
    PoissonNetOptions options;
    options.Width = 4;
    options.Blocks = 2;
    options.ComplexLayers = 1 + variant % 3;
    options.Modulate = (variant & 1) != 0;
    options.ModulateHead = (variant & 2) != 0;
    options.InnerProducts = (variant & 4) != 0;
    options.Normalize = (variant & 8) != 0;
    options.ExtraFeatures = (variant & 16) != 0 ? 3 : 0;
    options.Head = (variant & 32) != 0 ? PoissonNetHead::Linear : PoissonNetHead::GradientDomain;
    std::map<std::string, std::vector<std::int64_t>> found;
    for (const auto& parameter : PoissonNet(options)->named_parameters())
    {
      found[parameter.key()] = parameter.value().sizes().vec();
    }
    EXPECT_EQ(found, ExpectedTensors(options)) << "variant " << variant;
  }
}

TEST_F(OnSphere, ABatchIsItsSamples)
{
  torch::manual_seed(6);
  PoissonNetOptions options;
  options.Width = 8;
  options.ExtraFeatures = 2;
  options.Normalize = true;
  PoissonNet network(options);
  network->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  const torch::Tensor x = Random({ 3, this->Vertices, 3 });
  const torch::Tensor extra = Random({ 3, 1, 2 });
  const PoissonNetOutput batch = network->forward(this->Mesh, x, extra);
  const PoissonNetOutput alone = network->forward(this->Mesh, x[1], extra[1]);
  EXPECT_LE(Difference(batch.Values[1], alone.Values), 1e-9);
  EXPECT_LE(Difference(batch.Gradients[1], alone.Gradients), 1e-9);
}

TEST_F(OnSphere, WrongShapesAreNamed)
{
  PoissonNetOptions options;
  options.Width = 4;
  options.ExtraFeatures = 2;
  PoissonNet network(options);
  const MeshTensors mesh(this->Own);
  const auto x = torch::zeros({ this->Vertices, 3 });
  const auto extra = torch::zeros({ 2 });
  EXPECT_NO_THROW(network->forward(mesh, x, extra));
  EXPECT_THROW(network->forward(mesh, torch::zeros({ this->Vertices, 4 }), extra), InvalidInput);
  EXPECT_THROW(network->forward(mesh, torch::zeros({ this->Vertices + 1, 3 }), extra), InvalidInput);
  EXPECT_THROW(network->forward(mesh, x, torch::zeros({ 3 })), InvalidInput);
  EXPECT_THROW(network->forward(mesh, x, torch::zeros({ 5, 2 })), InvalidInput);
  EXPECT_THROW(network->forward(mesh, x), InvalidInput);
}
