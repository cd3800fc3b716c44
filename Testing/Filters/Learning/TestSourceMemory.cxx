// SPDX-License-Identifier: BSD-3-Clause
//
// Trainings on many sources under a limit of memory: the same bits, and no more bytes than the limit.
#include "TrainingData.h"

#include "RandomPoissonNet.h"

#include "Learning/Training/FlowMatchingTrainer.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
constexpr double MiB = 1048576.0;

/// Sources of one shape on two triangulations, with different samples.
SignalDataset FourSpheres()
{
  SignalDataset dataset = DeformedSpheres(2, 2);
  for (int k = 1; k < 4; ++k)
  {
    SignalSource source = DeformedSpheres(2 + k, k == 3 ? 1 : 2).Sources[0];
    source.Samples *= 1.0F + 0.1F * static_cast<float>(k);
    dataset.Sources.push_back(source);
  }
  return dataset;
}

/// The same with a shape for each source.
SignalDataset FourEllipsoids()
{
  SignalDataset dataset = FourSpheres();
  for (std::size_t k = 0; k < dataset.Sources.size(); ++k)
  {
    dataset.Sources[k].Mesh.Points.col(1) *= 1.0 + 0.2 * static_cast<double>(k);
  }
  return dataset;
}

/// Two sources in each of ten iterations, and a loss that is measured on all of them first.
FlowMatchingTrainingOptions TenIterations()
{
  FlowMatchingTrainingOptions options = TinyRecipe(10);
  options.Prediction = FlowPrediction::Data;
  options.BatchSize = 4;
  options.SourcesPerBatch = 2;
  return options;
}

void ExpectSameTraining(const FlowMatchingTrainer& found, const FlowMatchingTrainer& expected)
{
  EXPECT_EQ(Weights(found), Weights(expected));
  EXPECT_TRUE(found.History() == expected.History());
  EXPECT_EQ(found.Model().Noise.Scale, expected.Model().Noise.Scale);
}
} // namespace

TEST_F(FlowMatchingTraining, EveryLimitOfSourceMemoryGivesTheSameBits)
{
  FlowMatchingTrainingOptions withEncoder = TenIterations();
  withEncoder.Encoder = RandomModel(TwoChannelEncoder());
  FlowMatchingTrainingOptions smooth = TenIterations();
  smooth.Noise.Model = NoiseModel::Spectral;
  smooth.Noise.Eigenpairs = 10;
  smooth.Noise.Smoothing = 0.5;
  const std::pair<SignalDataset, FlowMatchingTrainingOptions> cases[] = { { FourSpheres(), TenIterations() },
    { FourEllipsoids(), withEncoder }, { FourSpheres(), smooth } };
  for (const auto& [dataset, options] : cases)
  {
    const FlowMatchingTrainer resident = Trained(dataset, options, 10);
    EXPECT_EQ(resident.SourceMemory().Builds, 0);
    EXPECT_EQ(resident.SourceMemory().Peak, resident.SourceMemory().Bytes);
    const double all = static_cast<double>(resident.SourceMemory().Bytes);
    for (const double share : { 0.0, 0.35, 0.7 }) // for the one in use, one, two of the three large ones
    {
      FlowMatchingTrainingOptions limited = options;
      limited.SourceMemory = share * all / MiB;
      const FlowMatchingTrainer trainer = Trained(dataset, limited, 10);
      ExpectSameTraining(trainer, resident);
      const SourceMemoryUse& use = trainer.SourceMemory();
      EXPECT_GT(use.Builds, 0) << share;
      EXPECT_LE(use.Builds, 4 + 2 * 10) << "at most one for each source of a batch and of the first measurement";
      EXPECT_GT(use.BuildSeconds, 0.0);
      if (share > 0.0)
      {
        EXPECT_LE(static_cast<double>(use.Peak), share * all) << share;
      }
      else
      {
        EXPECT_LT(static_cast<double>(use.Peak), 0.35 * all) << "one source";
      }
    }
  }
}

TEST_F(FlowMatchingTraining, FewerSourcesAreBuiltWhereMoreAreKept)
{
  const SignalDataset dataset = FourSpheres();
  FlowMatchingTrainingOptions options = TenIterations();
  const double all = static_cast<double>(FlowMatchingTrainer(dataset, options).SourceMemory().Bytes) / MiB;
  std::vector<std::int64_t> builds;
  for (const double share : { 0.0, 0.7, 1.0 })
  {
    options.SourceMemory = share * all;
    builds.push_back(Trained(dataset, options, 10).SourceMemory().Builds);
  }
  EXPECT_GT(builds[0], builds[1]);
  EXPECT_GT(builds[1], 0);
  EXPECT_EQ(builds[2], 0) << "what fits exactly is kept";
}

TEST_F(FlowMatchingTraining, TheLimitOfSourceMemoryMayChangeWhenATrainingGoesOn)
{
  const SignalDataset dataset = FourSpheres();
  FlowMatchingTrainingOptions options = TenIterations();
  const FlowMatchingTrainer whole = Trained(dataset, options, 10);
  options.SourceMemory = 0.0;
  Trained(dataset, options, 4).SaveCheckpoint(this->File("checkpoint"));
  for (const double limit : { 0.0, 0.5 * static_cast<double>(whole.SourceMemory().Bytes) / MiB, 8192.0 })
  {
    options.SourceMemory = limit;
    FlowMatchingTrainer resumed(dataset, options);
    resumed.LoadCheckpoint(this->File("checkpoint"));
    ASSERT_EQ(resumed.Iteration(), 4);
    while (resumed.Iteration() < 10)
    {
      resumed.Step();
    }
    ExpectSameTraining(resumed, whole);
  }
}

TEST_F(FlowMatchingTraining, SourceMemoryCountsEachFactorisation)
{
  const SignalDataset dataset = DeformedSpheres(2, 2);
  const auto bytes = [&](const FlowNoise& noise) {
    FlowMatchingTrainingOptions options = TinyRecipe(1);
    options.Noise = noise;
    return static_cast<double>(FlowMatchingTrainer(dataset, options).SourceMemory().Bytes);
  };
  FlowNoise noise = { NoiseModel::White, 100.0, 256, 1.0, 0.0 };
  const double plain = bytes(noise);
  noise.Smoothing = 1.0;
  const double smoothed = bytes(noise);
  noise.Model = NoiseModel::Matern;
  const double both = bytes(noise);
  const double vertices = static_cast<double>(dataset.Sources[0].Mesh.NumberOfPoints());
  EXPECT_GT(smoothed - plain, 8.0 * 7.0 * vertices) << "at least the lower triangle of the matrix";
  EXPECT_EQ(both - smoothed, smoothed - plain) << "of the same pattern";
  noise = { NoiseModel::Spectral, 100.0, 20, 1.0, 0.0 };
  EXPECT_EQ(bytes(noise) - plain, 8.0 * 20.0 * vertices);
}
