// SPDX-License-Identifier: BSD-3-Clause
// Training of field latents: rings, losses that fall, exact resumption, and what is refused.
#include "RandomFieldLatents.h"
#include "SmallTextures.h"
#include "TrainingData.h"

#include "Core/Common/Errors.h"
#include "Inference/FieldLatents/FieldLatentDecoder.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Learning/Training/FieldLatentTrainer.h"
#include "Learning/Training/TextureRings.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
FieldLatentTrainingOptions TinyTraining(
  std::int64_t iterations, FieldLatentCoordinates coordinates = FieldLatentCoordinates::Logarithmic)
{
  FieldLatentTrainingOptions options;
  options.Network = TinyFieldLatents();
  options.Network.Coordinates = coordinates;
  options.Network.SamplesPerRing = 12;
  options.Network.DecoderWidth = 24;
  options.BatchSize = 12;
  options.Iterations = iterations;
  options.Device = TrainingDevice::CPU;
  return options;
}

FieldLatentTrainer TrainedLatents(const FieldLatentTrainingOptions& options, std::int64_t iterations)
{
  FieldLatentTrainer trainer(SmallTextures(), options);
  for (std::int64_t k = 0; k < iterations; ++k)
  {
    trainer.Step();
  }
  return trainer;
}

std::map<std::string, std::vector<float>> WeightsOf(const FieldLatentTrainer& trainer)
{
  std::map<std::string, std::vector<float>> weights;
  for (const auto& [name, tensor] : trainer.Model().Tensors)
  {
    weights[name] = tensor.Values;
  }
  return weights;
}

/// Mean of a column over @p count rows from @p first on.
double MeanOf(const LossHistory& history, const std::string& column, std::size_t first, std::size_t count)
{
  const std::vector<double> values = history.Column(column);
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
  return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(count), 0.0) / static_cast<double>(count);
}
} // namespace

TEST(TextureRings, SamplesLieInTheRingsAndHaveTheColorsOfTheImage)
{
  // A ramp of colors along the columns: the color of a sample is an affine function of its logarithm.
  TextureDataset dataset;
  dataset.Meshes = { SquareMesh(6) };
  TextureImage image = { 200, 200, {} };
  for (std::int64_t pixel = 0; pixel < 200 * 200; ++pixel)
  {
    const auto value = static_cast<unsigned char>(pixel % 200);
    image.Pixels.insert(image.Pixels.end(), { value, value, 255 });
  }
  dataset.Images = { image };
  const TextureRings rings(dataset);
  TextureRingSizes sizes;
  sizes.Rings = 6;
  sizes.Samples = 400;
  const TextureRingBatch batch = rings.Draw(sizes, 3, 7);
  for (std::int64_t r = 0; r < 6; ++r)
  {
    const Eigen::Map<const FieldLatentMatrix> logarithms(batch.Logarithms.data() + 800 * r, 400, 2);
    const Eigen::Map<const FieldLatentMatrix> colors(batch.Colors.data() + 1200 * r, 400, 3);
    // Uniform in a one-ring of area pi: a disk would have a mean square of 1/2.
    EXPECT_NEAR(logarithms.rowwise().squaredNorm().mean(), 0.55F, 0.15F);
    EXPECT_LT(logarithms.rowwise().norm().maxCoeff(), 2.5F);
    EXPECT_NEAR((colors.col(2).array() - 1.0F).abs().maxCoeff(), 0.0F, 1e-5F);
    Eigen::MatrixXd affine(400, 3);
    affine << logarithms.cast<double>(), Eigen::VectorXd::Ones(400);
    const Eigen::VectorXd red = colors.col(0).cast<double>();
    const Eigen::VectorXd fit = (affine.transpose() * affine).ldlt().solve(affine.transpose() * red);
    EXPECT_LT((affine * fit - red).cwiseAbs().maxCoeff(), 1e-4);
    // The slope tells the scale: 10 to 150 pixels for a vertex, rings about three times that.
    const double pixels = fit.head(2).norm() * 127.5;
    EXPECT_GT(pixels, 2.0);
    EXPECT_LT(pixels, 20.0);
  }
  const TextureRingBatch again = rings.Draw(sizes, 3, 7);
  EXPECT_EQ(again.Logarithms, batch.Logarithms);
  EXPECT_EQ(again.TargetColors, batch.TargetColors);
  EXPECT_NE(rings.Draw(sizes, 3, 8).Logarithms, batch.Logarithms);
  EXPECT_NE(batch.TargetLogarithms, batch.Logarithms);
}

