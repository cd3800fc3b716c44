// SPDX-License-Identifier: BSD-3-Clause
// Training of geometric textures: seeds, checkpoints, files, and what is refused.
#include "ExampleMeshes.h"
#include "TrainingData.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{

/// A bumpy sphere of 20 triangles and its subdivisions, with the smooth one as template.
MultiscaleDataset Bumps(int levels)
{
  MultiscaleDataset dataset;
  dataset.Template = Icosphere(0, 3.0);
  TriangleMesh mesh = dataset.Template;
  for (int level = 0; level < levels; ++level)
  {
    if (level > 0)
    {
      mesh = SubdivideAtMidpoints(mesh).Mesh;
    }
    TriangleMesh bumpy = mesh;
    for (Eigen::Index v = 0; v < bumpy.Points.rows(); ++v)
    {
      const double height = 1.0 + 0.2 * std::sin(3.0 * bumpy.Points(v, 0)) * std::cos(2.0 * bumpy.Points(v, 1) + 1.0);
      bumpy.Points.row(v) *= 3.0 * height / bumpy.Points.row(v).norm();
    }
    dataset.Levels.push_back(bumpy);
  }
  return dataset;
}

GeometricTextureTrainingOptions TinyGeometricTexture()
{
  GeometricTextureTrainingOptions options;
  options.Objective = TextureObjective::Adversarial;
  options.Network.Layers = 4;
  options.Network.StartChannels = 4;
  options.Network.MinimumChannels = 4;
  options.Network.MaximumChannels = 4;
  options.IterationsPerLevel = 3;
  options.LearningRateInterval = 2;
  options.Device = TrainingDevice::CPU;
  return options;
}

std::map<std::string, std::vector<float>> WeightsOf(const GeometricTextureTrainer& trainer)
{
  const GeometricTextureModel model = trainer.Model();
  std::map<std::string, std::vector<float>> weights;
  for (const auto& [name, tensor] : model.Generator)
  {
    weights["generator." + name] = tensor.Values;
  }
  for (const auto& [name, tensor] : model.Discriminator)
  {
    weights["discriminator." + name] = tensor.Values;
  }
  return weights;
}

GeometricTextureTrainer Trained(const GeometricTextureTrainingOptions& options, int levels, int iterations)
{
  GeometricTextureTrainer trainer(Bumps(levels), options);
  for (int k = 0; k < iterations; ++k)
  {
    trainer.Step();
  }
  return trainer;
}

/// Two references: the bumpy sphere, and a bumpy torus.
std::vector<MultiscaleDataset> SphereAndTorus()
{
  std::vector<MultiscaleDataset> references = { Bumps(2), {} };
  TriangleMesh mesh = Torus(9, 6);
  for (int level = 0; level < 2; ++level)
  {
    mesh = level == 0 ? mesh : SubdivideAtMidpoints(mesh).Mesh;
    TriangleMesh bumpy = mesh;
    for (Eigen::Index v = 0; v < bumpy.Points.rows(); ++v)
    {
      bumpy.Points.row(v) *= 1.0 + 0.1 * std::sin(7.0 * bumpy.Points(v, 0) + 5.0 * bumpy.Points(v, 2));
    }
    references[1].Levels.push_back(bumpy);
  }
  return references;
}

/// After a number of steps.
GeometricTextureTrainer Stepped(GeometricTextureTrainer trainer, std::int64_t iterations)
{
  for (std::int64_t k = 0; k < iterations; ++k)
  {
    trainer.Step();
  }
  return trainer;
}

