// SPDX-License-Identifier: BSD-3-Clause
// The encoding of many surfaces, and flow matching models that use it.
#include "ExampleMeshes.h"
#include "TrainingData.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{

/// An ellipsoid with half axes 1, b and c.
TriangleMesh Ellipsoid(double b, double c)
{
  TriangleMesh mesh = test::IrregularSphere(1);
  mesh.Points.col(1) *= b;
  mesh.Points.col(2) *= c;
  return mesh;
}

/// Two ellipsoids of the same triangles, each with three others as samples.
SignalDataset Ellipsoids()
{
  SignalDataset dataset;
  for (int k = 0; k < 2; ++k)
  {
    SignalSource source;
    source.Mesh = Ellipsoid(1.4, 1.8 + 0.2 * k);
    source.Samples.resize(3, source.Mesh.Points.size());
    for (int n = 0; n < 3; ++n)
    {
      const PointMatrix points = Ellipsoid(1.3 + 0.1 * n, 1.7 + 0.1 * k).Points;
      source.Samples.row(n) = Eigen::Map<const Eigen::RowVectorXd>(points.data(), points.size()).cast<float>();
    }
    dataset.Sources.push_back(source);
  }
  return dataset;
}

EncodingTrainingOptions SmallEncoding()
{
  EncodingTrainingOptions options;
  options.Eigenfunctions = 3;
  options.Width = 12;
  options.Blocks = 1;
  options.ComplexLayers = 2;
  options.BatchSize = 2;
  options.Iterations = 150;
  options.LearningRate = 1e-2;
  options.Device = TrainingDevice::CPU;
  return options;
}

TEST(EncodingTrainer, LearnsTheEigenfunctionsOfTheReference)
{
  EncodingTrainer trainer(Ellipsoids(), SmallEncoding());
  double first = 0.0;
  double last = 0.0;
  for (int k = 0; k < 150; ++k)
  {
    trainer.Step();
    const double loss = trainer.History().Last();
    (k < 10 ? first : last) += k < 10 || k >= 140 ? loss / 10.0 : 0.0;
  }
  // The eigenfunctions have mean square 1: a loss of 1 is that of a prediction of 0.
  EXPECT_GT(first, 0.5);
  EXPECT_LT(last, 0.1);

  // On an ellipsoid of other proportions and triangles the first one follows the longest axis too.
  TriangleMesh unseen = test::IrregularSphere(2);
  unseen.Points.col(1) *= 1.35;
  unseen.Points.col(2) *= 1.85;
  const FeatureMatrix values = EvaluatePoissonNet(trainer.Model(), unseen).Values;
  const Eigen::VectorXd z = unseen.Points.col(2).array() - unseen.Points.col(2).mean();
  const Eigen::VectorXd phi = values.col(0).cast<double>().array() - values.col(0).cast<double>().mean();
  EXPECT_GT(std::abs(z.dot(phi)) / (z.norm() * phi.norm()), 0.95);
}

/// Error of the first eigenfunction, up to its sign, on the surface that is split in all edges.
double ErrorOnFiner(const PoissonNetModel& model, const PoissonNetModel& teacher, const TriangleMesh& mesh)
{
  const TriangleMesh fine = SubdivideAtMidpoints(mesh).Mesh;
  const Eigen::VectorXf wanted = EvaluatePoissonNet(teacher, mesh).Values.col(0);
  return (EvaluatePoissonNet(model, fine).Values.col(0).head(wanted.size()) - wanted).norm() / wanted.norm();
}

TEST(EncodingTrainer, WithEdgeSplitsItLearnsNoTriangulationByHeart)
{
  EncodingTrainingOptions options = SmallEncoding();
  EncodingTrainer same(Ellipsoids(), options);
  options.EdgeSplits = 1.0;
  EncodingTrainer split(Ellipsoids(), options);
  for (int k = 0; k < 150; ++k)
  {
    same.Step();
    split.Step();
  }
  EXPECT_LT(split.History().Last(), 0.15);
  const TriangleMesh mesh = Ellipsoid(1.4, 1.8);
  EXPECT_LT(ErrorOnFiner(split.Model(), split.Model(), mesh), ErrorOnFiner(same.Model(), same.Model(), mesh));
  options.EdgeSplits = 1.5;
  EXPECT_THROW(CheckOptions(options), InvalidInput);
}

TEST(EncodingTrainer, GoesOnFromACheckpointAsIfItHadNotStopped)
{
  EncodingTrainingOptions options = SmallEncoding();
  options.EdgeSplits = 0.5;
  EncodingTrainer whole(Ellipsoids(), options);
  EncodingTrainer first(Ellipsoids(), options);
  for (int k = 0; k < 4; ++k)
  {
    whole.Step();
    if (k < 2)
    {
      first.Step();
    }
  }
  first.SaveCheckpoint("encoding.checkpoint");
  EncodingTrainer second(Ellipsoids(), options);
  second.LoadCheckpoint("encoding.checkpoint");
  EXPECT_EQ(second.Iteration(), 2);
  second.Step();
  second.Step();
  const PoissonNetModel expected = whole.Model();
  const PoissonNetModel found = second.Model();
  for (const auto& [name, tensor] : expected.Tensors)
  {
    EXPECT_EQ(found.Tensors.at(name).Values, tensor.Values) << name;
  }
  std::remove("encoding.checkpoint");
}

