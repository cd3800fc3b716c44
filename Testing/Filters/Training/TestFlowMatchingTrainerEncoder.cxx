// SPDX-License-Identifier: BSD-3-Clause
//
// vtkFlowMatchingTrainer on many surfaces: the positional encoding that it trains before the model.
#include "FlowMatchingTrainings.h"

#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
namespace fs = std::filesystem;

/// Two bodies that correspond and differ in shape.
vtkSmartPointer<vtkMultiBlockDataSet> Bodies() { return Blocks(Surfaces{ Stretched(1.0), nullptr, Stretched(2.0) }); }

/// The samples of each body.
std::vector<Surfaces> Poses() { return { Samples(), { Stretched(1.8), Stretched(2.3) } }; }

vtkSmartPointer<vtkMultiBlockDataSet> BlocksOfPoses()
{
  const std::vector<Surfaces> poses = Poses();
  return Blocks(std::vector<vtkSmartPointer<vtkDataObject>>{ Blocks(poses[0]), Blocks(poses[1]) });
}

surfsynth::SignalDataset DatasetOfBodies()
{
  surfsynth::SignalDataset dataset;
  dataset.Sources = { SourceOf(Stretched(1.0), Poses()[0]), SourceOf(Stretched(2.0), Poses()[1]) };
  return dataset;
}

class FlowMatchingTrainerEncoder : public FlowMatchingTrainerFilter
{
protected:
  /// Trains an encoder in four iterations, and a model in five.
  vtkSmartPointer<vtkFlowMatchingTrainer> OnBodies(const std::string& name) const
  {
    auto filter = this->Tiny(name);
    filter->SetInputDataObject(0, Bodies());
    filter->SetInputDataObject(1, BlocksOfPoses());
    filter->SetEncoderIterations(4);
    filter->SetNumberOfEigenfunctions(3);
    return filter;
  }

  /// The files that a training leaves, but for the table of losses.
  std::vector<std::string> FilesOf(const std::string& name) const
  {
    std::vector<std::string> contents;
    for (const char* kind : { "", ".checkpoint", ".encoder", ".encoder.checkpoint" })
    {
      contents.push_back(BytesOf(this->File(name + kind)));
    }
    return contents;
  }

  std::ptrdiff_t LinesOf(const std::string& name) const
  {
    std::ifstream file(this->File(name));
    return std::count(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>(), '\n');
  }
};

template <typename Options>
void MakeTiny(Options& options)
{
  options.Width = 8;
  options.Blocks = 2;
  options.ComplexLayers = 2;
  options.BatchSize = 2;
  options.Device = surfsynth::TrainingDevice::CPU;
}
} // namespace

TEST_F(FlowMatchingTrainerEncoder, ATimeBudgetEndsTheTrainingOfTheEncoderFirst)
{
  const auto filter = this->OnBodies("parts");
  filter->SetTimeBudget(1e-9); // of one iteration
  for (int update = 1; update <= 8;
       ++update) // four of the encoder; its last goes on with the first of five of the model
  {
    EventRecorder events(filter);
    filter->Modified();
    EXPECT_TRUE(Update(filter));
    EXPECT_THAT(events.Errors, ::testing::IsEmpty());
    EXPECT_EQ(filter->GetNumberOfIterationsDone(), std::max(0, update - 3));
    ASSERT_EQ(events.Warnings.size(), update < 8 ? 1u : 0u);
    if (update < 8)
    {
      EXPECT_THAT(
        events.Warnings[0], ::testing::HasSubstr(update < 4 ? "training of the encoder" : "training of the model"));
    }
  }
  this->ModelBytes(this->OnBodies("whole"));
  EXPECT_TRUE(this->FilesOf("parts") == this->FilesOf("whole"));
}

TEST_F(FlowMatchingTrainerEncoder, OneUpdateGivesTheFilesOfTheTwoTrainingsOfTheLibrary)
{
  const auto filter = this->OnBodies("model");
  const std::string model = this->ModelBytes(filter);

  surfsynth::EncodingTrainingOptions encoding;
  MakeTiny(encoding);
  encoding.Iterations = 4;
  encoding.Eigenfunctions = 3;
  surfsynth::TrainingFiles files;
  files.Model = this->File("expected.encoder");
  const surfsynth::EncodingTrainer encoder = TrainEncoding(DatasetOfBodies(), encoding, files);
  EXPECT_TRUE(BytesOf(this->File("model.encoder")) == BytesOf(files.Model));
  EXPECT_EQ(filter->GetEncoderLoss(), encoder.History().Last());
  EXPECT_GT(filter->GetEncoderLoss(), 0.0);

  surfsynth::FlowMatchingTrainingOptions options;
  MakeTiny(options);
  options.Iterations = 5;
  options.Encoder = surfsynth::ReadPoissonNet(files.Model);
  files.Model = this->File("expected");
  TrainFlowMatching(DatasetOfBodies(), options, files);
  EXPECT_TRUE(model == BytesOf(files.Model));
  EXPECT_EQ(surfsynth::ReadFlowMatchingModel(this->File("model")).Encoder->Options.OutputChannels, 3);
}

