// SPDX-License-Identifier: BSD-3-Clause
#include "FlowMatchingTrainings.h"

#include "Inference/FlowMatching/FlowMatchingModel.h"

#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
namespace fs = std::filesystem;
/// A time series: at time 10 k the k-th sample. Can fail at one of the times.
class TimeSeries : public vtkPolyDataAlgorithm
{
public:
  static TimeSeries* New();
  vtkTypeMacro(TimeSeries, vtkPolyDataAlgorithm);

  int FailAt = -1;
  std::vector<double> Requested;

protected:
  TimeSeries() { this->SetNumberOfInputPorts(0); }

  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    std::vector<double> times;
    for (std::size_t k = 0; k < Stretches.size(); ++k)
    {
      times.push_back(10.0 * static_cast<double>(k));
    }
    const double range[2] = { times.front(), times.back() };
    vtkInformation* info = output->GetInformationObject(0);
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
    info->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
    return 1;
  }

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* info = output->GetInformationObject(0);
    const double time = info->Get(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
    this->Requested.push_back(time);
    const auto step = static_cast<int>(std::lround(time / 10.0));
    if (step == this->FailAt)
    {
      vtkErrorMacro("The series breaks off.");
      return 0;
    }
    vtkPolyData::GetData(info)->ShallowCopy(Stretched(Stretches[static_cast<std::size_t>(step)]));
    return 1;
  }
};
vtkStandardNewMacro(TimeSeries);
} // namespace

TEST_F(FlowMatchingTrainerFilter, BlocksGiveTheModelOfTheDatasetFile)
{
  const auto filter = this->OnBlocks("blocks");
  const std::string bytes = this->ModelBytes(filter);
  surfsynth::SignalDataset dataset;
  dataset.Sources = { SourceOf(Stretched(1.0), Samples()) };
  EXPECT_EQ(bytes, this->DatasetBytes(dataset, this->Tiny("dataset")));
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 5);
  EXPECT_STREQ(filter->GetDeviceInUse(), "CPU");
  EXPECT_EQ(surfsynth::ReadFlowMatchingModel(this->File("blocks")).Iterations, 5);
}

TEST_F(FlowMatchingTrainerFilter, ATimeSeriesGivesTheModelOfItsBlocks)
{
  vtkNew<TimeSeries> series;
  const auto filter = this->Tiny("series");
  filter->SetInputDataObject(0, Stretched(1.0));
  filter->SetInputConnection(1, series->GetOutputPort());
  EXPECT_EQ(this->ModelBytes(filter), this->ModelBytes(this->OnBlocks("blocks")));
  EXPECT_THAT(series->Requested, ::testing::ElementsAre(0.0, 10.0, 20.0));
  vtkInformation* output = filter->GetOutputInformation(0);
  EXPECT_FALSE(output->Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS()));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0);
}

TEST_F(FlowMatchingTrainerFilter, ASeriesMayBeItsOwnSource)
{
  vtkNew<TimeSeries> series;
  const auto filter = this->Tiny("series");
  filter->SetInputConnection(0, series->GetOutputPort());
  filter->SetInputConnection(1, series->GetOutputPort());
  const std::string bytes = this->ModelBytes(filter);
  const auto blocks = this->OnBlocks("blocks");
  blocks->SetInputDataObject(0, Stretched(Stretches[0])); // as it is at the first time
  EXPECT_EQ(bytes, this->ModelBytes(blocks));
}

TEST_F(FlowMatchingTrainerFilter, ASeriesThatBreaksOffIsAnErrorAndCanBeReadAgain)
{
  vtkNew<TimeSeries> series;
  series->FailAt = 2;
  EventRecorder upstream(series);
  const auto filter = this->Tiny("refused");
  filter->SetInputDataObject(0, Stretched(1.0));
  filter->SetInputConnection(1, series->GetOutputPort());
  this->ExpectRefusal(filter, { "samples of one of the time steps could not be made" });
  EXPECT_EQ(upstream.Errors.size(), 1u);
  series->FailAt = -1;
  series->Modified();
  EXPECT_EQ(this->ModelBytes(filter), this->ModelBytes(this->OnBlocks("blocks")));
}