/// Checks that a training from @p references goes on from checkpoints before, within, between and after levels.
void ExpectExactResumption(const std::vector<MultiscaleDataset>& references,
  const GeometricTextureTrainingOptions& options, const std::string& checkpoint)
{
  GeometricTextureTrainer whole(references, options);
  while (whole.Iteration() < whole.Iterations())
  {
    whole.SaveCheckpoint(checkpoint + std::to_string(whole.Iteration()));
    whole.Step();
  }
  for (std::int64_t done = 0; done < whole.Iterations(); ++done)
  {
    GeometricTextureTrainer resumed = Stepped({ references, options }, 2);
    resumed.LoadCheckpoint(checkpoint + std::to_string(done));
    resumed = Stepped(std::move(resumed), whole.Iterations() - done);
    EXPECT_EQ(WeightsOf(resumed), WeightsOf(whole)) << done;
    EXPECT_TRUE(resumed.History() == whole.History()) << done;
  }
}

class GeometricTextureTraining : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder = std::filesystem::path("GeometricTextureTraining") /
      ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(this->Folder);
    std::filesystem::create_directories(this->Folder);
  }
  TrainingFiles Files() const
  {
    TrainingFiles files;
    files.Model = this->File("model.safetensors");
    files.Checkpoint = this->File("checkpoint");
    files.LossTable = this->File("losses.csv");
    files.CheckpointInterval = 100;
    return files;
  }
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }

  std::filesystem::path Folder;
};

} // namespace

TEST_F(GeometricTextureTraining, TheSameSeedGivesTheSameWeightsAndAnotherOneOthers)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  const auto first = WeightsOf(Trained(options, 2, 4));
  EXPECT_EQ(WeightsOf(Trained(options, 2, 4)), first);
  options.Seed = 1;
  EXPECT_NE(WeightsOf(Trained(options, 2, 4)), first);
}

TEST_F(GeometricTextureTraining, GoesOnFromAnyCheckpointAsIfItHadNotStopped)
{
  const GeometricTextureTrainingOptions options = TinyGeometricTexture();
  const GeometricTextureTrainer whole = Trained(options, 2, 6);
  for (const int done : { 0, 1, 3, 4, 6 }) // before, within and between levels
  {
    Trained(options, 2, done).SaveCheckpoint(this->File("checkpoint"));
    GeometricTextureTrainer resumed = Trained(options, 2, 5); // whose state is replaced
    resumed.LoadCheckpoint(this->File("checkpoint"));
    EXPECT_EQ(resumed.Iteration(), done);
    while (resumed.Iteration() < resumed.Iterations())
    {
      resumed.Step();
    }
    EXPECT_EQ(WeightsOf(resumed), WeightsOf(whole)) << done;
    EXPECT_EQ(resumed.History().Size(), 6u);
    EXPECT_TRUE(resumed.History() == whole.History());
  }
}

TEST_F(GeometricTextureTraining, LevelsBelowStayAndLevelsOfTheSameChannelsBeginWithTheirWeights)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.LearningRate = 1e-30; // steps that float32 does not see
  const auto before = WeightsOf(Trained(options, 2, 0));
  const auto copied = WeightsOf(Trained(options, 2, 4));
  EXPECT_EQ(
    copied.at("generator.levels.1.layers.0.0.conv.weight"), before.at("generator.levels.0.layers.0.0.conv.weight"));
  EXPECT_NE(
    before.at("generator.levels.1.layers.0.0.conv.weight"), before.at("generator.levels.0.layers.0.0.conv.weight"));
  options.LearningRate = 5e-4;
  const auto atTheEndOfLevel0 = WeightsOf(Trained(options, 2, 3));
  const auto inLevel1 = WeightsOf(Trained(options, 2, 5));
  for (const auto& [name, values] : inLevel1)
  {
    EXPECT_EQ(values == atTheEndOfLevel0.at(name), name.find("levels.0.") != std::string::npos) << name;
  }
}

TEST_F(GeometricTextureTraining, TheLearningRateHalvesWithinEachLevel)
{
  const GeometricTextureTrainer trainer = Trained(TinyGeometricTexture(), 2, 6);
  const LossHistory& history = trainer.History();
  for (std::size_t k = 0; k < history.Size(); ++k)
  {
    EXPECT_TRUE(std::isfinite(history.Value(k, "critic_loss") + history.Value(k, "adversarial_loss")));
    EXPECT_GT(history.Value(k, "gradient_penalty"), 0.0);
    EXPECT_GT(history.Value(k, "reconstruction_loss"), 0.0);
  }
  EXPECT_EQ(history.Column("level"), (std::vector<double>{ 0, 0, 0, 1, 1, 1 }));
  EXPECT_EQ(history.Column("learning_rate"), (std::vector<double>{ 5e-4, 5e-4, 2.5e-4, 5e-4, 5e-4, 2.5e-4 }));
}

