// SPDX-License-Identifier: BSD-3-Clause
// PoissonNet against the numbers of the published implementation: `ref.*` of the fixtures, computed there in float64
// from float32 weights and operators. README.md tables the limits.
#include "FixtureTensors.h"
#include "Fixtures.h"

#include "Inference/PoissonNet/PoissonNetEvaluator.h"
#include "Learning/Networks/PoissonNet.h"

#include <gtest/gtest.h>

#include <optional>
#include <ostream>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{

/// A network of the published code with the file of its weights, and the prefix of their names.
struct Fixture
{
  std::string Name;
  std::string Weights;
  std::string Prefix;
};

void PrintTo(const Fixture& fixture, std::ostream* stream) { *stream << fixture.Name; }

const Fixture Fixtures[] = {
  { "crumpling", "poissonnet/crumpling__three_peaks", "" },
  { "random_A", "poissonnet/random_A_ours_w32", "weights." },
  { "random_C", "poissonnet/random_C_norm_nomod", "weights." },
  { "random_D", "poissonnet/random_D_vertices", "weights." },
  { "random_F", "poissonnet/random_F_ours_w128", "weights." },
};

class PoissonNetParity : public testing::TestWithParam<Fixture>
{
protected:
  void SetUp() override
  {
    const std::string path = FindFixture(GetParam().Weights);
    const std::string weights = GetParam().Prefix.empty() ? FindFixture("poissonnet/weights/" + GetParam().Name) : path;
    if (path.empty() || weights.empty())
    {
      GTEST_SKIP() << GetParam().Weights << " lies neither in Testing/Data/Parity nor in SURFACE_SYNTHESIS_PARITY_DIR";
    }
    this->File.emplace(path);
    this->Model = ReadPoissonNet(SafetensorsFile(weights), GetParam().Prefix);
  }

  /// The network's output with these operators in that type.
  PoissonNetOutput Run(const PoissonOperators& operators, torch::ScalarType type, const std::string& suffix = "") const
  {
    PoissonNet network = MakePoissonNet(*this->Model);
    network->eval();
    network->to(type);
    const torch::NoGradGuard noGradients;
    const torch::Tensor extra = this->File->Contains("in.extra" + suffix)
      ? ToTensor(*this->File, "in.extra" + suffix, type)
      : torch::Tensor();
    return network->forward(MeshTensors(operators, type), ToTensor(*this->File, "in.x", type), extra);
  }

  void ExpectAgreement(
    const PoissonNetOutput& output, const std::string& suffix, double limit, double gradientLimit) const
  {
    EXPECT_LE(RelativeError(ToMatrix(output.Values), ReadMatrix(*this->File, "ref.out" + suffix)), limit) << suffix;
    ASSERT_EQ(output.Gradients.defined(), this->File->Contains("ref.grads" + suffix));
    if (output.Gradients.defined())
    {
      EXPECT_LE(RelativeError(ToMatrix(output.Gradients), ReadMatrix(*this->File, "ref.grads" + suffix)), gradientLimit)
        << suffix;
    }
  }

  /// "" and what follows ref.out in the names of further outputs.
  std::vector<std::string> Suffixes() const
  {
    std::vector<std::string> suffixes;
    for (const auto& tensor : this->File->Tensors())
    {
      if (tensor.first.rfind("ref.out", 0) == 0)
      {
        suffixes.push_back(tensor.first.substr(7));
      }
    }
    return suffixes;
  }

  std::optional<SafetensorsFile> File;
  std::optional<PoissonNetModel> Model;
};

INSTANTIATE_TEST_SUITE_P(
  Published, PoissonNetParity, testing::ValuesIn(Fixtures), [](const auto& info) { return info.param.Name; });

} // namespace

// Far below the published limits: what is left comes from the rounding noise of the nearly singular solves.
TEST_P(PoissonNetParity, InDoubleWithStoredOperators)
{
  for (const std::string& suffix : this->Suffixes())
  {
    this->ExpectAgreement(this->Run(ReadOperators(*this->File), torch::kFloat64, suffix), suffix, 1e-8, 1e-6);
  }
}

TEST_P(PoissonNetParity, InSingleWithStoredOperators)
{
  for (const std::string& suffix : this->Suffixes())
  {
    this->ExpectAgreement(this->Run(ReadOperators(*this->File), torch::kFloat32, suffix), suffix, 1e-5, 1e-4);
  }
}

TEST_P(PoissonNetParity, InSingleWithOwnOperators)
{
  for (const std::string& suffix : this->Suffixes())
  {
    this->ExpectAgreement(this->Run(OwnOperators(*this->File), torch::kFloat32, suffix), suffix, 3e-5, 2e-4);
  }
}

// --- The fast path -------------------------------------------------------------------------------------------------

