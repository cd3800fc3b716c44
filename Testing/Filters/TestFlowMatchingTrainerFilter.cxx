// SPDX-License-Identifier: BSD-3-Clause
#include "MalformedCorpus.h"
#include "TestSurfaces.h"

#include "vtkFlowMatchingTrainer.h"

#include "IO/Mesh/SignalDataset.h"
#include "Learning/Models/FlowMatchingModel.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTable.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
namespace fs = std::filesystem;
using Surfaces = std::vector<vtkSmartPointer<vtkPolyData>>;

/// A sphere stretched along z, with the point array Heat of two components.
vtkSmartPointer<vtkPolyData> Stretched(double stretch, int pointType = VTK_DOUBLE)
{
  Soup soup = Icosphere(1);
  for (std::size_t k = 2; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] *= stretch;
  }
  auto surface = soup.ToPolyData(pointType);
  vtkNew<vtkFloatArray> heat;
  heat->SetName("Heat");
  heat->SetNumberOfComponents(2);
  for (vtkIdType k = 0; k < surface->GetNumberOfPoints(); ++k)
  {
    const double* point = surface->GetPoint(k);
    heat->InsertNextTuple2(20.0 + point[0] * stretch, point[2]);
  }
  surface->GetPointData()->AddArray(heat);
  return surface;
}

const std::vector<double> Stretches = { 1.2, 1.5, 0.7 };

Surfaces Samples()
{
  Surfaces samples;
  for (const double stretch : Stretches)
  {
    samples.push_back(Stretched(stretch));
  }
  return samples;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const std::vector<vtkSmartPointer<vtkDataObject>>& leaves)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const auto& leaf : leaves)
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), leaf);
  }
  return blocks;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const Surfaces& surfaces)
{
  return Blocks(std::vector<vtkSmartPointer<vtkDataObject>>(surfaces.begin(), surfaces.end()));
}

/// What a dataset file of these surfaces of triangles holds; @p array "" for the positions.
surfsynth::SignalSource SourceOf(vtkPolyData* surface, const Surfaces& samples, const char* array = "")
{
  surfsynth::SignalSource source;
  const vtkIdType points = surface->GetNumberOfPoints();
  source.Mesh.Points.resize(points, 3);
  for (vtkIdType k = 0; k < points; ++k)
  {
    surface->GetPoint(k, source.Mesh.Points.row(k).data());
  }
  source.Mesh.Triangles.resize(surface->GetNumberOfCells(), 3);
  for (vtkIdType f = 0; f < surface->GetNumberOfCells(); ++f)
  {
    vtkNew<vtkIdList> ids;
    surface->GetCellPoints(f, ids);
    for (int c = 0; c < 3; ++c)
    {
      source.Mesh.Triangles(f, c) = static_cast<surfsynth::Index>(ids->GetId(c));
    }
  }
  for (std::size_t n = 0; n < samples.size(); ++n)
  {
    vtkDataArray* values =
      array[0] ? samples[n]->GetPointData()->GetArray(array) : samples[n]->GetPoints()->GetData();
    const int components = values->GetNumberOfComponents();
    source.Samples.conservativeResize(static_cast<Eigen::Index>(n) + 1, points * components);
    for (vtkIdType k = 0; k < points * components; ++k)
    {
      source.Samples(static_cast<Eigen::Index>(n), k) =
        static_cast<float>(values->GetComponent(k / components, static_cast<int>(k % components)));
    }
  }
  return source;
}

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

std::string BytesOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return { std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>() };
}

vtkTable* TableOf(vtkAlgorithm* filter) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(0)); }