TEST_F(GeometricTextureTraining, LevelsMayHaveOtherNumbersOfIterations)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.IterationsOfLevels = { 3, 1 };
  GeometricTextureTrainer trainer(Bumps(2), options);
  EXPECT_EQ(trainer.Iterations(), 4);
  std::vector<bool> ends;
  while (trainer.Iteration() < trainer.Iterations())
  {
    trainer.Step();
    ends.push_back(trainer.IsAtEndOfStage());
  }
  EXPECT_EQ(ends, (std::vector<bool>{ false, false, true, true }));
  EXPECT_EQ(trainer.History().Column("level"), (std::vector<double>{ 0, 0, 0, 1 }));
  // Level 1 is that of a training with as many iterations of each level.
  EXPECT_EQ(WeightsOf(trainer), WeightsOf(Trained(TinyGeometricTexture(), 2, 4)));
  EXPECT_THAT(TextOf<InvalidInput>([&] { trainer.Step(); }), HasSubstr("all 4 iterations are done"));
  ExpectExactResumption({ Bumps(2) }, options, this->File("checkpoint"));
  // Equal numbers are one number, in checkpoints too.
  Trained(TinyGeometricTexture(), 2, 4).SaveCheckpoint(this->File("equal"));
  options.IterationsOfLevels = { 3, 3 };
  GeometricTextureTrainer equal(Bumps(2), options);
  equal.LoadCheckpoint(this->File("equal"));
  EXPECT_EQ(equal.Iteration(), 4);
}

TEST_F(GeometricTextureTraining, TheLearningRateMayFallAfterQuartersOfLevels)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.IterationsOfLevels = { 8, 2 };
  options.LearningRateInterval = 0;
  const GeometricTextureTrainer trainer = Trained(options, 2, 10);
  EXPECT_EQ(trainer.History().Column("learning_rate"),
    (std::vector<double>{ 5e-4, 5e-4, 2.5e-4, 2.5e-4, 1.25e-4, 1.25e-4, 6.25e-5, 6.25e-5, 5e-4, 2.5e-4 }));
}

TEST_F(GeometricTextureTraining, ThePenaltyMayComeInSomeSteps)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.PenaltyInterval = 4; // of two steps in an iteration
  const LossHistory rare = Trained(options, 2, 6).History();
  const LossHistory each = Trained(TinyGeometricTexture(), 2, 6).History();
  for (std::size_t k = 0; k < rare.Size(); ++k)
  {
    EXPECT_EQ(rare.Value(k, "gradient_penalty") > 0.0, k % 3 != 1) << k; // in iterations 0 and 2 of each level
    EXPECT_GT(each.Value(k, "gradient_penalty"), 0.0);
  }
  ExpectExactResumption({ Bumps(2) }, options, this->File("checkpoint"));
}