TEST_F(FlowMatchingTrainerFilter, ASignalGivesTheModelOfTheDatasetFile)
{
  const auto filter = this->OnBlocks("blocks");
  filter->SetSignalArrayName("Heat");
  const std::string bytes = this->ModelBytes(filter);
  surfsynth::SignalDataset dataset;
  dataset.SignalName = "Heat";
  dataset.Sources = { SourceOf(Stretched(1.0), Samples(), "Heat") };
  EXPECT_EQ(bytes, this->DatasetBytes(dataset, this->Tiny("dataset")));
  EXPECT_EQ(surfsynth::ReadFlowMatchingModel(this->File("blocks")).Components(), 2);

  // The same samples as numbered arrays of one surface.
  auto surface = Stretched(1.0);
  for (std::size_t k = 0; k < Stretches.size(); ++k)
  {
    vtkSmartPointer<vtkDataArray> values = Samples()[k]->GetPointData()->GetArray("Heat");
    values->SetName(("Warmth_" + std::to_string(k)).c_str());
    surface->GetPointData()->AddArray(values);
  }
  const auto numbered = this->Tiny("numbered");
  numbered->SetInputDataObject(0, surface);
  numbered->SetInputDataObject(1, surface);
  numbered->SetSignalArrayName("Warmth");
  this->ModelBytes(numbered);
  const auto velocity = [this](const char* name) {
    return surfsynth::ReadFlowMatchingModel(this->File(name)).Velocity.Tensors.begin()->second.Values;
  };
  EXPECT_EQ(velocity("numbered"), velocity("blocks"));
}

TEST_F(FlowMatchingTrainerFilter, PointsThatNoPolygonUsesAreLeftOut)
{
  const auto withStray = [](double stretch) {
    auto surface = Stretched(stretch);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    surface->GetPointData()->Initialize();
    surface->GetPoints()->InsertNextPoint(nan, nan, nan);
    return surface;
  };
  Surfaces samples;
  for (const double stretch : Stretches)
  {
    samples.push_back(withStray(stretch));
  }
  const auto filter = this->Tiny("stray");
  filter->SetInputDataObject(0, withStray(1.0));
  filter->SetInputDataObject(1, Blocks(samples));
  EXPECT_EQ(this->ModelBytes(filter), this->ModelBytes(this->OnBlocks("blocks")));
}

TEST_F(FlowMatchingTrainerFilter, FloatPointsAndPolygonsTrain)
{
  const auto cut = [](int pointType, double stretch) {
    Soup soup = Grid(4, 4);
    for (std::size_t k = 0; k < soup.Points.size(); k += 3)
    {
      soup.Points[k + 2] = stretch * soup.Points[k] * soup.Points[k + 1];
    }
    return soup.ToPolyData(pointType);
  };
  for (const int pointType : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto filter = this->Tiny("quads" + std::to_string(pointType));
    filter->SetInputDataObject(0, cut(pointType, 0.0));
    filter->SetInputDataObject(1, Blocks(Surfaces{ cut(pointType, 0.5), cut(pointType, -0.3) }));
    this->ModelBytes(filter);
  }
}

