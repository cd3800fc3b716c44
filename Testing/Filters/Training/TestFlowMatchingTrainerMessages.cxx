// SPDX-License-Identifier: BSD-3-Clause
//
// vtkFlowMatchingTrainer: what it says of mistakes, what it makes of malformed input, its properties.
#include "FlowMatchingTrainings.h"
#include "MalformedCorpus.h"

#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <vtkCallbackCommand.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;

namespace
{
using Spoil = std::function<void(vtkFlowMatchingTrainer*)>;
/// Changes that make a training invalid, each with parts of the message.
using Mistakes = std::vector<std::pair<Spoil, std::vector<std::string>>>;

class TrainingOnMalformedInput
  : public FlowMatchingTrainerFilter
  , public ::testing::WithParamInterface<MalformedCase>
{
protected:
  /// R1, R2, R3 and R6 for one malformed case as the given inputs.
  void Check(vtkDataObject* source, vtkDataObject* samples) const
  {
    const auto filter = this->Tiny("model", 2);
    filter->ResumeOff();
    filter->SetInputDataObject(0, source);
    filter->SetInputDataObject(1, samples);
    const std::uint64_t before = HashOf(source) ^ HashOf(samples);
    EventRecorder events(filter);
    const double start = Now();
    const bool updated = Update(filter);
    EXPECT_LT(Now() - start, CaseTimeLimit()) << "R1";
    EXPECT_EQ(HashOf(source) ^ HashOf(samples), before) << "R6";
    EXPECT_EQ(updated, events.Errors.empty()) << events.AllErrors();
    // One of the filter; the executive has one for each port that is given what is no surface.
    EXPECT_LE(std::count_if(events.Errors.begin(), events.Errors.end(),
                [](const std::string& text) { return text.find("vtkFlowMatchingTrainer (") != std::string::npos; }),
      1)
      << events.AllErrors();
    vtkTable* table = TableOf(filter);
    EXPECT_EQ(table->GetNumberOfRows() > 0, filter->GetNumberOfIterationsDone() > 0);
    for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
    {
      EXPECT_TRUE(std::isfinite(table->GetValueByName(row, "loss").ToDouble())) << "R2";
    }
    if (GetParam().Expected == Expectation::Empty && source == samples)
    {
      EXPECT_TRUE(updated) << "R3";
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Corpus, TrainingOnMalformedInput, ::testing::ValuesIn(MalformedCorpus()),
  [](const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; });
} // namespace

TEST_P(TrainingOnMalformedInput, IsFiniteOrAnError)
{
  const auto malformed = GetParam().Make();
  this->Check(malformed, malformed);
  this->Check(malformed, Blocks(Samples()));
  this->Check(Stretched(1.0), malformed);
}

TEST_F(FlowMatchingTrainerFilter, EachMistakeInTheInputsIsOneErrorThatNamesIt)
{
  const auto samples = [](const Surfaces& surfaces) -> Spoil {
    return [surfaces](vtkFlowMatchingTrainer* f) { f->SetInputDataObject(1, Blocks(surfaces)); };
  };
  auto coarse = Icosphere(0).ToPolyData();
  auto nan = Stretched(1.1);
  nan->GetPoints()->SetPoint(7, 0.0, std::nan(""), 0.0);
  auto huge = Stretched(1.1);
  huge->GetPoints()->SetPoint(3, 1e300, 0.0, 0.0);
  auto turned = Stretched(1.1);
  turned->ReverseCell(0);
  auto torn = Stretched(1.0);
  torn->GetPoints()->SetPoint(2, std::nan(""), 0.0, 0.0);
  auto other = Stretched(1.1);
  vtkNew<vtkFloatArray> heat;
  heat->SetName("Heat");
  heat->SetNumberOfTuples(other->GetNumberOfPoints());
  heat->FillValue(1.0F);
  other->GetPointData()->AddArray(heat);
  const Mistakes mistakes = {
    { [](auto* f) { f->SetInputDataObject(0, nullptr); }, { "There is no source", "DatasetFileName" } },
    { [](auto* f) { f->SetInputDataObject(1, nullptr); }, { "There is no dataset of samples on port 1" } },
    { [](auto* f) { f->SetInputDataObject(0, vtkSmartPointer<vtkPolyData>::New()); }, { "The source is empty" } },
    { samples({}), { "There is no sample of the source" } },
    { samples({ Stretched(1.1), coarse }), { "training sample 1 (Block 2) has 12 points", "the source has 42" } },
    { samples({ nan }), { "training sample 0 (Block 1) is not finite in single precision at point 7" } },
    { samples({ huge }), { "not finite in single precision at point 3" } },
    { samples({ turned }), { "has other polygons or strips than the source" } },
    { [&](auto* f) { f->SetInputDataObject(0, torn); }, { "the source: ", "1 point(s) with a NaN", "first point 2" } },
    { [](auto* f) { f->SetSignalArrayName("Cold"); },
      { "Block 1 of the training ensemble", "\"Cold\"", "name an array that all surfaces have" } },
    { [&](auto* f) {
       f->SetSignalArrayName("Heat");
       f->SetInputDataObject(1, Blocks(Surfaces{ Stretched(1.1), other }));
     },
      { "training sample 1 (Block 2) has 1 components and the first sample has 2" } },
    { [&](auto* f) {
       f->SetSignalArrayName("Heat");
       f->SetInputDataObject(1, other);
     },
      { "component 0 of the signal is the same number everywhere" } },
    { [](auto* f) {
       vtkNew<vtkStructuredGrid> grid;
       grid->SetPoints(Stretched(1.0)->GetPoints());
       f->SetInputDataObject(1, Blocks(std::vector<vtkSmartPointer<vtkDataObject>>{ grid.Get() }));
     },
      { "is a vtkStructuredGrid where a vtkPolyData is needed" } },
  };
  for (const auto& [spoil, parts] : mistakes)
  {
    const auto filter = this->OnBlocks("refused");
    spoil(filter);
    this->ExpectRefusal(filter, parts);
  }
}

TEST_F(FlowMatchingTrainerFilter, EachMistakeInThePropertiesIsOneErrorThatNamesIt)
{
  const std::string damaged = this->File("damaged");
  std::ofstream(damaged) << "no dataset";
  const Mistakes mistakes = {
    { [](auto* f) { f->SetModelFileName(""); }, { "ModelFileName is empty" } },
    { [](auto* f) { f->SetSourcesPerBatch(3); }, { "SourcesPerBatch is 3; expected a number that divides BatchSize" } },
    { [](auto* f) { f->SetLearningRate(std::nan("")); }, { "LearningRate is nan" } },
    { [](auto* f) { f->SetLearningRate(1e300); }, { "LearningRate is 1e+300" } },
    { [](auto* f) {
       f->SetNumberOfMilestones(1);
       f->SetMilestone(0, -4);
     },
      { "a milestone is -4" } },
    { [&](auto* f) { f->SetDatasetFileName(damaged.c_str()); }, { damaged } },
    { [&](auto* f) { f->SetDatasetFileName(this->File("absent").c_str()); }, { "absent" } },
    { [&](auto* f) { f->SetEncoderFileName(this->File("absent").c_str()); }, { "absent", "EncoderFileName" } },
    { [&](auto* f) { f->SetInitialModelFileName(this->File("absent").c_str()); },
      { "absent", "InitialModelFileName" } },
    { [&](auto* f) { f->SetModelFileName(this->File("absent/model").c_str()); }, { "the file of the model" } },
    { [&](auto* f) { f->SetCheckpointFileName(damaged.c_str()); }, { damaged } },
  };
  for (const auto& [spoil, parts] : mistakes)
  {
    const auto filter = this->OnBlocks("refused");
    spoil(filter);
    this->ExpectRefusal(filter, parts);
  }
}

TEST_F(FlowMatchingTrainerFilter, TheTimeToExpectIsAMessage)
{
  const auto filter = this->OnBlocks("long");
  filter->SetIterations(100000000);
  std::string message;
  vtkNew<vtkCallbackCommand> observer;
  observer->SetClientData(&message);
  observer->SetCallback([](vtkObject* sender, unsigned long, void* text, void* data) {
    static_cast<std::string*>(text)->append(static_cast<const char*>(data));
    vtkAlgorithm::SafeDownCast(sender)->SetAbortExecute(1);
  });
  filter->AddObserver(vtkCommand::MessageEvent, observer);
  Update(filter);
  EXPECT_THAT(message, ::testing::ContainsRegex("^The other [0-9]+ of 100000000 iterations take about [0-9:]+\\.$"));
}

TEST_F(FlowMatchingTrainerFilter, CudaWithoutADeviceIsAnError)
{
  const auto filter = this->OnBlocks("device");
  filter->SetDeviceToCUDA();
  EventRecorder events(filter);
  if (Update(filter))
  {
    EXPECT_STREQ(filter->GetDeviceInUse(), "CUDA");
    return;
  }
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], HasSubstr("the device is CUDA and LibTorch finds none"));
}