TEST_F(GeometricTextureTraining, OtherObjectivesGoOnFromAnyCheckpointAndHaveNoDiscriminator)
{
  for (const TextureObjective objective : { TextureObjective::SlicedWasserstein, TextureObjective::FlowMatching })
  {
    GeometricTextureTrainingOptions options = TinyGeometricTexture();
    options.Objective = objective;
    options.IterationsPerLevel = 2;
    options.FlowSteps = 4;
    ExpectExactResumption(SphereAndTorus(), options, this->File("checkpoint"));
    const GeometricTextureTrainer trainer = Trained(options, 2, 4);
    const GeometricTextureModel model = trainer.Model();
    const bool isFlow = objective == TextureObjective::FlowMatching;
    EXPECT_TRUE(model.Discriminator.empty());
    EXPECT_EQ(model.Options.FlowSteps, isFlow ? 4 : 0);
    EXPECT_EQ(model.Statistics.at("levels.0.layers.0.mean").Shape.size(), isFlow ? 2U : 1U);
    EXPECT_EQ(trainer.History().Column("critic_loss"), std::vector<double>(4, 0.0));
    for (const double distance : trainer.History().Column("adversarial_loss"))
    {
      EXPECT_EQ(distance > 0.0, !isFlow);
    }
    // What it was learnt by is part of the recipe.
    trainer.SaveCheckpoint(this->File("other"));
    options.Objective = TextureObjective::Adversarial;
    GeometricTextureTrainer published = Trained(options, 2, 0);
    EXPECT_THROW(published.LoadCheckpoint(this->File("other")), ModelMismatch);
    options.Objective = objective;
    EXPECT_NO_THROW(Trained(options, 2, 0).LoadCheckpoint(this->File("other")));
  }
}

TEST_F(GeometricTextureTraining, AFlowTurnsNoiseIntoTheDisplacementsOfTheReference)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.Objective = TextureObjective::FlowMatching;
  options.Network.StartChannels = options.Network.MinimumChannels = options.Network.MaximumChannels = 16;
  options.Network.Layers = 5;
  options.IterationsPerLevel = 400;
  options.LearningRate = 5e-3;
  options.LearningRateInterval = 0;
  MultiscaleDataset dataset; // a sphere that grows: whatever the noise, the displacement is known
  dataset.Template = Icosphere(1, 1.0);
  dataset.Levels = { Icosphere(1, 1.25) };
  const auto model = std::make_shared<GeometricTextureModel>(
    Stepped({ { dataset }, options }, options.IterationsPerLevel).Model());
  const double unit = MeanEdgeLength(dataset.Levels.front());
  const PointMatrix start = dataset.Template.Points / unit;
  const PointMatrix wanted = dataset.Levels.front().Points / unit - start;
  GeometricTextureRequest request;
  request.Seed = 3;
  const PointMatrix found = GeometricTextureSampler(model).Generate(0, request).Mesh.Points - model->Template.Points;
  const double correlation = found.cwiseProduct(wanted).sum() / (found.norm() * wanted.norm());
  EXPECT_GT(correlation, 0.98);
  EXPECT_NEAR(found.norm() / wanted.norm(), 1.0, 0.1);
}

TEST_F(GeometricTextureTraining, TheBaseOfAFlowHasNoiseAboveLevel0)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.Objective = TextureObjective::FlowMatching;
  options.IterationsPerLevel = 1;
  options.BaseSamples = 0;
  const auto lossesOf = [&](double amplitude) {
    options.BaseNoiseAmplitude = amplitude;
    return Trained(options, 2, 2).History().Column("reconstruction_loss");
  };
  const std::vector<double> exact = lossesOf(0.0), noisy = lossesOf(0.5);
  EXPECT_EQ(exact[0], noisy[0]) << "level 0 has its template";
  EXPECT_GT(noisy[1], 2.0 * exact[1]) << "the displacement takes the noise back";
}

TEST_F(GeometricTextureTraining, TheBaseOfAFlowIsASampleNearTheReference)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.Objective = TextureObjective::FlowMatching;
  options.BaseNoiseAmplitude = 0.0;
  options.IterationsOfLevels = { 3, 3 };
  const auto lossesOf = [&](std::int64_t samples) {
    options.BaseSamples = samples;
    return Trained(options, 2, 6).History().Column("reconstruction_loss");
  };
  const std::vector<double> exact = lossesOf(0), one = lossesOf(1), eight = lossesOf(8);
  options.BaseNoiseAmplitude = 0.5;
  const std::vector<double> noisy = lossesOf(0);
  options.BaseNoiseAmplitude = 0.0;
  options.BaseSamples = 8;
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_EQ(exact[k], eight[k]) << "level 0 has its template";
  }
  EXPECT_NE(exact[3], one[3]);
  EXPECT_NE(one, eight);
  EXPECT_NEAR(eight[3], exact[3], 0.5 * exact[3]) << "near the reference";
  EXPECT_GT(noisy[3], 1.5 * exact[3]) << "what is not near it has another loss";
  ExpectExactResumption(SphereAndTorus(), options, this->File("checkpoint"));
}