TEST_F(FlowMatchingTrainerFilter, SeveralSourcesHaveABlockOfSamplesEach)
{
  const auto sphere = [](double stretch) {
    Soup soup = Icosphere(2);
    for (std::size_t k = 2; k < soup.Points.size(); k += 3)
    {
      soup.Points[k] *= stretch;
    }
    return soup.ToPolyData();
  };
  const auto filter = this->OnBlocks("several");
  filter->SetInputDataObject(0, Blocks(Surfaces{ Stretched(1.0), nullptr, sphere(1.0) }));
  const vtkSmartPointer<vtkDataObject> coarse = Blocks(Samples());
  filter->SetInputDataObject(1, Blocks(std::vector<vtkSmartPointer<vtkDataObject>>{ coarse, nullptr, sphere(1.3) }));
  const std::string bytes = this->ModelBytes(filter);
  surfsynth::SignalDataset dataset;
  dataset.Sources = { SourceOf(Stretched(1.0), Samples()), SourceOf(sphere(1.0), { sphere(1.3) }) };
  EXPECT_EQ(bytes, this->DatasetBytes(dataset, this->Tiny("dataset")));

  const auto wrong = this->Tiny("refused");
  wrong->SetInputDataObject(0, Blocks(Surfaces{ Stretched(1.0), sphere(1.0) }));
  wrong->SetInputDataObject(1, Blocks(Samples()));
  this->ExpectRefusal(wrong, { "2 sources, and samples in 3 blocks" });
}

TEST_F(FlowMatchingTrainerFilter, PositionsFarFromTheOriginKeepTheirDigits)
{
  const auto loss = [this](double offset) {
    const auto moved = [&](double stretch) {
      auto surface = Stretched(stretch);
      for (vtkIdType k = 0; k < surface->GetNumberOfPoints(); ++k)
      {
        double point[3];
        surface->GetPoint(k, point);
        surface->GetPoints()->SetPoint(k, point[0] + offset, point[1], point[2]);
      }
      return surface;
    };
    const auto filter = this->Tiny("at" + std::to_string(offset), 1);
    filter->SetInputDataObject(0, moved(1.0));
    filter->SetInputDataObject(1, Blocks(Surfaces{ moved(1.2), moved(0.7) }));
    this->ModelBytes(filter);
    return TableOf(filter)->GetValueByName(0, "loss").ToDouble();
  };
  EXPECT_NEAR(loss(1e8), loss(0.0), 1e-4 * loss(0.0)); // single precision has steps of 8 there
}

TEST_F(FlowMatchingTrainerFilter, TheTableHoldsTheLossesOfEachIteration)
{
  const auto filter = this->OnBlocks("a", 4);
  filter->SetLossTableFileName(this->File("a.csv").c_str());
  filter->SetVertexWeight(0.5);
  this->ModelBytes(filter);
  vtkTable* table = TableOf(filter);
  const std::vector<std::string> names = { "iteration", "loss", "vertex_loss", "jacobian_loss", "gradient_norm",
    "learning_rate", "loss_1", "loss_2", "loss_3", "loss_4", "loss_5", "loss_6", "loss_7", "loss_8" };
  ASSERT_EQ(table->GetNumberOfColumns(), 14);
  for (int k = 0; k < 14; ++k)
  {
    EXPECT_EQ(table->GetColumnName(k), names[static_cast<std::size_t>(k)]);
  }
  const auto value = [&](vtkIdType row, const char* name) { return table->GetValueByName(row, name).ToDouble(); };
  std::ifstream file(this->File("a.csv"));
  std::string line;
  std::getline(file, line);
  for (vtkIdType row = 0; row < 4; ++row)
  {
    EXPECT_EQ(value(row, "iteration"), static_cast<double>(row + 1));
    EXPECT_NEAR(value(row, "loss"), 0.5 * value(row, "vertex_loss") + value(row, "jacobian_loss"), 1e-12);
    ASSERT_TRUE(std::getline(file, line));
    EXPECT_THAT(line, ::testing::StartsWith(std::to_string(row + 1) + ","));
  }
}

