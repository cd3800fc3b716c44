// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingData.h"

#include "ExampleMeshes.h"
#include "RandomPoissonNet.h"

#include "Core/Common/Errors.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
/// Four hundred iterations of four copies of the same sample: seconds.
FlowMatchingTrainingOptions QuickRecipe()
{
  FlowMatchingTrainingOptions options = TinyRecipe(400);
  options.Width = 16;
  options.BatchSize = 4;
  options.LearningRate = 1e-2;
  options.Milestones = { 200, 300 };
  options.Noise.Smoothing = 0.0; // these surfaces have edges as long as the noise has correlation
  return options;
}

/// The same with another prediction, with Muon.
FlowMatchingTrainingOptions QuickRecipeOf(FlowPrediction prediction)
{
  FlowMatchingTrainingOptions options = QuickRecipe();
  options.Prediction = prediction;
  options.Optimizer = TrainingOptimizer::Muon;
  options.Schedule = LearningRateSchedule::Cosine;
  options.LearningRate = 2e-2;
  return options;
}

/// One sample is learnt: samples of the model are that sample, wherever their noise begins. @returns their relative error,
/// weighted by mass, of deviations from the mean of each component.
double ErrorOfOneSample(const SignalDataset& dataset, const FlowMatchingTrainingOptions& options)
{
  const FlowMatchingTrainer trainer = TrainFlowMatching(dataset, options, {});
  const SignalSource& source = dataset.Sources[0];
  const FlowMatchingSampler sampler(std::make_shared<FlowMatchingModel>(trainer.Model()), source.Mesh);
  const Eigen::Index components = source.NumberOfComponents();
  const Eigen::MatrixXd expected =
    Eigen::Map<const SignalSamples>(source.Samples.data(), source.Mesh.NumberOfPoints(), components).cast<double>();
  const Eigen::VectorXd mass = LumpedMass(source.Mesh, MeshTopology(source.Mesh));
  const auto centered = [&](const Eigen::MatrixXd& values) -> Eigen::MatrixXd {
    return values.rowwise() - (mass.transpose() * values / mass.sum()).eval();
  };
  const auto squares = [&](const Eigen::MatrixXd& values) -> Eigen::RowVectorXd {
    return mass.transpose() * values.cwiseAbs2();
  };
  double worst = 0.0;
  for (std::uint32_t sample = 0; sample < 3; ++sample)
  {
    FlowSampleRequest request;
    request.Seed = 99;
    request.Sample = sample;
    const Eigen::MatrixXd found = sampler.ToSignal(sampler.Integrate(sampler.InitialNoise(request), request));
    const Eigen::RowVectorXd errors =
      squares(centered(found) - centered(expected)).cwiseQuotient(squares(centered(expected))).cwiseSqrt();
    worst = std::max(worst, errors.maxCoeff());
  }
  return worst;
}

/// The mean square of a model's noise on @p mesh.
double NoiseSquares(const FlowMatchingModel& model, const TriangleMesh& mesh)
{
  const FlowMatchingSampler sampler(std::make_shared<FlowMatchingModel>(model), mesh);
  constexpr std::uint32_t samples = 200;
  double squares = 0.0;
  for (std::uint32_t k = 0; k < samples; ++k)
  {
    FlowSampleRequest request;
    request.Sample = k;
    squares += sampler.InitialNoise(request).cast<double>().cwiseAbs2().mean() / samples;
  }
  return squares;
}

/// The unbiased variance of samples in the rows, in the mean over the columns.
double MeanVariance(const Eigen::MatrixXd& samples)
{
  return (samples.rowwise() - samples.colwise().mean()).squaredNorm() /
    static_cast<double>((samples.rows() - 1) * samples.cols());
}
} // namespace

TEST_F(FlowMatchingTraining, TheSameSeedGivesTheSameWeightsAndAnotherSeedOthers)
{
  const SignalDataset dataset = DeformedSpheres(3);
  FlowMatchingTrainingOptions options = TinyRecipe(5);
  const FlowMatchingTrainer first = Trained(dataset, options, 5);
  const FlowMatchingTrainer again = Trained(dataset, options, 5);
  EXPECT_EQ(Weights(first), Weights(again));
  EXPECT_EQ(first.History().Row(4), again.History().Row(4));
  options.Seed = 1;
  EXPECT_NE(Weights(first), Weights(Trained(dataset, options, 5)));
}

