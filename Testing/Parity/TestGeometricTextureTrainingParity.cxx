// SPDX-License-Identifier: BSD-3-Clause
// Training of geometric textures against the published implementation: a step of the discriminator and one of the
// generator of two levels, and the losses of the fit at several scales, all in float64.
#include "FixtureTensors.h"
#include "Fixtures.h"

#include "Learning/Losses/GeometricTextureLosses.h"
#include "Learning/Losses/MeshFitLosses.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{

TriangleMesh ReadMesh(const SafetensorsFile& file, const std::string& points, const std::string& triangles)
{
  TriangleMesh mesh;
  mesh.Points = ReadMatrix(file, points);
  const std::vector<std::int64_t> ids = file.Integers(triangles);
  mesh.Triangles.resize(static_cast<Eigen::Index>(ids.size()) / 3, 3);
  std::copy(ids.begin(), ids.end(), mesh.Triangles.data());
  return mesh;
}

/// The networks of both levels with the published random weights.
GeometricTextureNetwork ReadNetwork(const std::string& path, bool discriminator)
{
  const SafetensorsFile file(path);
  GeometricTextureOptions options;
  options.Levels = 2;
  GeometricTextureNetwork network(options, discriminator);
  network->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  for (auto& parameter : network->named_parameters())
  {
    parameter.value().copy_(ToTensor(file, parameter.key(), torch::kFloat64));
  }
  return network;
}

class GeometricTextureStep : public testing::TestWithParam<int>
{
protected:
  void SetUp() override
  {
    const std::string step = FindFixture("dgts/train_step");
    const std::string generator = FindFixture("dgts/generator_random");
    const std::string discriminator = FindFixture("dgts/discriminator_random");
    if (step.empty() || generator.empty() || discriminator.empty())
    {
      GTEST_SKIP() << "dgts lies neither in Testing/Data/Parity nor in SURFACE_SYNTHESIS_PARITY_DIR";
    }
    this->File = std::make_unique<SafetensorsFile>(step);
    this->Generator = ReadNetwork(generator, false);
    this->Discriminator = ReadNetwork(discriminator, true);
    const FixtureMatrix scales = ReadMatrix(*this->File, "scales");
    const TriangleMesh start = ReadMesh(*this->File, "mesh.template_vertices", "mesh.template_faces");
    const SubdividedMesh finer = SubdivideAtMidpoints(start);
    this->Tables[0] = FaceTables(start, torch::kFloat64);
    this->Tables[1] = FaceTables(finer.Mesh, torch::kFloat64);
    this->Parents = ParentTensor(finer, torch::kCPU);
    this->Start = this->Tensor("mesh.template_vertices") * scales(0, 0);
    this->Real = this->Tensor("real.level" + std::to_string(this->Level)) * scales(this->Level, 0);
  }

  torch::Tensor Tensor(const std::string& name) const { return ToTensor(*this->File, name, torch::kFloat64); }
  std::string Name(const std::string& name) const { return "L" + std::to_string(this->Level) + "." + name; }
  torch::Tensor Noise(const std::string& pass, int level) const
  {
    const std::string name = this->Name("noise_" + pass + std::to_string(level));
    return this->File->Contains(name) ? this->Tensor(name) : torch::Tensor();
  }
  GeometricTextureLevelNetworkImpl& Of(GeometricTextureNetwork& network)
  {
    return network->Level(static_cast<std::size_t>(this->Level));
  }
  const FaceTables& Faces() const { return this->Tables[this->Level]; }

  /// A pass through all levels up to this one, with the noise of that name.
  torch::Tensor Generated(const std::string& pass)
  {
    torch::Tensor positions = this->Start;
    if (this->Level == 1)
    {
      const torch::NoGradGuard noGradients;
      positions = DoubledSubdivision(
        Displaced(this->Generator->Level(0), this->Tables[0], positions, this->Noise(pass, 0)), this->Parents);
    }
    return Displaced(this->Of(this->Generator), this->Faces(), positions, this->Noise(pass, this->Level));
  }

