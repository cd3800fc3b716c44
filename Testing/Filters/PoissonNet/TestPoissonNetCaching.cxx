// SPDX-License-Identifier: BSD-3-Clause
//
// R5 (how often the filter executes), what an execution costs, R7 (the same bits for every number of threads), R9 and
// R10 (abort and progress), R12 (two filters on two threads).
#include "PoissonNetPipelines.h"

#include "FilterContract.h"

#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

using namespace surfsynth;
using namespace surfsynthtest;
using Filter = vtkPoissonNetFilter;

namespace
{
/// Models read and meshes factored by one more update.
struct Cost
{
  vtkTypeInt64 Loads;
  vtkTypeInt64 Factorizations;
  bool operator==(const Cost& other) const
  {
    return this->Loads == other.Loads && this->Factorizations == other.Factorizations;
  }
};

std::ostream& operator<<(std::ostream& os, const Cost& cost)
{
  return os << cost.Loads << " loads, " << cost.Factorizations << " factorisations";
}

Cost CostOf(Filter* filter, const std::function<void(Filter*)>& change)
{
  change(filter);
  const Cost before{ filter->GetNumberOfModelLoads(), filter->GetNumberOfFactorizations() };
  EXPECT_TRUE(Update(filter));
  return { filter->GetNumberOfModelLoads() - before.Loads,
    filter->GetNumberOfFactorizations() - before.Factorizations };
}

vtkDataArray* PredictionOf(vtkAlgorithm* filter)
{
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetPointData()->GetArray("Prediction");
}

std::string Classifier(const std::string& name, std::uint64_t seed = 1)
{
  return WriteModel(name, SmallOptions(PoissonNetDomain::Vertices, LastActivation::LogSoftmax), seed);
}

/// A network of the published width on 10,000 triangles: seconds of work.
vtkSmartPointer<Filter> LargeFilter()
{
  PoissonNetOptions options = SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity);
  options.Width = 96;
  options.Blocks = 4;
  const auto filter = PoissonNetOn(RingSphere(70, 70), WriteModel("large.model", options));
  filter->SetInputNormalizationToSurfaceArea();
  return filter;
}
} // namespace

TEST(PoissonNetCaching, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto sphere = UnitAreaSphere(2).ToPolyData();
  vtkNew<vtkFloatArray> time;
  time->SetName("Time");
  time->SetNumberOfTuples(sphere->GetNumberOfPoints());
  time->Fill(0.5);
  sphere->GetPointData()->AddArray(time);
  const auto filter = PoissonNetOn(sphere, WriteModel("one.model", SmallGradientOptions(1)));
  filter->SetNumberOfConditions(1);
  ASSERT_TRUE(Update(filter));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  WriteModel("two.model", SmallGradientOptions(1), 2);
  const PropertyChanges<Filter> changes = {
    { "ModelFileName", [](Filter* f) { f->SetModelFileName("two.model"); } },
    { "InputNormalization", [](Filter* f) { f->SetInputNormalizationToUnitSphere(); } },
    { "Condition", [](Filter* f) { f->SetCondition(0, 0.75); } },
    { "ConditionArrayName", [](Filter* f) { f->SetConditionArrayName("Time"); } },
    { "NumberOfConditions", [](Filter* f) { f->SetNumberOfConditions(3); } },
    { "PredictionArrayName", [](Filter* f) { f->SetPredictionArrayName("A"); } },
    { "LabelArrayName", [](Filter* f) { f->SetLabelArrayName("B"); } },
    { "ClassNamesArrayName", [](Filter* f) { f->SetClassNamesArrayName("C"); } },
    { "DisplacementArrayName", [](Filter* f) { f->SetDisplacementArrayName("D"); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
}

TEST(PoissonNetCaching, ModelAndOperatorsAreKeptWhileTheyAreTheSame)
{
  const auto sphere = UnitAreaSphere(2).ToPolyData();
  const auto filter = PoissonNetOn(sphere, WriteModel("kept.model", SmallGradientOptions(1)));
  filter->SetNumberOfConditions(1);
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 1, 1 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetCondition(0, 0.5); }), (Cost{ 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetPredictionArrayName("Shape"); }), (Cost{ 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetInputNormalizationToNone(); }), (Cost{ 0, 0 }))
    << "what the model asks for";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetInputNormalizationToSurfaceArea(); }), (Cost{ 0, 1 }));
  sphere->Modified();
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 0 })) << "modified, but the same";
  sphere->GetPoints()->SetPoint(0, 0.0, 0.0, 0.3);
  sphere->GetPoints()->Modified();
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 1 }));
}