TEST_F(FlowMatchingTraining, TheLossIsTheWeightedSumOfItsParts)
{
  FlowMatchingTrainingOptions options = TinyRecipe(8);
  options.VertexWeight = 2.0;
  options.JacobianWeight = 0.5;
  options.LearningRate = 1e-3;
  options.Milestones = { 1, 6 };
  options.LearningRateFactor = 0.5;
  const FlowMatchingTrainer trainer = Trained(DeformedSpheres(3), options, 8);
  const LossHistory& history = trainer.History();
  ASSERT_EQ(history.Size(), 8u);
  EXPECT_EQ(trainer.DeviceName(), "CPU");
  const std::vector<double> rates = { 1e-3, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 2.5e-4, 2.5e-4 };
  for (std::size_t k = 0; k < 8; ++k)
  {
    const double vertexLoss = history.Value(k, "vertex_loss");
    const double jacobianLoss = history.Value(k, "jacobian_loss");
    EXPECT_EQ(history.Value(k, "iteration"), static_cast<double>(k + 1));
    EXPECT_NEAR(history.Value(k, "loss"), 2.0 * vertexLoss + 0.5 * jacobianLoss, 1e-12);
    EXPECT_GT(vertexLoss, 0.0);
    EXPECT_GT(jacobianLoss, 0.0);
    EXPECT_GT(history.Value(k, "gradient_norm"), 0.0);
    EXPECT_DOUBLE_EQ(history.Value(k, "learning_rate"), rates[k]);
  }
}

TEST_F(FlowMatchingTraining, TheLossOfASampleIsInTheColumnOfItsTime)
{
  FlowMatchingTrainingOptions options = TinyRecipe(40);
  options.BatchSize = 1;
  options.Seed = 3;
  options.VertexWeight = 2.0;
  const FlowMatchingTrainer trainer = Trained(DeformedSpheres(3), options, 40);
  const LossHistory& history = trainer.History();
  std::vector<double> expected(8, 0.0);
  std::set<std::size_t> seen;
  for (std::size_t row = 0; row < 40; ++row)
  {
    NormalKey key;
    key.Seed = options.Seed;
    key.Sample = static_cast<std::uint32_t>(row);
    const auto part = static_cast<std::size_t>(8.0 * Uniform(key, 2));
    seen.insert(part);
    expected[part] = history.Value(row, "loss");
    for (std::size_t k = 0; k < 8; ++k)
    {
      const double found = history.Value(row, "loss_" + std::to_string(k + 1));
      EXPECT_NEAR(found, expected[k], 1e-6 * expected[k]) << row << " " << k;
    }
  }
  EXPECT_GE(seen.size(), 7U);
}

TEST_F(FlowMatchingTraining, LossesByTimeAreMeansOfTheSamplesOfAllSurfaces)
{
  SignalDataset dataset = DeformedSpheres(2, 1);
  dataset.Sources.push_back(DeformedSpheres(3, 2).Sources[0]);
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.BatchSize = 64;
  options.SourcesPerBatch = 2;
  const FlowMatchingTrainer trainer = Trained(dataset, options, 1);
  std::vector<int> counts(8, 0);
  for (std::uint32_t slot = 0; slot < 64; ++slot)
  {
    NormalKey key;
    key.Seed = options.Seed;
    key.Component = slot;
    ++counts[static_cast<std::size_t>(8.0 * Uniform(key, 2))];
  }
  double sum = 0.0;
  for (std::size_t k = 0; k < 8; ++k)
  {
    ASSERT_GT(counts[k], 0);
    sum += counts[k] * trainer.History().Value(0, "loss_" + std::to_string(k + 1)) / 64.0;
  }
  EXPECT_NEAR(sum, trainer.History().Value(0, "loss"), 1e-5 * sum);
}