TEST_F(FlowMatchingTrainerFilter, AnAbortedTrainingGoesOnAndGivesTheSameBits)
{
  const auto filter = this->OnBlocks("parts", 30);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.5;
    Update(filter);
    EXPECT_THAT(events.Errors, IsEmpty());
    EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 0);
    EXPECT_EQ(filter->GetNumberOfIterationsDone(), 0);
    EXPECT_TRUE(fs::exists(this->File("parts.checkpoint")));
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, IsSanitized() ? 10.0 : 1.0);
  }
  const std::int64_t done = surfsynth::ReadFlowMatchingModel(this->File("parts")).Iterations;
  EXPECT_GT(done, 5);
  EXPECT_LT(done, 25);
  filter->SetAbortExecute(0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)); // although nothing was modified
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 30);
  const auto whole = this->OnBlocks("whole", 30);
  EventRecorder wholeEvents(whole);
  EXPECT_TRUE(Update(whole));
  EXPECT_EQ(events.Progress.size() + static_cast<std::size_t>(done), wholeEvents.Progress.size()); // one each
  EXPECT_EQ(BytesOf(this->File("parts")), BytesOf(this->File("whole")));
  EXPECT_EQ(BytesOf(this->File("parts.checkpoint")), BytesOf(this->File("whole.checkpoint")));
}

TEST_F(FlowMatchingTrainerFilter, ATimeBudgetEndsUpdatesThatGoOnToTheSameBits)
{
  const auto filter = this->OnBlocks("parts", 4);
  filter->SetTimeBudget(1e-9); // of one iteration
  for (int done = 1; done <= 4; ++done)
  {
    EventRecorder events(filter);
    filter->Modified();
    EXPECT_TRUE(Update(filter));
    EXPECT_THAT(events.Errors, IsEmpty());
    EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), done);
    EXPECT_EQ(filter->GetNumberOfIterationsDone(), done);
    EXPECT_EQ(surfsynth::ReadFlowMatchingModel(this->File("parts")).Iterations, done);
    ASSERT_EQ(events.Warnings.size(), done < 4 ? 1u : 0u);
    if (done < 4)
    {
      EXPECT_THAT(
        events.Warnings[0], HasSubstr("ended the training of the model after iteration " + std::to_string(done)));
    }
  }
  EXPECT_EQ(this->ModelBytes(this->OnBlocks("whole", 4)), BytesOf(this->File("parts")));
  EXPECT_EQ(BytesOf(this->File("parts.checkpoint")), BytesOf(this->File("whole.checkpoint")));
}

namespace
{
/// Updates a training in the background until it has an end that begins with @p end.
void WaitFor(vtkFlowMatchingTrainer* filter, const std::string& end)
{
  const double limit = surfsynthtest::Now() + 100.0;
  while (std::string(filter->GetBackgroundState()).rfind("running", 0) == 0 && surfsynthtest::Now() < limit)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::StartsWith(end));
}
} // namespace

TEST_F(FlowMatchingTrainerFilter, ATrainingInTheBackgroundWritesTheSameFiles)
{
  const auto filter = this->OnBlocks("background", 6);
  filter->BackgroundOn();
  EXPECT_STREQ(filter->GetBackgroundState(), "");
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::AnyOf(HasSubstr("running: "), HasSubstr("finished: ")));
  WaitFor(filter, "finished: iteration 6 of 6");
  filter->Modified();
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 6);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 6);
  EXPECT_STREQ(filter->GetDeviceInUse(), "CPU");
  EXPECT_EQ(this->ModelBytes(this->OnBlocks("whole", 6)), BytesOf(this->File("background")));
  EXPECT_EQ(BytesOf(this->File("background.checkpoint")), BytesOf(this->File("whole.checkpoint")));
}

TEST_F(FlowMatchingTrainerFilter, ATrainingInTheBackgroundIsStoppedAndGoesOn)
{
  const auto filter = this->OnBlocks("background", 1000000);
  filter->BackgroundOn();
  EXPECT_TRUE(Update(filter));
  const double limit = surfsynthtest::Now() + 100.0;
  while (filter->GetNumberOfIterationsDone() < 3 && surfsynthtest::Now() < limit)
  {
    filter->Modified();
    EXPECT_TRUE(Update(filter));
  }
  EXPECT_GT(filter->GetRemainingTime(), 0.0);
  filter->StopBackground();
  EXPECT_THAT(filter->GetBackgroundState(), ::testing::StartsWith("stopped: iteration "));
  EXPECT_TRUE(Update(filter));
  const vtkTypeInt64 done = filter->GetNumberOfIterationsDone();
  EXPECT_EQ(surfsynth::ReadFlowMatchingModel(this->File("background")).Iterations, done);
  filter->BackgroundOff();
  filter->SetIterations(static_cast<int>(done) + 1);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), done + 1);
}