TEST_P(PoissonNetParity, FastPathWithStoredAndOwnOperators)
{
  const auto model = std::make_shared<const PoissonNetModel>(*this->Model);
  for (const bool own : { false, true })
  {
    const PoissonNetEvaluator evaluator(
      model, own ? OwnOperators(*this->File) : ReadOperators(*this->File), ReadMesh(*this->File).Points);
    for (const std::string& suffix : this->Suffixes())
    {
      PoissonNetInput input;
      input.Signal = ReadMatrix(*this->File, "in.x").cast<float>();
      if (this->File->Contains("in.extra" + suffix))
      {
        input.Extra = ReadMatrix(*this->File, "in.extra" + suffix).cast<float>();
      }
      const PoissonNetPrediction prediction = evaluator.Evaluate(input);
      const FixtureMatrix values = prediction.Values.cast<double>();
      EXPECT_LE(RelativeError(values, ReadMatrix(*this->File, "ref.out" + suffix)), own ? 3e-5 : 1e-5) << suffix;
      ASSERT_EQ(prediction.Gradients.size() > 0, this->File->Contains("ref.grads" + suffix));
      if (prediction.Gradients.size() > 0)
      {
        const FixtureMatrix gradients = prediction.Gradients.cast<double>();
        EXPECT_LE(RelativeError(gradients, ReadMatrix(*this->File, "ref.grads" + suffix)), own ? 2e-4 : 1e-4) << suffix;
      }
    }
  }
}

// --- Steps ---------------------------------------------------------------------------------------------------------

TEST_P(PoissonNetParity, BlockOutputs)
{
  const PoissonOperators operators = ReadOperators(*this->File);
  const MeshTensors mesh(operators, torch::kFloat64);
  PoissonNet network = MakePoissonNet(*this->Model);
  network->eval();
  network->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  const auto modules = network->named_modules("", false);
  const auto linear = [&](const std::string& name, const torch::Tensor& x) {
    return modules[name]->as<torch::nn::Linear>()->forward(x);
  };

  torch::Tensor x = linear("proj_in", ToTensor(*this->File, "in.x", torch::kFloat64));
  EXPECT_LE(RelativeError(ToMatrix(x), ReadMatrix(*this->File, "ref.proj_in.out")), 1e-6);
  torch::Tensor extra;
  if (this->File->Contains("in.extra"))
  {
    extra = modules["extra_feat_mlp"]->as<torch::nn::Sequential>()->forward(
      ToTensor(*this->File, "in.extra", torch::kFloat64));
    const FixtureMatrix expected = ReadMatrix(*this->File, "ref.extra_feat_mlp.out");
    EXPECT_LE(
      RelativeError(ToMatrix(extra), Eigen::Map<const FixtureMatrix>(expected.data(), extra.size(0), extra.size(1))),
      1e-6);
    extra = extra.expand_as(x);
  }
  for (std::int64_t block = 0; block < this->Model->Options.Blocks; ++block)
  {
    x = modules["blocks." + std::to_string(block)]->as<PoissonBlock>()->forward(mesh, x, extra);
    const std::string name = "ref.block" + std::to_string(block) + ".out";
    EXPECT_LE(RelativeError(ToMatrix(x), ReadMatrix(*this->File, name)), block < 2 ? 5e-6 : 1e-4) << name;
  }
}

// Every step of the first block but the inner products, whose effect is in the block's output.
using PoissonNetSteps = PoissonNetParity;
INSTANTIATE_TEST_SUITE_P(Published, PoissonNetSteps, testing::Values(Fixtures[1], Fixtures[2], Fixtures[3]),
  [](const auto& info) { return info.param.Name; });

TEST_P(PoissonNetSteps, OfTheFirstBlock)
{
  const MeshTensors mesh(ReadOperators(*this->File), torch::kFloat64);
  PoissonNet network = MakePoissonNet(*this->Model);
  network->to(torch::kFloat64);
  const torch::NoGradGuard noGradients;
  const auto expect = [&](const torch::Tensor& found, const std::string& name) {
    EXPECT_LE(RelativeError(ToMatrix(found), ReadMatrix(*this->File, "ref.block0." + name)), 1e-6) << name;
  };

  const torch::Tensor x = network->named_modules("", false)["proj_in"]->as<torch::nn::Linear>()->forward(
    ToTensor(*this->File, "in.x", torch::kFloat64));
  const torch::Tensor onFaces = FaceMean(mesh, x);
  const ComplexTensor gradient = FaceGradient(mesh, x);
  expect(onFaces, "x_face");
  expect(Interleaved(gradient), "grads_in");
  const auto mlp = network->named_modules("", false)["blocks.0.grad_mlp"]->as<ComplexMlp>();
  if (this->Model->Options.Modulate)
  {
    const ComplexTensor modulated = mlp->Modulated(gradient, onFaces);
    expect(modulated.Real, "mod_re");
    expect(modulated.Imaginary, "mod_im");
  }
  const ComplexTensor features = mlp->forward(gradient, onFaces);
  expect(Interleaved(features), "grads");
  const torch::Tensor rightHandSide = IntegratedDivergence(mesh, features);
  expect(rightHandSide, "rhs");
  const torch::Tensor solution = SolvePoisson(mesh, rightHandSide);
  expect(WithoutMean(mesh, solution), "u");
}
