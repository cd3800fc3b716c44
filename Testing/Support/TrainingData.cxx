// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingData.h"

#include "ExampleMeshes.h"

#include "Inference/FlowMatching/FlowMatchingModel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

namespace surfsynth::test
{

SignalDataset DeformedSpheres(int samples, int level)
{
  SignalDataset dataset;
  SignalSource& source = dataset.Sources.emplace_back();
  source.Mesh = Icosphere(level);
  source.Samples.resize(samples, source.Mesh.Points.size());
  for (int n = 0; n < samples; ++n)
  {
    const double stretch = 1.0 + 0.5 * Uniform(7, static_cast<std::uint64_t>(n));
    for (Eigen::Index v = 0; v < source.Mesh.Points.rows(); ++v)
    {
      const Eigen::RowVector3d point = source.Mesh.Points.row(v);
      const double bump = 1.0 + 0.4 * std::exp(-4.0 * (point - Eigen::RowVector3d(0.0, 1.0, 0.0)).squaredNorm());
      source.Samples.row(n).segment(
        3 * v, 3) = (bump * point.cwiseProduct(Eigen::RowVector3d(1.0, 1.0, 1.0 + stretch))).cast<float>();
    }
  }
  return dataset;
}

SignalDataset HeatOnSphere(int samples, int level)
{
  SignalDataset dataset;
  dataset.SignalName = "Heat";
  SignalSource& source = dataset.Sources.emplace_back();
  source.Mesh = Icosphere(level);
  const Eigen::Index vertices = source.Mesh.Points.rows();
  source.Samples.resize(samples, 2 * vertices);
  for (int n = 0; n < samples; ++n)
  {
    const double shift = 0.3 * Uniform(8, static_cast<std::uint64_t>(n));
    for (Eigen::Index v = 0; v < vertices; ++v)
    {
      const Eigen::RowVector3d point = source.Mesh.Points.row(v);
      source.Samples(n, 2 * v) = static_cast<float>(300.0 + 20.0 * (point[0] + shift));
      source.Samples(n, 2 * v + 1) = static_cast<float>(0.1 * (point[1] * point[2] - shift));
    }
  }
  return dataset;
}

FlowMatchingTrainingOptions TinyRecipe(std::int64_t iterations)
{
  FlowMatchingTrainingOptions options;
  options.Prediction = FlowPrediction::Velocity;
  options.Noise.Smoothing = 1.0;
  options.Optimizer = TrainingOptimizer::Adam;
  options.LearningRate = 5e-4;
  options.Schedule = LearningRateSchedule::Milestones;
  options.WeightAveraging = 0.0;
  options.Width = 8;
  options.Blocks = 2;
  options.ComplexLayers = 2;
  options.Iterations = iterations;
  options.InnerProducts = true; // all parts of the network
  options.BatchSize = 2;
  options.Device = TrainingDevice::CPU;
  return options;
}

std::map<std::string, std::vector<float>> Weights(const FlowMatchingTrainer& trainer)
{
  std::map<std::string, std::vector<float>> weights;
  for (const auto& [name, tensor] : trainer.Model().Velocity.Tensors)
  {
    weights[name] = tensor.Values;
  }
  return weights;
}

FlowMatchingTrainer Trained(const SignalDataset& dataset, const FlowMatchingTrainingOptions& options, int iterations)
{
  FlowMatchingTrainer trainer(dataset, options);
  for (int k = 0; k < iterations; ++k)
  {
    trainer.Step();
  }
  return trainer;
}

PoissonNetOptions TwoChannelEncoder()
{
  PoissonNetOptions encoder;
  encoder.Width = 8;
  encoder.Blocks = 1;
  encoder.OutputChannels = 2;
  encoder.Head = PoissonNetHead::Linear;
  return encoder;
}

} // namespace surfsynth::test