TEST_F(GeometricTextureTraining, LearnsFromSeveralReferences)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.IterationsPerLevel = 4;
  const std::vector<MultiscaleDataset> references = SphereAndTorus();
  const auto both = WeightsOf(Stepped({ references, options }, 8));
  EXPECT_NE(both, WeightsOf(Stepped({ references[0], options }, 8)));
  EXPECT_NE(both, WeightsOf(Stepped({ references[1], options }, 8)));
  // The same reference twice is that reference, whichever is drawn, but for the noise that reconstructs the second.
  const std::vector<MultiscaleDataset> twice = { references[0], references[0] };
  EXPECT_EQ(WeightsOf(Stepped({ twice, options }, 4)), WeightsOf(Stepped({ references[0], options }, 4)));
  ExpectExactResumption(references, options, this->File("checkpoint"));
}

TEST_F(GeometricTextureTraining, StatisticsOfTheNormsAreThoseOfAllReferences)
{
  const std::vector<MultiscaleDataset> references = SphereAndTorus();
  const GeometricTextureModel model = Stepped({ references, TinyGeometricTexture() }, 2).Model();
  EXPECT_EQ(model.Template.NumberOfPoints(), references[0].Levels[0].NumberOfPoints());
  const std::string mean = NamesOfStatistics(1, 0).Mean;
  const std::vector<float> ofBoth = model.Statistics.at(mean).Values;
  const auto ofSphere = MeasureStatistics(model);
  GeometricTextureModel onTorus = model;
  onTorus.Template = references[1].Levels[0];
  onTorus.Template.Points /= MeanEdgeLength(onTorus.Template);
  const auto ofTorus = MeasureStatistics(model, { onTorus.Template });
  for (std::size_t c = 0; c < ofBoth.size(); ++c)
  {
    EXPECT_NEAR(ofBoth[c], 0.5F * (ofSphere.at(mean).Values[c] + ofTorus.at(mean).Values[c]), 1e-4) << c;
  }
  EXPECT_NE(ofBoth, ofSphere.at(mean).Values);
}

TEST_F(GeometricTextureTraining, RefusesReferencesOfOtherNumbersOfLevels)
{
  const auto refusal = [](const std::vector<MultiscaleDataset>& references) {
    return TextOf<InvalidInput>([&] { GeometricTextureTrainer(references, TinyGeometricTexture()); });
  };
  EXPECT_THAT(refusal({}), HasSubstr("there is no reference"));
  EXPECT_THAT(refusal({ Bumps(2), Bumps(1) }), HasSubstr("reference 1 has 1 levels; expected 2, as reference 0 has"));
}

TEST_F(GeometricTextureTraining, LearnsToReconstructTheReference)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.Network.NoiseAmplitude = 0.01;
  options.IterationsPerLevel = 60;
  options.LearningRate = 1e-2;
  options.LearningRateInterval = 60;
  options.ReconstructionWeight = 100.0;
  const GeometricTextureTrainer trainer = Trained(options, 1, 60);
  EXPECT_LT(trainer.History().Last(), 0.5 * trainer.History().Value(0, "reconstruction_loss"));
}