TEST_F(FlowMatchingTrainerEncoder, TheEncoderThatWasWrittenServesOtherModels)
{
  const auto first = this->OnBodies("first");
  first->SetEncoderFileName(this->File("encoder").c_str());
  const std::string model = this->ModelBytes(first);
  EXPECT_FALSE(fs::exists(this->File("first.encoder")));
  const auto second = this->OnBodies("second");
  second->SetEncoderFileName(this->File("encoder").c_str());
  second->SetEncoderIterations(0);
  EXPECT_TRUE(this->ModelBytes(second) == model);
  EXPECT_EQ(second->GetEncoderLoss(), -1.0);
}

TEST_F(FlowMatchingTrainerEncoder, AnAbortInEitherTrainingCanBeGoneOnFrom)
{
  this->ModelBytes(this->OnBodies("whole"));
  const std::vector<std::string> whole = this->FilesOf("whole");
  for (const double abortAt : { 0.25, 0.75 })
  {
    const std::string name = "parts" + std::to_string(abortAt);
    const auto filter = this->OnBodies(name);
    {
      EventRecorder events(filter);
      events.AbortAt = abortAt;
      Update(filter);
      EXPECT_THAT(events.Errors, IsEmpty());
      EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 0);
    }
    EXPECT_TRUE(fs::exists(this->File(name + ".encoder.checkpoint")));
    EXPECT_EQ(fs::exists(this->File(name)), abortAt > 0.5) << abortAt;
    filter->SetAbortExecute(0);
    EXPECT_TRUE(Update(filter));
    EXPECT_TRUE(this->FilesOf(name) == whole) << abortAt;
  }
}

TEST_F(FlowMatchingTrainerEncoder, TheCheckpointsAloneGiveTheFilesAgain)
{
  const auto filter = this->OnBodies("model");
  this->ModelBytes(filter);
  const std::vector<std::string> files = this->FilesOf("model");
  const double loss = filter->GetEncoderLoss();
  fs::remove(this->File("model"));
  fs::remove(this->File("model.encoder"));
  filter->Modified();
  this->ModelBytes(filter);
  EXPECT_TRUE(this->FilesOf("model") == files);
  EXPECT_EQ(filter->GetEncoderLoss(), loss);

  filter->SetSeed(1); // another recipe: both checkpoints are not this one's
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], HasSubstr("model.encoder.checkpoint"));
  EXPECT_THAT(events.Errors[0], HasSubstr("seed = 0; expected 1"));
  filter->ResumeOff();
  EXPECT_TRUE(Update(filter));
  EXPECT_FALSE(this->FilesOf("model") == files);
}

TEST_F(FlowMatchingTrainerEncoder, AnEncoderThatAModelWasBegunWithIsNotTrainedOn)
{
  const auto filter = this->OnBodies("model");
  this->ModelBytes(filter);
  const std::vector<std::string> files = this->FilesOf("model");
  filter->SetEncoderIterations(6);
  {
    EventRecorder events(filter);
    EXPECT_FALSE(Update(filter));
    ASSERT_EQ(events.Errors.size(), 1u);
    EXPECT_THAT(events.Errors[0], HasSubstr("model.checkpoint"));
    EXPECT_THAT(events.Errors[0], HasSubstr("an encoder of 4 iterations; expected the 6 of EncoderIterations"));
  }
  EXPECT_TRUE(this->FilesOf("model") == files);

  filter->SetCheckpointFileName(this->File("another.checkpoint").c_str());
  this->ModelBytes(filter);
  const std::vector<std::string> longer = this->FilesOf("model");
  EXPECT_FALSE(longer[0] == files[0]);
  EXPECT_FALSE(longer[2] == files[2]) << "the encoder was trained on";
}

TEST_F(FlowMatchingTrainerEncoder, BothTrainingsHaveATableOfLosses)
{
  const auto filter = this->OnBodies("model");
  filter->SetLossTableFileName(this->File("model.csv").c_str());
  this->ModelBytes(filter);
  EXPECT_EQ(this->LinesOf("model.csv"), 6);
  EXPECT_EQ(this->LinesOf("model.encoder.csv"), 5);
}

