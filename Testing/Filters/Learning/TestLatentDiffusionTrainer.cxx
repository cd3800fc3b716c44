// SPDX-License-Identifier: BSD-3-Clause
// Training of the diffusion of field latents: losses and their weights, exact resumption, averages, and what is refused.
#include "SmallLatents.h"
#include "TrainingData.h"

#include "Core/Common/Errors.h"
#include "Inference/FieldLatents/LatentDiffusionSampler.h"
#include "Learning/Losses/LatentDiffusionLosses.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/LatentDiffusionTrainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
LatentDiffusionTrainingOptions TinyDiffusionTraining(std::int64_t iterations)
{
  LatentDiffusionTrainingOptions options;
  options.Network.Channels = 6;
  options.Network.CoarseChannels = 8;
  options.Network.CoarseBlocks = 1;
  options.Network.OutputBlocks = 1;
  options.Network.EmbeddingDimension = 8;
  options.BatchSize = 2;
  options.Iterations = iterations;
  options.Device = TrainingDevice::CPU;
  return options;
}

LatentDiffusionTrainer TrainedDiffusion(const LatentDiffusionTrainingOptions& options, std::int64_t iterations)
{
  LatentDiffusionTrainer trainer(SmallLatents(), options);
  for (std::int64_t k = 0; k < iterations; ++k)
  {
    trainer.Step();
  }
  return trainer;
}

std::map<std::string, std::vector<float>> WeightsOf(const LatentDiffusionTrainer& trainer)
{
  std::map<std::string, std::vector<float>> weights;
  for (const auto& [name, tensor] : trainer.Model().Tensors)
  {
    weights[name] = tensor.Values;
  }
  return weights;
}

double MeanOf(const LossHistory& history, const std::string& column, std::size_t first, std::size_t count)
{
  const std::vector<double> values = history.Column(column);
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
  return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(count), 0.0) / static_cast<double>(count);
}

constexpr DiffusionTarget AllTargets[] = { DiffusionTarget::Noise, DiffusionTarget::Data, DiffusionTarget::Velocity };
} // namespace

TEST(LatentDiffusionLosses, ErrorsOfAllTargetsMeanTheSameErrorOfTheNoise)
{
  const double alpha = 0.3;
  const torch::Tensor data = torch::tensor({ 0.5, -1.0, 2.0 }, torch::kFloat64);
  const torch::Tensor noise = torch::tensor({ 1.0, 0.25, -0.5 }, torch::kFloat64);
  const torch::Tensor state = std::sqrt(alpha) * data + std::sqrt(1.0 - alpha) * noise;
  // Another noise with the data that the same state then means.
  const torch::Tensor otherNoise = noise + 0.1;
  const torch::Tensor otherData = (state - std::sqrt(1.0 - alpha) * otherNoise) / std::sqrt(alpha);
  for (const DiffusionTarget target : AllTargets)
  {
    const torch::Tensor error = DenoisingTarget(target, alpha, otherData, otherNoise) -
      DenoisingTarget(target, alpha, data, noise);
    EXPECT_NEAR(NoiseErrorFactor(target, alpha) * error.square().mean().item<double>(), 0.01, 1e-12);
    // Weights: of the squared error of the data, at most the limit.
    const double dataError = (otherData - data).square().mean().item<double>();
    for (const double limit : { 0.2, 5.0 })
    {
      EXPECT_NEAR(DenoisingWeight(target, alpha, limit) * error.square().mean().item<double>(),
        std::min(limit, alpha / (1.0 - alpha)) * dataError, 1e-12);
    }
    EXPECT_EQ(DenoisingWeight(target, alpha, 0.0), 1.0);
  }
}