TEST(TextureRings, TargetsLieNearTheVertexByTheirPower)
{
  const TextureRings rings(SmallTextures());
  TextureRingSizes sizes;
  sizes.Rings = 8;
  sizes.Samples = 4000;
  const auto meanSquare = [&](const std::vector<float>& logarithms) {
    return std::inner_product(logarithms.begin(), logarithms.end(), logarithms.begin(), 0.0) /
      static_cast<double>(sizes.Rings * sizes.Samples);
  };
  const TextureRingBatch uniform = rings.Draw(sizes, 5, 0);
  for (const double power : { 1.0, 2.0, 5.5 })
  {
    sizes.TargetPower = power;
    const TextureRingBatch batch = rings.Draw(sizes, 5, 0);
    EXPECT_EQ(batch.Logarithms, uniform.Logarithms); // the encoder's samples stay
    EXPECT_EQ(batch.Colors, uniform.Colors);
    // A point is 1 - b times as far as the opposite edge: with density b^k the mean of (1 - b)^2 is 6 / ((k + 3) (k + 4)).
    EXPECT_NEAR(meanSquare(batch.TargetLogarithms) / meanSquare(uniform.TargetLogarithms),
      12.0 / ((power + 3.0) * (power + 4.0)), 0.02)
      << power;
  }
}

TEST(TextureRings, AugmentedColorsAreAffineInOneChannelOfTheImage)
{
  TextureRingSizes sizes;
  sizes.Rings = 48;
  sizes.Samples = 30;
  const TextureRings rings(SmallTextures());
  const TextureRingBatch plain = rings.Draw(sizes, 4, 1);
  sizes.ColorAugmentation = 0.5;
  const TextureRingBatch batch = rings.Draw(sizes, 4, 1);
  EXPECT_EQ(batch.Logarithms, plain.Logarithms);
  int changed = 0;
  for (std::int64_t r = 0; r < sizes.Rings; ++r)
  {
    const Eigen::Map<const FieldLatentMatrix> before(plain.Colors.data() + 90 * r, 30, 3);
    const Eigen::Map<const FieldLatentMatrix> after(batch.Colors.data() + 90 * r, 30, 3);
    const Eigen::Map<const FieldLatentMatrix> targets(plain.TargetColors.data() + 90 * r, 30, 3);
    const Eigen::Map<const FieldLatentMatrix> augmented(batch.TargetColors.data() + 90 * r, 30, 3);
    changed += before != after ? 1 : 0;
    EXPECT_LE(after.cwiseAbs().maxCoeff(), 1.0F);
    for (Eigen::Index c = 0; c < 3; ++c)
    {
      double least = 1.0; // largest residual of the best channel, of samples and targets alike
      for (Eigen::Index from = 0; from < 3; ++from)
      {
        Eigen::MatrixXd affine(30, 2);
        affine << before.col(from).cast<double>(), Eigen::VectorXd::Ones(30);
        const Eigen::VectorXd wanted = after.col(c).cast<double>();
        const Eigen::Vector2d fit = affine.completeOrthogonalDecomposition().solve(wanted);
        const Eigen::VectorXd found = (targets.col(from).cast<double>() * fit[0]).array() + fit[1];
        least = std::min(least,
          std::max((affine * fit - wanted).cwiseAbs().maxCoeff(),
            (found - augmented.col(c).cast<double>()).cwiseAbs().maxCoeff()));
      }
      EXPECT_LT(least, 1e-4) << r;
    }
  }
  EXPECT_GT(changed, 12);
  EXPECT_LT(changed, 36);
}