TEST_F(FlowMatchingTraining, WithoutMilestonesTheLearningRateFallsAfterAQuarter)
{
  const FlowMatchingTrainer trainer = Trained(DeformedSpheres(2), TinyRecipe(8), 3);
  EXPECT_DOUBLE_EQ(trainer.History().Value(1, "learning_rate"), 5e-4);
  EXPECT_DOUBLE_EQ(trainer.History().Value(2, "learning_rate"), 1e-4);
}

TEST_F(FlowMatchingTraining, TheLossTableHasARowForEachIteration)
{
  const FlowMatchingTrainer trainer = TrainFlowMatching(DeformedSpheres(2), TinyRecipe(6), this->Files("a"));
  std::ifstream file(this->File("a.csv"));
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line,
    "iteration,loss,vertex_loss,jacobian_loss,gradient_norm,learning_rate,"
    "loss_1,loss_2,loss_3,loss_4,loss_5,loss_6,loss_7,loss_8");
  for (const double loss : trainer.History().Column("loss"))
  {
    ASSERT_TRUE(std::getline(file, line));
    std::istringstream row(line);
    double found = 0.0;
    char comma = 0;
    row >> found >> comma >> found;
    EXPECT_NEAR(found, loss, 1e-8 * loss);
  }
  EXPECT_FALSE(std::getline(file, line));
}

TEST_F(FlowMatchingTraining, OneShapeIsLearnt)
{
  EXPECT_LT(ErrorOfOneSample(DeformedSpheres(1, 2), QuickRecipe()), 0.08);
}

TEST_F(FlowMatchingTraining, OneSignalOfTwoComponentsIsLearnt)
{
  EXPECT_LT(ErrorOfOneSample(HeatOnSphere(1, 2), QuickRecipe()), 0.08);
}

TEST_F(FlowMatchingTraining, OneShapeIsLearntByPredictionsOfIt)
{
  EXPECT_LT(ErrorOfOneSample(DeformedSpheres(1, 2), QuickRecipeOf(FlowPrediction::Data)), 0.01);
}

TEST_F(FlowMatchingTraining, OneSignalIsLearntByPredictionsOfIt)
{
  EXPECT_LT(ErrorOfOneSample(HeatOnSphere(1, 2), QuickRecipeOf(FlowPrediction::Data)), 0.03);
}

TEST_F(FlowMatchingTraining, OneShapeAndOneSignalAreLearntByPreconditionedPredictions)
{
  FlowMatchingTrainingOptions options = QuickRecipeOf(FlowPrediction::Preconditioned);
  options.Iterations = 600; // after 400 rounding decides: errors of shapes are 0.029 to 0.031
  EXPECT_LT(ErrorOfOneSample(DeformedSpheres(1, 2), options), 0.03);
  EXPECT_LT(ErrorOfOneSample(HeatOnSphere(1, 2), options), 0.05);
}

TEST_F(FlowMatchingTraining, PositionsAreDataAndOtherSignalsPreconditionedUnlessTheRecipeSaysSo)
{
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  EXPECT_EQ(FlowMatchingTrainer(HeatOnSphere(2), options).Model().Prediction, FlowPrediction::Velocity);
  options.Prediction.reset();
  EXPECT_EQ(FlowMatchingTrainer(DeformedSpheres(2), options).Model().Prediction, FlowPrediction::Data);
  EXPECT_EQ(FlowMatchingTrainer(HeatOnSphere(2), options).Model().Prediction, FlowPrediction::Preconditioned);
}

TEST_F(FlowMatchingTraining, ModelsThatPredictDataSaySoAndHowTheDataDeviate)
{
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.Prediction = FlowPrediction::Data;
  const SignalDataset dataset = DeformedSpheres(3);
  const FlowMatchingModel model = FlowMatchingTrainer(dataset, options).Model();
  EXPECT_EQ(model.Prediction, FlowPrediction::Data);
  // In the units of the network: about its mean, of a surface with area 1.
  const SignalSource& source = dataset.Sources[0];
  const Eigen::VectorXd mass = LumpedMass(source.Mesh, MeshTopology(source.Mesh));
  double squares = 0.0;
  for (Eigen::Index n = 0; n < 3; ++n)
  {
    const Eigen::MatrixXd sample =
      Eigen::Map<const SignalSamples>(source.Samples.row(n).data(), source.Mesh.NumberOfPoints(), 3).cast<double>();
    const Eigen::MatrixXd moved = sample - source.Mesh.Points;
    const Eigen::RowVectorXd mean = mass.transpose() * moved / mass.sum();
    squares += (mass.transpose() * (moved.rowwise() - mean).cwiseAbs2()).sum() / (9.0 * mass.sum() * mass.sum());
  }
  EXPECT_NEAR(model.DataDeviation, std::sqrt(squares), 1e-5 * std::sqrt(squares));
}