TEST(LatentDiffusionTrainer, TheCallAfterWritingSeesEachModelAndMayAskWhetherToGoOn)
{
  TrainingFiles files;
  files.Model = "along.model";
  files.Checkpoint = "along.checkpoint";
  files.Resume = false;
  files.CheckpointInterval = 2;
  std::vector<std::int64_t> written;
  bool goesOn = true;
  files.AfterWriting = [&](const std::function<bool()>& goOn) {
    written.push_back(ReadLatentDiffusion(files.Model).Iterations);
    goesOn = goesOn && goOn();
  };
  TrainLatentDiffusion(SmallLatents(), TinyDiffusionTraining(5), files);
  EXPECT_THAT(written, testing::ElementsAre(2, 4, 5));
  EXPECT_TRUE(goesOn);
  written.clear();
  std::int64_t calls = 0;
  TrainingFiles stopped = files;
  stopped.AfterWriting = [&](const std::function<bool()>& goOn) { goesOn = goOn(); };
  const Progress untilTheCall = [&](double) { return ++calls < 3; };
  EXPECT_THROW(TrainLatentDiffusion(SmallLatents(), TinyDiffusionTraining(5), stopped, {}, untilTheCall), Cancelled);
  EXPECT_FALSE(goesOn);
}

TEST(LatentDiffusionTrainer, MuonLearnsFromTheSmallRateOfItsFirstIterationsOn)
{
  LatentDiffusionTrainingOptions options = TinyDiffusionTraining(200);
  options.Network.Channels = 16; // Muon leaves smaller matrices to Adam
  options.Network.Target = DiffusionTarget::Velocity;
  options.Optimizer = TrainingOptimizer::Muon;
  options.LearningRate = 1e-2;
  const LatentDiffusionTrainer trainer = TrainedDiffusion(options, 200);
  const LossHistory& history = trainer.History();
  EXPECT_LT(MeanOf(history, "loss", 170, 30), 0.85 * MeanOf(history, "loss", 0, 10));
  EXPECT_NEAR(history.Value(0, "learning_rate"), 0.5e-2, 1e-6) << "half of the first hundredth";
  EXPECT_NEAR(history.Value(100, "learning_rate"), 0.5 * (1e-2 + 1e-5), 1e-6);
}

TEST(LatentDiffusionTrainer, LossesFallForEachTarget)
{
  for (const DiffusionTarget target : AllTargets)
  {
    LatentDiffusionTrainingOptions options = TinyDiffusionTraining(150);
    options.Network.Target = target;
    options.LearningRate = 1e-2;
    const LatentDiffusionTrainer trainer = TrainedDiffusion(options, 150);
    const LossHistory& history = trainer.History();
    ASSERT_EQ(history.Size(), 150U);
    // The first prediction is 0: the mean square of the target, which is near 1.
    EXPECT_NEAR(history.Value(0, "loss"), 1.0, 0.4) << NameOf(target);
    EXPECT_LT(MeanOf(history, "loss", 120, 30), 0.85 * MeanOf(history, "loss", 0, 10)) << NameOf(target);
    EXPECT_EQ(history.Value(0, "learning_rate"), 1e-2);
    EXPECT_NEAR(history.Value(75, "learning_rate"), 0.5 * (1e-2 + 1e-5), 1e-6);
    for (int bin = 1; bin <= LatentDiffusionTrainer::NumberOfTimeBins; ++bin)
    {
      EXPECT_GT(history.Value(149, "noise_loss_" + std::to_string(bin)), 0.0) << bin;
    }
  }
}

TEST(LatentDiffusionTrainer, SizesAreThoseOfTheDatasetAndScalesThoseOfTheLatents)
{
  LatentDiffusionTrainingOptions options = TinyDiffusionTraining(2);
  options.SampleLatents = false;
  const LatentDiffusionModel model = TrainedDiffusion(options, 1).Model();
  CheckModel(model);
  EXPECT_EQ(model.Options.LatentDimension, 2);
  EXPECT_EQ(model.Options.NumberOfLabels, 3);
  EXPECT_TRUE(model.Options.Directed);
  LatentDataset dataset = SmallLatents();
  FieldLatentMatrix both(dataset.Surfaces[0].Means.rows() + dataset.Surfaces[1].Means.rows(), 4);
  both << dataset.Surfaces[0].Means, dataset.Surfaces[1].Means;
  const std::vector<float> scale = LatentScale(both);
  EXPECT_NEAR(model.Tensors.at("latent_scale").Values[0], scale[0], 1e-5F);
  EXPECT_NEAR(model.Tensors.at("latent_scale").Values[1], scale[1], 1e-5F);
  EXPECT_NEAR(scale[0], std::sqrt(std::acos(-1.0) / 2.0), 1e-5);

  for (LatentSurface& surface : dataset.Surfaces)
  {
    surface.Labels.assign(surface.Labels.size(), -1);
    surface.Directions.resize(0, 0);
  }
  LatentDiffusionTrainer plain(dataset, options);
  plain.Step();
  EXPECT_EQ(plain.Options().Network.NumberOfLabels, 0);
  EXPECT_FALSE(plain.Model().Options.Directed);
}