/// A folder of its own for the files of a test.
class FlowMatchingTrainerFilter : public ::testing::Test
{
protected:
  void SetUp() override
  {
    std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '_');
    this->Folder = fs::path("FlowMatchingTrainerFilter") / name;
    fs::remove_all(this->Folder);
    fs::create_directories(this->Folder);
  }
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }

  /// A training of seconds that writes <name>.
  vtkSmartPointer<vtkFlowMatchingTrainer> Tiny(const std::string& name, int iterations = 5) const
  {
    auto filter = vtkSmartPointer<vtkFlowMatchingTrainer>::New();
    filter->SetModelFileName(this->File(name).c_str());
    filter->SetIterations(iterations);
    filter->SetWidth(8);
    filter->SetBlocks(2);
    filter->SetComplexLayers(2);
    filter->SetBatchSize(2);
    filter->SetDeviceToCPU();
    return filter;
  }

  vtkSmartPointer<vtkFlowMatchingTrainer> OnBlocks(const std::string& name, int iterations = 5) const
  {
    auto filter = this->Tiny(name, iterations);
    filter->SetInputDataObject(0, Stretched(1.0));
    filter->SetInputDataObject(1, Blocks(Samples()));
    return filter;
  }

  /// The bytes of the model that a filter writes.
  std::string ModelBytes(vtkFlowMatchingTrainer* filter) const
  {
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter)) << events.AllErrors();
    EXPECT_THAT(events.Errors, IsEmpty());
    EXPECT_EQ(events.Executions, 1);
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_FALSE(events.ForeignThread);
    EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), filter->GetIterations());
    return BytesOf(filter->GetModelFileName());
  }

  /// The bytes of the model that is trained on a dataset file with the recipe of @p like.
  std::string DatasetBytes(
    const surfsynth::SignalDataset& dataset, const vtkSmartPointer<vtkFlowMatchingTrainer>& filter) const
  {
    surfsynth::WriteSignalDataset(this->File("dataset.safetensors"), dataset);
    filter->SetDatasetFileName(this->File("dataset.safetensors").c_str());
    return this->ModelBytes(filter);
  }

  void ExpectRefusal(vtkFlowMatchingTrainer* filter, const std::vector<std::string>& parts) const
  {
    EventRecorder events(filter);
    EXPECT_FALSE(Update(filter));
    ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors() << ::testing::PrintToString(parts);
    for (const std::string& part : parts)
    {
      EXPECT_THAT(events.Errors[0], HasSubstr(part));
    }
    EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 0);
    EXPECT_EQ(filter->GetNumberOfIterationsDone(), 0);
    EXPECT_FALSE(fs::exists(this->File("refused")));
  }

  fs::path Folder;
};

class TrainingOnMalformedInput : public FlowMatchingTrainerFilter, public ::testing::WithParamInterface<MalformedCase>
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
}

TEST_P(TrainingOnMalformedInput, IsFiniteOrAnError)
{
  const auto malformed = GetParam().Make();
  this->Check(malformed, malformed);
  this->Check(malformed, Blocks(Samples()));
  this->Check(Stretched(1.0), malformed);
}

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
  const auto velocity = [this](const char* name)
  { return surfsynth::ReadFlowMatchingModel(this->File(name)).Velocity.Tensors.begin()->second.Values; };
  EXPECT_EQ(velocity("numbered"), velocity("blocks"));
}