TEST(TextureRings, SmallImagesHoldTheirRings)
{
  TextureDataset dataset = SmallTextures();
  dataset.Images = { WaveImage(1, 1, 0.0), WaveImage(3, 2, 0.0) };
  TextureRingSizes sizes;
  sizes.Rings = 12;
  sizes.Samples = 20;
  for (const bool inTriangles : { false, true })
  {
    sizes.InTriangles = inTriangles;
    const TextureRingBatch batch = TextureRings(dataset, inTriangles).Draw(sizes, 1, 0);
    for (const float value : batch.TargetColors)
    {
      EXPECT_LE(std::abs(value), 1.0F);
    }
    EXPECT_EQ(batch.Barycentric.size(), inTriangles ? 720U : 0U);
    EXPECT_EQ(batch.TargetLogarithms.size(), inTriangles ? 0U : 480U);
  }
}

TEST(FieldLatentTrainer, LossesFall)
{
  for (const FieldLatentCoordinates coordinates :
    { FieldLatentCoordinates::Logarithmic, FieldLatentCoordinates::Barycentric })
  {
    FieldLatentTrainingOptions options = TinyTraining(250, coordinates);
    options.LearningRate = 1e-2;
    options.MinimumTexels = 4.0;
    options.MaximumTexels = 16.0;
    const FieldLatentTrainer trainer = TrainedLatents(options, 250);
    const LossHistory& history = trainer.History();
    ASSERT_EQ(history.Size(), 250U);
    const double first = MeanOf(history, "reconstruction_loss", 0, 10);
    const double last = MeanOf(history, "reconstruction_loss", 220, 30);
    EXPECT_LT(last, 0.75 * first) << NameOf(coordinates);
    EXPECT_NEAR(history.Value(100, "loss"),
      history.Value(100, "reconstruction_loss") + 0.01 * history.Value(100, "divergence_loss"), 1e-5);
    EXPECT_EQ(history.Value(0, "learning_rate"), 1e-2);
    EXPECT_NEAR(history.Value(125, "learning_rate"), 0.5 * (1e-2 + 1e-5), 1e-6);
    EXPECT_LT(history.Value(249, "learning_rate"), 1.2e-5);
  }
}

TEST(FieldLatentTrainer, ResumingGivesTheBitsOfAnUninterruptedTraining)
{
  for (const FieldLatentCoordinates coordinates :
    { FieldLatentCoordinates::Logarithmic, FieldLatentCoordinates::Barycentric })
  {
    const FieldLatentTrainingOptions options = TinyTraining(9, coordinates);
    const FieldLatentTrainer whole = TrainedLatents(options, 9);
    TrainedLatents(options, 4).SaveCheckpoint("latents.checkpoint");
    FieldLatentTrainer resumed(SmallTextures(), options);
    resumed.LoadCheckpoint("latents.checkpoint");
    EXPECT_EQ(resumed.Iteration(), 4);
    for (int k = 4; k < 9; ++k)
    {
      resumed.Step();
    }
    EXPECT_EQ(WeightsOf(resumed), WeightsOf(whole));
    EXPECT_TRUE(resumed.History() == whole.History());
  }
  std::remove("latents.checkpoint");
}