TEST(LatentDiffusionTrainer, ModelsHoldTheAverageOfTheWeights)
{
  LatentDiffusionTrainingOptions options = TinyDiffusionTraining(3);
  options.WeightAveraging = 0.0;
  std::vector<std::vector<float>> weights = { InitialLatentDiffusion(
    TrainedDiffusion(options, 0).Options().Network, options.Seed)
                                                .Tensors.at("output.weight")
                                                .Values };
  for (int k = 1; k <= 2; ++k)
  {
    weights.push_back(WeightsOf(TrainedDiffusion(options, k)).at("output.weight"));
  }
  options.WeightAveraging = 0.15;
  const std::vector<float> average = WeightsOf(TrainedDiffusion(options, 2)).at("output.weight");
  for (std::size_t k = 0; k < average.size(); ++k)
  {
    // Iterations 0 and 1: the parts kept are min(0.15, 1 / 10) and min(0.15, 2 / 11).
    const float first = 0.1F * weights[0][k] + 0.9F * weights[1][k];
    EXPECT_NEAR(average[k], 0.15F * first + 0.85F * weights[2][k], 1e-6F);
  }
}

TEST(LatentDiffusionTrainer, ResumingGivesTheBitsOfAnUninterruptedTraining)
{
  LatentDiffusionTrainingOptions options = TinyDiffusionTraining(7);
  for (const TrainingOptimizer optimizer : { TrainingOptimizer::Muon, TrainingOptimizer::Adam })
  {
    options.Optimizer = optimizer;
    options.Network.Channels = optimizer == TrainingOptimizer::Muon ? 16 : 6; // Muon leaves smaller matrices to Adam
    const LatentDiffusionTrainer whole = TrainedDiffusion(options, 7);
    TrainedDiffusion(options, 3).SaveCheckpoint("diffusion.checkpoint");
    LatentDiffusionTrainer resumed(SmallLatents(), options);
    resumed.LoadCheckpoint("diffusion.checkpoint");
    EXPECT_EQ(resumed.Iteration(), 3);
    for (int k = 3; k < 7; ++k)
    {
      resumed.Step();
    }
    EXPECT_EQ(WeightsOf(resumed), WeightsOf(whole)) << static_cast<int>(optimizer);
    EXPECT_TRUE(resumed.History() == whole.History());
  }
}

TEST(LatentDiffusionTrainer, CheckpointsOfAnotherDatasetOrRecipeAreRefused)
{
  const LatentDiffusionTrainingOptions options = TinyDiffusionTraining(7);
  TrainedDiffusion(options, 1).SaveCheckpoint("diffusion.checkpoint");
  LatentDiffusionTrainingOptions other = options;
  other.SnrLimit = 5.0;
  EXPECT_THAT(TextOf<ModelMismatch>(
                [&] { LatentDiffusionTrainer(SmallLatents(), other).LoadCheckpoint("diffusion.checkpoint"); }),
    HasSubstr("snr_limit = 0; expected 5"));
  other = options;
  other.Optimizer = TrainingOptimizer::Muon;
  EXPECT_THAT(TextOf<ModelMismatch>(
                [&] { LatentDiffusionTrainer(SmallLatents(), other).LoadCheckpoint("diffusion.checkpoint"); }),
    HasSubstr("optimizer"));
  LatentDataset dataset = SmallLatents();
  dataset.Surfaces[0].Means(0, 0) += 1.0F;
  EXPECT_THAT(
    TextOf<ModelMismatch>([&] { LatentDiffusionTrainer(dataset, options).LoadCheckpoint("diffusion.checkpoint"); }),
    HasSubstr("dataset = "));
  std::remove("diffusion.checkpoint");
}