TEST_F(FlowMatchingTraining, TheCosineScheduleRisesAndFallsToZero)
{
  FlowMatchingTrainingOptions options = TinyRecipe(400);
  options.Schedule = LearningRateSchedule::Cosine;
  options.LearningRate = 1e-3;
  const FlowMatchingTrainer trainer = TrainFlowMatching(DeformedSpheres(2), options, {});
  const LossHistory& history = trainer.History();
  EXPECT_NEAR(history.Value(0, "learning_rate"), 0.25e-3, 1e-8);
  EXPECT_NEAR(history.Value(3, "learning_rate"), 1e-3, 1e-6);
  EXPECT_NEAR(history.Value(200, "learning_rate"), 0.5e-3, 1e-9);
  EXPECT_NEAR(history.Value(399, "learning_rate"), 0.0, 1e-7);
  EXPECT_GT(history.Value(399, "learning_rate"), 0.0);
}

TEST_F(FlowMatchingTraining, ATrainingGoesOnFromTheInitialModelOnAnotherTriangulation)
{
  FlowMatchingTrainingOptions options = TinyRecipe(20);
  options.Prediction = FlowPrediction::Data;
  options.Noise.Screening = 50.0;
  const FlowMatchingModel initial = Trained(DeformedSpheres(3), options, 20).Model();
  FlowMatchingTrainingOptions next = TinyRecipe(1);
  next.Width = 2 * options.Width; // has no effect
  next.InitialModel = initial;
  const FlowMatchingTrainer begun(DeformedSpheres(2, 2), next);
  const FlowMatchingModel model = begun.Model();
  EXPECT_EQ(model.Prediction, FlowPrediction::Data);
  EXPECT_EQ(model.DataDeviation, initial.DataDeviation);
  EXPECT_EQ(model.Noise.Screening, 50.0);
  EXPECT_EQ(model.Noise.Scale, initial.Noise.Scale);
  EXPECT_EQ(model.Noise.Smoothing, initial.Noise.Smoothing);
  ASSERT_EQ(model.Velocity.Tensors.size(), initial.Velocity.Tensors.size());
  for (const auto& [name, tensor] : initial.Velocity.Tensors)
  {
    EXPECT_EQ(model.Velocity.Tensors.at(name).Values, tensor.Values) << name;
  }
  EXPECT_NE(Weights(Trained(DeformedSpheres(2, 2), next, 1)), Weights(begun));
}

TEST_F(FlowMatchingTraining, AnInitialModelKeepsTheUnitsOfItsSignal)
{
  const FlowMatchingModel initial = Trained(HeatOnSphere(3), TinyRecipe(2), 2).Model();
  SignalDataset dataset = HeatOnSphere(3);
  dataset.Sources[0].Samples.array() += 5.0F;
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.InitialModel = initial;
  const FlowMatchingModel model = Trained(dataset, options, 1).Model();
  EXPECT_EQ(model.SignalMean, initial.SignalMean);
  EXPECT_EQ(model.SignalScale, initial.SignalScale);
}

TEST_F(FlowMatchingTraining, AnInitialModelOfAnotherSignalIsRefused)
{
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.InitialModel = Trained(HeatOnSphere(2), TinyRecipe(1), 1).Model();
  const auto text = TextOf<InvalidInput>([&] { FlowMatchingTrainer(DeformedSpheres(2), options); });
  EXPECT_THAT(text, HasSubstr("the dataset has the signal \"Position\", 3 components"));
  EXPECT_THAT(text, HasSubstr("expected that of the initial model, \"Heat\", 2"));
}