TEST(FieldLatentTrainer, ACancelledTrainingGoesOnFromTheIterationItStoppedIn)
{
  TrainingFiles files;
  files.Model = "latents.safetensors";
  files.Checkpoint = "latents.checkpoint";
  files.LossTable = "latents.csv";
  std::remove(files.Checkpoint.c_str());
  const FieldLatentTrainingOptions options = TinyTraining(6);
  const std::string text = TextOf<Cancelled>([&] {
    TrainFieldLatents(SmallTextures(), options, files, [](const LossHistory& history) { return history.Size() < 3; });
  });
  EXPECT_THAT(text, HasSubstr("stopped after iteration 3"));
  const FieldLatentTrainer trainer = TrainFieldLatents(SmallTextures(), options, files);
  EXPECT_EQ(WeightsOf(trainer), WeightsOf(TrainedLatents(options, 6)));
  const FieldLatentModel model = ReadFieldLatents(files.Model);
  EXPECT_EQ(model.Iterations, 6);
  EXPECT_EQ(model.Tensors.at("decoder.layers.0.bias").Values, WeightsOf(trainer).at("decoder.layers.0.bias"));
  EXPECT_THAT(BytesOf(files.LossTable), HasSubstr("iteration,loss,reconstruction_loss,divergence_loss"));

  // Another dataset or recipe is another training.
  FieldLatentTrainingOptions other = options;
  other.Network.Heads = 4;
  EXPECT_THAT(
    TextOf<ModelMismatch>([&] { FieldLatentTrainer(SmallTextures(), other).LoadCheckpoint(files.Checkpoint); }),
    HasSubstr("heads = 3; expected 4"));
  TextureDataset textures = SmallTextures();
  textures.Images[0].Pixels[0] ^= 1;
  EXPECT_THAT(TextOf<ModelMismatch>([&] { FieldLatentTrainer(textures, options).LoadCheckpoint(files.Checkpoint); }),
    HasSubstr("dataset = "));
  for (const std::string& file : { files.Model, files.Checkpoint, files.LossTable })
  {
    std::remove(file.c_str());
  }
}

TEST(FieldLatentTrainer, OptionsAndDatasetsThatDoNotFitAreNamed)
{
  const auto refusal = [](const std::function<void(FieldLatentTrainingOptions&)>& change) {
    FieldLatentTrainingOptions options = TinyTraining(3);
    change(options);
    return TextOf<InvalidInput>([&] { FieldLatentTrainer(SmallTextures(), options); });
  };
  using Options = FieldLatentTrainingOptions;
  EXPECT_THAT(refusal([](Options& o) { o.Iterations = 0; }), HasSubstr("Iterations is 0"));
  EXPECT_THAT(refusal([](Options& o) { o.BatchSize = 0; }), HasSubstr("BatchSize is 0"));
  EXPECT_THAT(refusal([](Options& o) {
    o.BatchSize = 16;
    o.Network.Coordinates = FieldLatentCoordinates::Barycentric;
  }),
    HasSubstr("BatchSize is 16; expected a multiple of 3"));
  EXPECT_THAT(refusal([](Options& o) { o.FinalLearningRate = 0.0; }), HasSubstr("FinalLearningRate is 0"));
  EXPECT_THAT(refusal([](Options& o) { o.DivergenceWeight = -1.0; }), HasSubstr("DivergenceWeight is -1"));
  EXPECT_THAT(refusal([](Options& o) { o.MaximumTexels = 5.0; }), HasSubstr("MaximumTexels is 5; expected at least"));
  EXPECT_THAT(refusal([](Options& o) { o.TargetPower = -1.0; }), HasSubstr("TargetPower is -1"));
  EXPECT_THAT(refusal([](Options& o) { o.ColorAugmentation = 1.5; }), HasSubstr("ColorAugmentation is 1.5"));
  EXPECT_THAT(refusal([](Options& o) { o.Network.Heads = 5; }), HasSubstr("Heads is 5"));
  TextureDataset dataset = SmallTextures();
  dataset.Meshes[1] = SquareMesh(2);
  FieldLatentTrainingOptions barycentric = TinyTraining(1);
  barycentric.BatchSize = 3;
  barycentric.Network.Coordinates = FieldLatentCoordinates::Barycentric;
  EXPECT_THAT(TextOf<InvalidInput>([&] { FieldLatentTrainer(dataset, barycentric); }),
    HasSubstr("mesh 1 has no triangle of three interior vertices"));
  EXPECT_NO_THROW(FieldLatentTrainer(dataset, TinyTraining(1))) << "rings by themselves need no such triangle";
  EXPECT_THAT(TextOf<InvalidInput>([&] { FieldLatentTrainer({}, TinyTraining(3)); }), HasSubstr("0 images"));
}

TEST(FieldLatentTrainer, ARateThatIsTooHighIsNamed)
{
  FieldLatentTrainingOptions options = TinyTraining(20);
  options.LearningRate = 1e25;
  EXPECT_THAT(TextOf<SolverFailure>([&] { TrainedLatents(options, 20); }), HasSubstr("lower learning rate"));
}