TEST_F(GeometricTextureTraining, WritesAfterEachLevelAndItsModelIsComplete)
{
  const TrainingFiles files = this->Files();
  int seen = 0;
  const auto stop = [&](const LossHistory& losses) {
    ++seen;
    // The checkpoint of level 0 was written after its last iteration, long before the interval.
    EXPECT_EQ(std::filesystem::exists(files.Checkpoint), losses.Size() > 3);
    if (losses.Size() == 4) // a model to look at while the training goes on has no statistics, which take long
    {
      EXPECT_TRUE(ReadGeometricTexture(files.Model).Statistics.empty());
    }
    return losses.Size() < 5;
  };
  EXPECT_THROW(TrainGeometricTexture(Bumps(2), TinyGeometricTexture(), files, stop), Cancelled);
  EXPECT_EQ(seen, 5);
  EXPECT_FALSE(ReadGeometricTexture(files.Model).Statistics.empty()) << "of a training that was stopped";
  const GeometricTextureTrainer trainer = TrainGeometricTexture(Bumps(2), TinyGeometricTexture(), files);
  EXPECT_EQ(trainer.Iteration(), 6);
  EXPECT_EQ(WeightsOf(trainer), WeightsOf(Trained(TinyGeometricTexture(), 2, 6)));
  const GeometricTextureModel model = ReadGeometricTexture(files.Model);
  EXPECT_EQ(model.Options.Levels, 2);
  EXPECT_EQ(model.Template.NumberOfPoints(), 12);
  EXPECT_EQ(model.ReconstructionNoise.rows(), 12);
  EXPECT_EQ(model.Discriminator.size(), model.Generator.size());
  EXPECT_FALSE(model.Statistics.empty());
  const std::string table = BytesOf(files.LossTable);
  EXPECT_THAT(table, HasSubstr("iteration,level,critic_loss,gradient_penalty,adversarial_loss,reconstruction_loss,"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 7);
}

TEST_F(GeometricTextureTraining, RefusesCheckpointsOfAnotherRecipeOrDataset)
{
  Trained(TinyGeometricTexture(), 2, 2).SaveCheckpoint(this->File("checkpoint"));
  GeometricTextureTrainingOptions other = TinyGeometricTexture();
  other.PenaltyWeight = 1.0;
  GeometricTextureTrainer trainer(Bumps(2), other);
  EXPECT_THAT(TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("checkpoint")); }),
    HasSubstr("penalty_weight = 0.1"));
  EXPECT_EQ(trainer.Iteration(), 0);
  MultiscaleDataset dataset = Bumps(2);
  dataset.Levels[1].Points(3, 1) += 0.01;
  GeometricTextureTrainer moved(dataset, TinyGeometricTexture());
  EXPECT_THAT(
    TextOf<ModelMismatch>([&] { moved.LoadCheckpoint(this->File("checkpoint")); }), HasSubstr("with dataset ="));
}

TEST_F(GeometricTextureTraining, RefusesMomentsThatNoTrainingHasAndWeightsThatAreNotFinite)
{
  const GeometricTextureTrainingOptions options = TinyGeometricTexture();
  Trained(options, 2, 1).SaveCheckpoint(this->File("checkpoint")); // within a level, so that there are moments
  const TrainingCheckpoint original = ReadCheckpoint(this->File("checkpoint"));
  const auto write = [&](float mean, float square) {
    TrainingCheckpoint checkpoint = original;
    int changed = 0;
    for (auto& [name, tensor] : checkpoint.Tensors)
    {
      const bool isMean = name.compare(0, 10, "adam_mean.") == 0;
      if (isMean || name.compare(0, 12, "adam_square.") == 0)
      {
        std::fill(tensor.Values.begin(), tensor.Values.end(), isMean ? mean : square);
        ++changed;
      }
    }
    EXPECT_GT(changed, 1);
    WriteCheckpoint(this->File("checkpoint"), checkpoint);
  };
  write(0.0F, -1e-3F);
  GeometricTextureTrainer trainer(Bumps(2), options);
  EXPECT_THAT(TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("checkpoint")); }),
    HasSubstr("has negative numbers"));
  EXPECT_EQ(trainer.Iteration(), 0);
  write(3e38F, 0.0F);
  trainer.LoadCheckpoint(this->File("checkpoint"));
  EXPECT_THAT(TextOf<SolverFailure>([&] { trainer.Step(); }), HasSubstr("A weight is not finite after iteration 2"));
}