TEST_F(FlowMatchingTraining, EachNoiseModelTrains)
{
  std::vector<std::map<std::string, std::vector<float>>> weights;
  for (const NoiseModel model :
    { NoiseModel::Matern, NoiseModel::PerVertex, NoiseModel::White, NoiseModel::Unscreened, NoiseModel::Spectral })
  {
    FlowMatchingTrainingOptions options = TinyRecipe(4);
    options.Noise.Model = model;
    options.Noise.Eigenpairs = 10;
    const FlowMatchingTrainer trainer = Trained(DeformedSpheres(2), options, 4);
    EXPECT_EQ(trainer.Model().Noise.Model, model);
    EXPECT_GT(trainer.Model().Noise.Scale, 0.0);
    for (const double loss : trainer.History().Column("loss"))
    {
      EXPECT_TRUE(std::isfinite(loss) && loss > 0.0) << static_cast<int>(model);
    }
    EXPECT_THAT(weights, ::testing::Not(::testing::Contains(Weights(trainer)))) << static_cast<int>(model);
    weights.push_back(Weights(trainer));
  }
}

TEST_F(FlowMatchingTraining, NoiseIsSmoothedInEdgeLengthsOfTheSurface)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const TriangleMesh& mesh = dataset.Sources.front().Mesh;
  double lengths = 0.0; // the surface has area A: in units of sqrt(A)
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      lengths += (mesh.Points.row(mesh.Triangles(f, k)) - mesh.Points.row(mesh.Triangles(f, (k + 1) % 3))).norm();
    }
  }
  const double edge = lengths / static_cast<double>(mesh.Triangles.size());
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.Noise.Smoothing = 2.0;
  const double found = FlowMatchingTrainer(dataset, options).Model().Noise.Smoothing;
  EXPECT_NEAR(found, 2.0 * edge * edge / FaceAreas(mesh).sum(), 1e-12);
  options.Noise.Smoothing = 0.0;
  EXPECT_EQ(FlowMatchingTrainer(dataset, options).Model().Noise.Smoothing, 0.0);
  options.Noise.Smoothing = ChosenSmoothing;
  EXPECT_EQ(FlowMatchingTrainer(dataset, options).Model().Noise.Smoothing, 0.0) << "of positions";
  EXPECT_GT(FlowMatchingTrainer(HeatOnSphere(3), options).Model().Noise.Smoothing, 0.0);
}

TEST_F(FlowMatchingTraining, NoiseVariesAsMuchAsTheSamplesUnlessItsScaleIsGiven)
{
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  SignalDataset dataset = HeatOnSphere(4);
  const TriangleMesh mesh = dataset.Sources[0].Mesh; // of both datasets
  const FlowMatchingModel heat = FlowMatchingTrainer(dataset, options).Model();
  Eigen::MatrixXd values = dataset.Sources[0].Samples.cast<double>();
  for (Eigen::Index column = 0; column < values.cols(); ++column)
  {
    values.col(column) /= heat.SignalScale[column % 2];
  }
  EXPECT_NEAR(NoiseSquares(heat, mesh) / MeanVariance(values), 1.0, 0.15);

  dataset = DeformedSpheres(4);
  const Eigen::VectorXd mass = LumpedMass(mesh, MeshTopology(mesh));
  values = dataset.Sources[0].Samples.cast<double>() / std::sqrt(FaceAreas(mesh).sum());
  for (int axis = 0; axis < 3; ++axis)
  {
    Eigen::MatrixXd columns = values(Eigen::all, Eigen::seq(axis, Eigen::last, 3));
    columns.colwise() -= (columns * mass / mass.sum()).eval();
    values(Eigen::all, Eigen::seq(axis, Eigen::last, 3)) = columns;
  }
  const double spread = NoiseSquares(FlowMatchingTrainer(dataset, options).Model(), mesh) / MeanVariance(values);
  EXPECT_NEAR(spread, 1.0, 0.15) << "what all samples have in common does not count";

  options.Noise.Scale = 2.5;
  EXPECT_EQ(FlowMatchingTrainer(dataset, options).Model().Noise.Scale, 2.5);
}