TEST(EncodingTrainer, RefusesSurfacesThatDoNotCorrespond)
{
  const auto refusal = [](const SignalDataset& dataset) {
    return test::TextOf<InvalidInput>([&] { EncodingTrainer(dataset, SmallEncoding()); });
  };
  SignalDataset dataset = Ellipsoids();
  dataset.Sources[1].Mesh.Triangles.row(0).swap(dataset.Sources[1].Mesh.Triangles.row(1));
  EXPECT_THAT(refusal(dataset), HasSubstr("source 1 has other triangles than source 0"));

  dataset = Ellipsoids(); // the same triangles, and one vertex more that none of them uses
  SignalSource& source = dataset.Sources[1];
  const Eigen::Index vertices = source.Mesh.Points.rows();
  source.Mesh.Points.conservativeResize(vertices + 1, Eigen::NoChange);
  source.Mesh.Points.row(vertices).setZero();
  source.Samples = SignalSamples::Zero(1, 3 * (vertices + 1));
  EXPECT_THAT(refusal(dataset), HasSubstr("source 1 has " + std::to_string(vertices + 1) + " vertices"));
}

TEST(EncodingTrainer, RefusesSourcesAndSamplesThatAreNoSurfaces)
{
  SignalDataset dataset = Ellipsoids();
  dataset.Sources[1].Mesh.Points.setZero();
  EXPECT_THAT(test::TextOf<InvalidInput>([&] { EncodingTrainer(dataset, SmallEncoding()); }),
    HasSubstr("Source 1 of the dataset: "));

  dataset = Ellipsoids();
  for (SignalSource& source : dataset.Sources)
  {
    source.Samples.setZero();
  }
  EncodingTrainer trainer(dataset, SmallEncoding());
  const std::string text = test::TextOf<InvalidInput>([&] {
    for (int k = 0; k < 150; ++k)
    {
      trainer.Step();
    }
  });
  EXPECT_THAT(text, HasSubstr(" is no surface to learn from: "));
}

TEST(EncodingTrainer, SamplesThatAreNoPositionsAreNoSurfaces)
{
  SignalDataset heat = Ellipsoids();
  heat.SignalName = "Heat";
  EncodingTrainer onHeat(heat, SmallEncoding());
  SignalDataset sources = Ellipsoids();
  for (SignalSource& source : sources.Sources)
  {
    for (Eigen::Index n = 0; n < source.Samples.rows(); ++n)
    {
      source.Samples.row(
        n) = Eigen::Map<const Eigen::RowVectorXd>(source.Mesh.Points.data(), source.Mesh.Points.size()).cast<float>();
    }
  }
  EncodingTrainer onSources(sources, SmallEncoding());
  for (int k = 0; k < 3; ++k)
  {
    onHeat.Step();
    onSources.Step();
    EXPECT_NEAR(onHeat.History().Last(), onSources.History().Last(), 1e-5); // samples were in single precision
  }
}

TEST(EncodingTrainer, RefusesTooManyEigenfunctions)
{
  EncodingTrainingOptions options = SmallEncoding();
  options.Eigenfunctions = Ellipsoids().Sources[0].Mesh.NumberOfPoints();
  EXPECT_THAT(test::TextOf<InvalidInput>([&] { EncodingTrainer(Ellipsoids(), options); }), HasSubstr("more vertices"));
}

TEST(EncodingTrainer, ItsEncoderIsTheConditionOfAModelForManySurfaces)
{
  EncodingTrainer encoding(Ellipsoids(), SmallEncoding());
  encoding.Step();
  FlowMatchingTrainingOptions options;
  options.Encoder = encoding.Model();
  options.Prediction = FlowPrediction::Velocity; // which an untrained network's output is not small beside
  options.Width = 8;
  options.Blocks = 1;
  options.ComplexLayers = 2;
  options.BatchSize = 4;
  options.SourcesPerBatch = 2;
  options.Iterations = 3;
  options.Device = TrainingDevice::CPU;
  FlowMatchingTrainer trainer(Ellipsoids(), options);
  trainer.Step();
  WriteFlowMatchingModel("many.safetensors", trainer.Model());
  const auto model = std::make_shared<const FlowMatchingModel>(ReadFlowMatchingModel("many.safetensors"));
  ASSERT_TRUE(model->Encoder.has_value());
  EXPECT_EQ(model->Velocity.Options.ExtraFeatures, 7);
  EXPECT_GT(model->Shape.Spread, 0.0);

  // Samples on an unseen surface, which depend on the encoding.
  const TriangleMesh unseen = Ellipsoid(1.35, 1.9);
  const auto sample = [&unseen](const std::shared_ptr<const FlowMatchingModel>& used) {
    const FlowMatchingSampler sampler(used, unseen);
    EXPECT_TRUE(sampler.Warnings().empty());
    FlowSampleRequest request;
    request.Steps = 2;
    return sampler.ToSignal(sampler.Integrate(sampler.InitialNoise(request), request));
  };
  const Eigen::MatrixXd found = sample(model);
  EXPECT_TRUE(found.allFinite());
  FlowMatchingModel other = *model;
  for (float& weight : other.Encoder->Tensors.at("head.bias").Values)
  {
    weight += 1.0F;
  }
  EXPECT_GT((sample(std::make_shared<const FlowMatchingModel>(other)) - found).norm(), 1e-4 * found.norm());

  // A training that goes on may replace it by another with as many channels.
  FlowMatchingTrainingOptions further = options;
  further.InitialModel = *model;
  further.Encoder = other.Encoder;
  EXPECT_EQ(FlowMatchingTrainer(Ellipsoids(), further).Model().Encoder->Tensors.at("head.bias").Values,
    other.Encoder->Tensors.at("head.bias").Values);
  further.Encoder->Options.OutputChannels = 2;
  try
  {
    FlowMatchingTrainer(Ellipsoids(), further);
    FAIL() << "accepted";
  }
  catch (const InvalidInput& error)
  {
    EXPECT_THAT(error.what(), HasSubstr("as many channels as the encoder of that model"));
  }
  std::remove("many.safetensors");
}

} // namespace