TEST_F(GeometricTextureTraining, RefusesOptionsOutOfTheirRange)
{
  const auto refusal = [](const auto& change) {
    GeometricTextureTrainingOptions options = TinyGeometricTexture();
    change(options);
    return TextOf<InvalidInput>([&] { GeometricTextureTrainer(Bumps(1), options); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([](auto& o) { o.IterationsPerLevel = 0; }), HasSubstr("IterationsPerLevel is 0"));
  EXPECT_THAT(refusal([](auto& o) { o.IterationsOfLevels = { 0 }; }), HasSubstr("IterationsOfLevels[0] is 0"));
  EXPECT_THAT(refusal([](auto& o) {
    o.IterationsOfLevels = { 1, 2 };
  }),
    HasSubstr("IterationsOfLevels has 2 entries; expected one for each of the 1 levels"));
  EXPECT_THAT(refusal([](auto& o) { o.LearningRateInterval = -1; }), HasSubstr("LearningRateInterval is -1"));
  EXPECT_THAT(refusal([](auto& o) { o.PenaltyInterval = 0; }), HasSubstr("PenaltyInterval is 0"));
  EXPECT_THAT(refusal([](auto& o) { o.FlowSteps = 0; }), HasSubstr("FlowSteps is 0"));
  EXPECT_THAT(refusal([](auto& o) { o.BaseNoiseAmplitude = -0.1; }), HasSubstr("BaseNoiseAmplitude is -0.1"));
  EXPECT_THAT(refusal([](auto& o) { o.BaseSamples = -1; }), HasSubstr("BaseSamples is -1"));
  EXPECT_THAT(refusal([](auto& o) { o.BaseSamples = 101; }), HasSubstr("BaseSamples is 101"));
  EXPECT_THAT(refusal([](auto& o) { o.Projections = 0; }), HasSubstr("Projections is 0"));
  EXPECT_THAT(refusal([](auto& o) { o.GeneratorSteps = 1001; }), HasSubstr("GeneratorSteps is 1001"));
  EXPECT_THAT(refusal([&](auto& o) { o.LearningRate = nan; }), HasSubstr("LearningRate is nan"));
  EXPECT_THAT(refusal([](auto& o) { o.LearningRateFactor = 1.5; }), HasSubstr("LearningRateFactor is 1.5"));
  EXPECT_THAT(refusal([](auto& o) { o.PenaltyWeight = -1.0; }), HasSubstr("PenaltyWeight is -1"));
  EXPECT_THAT(refusal([](auto& o) { o.Name.clear(); }), HasSubstr("Name is empty"));
}

TEST_F(GeometricTextureTraining, RefusesDatasetsThatAreNoLevelsOfOneAnother)
{
  const auto refusal = [](const MultiscaleDataset& dataset) {
    return TextOf<InvalidInput>([&] { GeometricTextureTrainer(dataset, TinyGeometricTexture()); });
  };
  EXPECT_THAT(refusal({}), HasSubstr("has no level"));
  MultiscaleDataset skipped = Bumps(3);
  skipped.Levels.erase(skipped.Levels.begin() + 1);
  EXPECT_THAT(refusal(skipped), HasSubstr("level 1 has other triangles"));
  MultiscaleDataset other = Bumps(1);
  other.Template = Tetrahedron();
  EXPECT_THAT(refusal(other), HasSubstr("the template has other triangles"));
  MultiscaleDataset broken = Bumps(2);
  broken.Levels[1].Points(5, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(refusal(broken), HasSubstr("level 1 has 80 triangles"));
  MultiscaleDataset flat = Bumps(1);
  flat.Levels[0].Points.row(0) = flat.Levels[0].Points.row(5);
  EXPECT_THAT(refusal(flat), HasSubstr("level 0: "));
}

TEST_F(GeometricTextureTraining, StopsWhenALossIsNotFinite)
{
  GeometricTextureTrainingOptions options = TinyGeometricTexture();
  options.LearningRate = 1e30;
  EXPECT_THAT(TextOf<SolverFailure>([&] { Trained(options, 1, 3); }), HasSubstr("is not finite"));
}