TEST_F(FlowMatchingTraining, NoiseVariesAsMuchAsTheSamplesInTheMeanOverSources)
{
  // White noise has a variance proportional to the number of vertices, and the second source has other samples. Smoothing
  // would have another length on both than on each alone.
  const SignalDataset coarse = DeformedSpheres(4, 1);
  SignalDataset fine = DeformedSpheres(4, 2);
  SignalSamples& samples = fine.Sources[0].Samples;
  const Eigen::RowVectorXf mean = samples.colwise().mean();
  samples = (3.0F * (samples.rowwise() - mean)).rowwise() + mean;
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.Noise.Model = NoiseModel::White;
  options.Noise.Smoothing = 0.0;
  std::vector<double> variances; // of samples
  std::vector<double> unscaled;  // of noise of scale 1
  for (const SignalDataset* one : { &coarse, static_cast<const SignalDataset*>(&fine) })
  {
    const FlowMatchingModel model = FlowMatchingTrainer(*one, options).Model();
    variances.push_back(NoiseSquares(model, one->Sources[0].Mesh));
    unscaled.push_back(variances.back() / std::pow(model.Noise.Scale, 2));
  }
  ASSERT_GT(unscaled[1], 2.0 * unscaled[0]);
  ASSERT_GT(variances[1], 3.0 * variances[0]);
  SignalDataset both = coarse;
  both.Sources.push_back(fine.Sources[0]);
  const double found = FlowMatchingTrainer(both, options).Model().Noise.Scale;
  EXPECT_NEAR(found * found * (unscaled[0] + unscaled[1]) / (variances[0] + variances[1]), 1.0, 0.15);
  std::swap(both.Sources[0], both.Sources[1]);
  EXPECT_NEAR(FlowMatchingTrainer(both, options).Model().Noise.Scale, found, 1e-9 * found) << "in another order";
}

TEST_F(FlowMatchingTraining, NoiseIsSmoothedInEdgeLengthsOfAllSources)
{
  FlowMatchingTrainingOptions options = TinyRecipe(1);
  options.Noise.Smoothing = 2.0;
  const SignalDataset coarse = DeformedSpheres(2, 1);
  const SignalDataset fine = DeformedSpheres(2, 2);
  const double ofCoarse = FlowMatchingTrainer(coarse, options).Model().Noise.Smoothing;
  const double ofFine = FlowMatchingTrainer(fine, options).Model().Noise.Smoothing;
  ASSERT_GT(ofCoarse, 3.0 * ofFine);
  SignalDataset both = fine;
  both.Sources.push_back(coarse.Sources[0]);
  const double expected = (ofCoarse + ofFine) / 2.0;
  EXPECT_NEAR(FlowMatchingTrainer(both, options).Model().Noise.Smoothing, expected, 1e-12 * expected);
}

TEST_F(FlowMatchingTraining, WeightAveragingKeepsTheModelBehindTheWeights)
{
  const SignalDataset dataset = DeformedSpheres(2);
  FlowMatchingTrainingOptions options = TinyRecipe(10);
  options.LearningRate = 1e-2;
  const auto plain = Weights(Trained(dataset, options, 10));
  const auto first = Weights(FlowMatchingTrainer(dataset, options));
  options.WeightAveraging = 0.999;
  const auto averaged = Weights(Trained(dataset, options, 10));
  double moved = 0.0;
  double movedOnAverage = 0.0;
  for (const auto& [name, values] : first)
  {
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      moved += std::pow(plain.at(name)[k] - values[k], 2);
      movedOnAverage += std::pow(averaged.at(name)[k] - values[k], 2);
    }
  }
  EXPECT_GT(movedOnAverage, 0.0);
  EXPECT_LT(movedOnAverage, moved);
}

TEST_F(FlowMatchingTraining, SeveralTriangulationsOfOneShapeNeedNoEncoderAndSeveralShapesDo)
{
  SignalDataset dataset = DeformedSpheres(2, 1);
  dataset.Sources.push_back(DeformedSpheres(3, 2).Sources[0]);
  FlowMatchingTrainingOptions options = TinyRecipe(4);
  options.SourcesPerBatch = 2;
  EXPECT_EQ(Trained(dataset, options, 4).Iteration(), 4);

  dataset.Sources[1].Mesh.Points.col(2) *= 2.0;
  const std::string text = TextOf<InvalidInput>([&] { FlowMatchingTrainer(dataset, options); });
  EXPECT_THAT(text, HasSubstr("the 2 surfaces have different shapes"));
  options.Encoder = RandomModel(TwoChannelEncoder());
  const FlowMatchingTrainer trainer = Trained(dataset, options, 2);
  EXPECT_EQ(trainer.Model().Velocity.Options.ExtraFeatures, FlowMatchingModel::PlainConditions + 2);
  EXPECT_TRUE(trainer.Model().Encoder);
}

