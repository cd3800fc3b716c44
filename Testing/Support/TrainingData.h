// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Small datasets, and recipes of networks that are trained on them in seconds.
#pragma once

#include "FileBytes.h"
#include "ThrownText.h"

#include "IO/Datasets/SignalDataset.h"
#include "Inference/PoissonNet/PoissonNetOptions.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace surfsynth::test
{

using surfsynthtest::BytesOf;
using surfsynthtest::TextOf;

/// @p samples deformations of a sphere of @p level (42 points at level 1, 162 at level 2): ellipsoids with a bump.
SignalDataset DeformedSpheres(int samples, int level = 1);

/// Two channels, smooth on the sphere and different in mean and range, called "Heat".
SignalDataset HeatOnSphere(int samples, int level = 1);

/// Two blocks of width 8, batches of 2, on the processor.
FlowMatchingTrainingOptions TinyRecipe(std::int64_t iterations);

/// The model's weights, by name.
std::map<std::string, std::vector<float>> Weights(const FlowMatchingTrainer& trainer);

/// A trainer that has done some iterations.
FlowMatchingTrainer Trained(const SignalDataset& dataset, const FlowMatchingTrainingOptions& options, int iterations);

/// An encoder of one block whose result has two channels.
PoissonNetOptions TwoChannelEncoder();

/// A folder of its own for the files of a test.
class FlowMatchingTraining : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder = std::filesystem::path("FlowMatchingTraining") /
      ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(this->Folder);
    std::filesystem::create_directories(this->Folder);
  }
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }

  TrainingFiles Files(const std::string& name) const
  {
    TrainingFiles files;
    files.Model = this->File(name + ".safetensors");
    files.Checkpoint = this->File(name + ".checkpoint");
    files.LossTable = this->File(name + ".csv");
    files.CheckpointInterval = 4;
    return files;
  }

  std::filesystem::path Folder;
};

} // namespace surfsynth::test
