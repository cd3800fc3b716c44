// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGeometricTextureTrainer: the model of the plain training, its table, resuming, messages.
#include "FileBytes.h"
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"

#include "vtkGeometricTextureTrainer.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include <vtkDataArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkStructuredGrid.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
constexpr int Iterations = 3; // of each of two levels

/// A dented ball at two scales, and a round one as the template.
MultiscaleDataset Dents()
{
  MultiscaleDataset dataset;
  dataset.Levels.push_back(ConvertSurface(Icosphere(1).ToPolyData()).Mesh);
  dataset.Levels.push_back(SubdivideAtMidpoints(dataset.Levels[0]).Mesh);
  dataset.Template = dataset.Levels[0];
  for (TriangleMesh& level : dataset.Levels)
  {
    for (Eigen::Index v = 0; v < level.Points.rows(); ++v)
    {
      level.Points.row(v) *= 1.0 + 0.1 * std::sin(5.0 * level.Points(v, 0)) * std::cos(4.0 * level.Points(v, 1));
    }
  }
  return dataset;
}

vtkSmartPointer<vtkPolyData> PolyDataOf(const TriangleMesh& mesh)
{
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  SetGeometry(surface, mesh, true);
  return surface;
}

vtkSmartPointer<vtkMultiBlockDataSet> BlocksOf(const MultiscaleDataset& dataset)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const TriangleMesh& level : dataset.Levels)
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), PolyDataOf(level));
  }
  return blocks;
}

/// A training of a second that begins anew and writes <name>.
vtkSmartPointer<vtkGeometricTextureTrainer> TrainerFor(const std::string& name, bool hasInputs = true)
{
  std::filesystem::remove(name);
  std::filesystem::remove(name + ".checkpoint");
  auto filter = vtkSmartPointer<vtkGeometricTextureTrainer>::New();
  const MultiscaleDataset dataset = Dents();
  if (hasInputs)
  {
    filter->SetInputDataObject(0, BlocksOf(dataset));
    filter->SetInputDataObject(1, PolyDataOf(dataset.Template));
  }
  filter->SetModelFileName(name.c_str());
  filter->SetTextureName("dents");
  filter->SetObjectiveToAdversarial();
  filter->SetIterationsPerLevel(Iterations);
  filter->SetStartChannels(8);
  filter->SetMinimumChannels(4);
  filter->SetMaximumChannels(8);
  filter->SetLayers(4);
  filter->SetDeviceToCPU();
  return filter;
}

GeometricTextureTrainingOptions SameOptions()
{
  GeometricTextureTrainingOptions options;
  options.Objective = TextureObjective::Adversarial;
  options.Name = "dents";
  options.IterationsPerLevel = Iterations;
  options.Network.StartChannels = 8;
  options.Network.MinimumChannels = 4;
  options.Network.MaximumChannels = 8;
  options.Network.Layers = 4;
  options.Device = TrainingDevice::CPU;
  return options;
}

vtkTable* TableOf(vtkAlgorithm* filter) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(0)); }

std::string ErrorOfTraining(vtkGeometricTextureTrainer* filter)
{
  const std::string error = surfsynthtest::ErrorOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 0);
  return error;
}
} // namespace

TEST(GeometricTextureTrainerFilter, ModelAndTableAreThoseOfThePlainTraining)
{
  const auto filter = TrainerFor("inputs.model");
  filter->SetLossTableFileName("inputs.csv");
  OutputOf(filter);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 2 * Iterations);
  EXPECT_STREQ(filter->GetDeviceInUse(), "CPU");
  TrainingFiles files;
  files.Model = "plain.model";
  files.LossTable = "plain.csv";
  const GeometricTextureTrainer plain = TrainGeometricTexture(Dents(), SameOptions(), files);
  EXPECT_EQ(BytesOf("inputs.model"), BytesOf("plain.model"));
  EXPECT_EQ(BytesOf("inputs.csv"), BytesOf("plain.csv"));
  vtkTable* table = TableOf(filter);
  ASSERT_EQ(table->GetNumberOfRows(), 2 * Iterations);
  ASSERT_EQ(table->GetNumberOfColumns(), 7);
  for (vtkIdType k = 0; k < table->GetNumberOfRows(); ++k)
  {
    const auto expected = [&plain, k](
                            const char* column) { return plain.History().Value(static_cast<std::size_t>(k), column); };
    EXPECT_EQ(table->GetValueByName(k, "iteration").ToInt(), k + 1);
    EXPECT_EQ(table->GetValueByName(k, "level").ToInt(), k / Iterations);
    EXPECT_EQ(table->GetValueByName(k, "critic_loss").ToDouble(), expected("critic_loss"));
    EXPECT_EQ(table->GetValueByName(k, "gradient_penalty").ToDouble(), expected("gradient_penalty"));
    EXPECT_EQ(table->GetValueByName(k, "adversarial_loss").ToDouble(), expected("adversarial_loss"));
    EXPECT_EQ(table->GetValueByName(k, "reconstruction_loss").ToDouble(), expected("reconstruction_loss"));
    EXPECT_EQ(table->GetValueByName(k, "learning_rate").ToDouble(), 5e-4);
  }
}