TEST_F(FlowMatchingTrainerFilter, PointsThatNoPolygonUsesAreLeftOut)
{
  const auto withStray = [](double stretch)
  {
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
  const auto cut = [](int pointType, double stretch)
  {
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
  const auto sphere = [](double stretch)
  {
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
  const auto loss = [this](double offset)
  {
    const auto moved = [&](double stretch)
    {
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
    "learning_rate" };
  ASSERT_EQ(table->GetNumberOfColumns(), 6);
  for (int k = 0; k < 6; ++k)
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

TEST_F(FlowMatchingTrainerFilter, EachMistakeIsOneErrorThatNamesIt)
{
  using Spoil = std::function<void(vtkFlowMatchingTrainer*)>;
  const auto samples = [](const Surfaces& surfaces) -> Spoil
  { return [surfaces](vtkFlowMatchingTrainer* f) { f->SetInputDataObject(1, Blocks(surfaces)); }; };
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
  const std::string damaged = this->File("damaged");
  std::ofstream(damaged) << "no dataset";
  const std::vector<std::pair<Spoil, std::vector<std::string>>> cases = {
    { [](auto* f) { f->SetInputDataObject(0, nullptr); }, { "There is no source", "DatasetFileName" } },
    { [](auto* f) { f->SetInputDataObject(1, nullptr); }, { "There is no dataset of samples on port 1" } },
    { [](auto* f) { f->SetModelFileName(""); }, { "ModelFileName is empty" } },
    { [](auto* f) { f->SetInputDataObject(0, vtkSmartPointer<vtkPolyData>::New()); }, { "The source is empty" } },
    { samples({}), { "There is no sample of the source" } },
    { samples({ Stretched(1.1), coarse }), { "training sample 1 (Block 2) has 12 points", "the source has 42" } },
    { samples({ nan }), { "training sample 0 (Block 1) is not finite in single precision at point 7" } },
    { samples({ huge }), { "not finite in single precision at point 3" } },
    { samples({ turned }), { "has other polygons or strips than the source" } },
    { [&](auto* f) { f->SetInputDataObject(0, torn); }, { "the source: ", "1 point(s) with a NaN", "first point 2" } },
    { [](auto* f) { f->SetSignalArrayName("Cold"); }, { "Block 1 of the training ensemble", "\"Cold\"" } },
    { [&](auto* f)
      {
        f->SetSignalArrayName("Heat");
        f->SetInputDataObject(1, Blocks(Surfaces{ Stretched(1.1), other }));
      },
      { "training sample 1 (Block 2) has 1 components and the first sample has 2" } },
    { [&](auto* f)
      {
        f->SetSignalArrayName("Heat");
        f->SetInputDataObject(1, other);
      },
      { "component 0 of the signal is the same number everywhere" } },
    { [](auto* f)
      {
        vtkNew<vtkUnstructuredGrid> grid;
        grid->SetPoints(Stretched(1.0)->GetPoints());
        f->SetInputDataObject(1, Blocks(std::vector<vtkSmartPointer<vtkDataObject>>{ grid.Get() }));
      },
      { "is a vtkUnstructuredGrid where a vtkPolyData is needed" } },
    { [](auto* f) { f->SetSourcesPerBatch(3); }, { "SourcesPerBatch is 3; expected a number that divides BatchSize" } },
    { [](auto* f) { f->SetLearningRate(std::nan("")); }, { "LearningRate is nan" } },
    { [](auto* f)
      {
        f->SetNumberOfMilestones(1);
        f->SetMilestone(0, -4);
      },
      { "a milestone is -4" } },
    { [&](auto* f) { f->SetDatasetFileName(damaged.c_str()); }, { damaged } },
    { [&](auto* f) { f->SetDatasetFileName(this->File("absent").c_str()); }, { "absent" } },
    { [&](auto* f) { f->SetEncoderFileName(this->File("absent").c_str()); }, { "absent", "EncoderFileName" } },
    { [&](auto* f) { f->SetModelFileName(this->File("absent/model").c_str()); }, { "the file of the model" } },
    { [&](auto* f) { f->SetCheckpointFileName(damaged.c_str()); }, { damaged } },
  };
  for (const auto& [spoil, parts] : cases)
  {
    const auto filter = this->OnBlocks("refused");
    spoil(filter);
    this->ExpectRefusal(filter, parts);
  }
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
  EXPECT_EQ(filter->GetWidth(), options.Width);
  EXPECT_EQ(filter->GetBlocks(), options.Blocks);
  EXPECT_EQ(filter->GetComplexLayers(), options.ComplexLayers);
  EXPECT_EQ(filter->GetInnerProducts(), options.InnerProducts);
  EXPECT_EQ(filter->GetNoiseModel(), static_cast<int>(options.Noise.Model));
  EXPECT_EQ(filter->GetScreening(), options.Noise.Screening);
  EXPECT_EQ(filter->GetNoiseScale(), options.Noise.Scale);
  EXPECT_EQ(filter->GetNumberOfEigenpairs(), options.Noise.Eigenpairs);
  EXPECT_EQ(filter->GetIterations(), options.Iterations);
  EXPECT_EQ(filter->GetBatchSize(), options.BatchSize);
  EXPECT_EQ(filter->GetSourcesPerBatch(), options.SourcesPerBatch);
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
}

TEST_F(FlowMatchingTrainerFilter, PropertiesAreClampedToTheirRanges)
{
  vtkNew<vtkFlowMatchingTrainer> filter;
  filter->SetWidth(0);
  filter->SetNoiseModel(9);
  filter->SetDevice(-1);
  filter->SetLearningRateFactor(2.0);
  filter->SetWeightAveraging(1.0);
  filter->SetCheckpointInterval(0);
  filter->SetNumberOfMilestones(2);
  filter->SetMilestone(1, 30);
  filter->SetMilestone(2, 40);
  EXPECT_EQ(filter->GetWidth(), 1);
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
         "Resume: 1", "DatasetFileName: ", "SignalArrayName: ", "EncoderFileName: ", "Width: 64", "Blocks: 4",
         "ComplexLayers: 3", "InnerProducts: 1", "NoiseModel: 0", "Screening: 100", "NoiseScale: 0",
         "NumberOfEigenpairs: 256", "Iterations: 20000", "BatchSize: 8", "SourcesPerBatch: 1", "LearningRate: 0.0005",
         "Milestones: 0 0", "LearningRateFactor: 0.2", "GradientClip: 1", "VertexWeight: 1", "JacobianWeight: 1",
         "WeightAveraging: 0", "Seed: 0", "Device: 0", "NumberOfIterationsDone: 0", "DeviceInUse: " })
  {
    EXPECT_THAT(stream.str(), HasSubstr(name));
  }
}