TEST_F(FlowMatchingTrainerFilter, DefaultsAreThoseOfTheLibrary)
{
  vtkNew<vtkFlowMatchingTrainer> filter;
  const surfsynth::FlowMatchingTrainingOptions options;
  const surfsynth::TrainingFiles files;
  EXPECT_EQ(filter->GetEncoderIterations(), 0);
  EXPECT_EQ(filter->GetNumberOfEigenfunctions(), surfsynth::EncodingTrainingOptions().Eigenfunctions);
  EXPECT_EQ(filter->GetEncoderEdgeSplits(), surfsynth::EncodingTrainingOptions().EdgeSplits);
  EXPECT_EQ(filter->GetWidth(), options.Width);
  EXPECT_EQ(filter->GetBlocks(), options.Blocks);
  EXPECT_EQ(filter->GetComplexLayers(), options.ComplexLayers);
  EXPECT_EQ(filter->GetInnerProducts(), options.InnerProducts);
  EXPECT_EQ(filter->GetPrediction(), vtkFlowMatchingTrainer::AUTOMATIC);
  EXPECT_FALSE(options.Prediction);
  EXPECT_EQ(filter->GetOptimizer(), static_cast<int>(options.Optimizer));
  EXPECT_EQ(filter->GetLearningRateSchedule(), static_cast<int>(options.Schedule));
  EXPECT_EQ(filter->GetNoiseModel(), static_cast<int>(options.Noise.Model));
  EXPECT_EQ(filter->GetScreening(), options.Noise.Screening);
  EXPECT_EQ(filter->GetNoiseSmoothing(), options.Noise.Smoothing);
  EXPECT_EQ(filter->GetNoiseScale(), options.Noise.Scale);
  EXPECT_EQ(filter->GetNumberOfEigenpairs(), options.Noise.Eigenpairs);
  EXPECT_EQ(filter->GetIterations(), options.Iterations);
  EXPECT_EQ(filter->GetBatchSize(), options.BatchSize);
  EXPECT_EQ(filter->GetSourcesPerBatch(), options.SourcesPerBatch);
  EXPECT_EQ(filter->GetSourceMemory(), options.SourceMemory);
  EXPECT_EQ(filter->GetWithoutEncoder(), options.WithoutEncoder);
  EXPECT_EQ(filter->GetLearningRate(), options.LearningRate);
  EXPECT_EQ(filter->GetNumberOfMilestones(), static_cast<int>(options.Milestones.size()));
  EXPECT_EQ(filter->GetLearningRateFactor(), options.LearningRateFactor);
  EXPECT_EQ(filter->GetGradientClip(), options.GradientClip);
  EXPECT_EQ(filter->GetVertexWeight(), options.VertexWeight);
  EXPECT_EQ(filter->GetJacobianWeight(), options.JacobianWeight);
  EXPECT_EQ(filter->GetWeightAveraging(), options.WeightAveraging);
  EXPECT_EQ(filter->GetSeed(), static_cast<int>(options.Seed));
  EXPECT_EQ(filter->GetDevice(), static_cast<int>(options.Device));
  EXPECT_EQ(filter->GetCheckpointInterval(), files.CheckpointInterval);
  EXPECT_EQ(filter->GetResume(), files.Resume);
  EXPECT_EQ(filter->GetTimeBudget(), files.TimeBudget);
}