TEST(GeometricTextureTrainerFilter, TheModelSynthesizesOnOtherSurfaces)
{
  OutputOf(TrainerFor("grows.model"));
  const auto synthesizer = SynthesizerOn(Icosphere(2).ToPolyData(), "grows.model");
  EXPECT_EQ(SurfaceOf(synthesizer)->GetNumberOfPolys(), 4 * 320);
  EXPECT_THAT(synthesizer->GetModelDescription(), HasSubstr("\"dents\": 2 levels"));
  const auto onTemplate = SynthesizerOn(nullptr, "grows.model");
  EXPECT_EQ(SurfaceOf(onTemplate)->GetNumberOfPolys(), 4 * 80);
}

TEST(GeometricTextureTrainerFilter, ADatasetFileTakesThePlaceOfTheInputs)
{
  OutputOf(TrainerFor("from_inputs.model"));
  WriteMultiscaleDataset("dents.dataset", Dents());
  const auto filter = TrainerFor("from_file.model", false);
  filter->SetDatasetFileName("dents.dataset");
  OutputOf(filter);
  EXPECT_EQ(BytesOf("from_file.model"), BytesOf("from_inputs.model"));
}

TEST(GeometricTextureTrainerFilter, WithoutATemplateItIsTheFirstLevel)
{
  const auto filter = TrainerFor("level0.model");
  filter->SetInputDataObject(1, nullptr);
  OutputOf(filter);
  MultiscaleDataset bare = Dents();
  bare.Template = {};
  TrainingFiles files;
  files.Model = "bare.model";
  TrainGeometricTexture(bare, SameOptions(), files);
  EXPECT_EQ(BytesOf("level0.model"), BytesOf("bare.model"));
}

TEST(GeometricTextureTrainerFilter, AnInterruptedTrainingGoesOn)
{
  OutputOf(TrainerFor("whole.model"));
  const auto filter = TrainerFor("parts.model");
  for (const double place : { 0.1, 0.6 })
  {
    EventRecorder events(filter);
    events.AbortAt = place;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
    EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
    EXPECT_TRUE(std::filesystem::exists("parts.model.checkpoint"));
  }
  OutputOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 2 * Iterations);
  EXPECT_EQ(BytesOf("parts.model"), BytesOf("whole.model"));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  filter->SetReconstructionWeight(4.0);
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("reconstruction_weight"));
  filter->ResumeOff();
  OutputOf(filter);
  EXPECT_NE(BytesOf("parts.model"), BytesOf("whole.model"));
}

TEST(GeometricTextureTrainerFilter, ProgressIsMonotone)
{
  const auto filter = TrainerFor("progress.model");
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
}

TEST(GeometricTextureTrainerFilter, Messages)
{
  const auto unnamed = TrainerFor("refused.model");
  unnamed->SetModelFileName("");
  EXPECT_THAT(ErrorOfTraining(unnamed), HasSubstr("ModelFileName is empty"));
  const auto nameless = TrainerFor("refused.model");
  nameless->SetTextureName("");
  EXPECT_THAT(ErrorOfTraining(nameless), HasSubstr("TextureName is empty"));
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", false)), HasSubstr("There are no levels on port 0"));
  const auto nowhere = TrainerFor("nowhere/refused.model");
  EXPECT_THAT(ErrorOfTraining(nowhere), HasSubstr("nowhere"));
  const auto missing = TrainerFor("refused.model", false);
  missing->SetDatasetFileName("none.dataset");
  EXPECT_THAT(ErrorOfTraining(missing), HasSubstr("none.dataset"));

  const auto filter = TrainerFor("refused.model");
  MultiscaleDataset swapped = Dents();
  std::swap(swapped.Levels[0], swapped.Levels[1]);
  filter->SetInputDataObject(0, BlocksOf(swapped));
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("evel 1"));
  Soup broken = Icosphere(1);
  broken.Polys[3] = { 0, 0, 1 };
  filter->SetInputDataObject(0, broken.ToPolyData());
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("Level 0"), HasSubstr("cell 3")));
  filter->SetInputDataObject(0, BlocksOf(Dents()));
  filter->SetInputDataObject(1, Icosphere(0).ToPolyData());
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("emplate"));
  vtkNew<vtkMultiBlockDataSet> grids;
  vtkNew<vtkStructuredGrid> grid;
  grids->SetBlock(0, grid);
  filter->SetInputDataObject(0, grids);
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("Level 0 is a vtkStructuredGrid"), HasSubstr("vtkPolyData")));
  EXPECT_FALSE(std::filesystem::exists("refused.model"));
}