TEST_F(FlowMatchingTraining, SeveralShapesTrainWithoutAnEncoderWhereTheRecipeSaysSo)
{
  SignalDataset dataset = DeformedSpheres(2, 1);
  dataset.Sources.push_back(DeformedSpheres(3, 2).Sources[0]);
  dataset.Sources[1].Mesh.Points.col(2) *= 2.0;
  FlowMatchingTrainingOptions options = TinyRecipe(4);
  options.WithoutEncoder = true;
  const FlowMatchingModel model = Trained(dataset, options, 4).Model();
  EXPECT_EQ(model.Velocity.Options.ExtraFeatures, FlowMatchingModel::PlainConditions);
  EXPECT_FALSE(model.Encoder);
  EXPECT_GT(model.Shape.Spread, FlowMatchingSampler::MomentTolerance);
  const FlowMatchingSampler sampler(std::make_shared<FlowMatchingModel>(model), dataset.Sources[1].Mesh);
  EXPECT_TRUE(sampler.Warnings().empty()) << "the surface is one of its training";
  FlowSampleRequest request;
  request.Steps = 2;
  EXPECT_TRUE(sampler.Integrate(sampler.InitialNoise(request), request).allFinite());
}

TEST_F(FlowMatchingTraining, TheModelIsReadAsItWasWritten)
{
  TrainFlowMatching(DeformedSpheres(2), TinyRecipe(3), this->Files("a"));
  const FlowMatchingModel model = ReadFlowMatchingModel(this->File("a.safetensors"));
  EXPECT_EQ(model.Iterations, 3);
  EXPECT_TRUE(model.GeneratesPositions());
  WriteFlowMatchingModel(this->File("again.safetensors"), model);
  EXPECT_EQ(BytesOf(this->File("again.safetensors")), BytesOf(this->File("a.safetensors")));
}

TEST_F(FlowMatchingTraining, SamplesThatDoNotVaryOrAreNotFiniteAreRefused)
{
  SignalDataset dataset = HeatOnSphere(2);
  dataset.Sources[0].Samples.setConstant(300.0F);
  EXPECT_THAT(TextOf<InvalidInput>([&] { FlowMatchingTrainer(dataset, TinyRecipe(1)); }),
    HasSubstr("component 0 of the signal is the same number everywhere"));
  dataset = DeformedSpheres(2);
  dataset.Sources[0].Samples.row(1) = dataset.Sources[0].Samples.row(0);
  EXPECT_THAT(TextOf<InvalidInput>([&] { FlowMatchingTrainer(dataset, TinyRecipe(1)); }), HasSubstr("all the same"));
  FlowMatchingTrainingOptions scaled = TinyRecipe(1);
  scaled.Noise.Scale = 1.0;
  EXPECT_EQ(Trained(dataset, scaled, 1).Iteration(), 1);
  dataset = DeformedSpheres(2);
  dataset.Sources[0].Samples(1, 5) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(TextOf<InvalidInput>([&] { FlowMatchingTrainer(dataset, TinyRecipe(1)); }), HasSubstr("not finite"));
  dataset = DeformedSpheres(2);
  dataset.Sources[0].Mesh.Triangles.row(0).setConstant(3);
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { FlowMatchingTrainer(dataset, TinyRecipe(1)); }), HasSubstr("Source 0 of the dataset: "));
}

TEST_F(FlowMatchingTraining, ALearningRateThatIsTooHighIsAnErrorAndNotAModel)
{
  FlowMatchingTrainingOptions options = TinyRecipe(50);
  options.LearningRate = 1e30;
  const std::string text = TextOf<SolverFailure>(
    [&] { TrainFlowMatching(DeformedSpheres(2), options, this->Files("a")); });
  EXPECT_THAT(text, HasSubstr("expected a lower learning rate"));
  EXPECT_FALSE(std::filesystem::exists(this->File("a.safetensors")));
}