TEST_F(FlowMatchingTrainerEncoder, SignalsAreLearntOnManySurfacesToo)
{
  const auto filter = this->OnBodies("heat");
  filter->SetSignalArrayName("Heat");
  this->ModelBytes(filter);
  const surfsynth::FlowMatchingModel model = surfsynth::ReadFlowMatchingModel(this->File("heat"));
  EXPECT_EQ(model.Components(), 2);
  EXPECT_TRUE(model.Encoder.has_value());
}

TEST_F(FlowMatchingTrainerEncoder, WithoutEncoderTheSameSurfacesAreTrainedOnWithinAnyMemory)
{
  const auto filter = this->OnBodies("plain");
  filter->SetEncoderIterations(0);
  filter->WithoutEncoderOn();
  const std::string bytes = this->ModelBytes(filter);
  EXPECT_FALSE(surfsynth::ReadFlowMatchingModel(this->File("plain")).Encoder);
  const auto limited = this->OnBodies("limited");
  limited->SetEncoderIterations(0);
  limited->WithoutEncoderOn();
  limited->SetSourceMemory(0.0);
  EXPECT_EQ(this->ModelBytes(limited), bytes);
}

TEST_F(FlowMatchingTrainerEncoder, EachMistakeIsOneErrorBeforeAnythingIsTrained)
{
  auto other = Stretched(2.0);
  other->ReverseCell(0);
  for (vtkIdType cell = 1; cell < other->GetNumberOfCells(); ++cell)
  {
    other->ReverseCell(cell); // all of them: sound, and other polygons than the first
  }
  surfsynth::WriteSignalDataset(this->File("data"), DatasetOfBodies());
  const std::string data = BytesOf(this->File("data"));
  using Spoil = std::function<void(vtkFlowMatchingTrainer*)>;
  const std::vector<std::pair<Spoil, std::vector<std::string>>> mistakes = {
    { [](auto* f) { f->SetEncoderIterations(0); }, { "the 2 surfaces have different shapes", "EncoderIterations" } },
    { [](auto* f) {
       f->SetInputDataObject(0, Stretched(1.0));
       f->SetInputDataObject(1, Blocks(Samples()));
     },
      { "EncoderIterations is 4 and there is one source" } },
    { [&](auto* f) {
       f->SetInputDataObject(0, Blocks(Surfaces{ Stretched(1.0), other }));
       f->SetInputDataObject(1, Blocks(Surfaces{ Stretched(1.2), other }));
     },
      { "source 1 has other triangles than source 0", "vertices correspond" } },
    { [](auto* f) {
       f->SetInputDataObject(0, Blocks(Surfaces{ Stretched(1.0), Icosphere(2).ToPolyData() }));
       f->SetInputDataObject(1, Blocks(Surfaces{ Stretched(1.2), Icosphere(2).ToPolyData() }));
     },
      { "source 1 has 162 vertices and 320 triangles, and source 0 has 42 and 80" } },
    { [](auto* f) { f->SetNumberOfEigenfunctions(41); }, { "41 eigenfunctions on 42 vertices" } },
    { [&](auto* f) { f->SetEncoderFileName(this->File("absent/encoder").c_str()); }, { "absent/encoder" } },
    { [&](auto* f) { f->SetEncoderFileName(this->File("refused").c_str()); },
      { "the file of the model", "is one that the training is made from" } },
    { [&](auto* f) { f->SetCheckpointFileName(this->File("refused.encoder").c_str()); }, { "file of the checkpoint" } },
    { [&](auto* f) {
       f->SetDatasetFileName(this->File("data").c_str());
       f->SetEncoderFileName(this->File("data").c_str());
     },
      { "the file of the model", "data", "is one that the training is made from" } },
    { [](auto* f) { f->SetSourcesPerBatch(3); }, { "SourcesPerBatch is 3" } },
    { [](auto* f) { f->WithoutEncoderOn(); }, { "EncoderIterations is 4 and WithoutEncoder is on" } },
    { [&](auto* f) { f->SetLossTableFileName(this->File("absent/a.csv").c_str()); }, { "loss table" } },
  };
  for (const auto& [spoil, parts] : mistakes)
  {
    const auto filter = this->OnBodies("refused");
    spoil(filter);
    this->ExpectRefusal(filter, parts);
    EXPECT_EQ(filter->GetEncoderLoss(), -1.0);
    EXPECT_FALSE(fs::exists(this->File("refused.encoder"))) << ::testing::PrintToString(parts);
  }
  EXPECT_EQ(BytesOf(this->File("data")), data);
}