TEST_F(FlowMatchingTrainerFilter, ErrorsOfTheBackgroundAreReportedByTheNextUpdate)
{
  const auto filter = this->OnBlocks("background", 1000);
  filter->SetLearningRate(1e20);
  filter->BackgroundOn();
  EventRecorder events(filter);
  Update(filter);
  WaitFor(filter, "failed: ");
  filter->Modified();
  Update(filter);
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], HasSubstr("not finite"));
}

TEST_F(FlowMatchingTrainerFilter, TheEndOfTheFilterStopsItsBackground)
{
  {
    const auto filter = this->OnBlocks("background", 1000000);
    filter->BackgroundOn();
    EXPECT_TRUE(Update(filter));
  }
  EXPECT_TRUE(Update(this->OnBlocks("other", 1)));
}

TEST_F(FlowMatchingTrainerFilter, ATimeBudgetSaysTheTimeToExpect)
{
  const auto filter = this->OnBlocks("model", 1000000);
  filter->SetTimeBudget(0.2 / 60.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_EQ(events.Warnings.size(), 1u);
  EXPECT_THAT(events.Warnings[0], HasSubstr("of 1000000. The other iterations take about "));
  EXPECT_GT(filter->GetNumberOfIterationsDone(), 1);
  EXPECT_GT(filter->GetRemainingTime(), 0.0);
  EXPECT_LT(filter->GetRemainingTime(), IsSanitized() ? 1e6 : 1e5);
  filter->SetIterations(static_cast<int>(filter->GetNumberOfIterationsDone()));
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Warnings.size(), 1u);
  EXPECT_EQ(filter->GetRemainingTime(), 0.0);
}

TEST_F(FlowMatchingTrainerFilter, AnAbortWhileTheSeriesIsReadStops)
{
  vtkNew<TimeSeries> series;
  const auto filter = this->Tiny("refused");
  filter->SetInputDataObject(0, Stretched(1.0));
  filter->SetInputConnection(1, series->GetOutputPort());
  EventRecorder events(filter);
  events.AbortAt = 0.01;
  Update(filter);
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_THAT(series->Requested, ::testing::ElementsAre(0.0));
  EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 0);
}

TEST_F(FlowMatchingTrainerFilter, RunsAgainOnlyAfterAChange)
{
  const auto filter = this->OnBlocks("a");
  this->ModelBytes(filter);
  EventRecorder events(filter);
  filter->SetIterations(5);
  filter->SetModelFileName(this->File("a").c_str());
  filter->SetNumberOfMilestones(0);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0);
  filter->SetIterations(7);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 1);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 7);
  filter->SetSeed(1); // another recipe: the checkpoint is not this one's
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], HasSubstr("seed = 0; expected 1"));
  filter->ResumeOff();
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 7);
}

TEST_F(FlowMatchingTrainerFilter, EmptyInputsGiveAnEmptyTableAndNoFile)
{
  const auto filter = this->Tiny("none");
  filter->SetInputDataObject(0, vtkSmartPointer<vtkPolyData>::New());
  filter->SetInputDataObject(1, vtkSmartPointer<vtkMultiBlockDataSet>::New());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_TRUE(fs::is_empty(this->Folder));
}

TEST_F(FlowMatchingTrainerFilter, TheInputsAreNotModified)
{
  const auto source = Stretched(1.0);
  const auto samples = Blocks(Samples());
  const auto filter = this->Tiny("a");
  filter->SetInputDataObject(0, source);
  filter->SetInputDataObject(1, samples);
  const std::uint64_t before[] = { HashOf(source), HashOf(samples) };
  this->ModelBytes(filter);
  EXPECT_EQ(HashOf(source), before[0]);
  EXPECT_EQ(HashOf(samples), before[1]);
}