TEST(PoissonNetCaching, AnotherModelKeepsTheOperatorsAndGivesItsOwnBits)
{
  const auto sphere = UnitAreaSphere(2).ToPolyData();
  const auto filter = PoissonNetOn(sphere, Classifier("first.model"));
  ASSERT_TRUE(Update(filter));
  const std::string second = Classifier("second.model", 7);
  EXPECT_EQ(CostOf(filter, [&](Filter* f) { f->SetModelFileName(second.c_str()); }), (Cost{ 1, 0 }));
  const auto fresh = PoissonNetOn(sphere, second);
  ASSERT_TRUE(Update(fresh));
  EXPECT_TRUE(SameBits(PredictionOf(filter), PredictionOf(fresh)));
}

TEST(PoissonNetCaching, AFileThatHasChangedIsReadAgain)
{
  const auto filter = PoissonNetOn(UnitAreaSphere(2).ToPolyData(), Classifier("changing.model"));
  ASSERT_TRUE(Update(filter));
  const vtkSmartPointer<vtkDataArray> before = PredictionOf(filter);
  Classifier("changing.model", 5);
  const auto time = std::filesystem::last_write_time("changing.model");
  std::filesystem::last_write_time("changing.model", time + std::chrono::seconds(2));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 1, 0 }));
  EXPECT_FALSE(SameBits(PredictionOf(filter), before));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 0, 0 }));
}

TEST(PoissonNetCaching, BlocksAreKeptOneByOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, UnitAreaSphere(1).ToPolyData());
  blocks->SetBlock(1, UnitAreaSphere(2).ToPolyData());
  const auto filter = PoissonNetOn(blocks, Classifier("kept_blocks.model"));
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 1, 2 })) << "one model for all blocks";
  blocks->SetBlock(1, Grid(8).ToPolyData());
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 1 })) << "only the new block";
  blocks->SetBlock(1, nullptr);
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 0 }));
  blocks->SetBlock(1, Grid(8).ToPolyData());
  EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 1 })) << "a block that was gone for an update is not kept";
}

TEST(PoissonNetCaching, BitsDoNotDependOnThreads)
{
  const auto sphere = UnitAreaSphere(IsSanitized() ? 2 : 4).ToPolyData();
  const std::string model = Classifier("threads.model");
  ExpectSameBitsForAllThreads([&] { return PoissonNetOn(sphere, model); }, PredictionOf);
}

TEST(PoissonNetCaching, TwoFiltersOnTwoThreadsDoNotDisturbEachOther)
{
  const std::string model = Classifier("two_threads.model");
  const auto first = PoissonNetOn(UnitAreaSphere(3).ToPolyData(), model);
  const auto second = PoissonNetOn(Grid(20).ToPolyData(), model);
  const auto alone = PoissonNetOn(Grid(20).ToPolyData(), model);
  ExpectIndependence(first, second, alone, PredictionOf);
}

TEST(PoissonNetCaching, AbortEmptiesTheOutputAndTheNextUpdateIsComplete)
{
  for (const double place : { 0.0, 0.2, 0.6 })
  {
    const auto filter = LargeFilter();
    ExpectAbort(filter, place);
    if (place > 0.5)
    {
      EXPECT_EQ(CostOf(filter, [](Filter*) {}), (Cost{ 0, 0 })) << "model and operators survive";
      EXPECT_TRUE(PredictionOf(filter));
    }
  }
}

TEST(PoissonNetCaching, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  const auto filter = LargeFilter();
  ExpectSteadyProgress(filter);
}