TEST(LatentDiffusionTrainer, ACancelledTrainingGoesOnAndItsModelSamples)
{
  TrainingFiles files;
  files.Model = "diffusion.safetensors";
  files.Checkpoint = "diffusion.checkpoint";
  files.LossTable = "diffusion.csv";
  std::remove(files.Checkpoint.c_str());
  const LatentDiffusionTrainingOptions options = TinyDiffusionTraining(5);
  const std::string text = TextOf<Cancelled>([&] {
    TrainLatentDiffusion(SmallLatents(), options, files, [](const LossHistory& history) { return history.Size() < 2; });
  });
  EXPECT_THAT(text, HasSubstr("stopped after iteration 2"));
  const LatentDiffusionTrainer trainer = TrainLatentDiffusion(SmallLatents(), options, files);
  EXPECT_EQ(WeightsOf(trainer), WeightsOf(TrainedDiffusion(options, 5)));
  EXPECT_THAT(BytesOf(files.LossTable), HasSubstr("iteration,loss,gradient_norm,learning_rate,noise_loss_1,"));
  const LatentDiffusionModel model = ReadLatentDiffusion(files.Model);
  EXPECT_EQ(model.Iterations, 5);
  LatentSampleRequest request;
  request.NumberOfSteps = 4;
  const OneRings rings(IrregularSphere(1));
  EXPECT_TRUE(LatentDiffusionSampler(model, rings).Sample(request).allFinite());
  for (const std::string& file : { files.Model, files.Checkpoint, files.LossTable })
  {
    std::remove(file.c_str());
  }
}

TEST(LatentDiffusionTrainer, OptionsAndDatasetsThatDoNotFitAreNamed)
{
  using Options = LatentDiffusionTrainingOptions;
  const auto refusal = [](const std::function<void(Options&)>& change) {
    Options options = TinyDiffusionTraining(3);
    change(options);
    return TextOf<InvalidInput>([&] { LatentDiffusionTrainer(SmallLatents(), options); });
  };
  EXPECT_THAT(refusal([](Options& o) { o.Iterations = 0; }), HasSubstr("Iterations is 0"));
  EXPECT_THAT(refusal([](Options& o) { o.BatchSize = 0; }), HasSubstr("BatchSize is 0"));
  EXPECT_THAT(refusal([](Options& o) { o.FinalLearningRate = 0.0; }), HasSubstr("FinalLearningRate is 0"));
  EXPECT_THAT(refusal([](Options& o) { o.WeightAveraging = 1.0; }), HasSubstr("WeightAveraging is 1"));
  EXPECT_THAT(refusal([](Options& o) { o.SnrLimit = -1.0; }), HasSubstr("SnrLimit is -1"));
  EXPECT_THAT(refusal([](Options& o) { o.ConditionDropout = 1.5; }), HasSubstr("ConditionDropout is 1.5"));
  EXPECT_THAT(refusal([](Options& o) { o.Network.EmbeddingDimension = 7; }), HasSubstr("expected an even number"));
  EXPECT_THAT(TextOf<InvalidInput>([&] { LatentDiffusionTrainer({}, TinyDiffusionTraining(3)); }),
    HasSubstr("the dataset has no surface"));
  LatentDataset dataset = SmallLatents();
  dataset.Surfaces[1].Mesh.Triangles.row(3).reverseInPlace();
  EXPECT_THAT(TextOf<InvalidInput>([&] { LatentDiffusionTrainer(dataset, TinyDiffusionTraining(3)); }),
    HasSubstr("LatentDiffusionTrainer: surface 1: "));
}

TEST(LatentDiffusionTrainer, ARateThatIsTooHighIsNamed)
{
  LatentDiffusionTrainingOptions options = TinyDiffusionTraining(20);
  options.LearningRate = 1e30;
  EXPECT_THAT(TextOf<SolverFailure>([&] { TrainedDiffusion(options, 20); }), HasSubstr("lower learning rate"));
}