  void ExpectClose(const torch::Tensor& found, const std::string& name, double limit) const
  {
    EXPECT_LE(RelativeError(ToMatrix(found), ReadMatrix(*this->File, this->Name("ref." + name))), limit) << name;
  }
  /// Each parameter against <what>.<parameter>; those that the fixture lacks have no gradient.
  void ExpectAll(GeometricTextureLevelNetworkImpl& network, const std::string& what, double limit,
    const std::function<torch::Tensor(const torch::Tensor&)>& value) const
  {
    for (const auto& parameter : network.named_parameters())
    {
      const std::string name = what + "." + parameter.key();
      if (!this->File->Contains(this->Name("ref." + name)))
      {
        EXPECT_EQ(name, "d.grad_penalty_only.layers.5.conv.bias"); // a constant has no slope
        continue;
      }
      const FixtureMatrix expected = ReadMatrix(*this->File, this->Name("ref." + name));
      const double norm = expected.norm();
      const FixtureMatrix found = ToMatrix(value(parameter.value()));
      ASSERT_EQ(found.size(), expected.size()) << name;
      // Biases before a norm over the faces have no gradient but rounding.
      EXPECT_LE((found.reshaped() - expected.reshaped()).norm(), limit * norm + 1e-12) << name << " of norm " << norm;
    }
  }

  int Level = GetParam();
  std::unique_ptr<SafetensorsFile> File;
  GeometricTextureNetwork Generator{ nullptr };
  GeometricTextureNetwork Discriminator{ nullptr };
  FaceTables Tables[2];
  torch::Tensor Parents;
  torch::Tensor Start;
  torch::Tensor Real;
};

INSTANTIATE_TEST_SUITE_P(Published, GeometricTextureStep, testing::Values(0, 1),
  [](const auto& info) { return "Level" + std::to_string(info.param); });

torch::optim::Adam OptimizerOf(torch::nn::Module& network)
{
  return torch::optim::Adam(network.parameters(), torch::optim::AdamOptions(5e-4).betas(std::make_tuple(0.5, 0.99)));
}

} // namespace

TEST_P(GeometricTextureStep, OfTheDiscriminatorThenOfTheGenerator)
{
  GeometricTextureLevelNetworkImpl& critic = this->Of(this->Discriminator);
  GeometricTextureLevelNetworkImpl& generator = this->Of(this->Generator);
  const FixtureMatrix losses = ReadMatrix(*this->File, this->Name("ref.d.losses"));
  const torch::Tensor fakePositions = this->Generated("d").detach();
  this->ExpectClose(fakePositions, "d.fake_vs", 1e-6);
  const torch::Tensor fake = EdgeFeatureTensor(this->Faces(), fakePositions);
  const torch::Tensor real = EdgeFeatureTensor(this->Faces(), this->Real);
  this->ExpectClose(real.t(), "d.features_real", 1e-6);
  this->ExpectClose(critic.forward(this->Faces(), real).t(), "d.out_real", 1e-5);
  this->ExpectClose(critic.forward(this->Faces(), fake).t(), "d.out_fake", 1e-5);

  torch::optim::Adam ofCritic = OptimizerOf(critic);
  const double alpha = ReadMatrix(*this->File, this->Name("alpha"))(0, 0);
  const torch::Tensor penalty = GradientPenalty(critic, this->Faces(), real, fake, alpha);
  EXPECT_NEAR(penalty.item<double>(), losses(2, 0), 1e-5 * losses(2, 0));
  ofCritic.zero_grad();
  (0.1 * penalty).backward();
  const auto gradient = [](const torch::Tensor& parameter) { return parameter.grad(); };
  this->ExpectAll(critic, "d.grad_penalty_only", 1e-3, gradient);
  const torch::Tensor valueOfReal = CriticValue(critic, this->Faces(), real);
  const torch::Tensor valueOfFake = CriticValue(critic, this->Faces(), fake);
  EXPECT_NEAR(valueOfReal.item<double>(), losses(0, 0), 1e-5 * losses(0, 0));
  EXPECT_NEAR(valueOfFake.item<double>(), losses(1, 0), 1e-5 * losses(1, 0));
  (valueOfFake - valueOfReal).backward();
  this->ExpectAll(critic, "d.grad", 1e-3, gradient);
  ofCritic.step();
  const auto itself = [](const torch::Tensor& parameter) { return parameter; };
  this->ExpectAll(critic, "d.after_step", 1e-3, itself);

  torch::optim::Adam ofGenerator = OptimizerOf(generator);
  const torch::Tensor generated = this->Generated("g");
  const torch::Tensor reconstructed = this->Generated("rec");
  this->ExpectClose(generated, "g.fake_vs", 1e-6);
  this->ExpectClose(reconstructed, "g.rec_vs", 1e-6);
  const torch::Tensor value = CriticValue(critic, this->Faces(), EdgeFeatureTensor(this->Faces(), generated));
  const torch::Tensor reconstruction = ReconstructionLoss(reconstructed, this->Real);
  const FixtureMatrix expected = ReadMatrix(*this->File, this->Name("ref.g.losses"));
  EXPECT_NEAR(value.item<double>(), expected(0, 0), 1e-5 * expected(0, 0));
  EXPECT_NEAR(reconstruction.item<double>(), expected(1, 0), 1e-5 * expected(1, 0));
  ofGenerator.zero_grad();
  (5.0 * reconstruction - value).backward();
  this->ExpectAll(generator, "g.grad", 1e-3, gradient);
  ofGenerator.step();
  this->ExpectAll(generator, "g.after_step", 1e-3, itself);
}