TEST(GeometricTextureTrainerFilter, EmptyLevelsAreNoError)
{
  const auto filter = TrainerFor("empty.model");
  vtkNew<vtkMultiBlockDataSet> none;
  filter->SetInputDataObject(0, none);
  OutputOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_FALSE(std::filesystem::exists("empty.model"));
}

TEST(GeometricTextureTrainerFilter, FormerNamesOfChannelsAreThoseOfMinimumAndMaximum)
{
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  vtkNew<vtkGeometricTextureTrainer> filter;
  filter->SetLeastChannels(5);
  filter->SetMostChannels(6);
  EXPECT_EQ(filter->GetMinimumChannels(), 5);
  EXPECT_EQ(filter->GetMaximumChannels(), 6);
  EXPECT_EQ(filter->GetLeastChannels(), 5);
  EXPECT_EQ(filter->GetMostChannels(), 6);
#pragma GCC diagnostic pop
}

TEST(GeometricTextureTrainerFilter, SeveralReferencesAndNumbersOfIterationsAreThoseOfThePlainTraining)
{
  const MultiscaleDataset first = Dents();
  MultiscaleDataset second = first;
  second.Template = {};
  for (TriangleMesh& level : second.Levels)
  {
    level.Points.col(2) *= 0.5;
  }
  GeometricTextureTrainingOptions options = SameOptions();
  options.IterationsOfLevels = { 4, 2 };
  options.PenaltyInterval = 2;
  TrainingFiles files;
  files.Model = "references.plain";
  TrainGeometricTexture({ first, second }, options, files);
  const auto configured = [](const std::string& name, bool hasInputs) {
    const auto filter = TrainerFor(name, hasInputs);
    filter->SetNumberOfIterationsOfLevels(2);
    filter->SetIterationsOfLevel(0, 4);
    filter->SetIterationsOfLevel(1, 2);
    filter->SetPenaltyInterval(2);
    return filter;
  };
  const auto connected = configured("references.connected", true);
  connected->AddInputDataObject(0, BlocksOf(second));
  OutputOf(connected);
  EXPECT_EQ(connected->GetNumberOfIterationsDone(), 6);
  EXPECT_TRUE(BytesOf("references.connected") == BytesOf("references.plain"));
  WriteMultiscaleDataset("references.first", first);
  WriteMultiscaleDataset("references.second", second);
  const auto fromFiles = configured("references.files", false);
  fromFiles->SetDatasetFileName("references.first");
  fromFiles->SetNumberOfReferenceFileNames(1);
  fromFiles->SetReferenceFileName(0, "references.second");
  EXPECT_STREQ(fromFiles->GetReferenceFileName(0), "references.second");
  EXPECT_EQ(fromFiles->GetReferenceFileName(1), nullptr);
  OutputOf(fromFiles);
  EXPECT_TRUE(BytesOf("references.files") == BytesOf("references.plain"));
}

TEST(GeometricTextureTrainerFilter, ObjectivesAreThoseOfThePlainTraining)
{
  const std::pair<int, TextureObjective> objectives[] = { { vtkGeometricTextureTrainer::ADVERSARIAL,
                                                            TextureObjective::Adversarial },
    { vtkGeometricTextureTrainer::SLICED_WASSERSTEIN, TextureObjective::SlicedWasserstein },
    { vtkGeometricTextureTrainer::FLOW_MATCHING, TextureObjective::FlowMatching } };
  for (const auto& [number, objective] : objectives)
  {
    GeometricTextureTrainingOptions options = SameOptions();
    options.Objective = objective;
    options.FlowSteps = 3;
    options.BaseNoiseAmplitude = 0.2;
    options.BaseSamples = 2;
    options.Projections = 5;
    TrainingFiles files;
    files.Model = "objective.plain";
    TrainGeometricTexture({ Dents() }, options, files);
    const auto filter = TrainerFor("objective.filter", true);
    filter->SetObjective(number);
    filter->SetFlowSteps(3);
    filter->SetBaseNoiseAmplitude(0.2);
    filter->SetNumberOfBaseSamples(2);
    filter->SetNumberOfProjections(5);
    OutputOf(filter);
    EXPECT_TRUE(BytesOf("objective.filter") == BytesOf("objective.plain")) << number;
  }
  vtkNew<vtkGeometricTextureTrainer> filter;
  filter->SetObjective(3);
  EXPECT_EQ(filter->GetObjective(), vtkGeometricTextureTrainer::FLOW_MATCHING);
  filter->SetObjectiveToSlicedWasserstein();
  EXPECT_EQ(filter->GetObjective(), vtkGeometricTextureTrainer::SLICED_WASSERSTEIN);
  filter->SetFlowSteps(0);
  EXPECT_EQ(filter->GetFlowSteps(), 1);
  filter->SetBaseNoiseAmplitude(-1.0);
  EXPECT_EQ(filter->GetBaseNoiseAmplitude(), 0.0);
  filter->SetNumberOfBaseSamples(101);
  EXPECT_EQ(filter->GetNumberOfBaseSamples(), 100);
}

