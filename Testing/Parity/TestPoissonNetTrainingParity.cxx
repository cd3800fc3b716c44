// SPDX-License-Identifier: BSD-3-Clause
// Training steps of PoissonNet against the published implementation: losses, gradients, and parameters after three
// steps of Adam (learning rate 5e-4), all in float64.
#include "FixtureTensors.h"
#include "Fixtures.h"

#include "Learning/Networks/PoissonNet.h"

#include <gtest/gtest.h>

#include <functional>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{

torch::Tensor Centered(const torch::Tensor& positions) { return positions - positions.mean(-2, true); }

/// sum of mass * difference^2 / (sum of mass * channels)
torch::Tensor MassWeightedError(const torch::Tensor& a, const torch::Tensor& b, const torch::Tensor& mass)
{
  return ((a - b).square() * mass).sum() / (mass.sum() * static_cast<double>(a.size(-1)));
}

/// One training case of a fixture: the names of its tensors begin with train.<Name>.
struct TrainingCase
{
  std::string Fixture;
  std::string Name;
};

void PrintTo(const TrainingCase& training, std::ostream* stream) { *stream << training.Name; }

class PoissonNetTraining : public testing::TestWithParam<TrainingCase>
{
protected:
  void SetUp() override
  {
    const std::string path = FindFixture(GetParam().Fixture);
    if (path.empty())
    {
      GTEST_SKIP() << GetParam().Fixture << " lies neither in Testing/Data/Parity nor in SURFACE_SYNTHESIS_PARITY_DIR";
    }
    this->File = std::make_unique<SafetensorsFile>(path);
    this->Mesh = MeshTensors(ReadOperators(*this->File), torch::kFloat64);
    this->Network = MakePoissonNet(ReadPoissonNet(*this->File, "weights."));
    this->Network->to(torch::kFloat64);
  }

  /// The terms of the loss; the first is the loss.
  std::vector<torch::Tensor> Losses()
  {
    const torch::Tensor x = ToTensor(*this->File, "in.x", torch::kFloat64);
    const torch::Tensor extra = this->File->Contains("in.extra") ? ToTensor(*this->File, "in.extra", torch::kFloat64)
                                                                 : torch::Tensor();
    const PoissonNetOutput output = this->Network->forward(this->Mesh, x, extra);
    if (GetParam().Name == "nll")
    {
      const std::vector<std::int64_t> labels = this->File->Integers("train.labels");
      const torch::Tensor target = torch::tensor(labels, torch::kInt64);
      return { torch::nll_loss(output.Values, target) };
    }
    const torch::Tensor target = Centered(ToTensor(*this->File, "train.target", torch::kFloat64));
    const torch::Tensor positions = Centered(output.Values);
    const torch::Tensor gradients = Interleaved(FaceGradient(this->Mesh, target));
    if (GetParam().Name == "plain")
    {
      const torch::Tensor atVertices = torch::mse_loss(positions, target);
      const torch::Tensor onFaces = torch::mse_loss(output.Gradients, gradients);
      return { 10.0 * atVertices + onFaces, atVertices, onFaces };
    }
    const torch::Tensor areas = this->Mesh.FaceAreas.repeat_interleave(2, 0);
    const torch::Tensor atVertices = MassWeightedError(positions, target, this->Mesh.VertexMass);
    const torch::Tensor onFaces = MassWeightedError(output.Gradients, gradients, areas);
    return { atVertices + onFaces, atVertices, onFaces };
  }

  /// Every parameter against train.<name>.<what>.<parameter>.
  void ExpectAll(const std::string& what, double limit, const std::function<torch::Tensor(const torch::Tensor&)>& value)
  {
    double difference = 0.0;
    double norm = 0.0;
    for (const auto& parameter : this->Network->named_parameters())
    {
      const FixtureMatrix expected = ReadMatrix(
        *this->File, "train." + GetParam().Name + "." + what + "." + parameter.key());
      const FixtureMatrix found = ToMatrix(value(parameter.value()));
      ASSERT_EQ(found.size(), expected.size());
      difference += (found - expected).squaredNorm();
      norm += expected.squaredNorm();
      // Adam divides by the root of squared gradients, so that tiny gradients count as much as large ones.
      EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-3 * expected.cwiseAbs().maxCoeff() + 1e-9)
        << what << " of " << parameter.key();
    }
    EXPECT_LE(std::sqrt(difference / norm), limit) << what;
  }

  std::unique_ptr<SafetensorsFile> File;
  MeshTensors Mesh;
  PoissonNet Network{ nullptr };
};

INSTANTIATE_TEST_SUITE_P(Published, PoissonNetTraining,
  testing::Values(TrainingCase{ "poissonnet/random_A_ours_w32", "mass" },
    TrainingCase{ "poissonnet/random_A_ours_w32", "plain" }, TrainingCase{ "poissonnet/random_C_norm_nomod", "nll" }),
  [](const auto& info) { return info.param.Name; });

} // namespace

TEST_P(PoissonNetTraining, LossesGradientsAndThreeSteps)
{
  torch::optim::Adam optimizer(this->Network->parameters(), torch::optim::AdamOptions(5e-4));
  const FixtureMatrix losses = ReadMatrix(*this->File, "train." + GetParam().Name + ".losses");
  ASSERT_EQ(losses.rows(), 3);
  for (int step = 0; step < 3; ++step)
  {
    optimizer.zero_grad();
    const std::vector<torch::Tensor> terms = this->Losses();
    ASSERT_EQ(static_cast<Eigen::Index>(terms.size()), losses.cols());
    for (std::size_t k = 0; k < terms.size(); ++k)
    {
      EXPECT_NEAR(terms[k].item<double>(), losses(step, k), 1e-6 * losses(step, k)) << "step " << step << " term " << k;
    }
    terms[0].backward();
    if (step == 0)
    {
      this->ExpectAll("grad", 1e-6, [](const torch::Tensor& parameter) { return parameter.grad(); });
    }
    if (GetParam().Name == "nll")
    {
      const double norm = torch::nn::utils::clip_grad_norm_(this->Network->parameters(), 0.05);
      const double expected = ReadMatrix(*this->File, "train.nll.grad_norm")(0, 0);
      EXPECT_TRUE(step > 0 || std::abs(norm - expected) <= 1e-6 * expected) << norm << " " << expected;
    }
    optimizer.step();
  }
  this->ExpectAll("after3", 1e-6, [](const torch::Tensor& parameter) { return parameter; });
}