namespace
{
class MeshFitParity : public testing::Test
{
protected:
  void SetUp() override
  {
    const std::string path = FindFixture("dgts/gt_losses");
    if (path.empty())
    {
      GTEST_SKIP() << "dgts/gt_losses lies neither in Testing/Data/Parity nor in SURFACE_SYNTHESIS_PARITY_DIR";
    }
    this->File = std::make_unique<SafetensorsFile>(path);
    this->Positions = ToTensor(*this->File, "ref.source.vs", torch::kFloat64).requires_grad_();
  }

  FitTables TablesOf(const std::string& mesh) const
  {
    return FitTables(ReadMesh(*this->File, "ref." + mesh + ".vs", mesh + ".faces"), torch::kFloat64);
  }
  SampledSurface Sampled(const std::string& mesh, const torch::Tensor& positions) const
  {
    const torch::Tensor faces = torch::tensor(this->File->Integers("smp." + mesh + ".face"), torch::kInt64);
    return EvaluateSamples(
      this->TablesOf(mesh), positions, { faces, ToTensor(*this->File, "smp." + mesh + ".uvw", torch::kFloat64) });
  }
  void Expect(const torch::Tensor& found, const std::string& name, Eigen::Index row) const
  {
    const double expected = ReadMatrix(*this->File, name)(row, 0);
    EXPECT_NEAR(found.item<double>(), expected, 1e-5 * std::abs(expected)) << name << " " << row;
  }
  void ExpectGradient(const std::string& name) const
  {
    EXPECT_LE(RelativeError(ToMatrix(this->Positions.grad()), ReadMatrix(*this->File, name)), 1e-3) << name;
  }

  std::unique_ptr<SafetensorsFile> File;
  torch::Tensor Positions;
};
} // namespace

TEST_F(MeshFitParity, OfTheTriangulation)
{
  const TriangulationLoss loss = ComputeTriangulationLoss(this->TablesOf("source"), this->Positions);
  this->Expect(loss.EdgeDeviation, "ref.triangulation.terms", 0);
  this->Expect(loss.EdgeEntropy, "ref.triangulation.terms", 1);
  this->Expect(loss.Roughness, "ref.triangulation.terms", 2);
  this->Expect(loss.Total, "ref.triangulation.loss", 0);
  loss.Total.backward();
  this->ExpectGradient("ref.triangulation.grad");
}

TEST_F(MeshFitParity, OfSamplesWithThePublishedNormals)
{
  const SampledSurface source = this->Sampled("source", this->Positions);
  const SampledSurface target = this->Sampled("target", ToTensor(*this->File, "ref.target.vs", torch::kFloat64));
  const torch::Tensor distances = torch::cdist(source.Points.detach(), target.Points);
  const NearestSampleIds nearest{ distances.argmin(1), distances.argmin(0) };
  const ChamferLoss published = ComputeChamferLoss(source, target, nearest, true);
  this->Expect(published.Distance[0], "ref.chamfer.terms", 0);
  this->Expect(published.Distance[1], "ref.chamfer.terms", 1);
  this->Expect(published.Normal[0], "ref.chamfer.terms", 2);
  this->Expect(published.Normal[1], "ref.chamfer.terms", 3);
  this->Expect(published.Total, "ref.chamfer.loss", 0);
  published.Total.backward();
  this->ExpectGradient("ref.chamfer.grad");
  // Normals of the nearest samples agree in both directions.
  const ChamferLoss correct = ComputeChamferLoss(source, target, nearest);
  EXPECT_LT(correct.Normal[0].item<double>(), -0.85);
  EXPECT_EQ(correct.Normal[1].item<double>(), published.Normal[1].item<double>());
}