TEST_F(FlowMatchingTrainerFilter, PropertiesAreClampedToTheirRanges)
{
  vtkNew<vtkFlowMatchingTrainer> filter;
  filter->SetWidth(0);
  filter->SetEncoderIterations(-1);
  filter->SetNumberOfEigenfunctions(0);
  filter->SetEncoderEdgeSplits(1.5);
  filter->SetNoiseModel(9);
  filter->SetDevice(-1);
  filter->SetLearningRateFactor(2.0);
  filter->SetWeightAveraging(1.0);
  filter->SetCheckpointInterval(0);
  filter->SetNumberOfMilestones(2);
  filter->SetMilestone(1, 30);
  filter->SetMilestone(2, 40);
  filter->SetSourceMemory(-1.0);
  EXPECT_EQ(filter->GetSourceMemory(), 0.0);
  EXPECT_EQ(filter->GetWidth(), 1);
  EXPECT_EQ(filter->GetEncoderIterations(), 0);
  EXPECT_EQ(filter->GetNumberOfEigenfunctions(), 1);
  EXPECT_EQ(filter->GetEncoderEdgeSplits(), 1.0);
  EXPECT_EQ(filter->GetNoiseModel(), vtkFlowMatchingTrainer::SPECTRAL);
  EXPECT_EQ(filter->GetDevice(), vtkFlowMatchingTrainer::AUTO);
  EXPECT_EQ(filter->GetLearningRateFactor(), 1.0);
  EXPECT_LT(filter->GetWeightAveraging(), 1.0);
  EXPECT_EQ(filter->GetCheckpointInterval(), 1);
  EXPECT_EQ(filter->GetMilestone(0), 0);
  EXPECT_EQ(filter->GetMilestone(1), 30);
  EXPECT_EQ(filter->GetMilestone(2), 0);
}