TEST(GeometricTextureTrainerFilter, ListsArePrintedAndKeepTheirRange)
{
  vtkNew<vtkGeometricTextureTrainer> filter;
  filter->SetNumberOfIterationsOfLevels(2);
  filter->SetIterationsOfLevel(1, 0);
  filter->SetIterationsOfLevel(2, 7);
  EXPECT_EQ(filter->GetIterationsOfLevel(0), 2000);
  EXPECT_EQ(filter->GetIterationsOfLevel(1), 1);
  EXPECT_EQ(filter->GetIterationsOfLevel(2), 0);
  filter->SetNumberOfReferenceFileNames(1);
  filter->SetReferenceFileName(0, "a.safetensors");
  filter->SetReferenceFileName(1, "b.safetensors");
  EXPECT_EQ(filter->GetNumberOfReferenceFileNames(), 1);
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("IterationsOfLevels: 2000 1\n"));
  EXPECT_THAT(text.str(), HasSubstr("ReferenceFileNames: a.safetensors\n"));
  filter->SetNumberOfReferenceFileNames(-1);
  EXPECT_EQ(filter->GetNumberOfReferenceFileNames(), 0);
}

TEST(GeometricTextureTrainerFilter, TheDatasetFileIsNeverWrittenOver)
{
  const auto filter = TrainerFor("kept.dataset", false); // removes what an earlier run left
  WriteMultiscaleDataset("kept.dataset", Dents());
  const std::string dataset = BytesOf("kept.dataset");
  filter->SetDatasetFileName("kept.dataset");
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("is one that the training is made from"));
  EXPECT_TRUE(BytesOf("kept.dataset") == dataset);
}

TEST(GeometricTextureTrainerFilter, PropertiesAreClampedAndPrinted)
{
  vtkNew<vtkGeometricTextureTrainer> filter;
  filter->SetIterationsPerLevel(0);
  EXPECT_EQ(filter->GetIterationsPerLevel(), 1);
  filter->SetLayers(2);
  EXPECT_EQ(filter->GetLayers(), 3);
  filter->SetLearningRateFactor(2.0);
  EXPECT_EQ(filter->GetLearningRateFactor(), 1.0);
  filter->SetDevice(9);
  EXPECT_EQ(filter->GetDevice(), vtkGeometricTextureTrainer::CUDA);
  const vtkMTimeType before = filter->GetMTime();
  filter->SetModelFileName(nullptr);
  filter->SetCheckpointFileName("");
  filter->SetLossTableFileName("");
  filter->SetDatasetFileName("");
  filter->SetTextureName("texture");
  EXPECT_EQ(filter->GetMTime(), before);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "ModelFileName: \n", "CheckpointFileName: \n", "LossTableFileName: \n",
         "CheckpointInterval: 500", "Resume: 1", "DatasetFileName: \n", "TextureName: texture", "Objective: 2",
         "FlowSteps: 10", "BaseNoiseAmplitude: 0.1", "NumberOfBaseSamples: 8", "NumberOfProjections: 64",
         "IterationsPerLevel: 1", "DiscriminatorSteps: 2", "GeneratorSteps: 3", "LearningRate: 0.0005",
         "LearningRateInterval: 500", "LearningRateFactor: 1", "PenaltyWeight: 0.1", "PenaltyInterval: 1",
         "ReconstructionWeight: 5", "Layers: 3", "StartChannels: 32", "MinimumChannels: 32", "MaximumChannels: 128",
         "NoiseAmplitude: 0.1", "Seed: 0", "Device: 2", "NumberOfIterationsDone: 0", "DeviceInUse: \n" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