TEST_F(FlowMatchingTraining, PreparationIsCancelledByItsProgress)
{
  EXPECT_THROW(FlowMatchingTrainer(DeformedSpheres(2), TinyRecipe(4), [](double) { return false; }), Cancelled);
  std::vector<double> reports;
  TrainFlowMatching(DeformedSpheres(2), TinyRecipe(20), {}, {}, [&](double fraction) {
    reports.push_back(fraction);
    return true;
  });
  EXPECT_GE(reports.size(), 20u);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_DOUBLE_EQ(reports.back(), 1.0);
}

TEST(FlowMatchingTrainingOptions, EachOptionOutOfItsRangeIsNamed)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  using Options = FlowMatchingTrainingOptions;
  const std::vector<std::pair<std::string, std::function<void(Options&)>>> cases = {
    { "Width is 0; expected 1 to 100000", [](Options& o) { o.Width = 0; } },
    { "Width is 100001", [](Options& o) { o.Width = 100001; } },
    { "Blocks is 0", [](Options& o) { o.Blocks = 0; } },
    { "ComplexLayers is -1", [](Options& o) { o.ComplexLayers = -1; } },
    { "Iterations is 0", [](Options& o) { o.Iterations = 0; } },
    { "BatchSize is 0", [](Options& o) { o.BatchSize = 0; } },
    { "SourcesPerBatch is 0", [](Options& o) { o.SourcesPerBatch = 0; } },
    { "SourcesPerBatch is 3; expected a number that divides BatchSize", [](Options& o) { o.SourcesPerBatch = 3; } },
    { "Iterations * BatchSize is 5e+09",
      [](Options& o) {
        o.Iterations = 50000000;
        o.BatchSize = 100;
      } },
    { "LearningRate is 0", [](Options& o) { o.LearningRate = 0.0; } },
    { "LearningRate is nan", [=](Options& o) { o.LearningRate = nan; } },
    { "LearningRateFactor is 0", [](Options& o) { o.LearningRateFactor = 0.0; } },
    { "LearningRateFactor is 1.5", [](Options& o) { o.LearningRateFactor = 1.5; } },
    { "WeightAveraging is 1; expected", [](Options& o) { o.WeightAveraging = 1.0; } },
    { "WeightAveraging is -0.1", [](Options& o) { o.WeightAveraging = -0.1; } },
    { "GradientClip is -1", [](Options& o) { o.GradientClip = -1.0; } },
    { "SourceMemory is -1; expected", [](Options& o) { o.SourceMemory = -1.0; } },
    { "WithoutEncoder is given with Encoder",
      [](Options& o) {
        o.WithoutEncoder = true;
        o.Encoder.emplace();
      } },
    { "VertexWeight is inf", [=](Options& o) { o.VertexWeight = infinity; } },
    { "JacobianWeight is -2", [](Options& o) { o.JacobianWeight = -2.0; } },
    { "VertexWeight + JacobianWeight is 0", [](Options& o) { o.VertexWeight = o.JacobianWeight = 0.0; } },
    { "Noise.Screening is 0", [](Options& o) { o.Noise.Screening = 0.0; } },
    { "Noise.Scale is nan", [=](Options& o) { o.Noise.Scale = nan; } },
    { "Noise.Smoothing is -2", [](Options& o) { o.Noise.Smoothing = -2.0; } },
    { "Noise.Eigenpairs is 0", [](Options& o) { o.Noise.Eigenpairs = 0; } },
    { "Encoder is given with InitialModel; expected none, or one with as many channels",
      [](Options& o) {
        o.InitialModel.emplace();
        o.Encoder.emplace();
      } },
    { "a milestone is -1",
      [](Options& o) {
        o.Milestones = { 3, -1 };
      } },
  };
  EXPECT_NO_THROW(CheckOptions(Options()));
  for (const auto& [expected, spoil] : cases)
  {
    Options options;
    spoil(options);
    EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr(expected));
    EXPECT_THROW(FlowMatchingTrainer(DeformedSpheres(1), options), InvalidInput) << expected;
  }
}