TEST_F(FlowMatchingTrainerFilter, PrintsAllProperties)
{
  vtkNew<vtkFlowMatchingTrainer> filter;
  filter->SetNumberOfMilestones(2);
  std::ostringstream stream;
  filter->Print(stream);
  for (const char* name : { "ModelFileName: ", "CheckpointFileName: ", "LossTableFileName: ", "CheckpointInterval: 500",
         "Resume: 1", "TimeBudget: 0", "Background: 0", "BackgroundState: ", "RemainingTime: 0", "DatasetFileName: ",
         "SignalArrayName: ", "EncoderFileName: ", "InitialModelFileName: ", "EncoderIterations: 0",
         "EncoderEdgeSplits: 0", "NumberOfEigenfunctions: 64", "EncoderLoss: -1", "Width: 64", "Blocks: 4",
         "ComplexLayers: 3", "InnerProducts: 0", "Prediction: -1", "Optimizer: 1", "LearningRateSchedule: 1",
         "NoiseModel: 0", "Screening: 100", "NoiseSmoothing: -1", "NoiseScale: 0", "NumberOfEigenpairs: 256",
         "Iterations: 3000", "BatchSize: 32", "SourcesPerBatch: 1", "SourceMemory: 8192", "WithoutEncoder: 0",
         "LearningRate: 0.02", "Milestones: 0 0", "LearningRateFactor: 0.2", "GradientClip: 1", "VertexWeight: 1",
         "JacobianWeight: 1", "WeightAveraging: 0.99", "Seed: 0", "Device: 0", "NumberOfIterationsDone: 0",
         "DeviceInUse: " })
  {
    EXPECT_THAT(stream.str(), HasSubstr(name));
  }
}
