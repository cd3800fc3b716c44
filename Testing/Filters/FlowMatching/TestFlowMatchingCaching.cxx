// SPDX-License-Identifier: BSD-3-Clause
//
// R5 (how often the filter executes), what an execution costs, R7 (the same bits for every number of threads), R9 and
// R10 (abort and progress), R12 (two filters on two threads).
#include "FlowMatchingPipelines.h"

#include "FilterContract.h"
#include "RandomPoissonNet.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>

using namespace surfsynth;
using namespace surfsynthtest;
using Filter = vtkFlowMatchingDeformer;

namespace
{
constexpr vtkTypeInt64 OneSample = 8; // evaluations: four midpoint steps

/// Models read, meshes factored and networks evaluated by one more update.
struct Cost
{
  vtkTypeInt64 Loads;
  vtkTypeInt64 Factorizations;
  vtkTypeInt64 Evaluations;
  bool operator==(const Cost& other) const
  {
    return this->Loads == other.Loads && this->Factorizations == other.Factorizations &&
      this->Evaluations == other.Evaluations;
  }
};

std::ostream& operator<<(std::ostream& os, const Cost& cost)
{
  return os << cost.Loads << " loads, " << cost.Factorizations << " factorisations, " << cost.Evaluations
            << " evaluations";
}

Cost TotalOf(Filter* filter)
{
  return { filter->GetNumberOfModelLoads(), filter->GetNumberOfFactorizations(), filter->GetNumberOfEvaluations() };
}

Cost CostOf(Filter* filter, const std::function<void(Filter*)>& change, double time = -1.0)
{
  change(filter);
  const Cost before = TotalOf(filter);
  EXPECT_TRUE(time < 0.0 ? Update(filter) : filter->UpdateTimeStep(time));
  const Cost after = TotalOf(filter);
  return { after.Loads - before.Loads, after.Factorizations - before.Factorizations,
    after.Evaluations - before.Evaluations };
}

void Unchanged(Filter*) {}

vtkDataArray* PointsOf(vtkAlgorithm* filter)
{
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetPoints()->GetData();
}

/// 10,000 triangles; instrumented, a fifth of them takes as long.
vtkSmartPointer<vtkPolyData> LargeSphere() { return IsSanitized() ? RingSphere(30, 30) : RingSphere(70, 70); }

/// A network of the published width on many triangles: seconds of work.
vtkSmartPointer<Filter> LargeFilter()
{
  const std::string model = WriteDeformer("large.model", 1, [](FlowMatchingModel& large) {
    PoissonNetOptions options = large.Velocity.Options;
    options.Width = 96;
    options.Blocks = 4;
    large.Velocity = surfsynth::test::RandomModel(options);
  });
  return DeformerOn(LargeSphere(), model);
}
} // namespace

TEST(FlowMatchingCaching, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), WriteDeformer("one.model"));
  ASSERT_TRUE(Update(filter));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  EXPECT_TRUE(filter->UpdateTimeStep(0.5));
  EXPECT_EQ(events.Executions, 0) << "without a trajectory, time is of no interest";
  WriteDeformer("two.model", 2);
  const PropertyChanges<Filter> changes = {
    { "ModelFileName", [](Filter* f) { f->SetModelFileName("two.model"); } },
    { "Seed", [](Filter* f) { f->SetSeed(3); } },
    { "FirstSample", [](Filter* f) { f->SetFirstSample(2); } },
    { "NumberOfSteps", [](Filter* f) { f->SetNumberOfSteps(3); } },
    { "Integrator", [](Filter* f) { f->SetIntegratorToEuler(); } },
    { "NumberOfCorrections", [](Filter* f) { f->SetNumberOfCorrections(1); } },
    { "Temperature", [](Filter* f) { f->SetTemperature(1.2); } },
    { "MovePoints", [](Filter* f) { f->MovePointsOff(); } },
    { "SignalArrayName", [](Filter* f) { f->SetSignalArrayName("A"); } },
    { "InitialNoiseArrayName", [](Filter* f) { f->SetInitialNoiseArrayName("B"); } },
    { "DisplacementArrayName", [](Filter* f) { f->SetDisplacementArrayName("C"); } },
    { "AreaRatioArrayName", [](Filter* f) { f->SetAreaRatioArrayName("D"); } },
    { "NormalizationArea", [](Filter* f) { f->SetNormalizationArea(12.0); } },
    { "NormalizationCenter", [](Filter* f) { f->SetNormalizationCenter(0.1, 0.0, 0.0); } },
    { "OutputTrajectory", [](Filter* f) { f->OutputTrajectoryOn(); } },
    { "NumberOfSamples", [](Filter* f) { f->SetNumberOfSamples(2); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
}

TEST(FlowMatchingCaching, WhatIsTheSameIsNotComputedAgain)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const auto filter = DeformerOn(sphere, WriteDeformer("kept.model"));
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 1, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetSeed(1); }), (Cost{ 0, 0, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetDisplacementArrayName("Motion"); }), (Cost{ 0, 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->MovePointsOff(); }), (Cost{ 0, 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetIntegratorToRungeKutta4(); }), (Cost{ 0, 0, 2 * OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetIntegratorToMidpoint(); }), (Cost{ 0, 0, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNumberOfCorrections(3); }), (Cost{ 0, 0, OneSample + 3 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNumberOfCorrections(0); }), (Cost{ 0, 0, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetTemperature(1.2); }), (Cost{ 0, 0, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNumberOfSamples(3); }), (Cost{ 0, 0, 2 * OneSample }))
    << "the first sample is there";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetFirstSample(1); }), (Cost{ 0, 0, OneSample })) << "and two of these";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNumberOfSamples(1); }), (Cost{ 0, 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNormalizationCenter(0.0, 0.0, 0.2); }), (Cost{ 0, 0, 0 }))
    << "the center of the sphere is its own";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNormalizationArea(15.0); }), (Cost{ 0, 1, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNormalizationCenter(0.0, 0.0, 0.1); }), (Cost{ 0, 1, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNormalizationArea(0.0); }), (Cost{ 0, 1, OneSample }));
  sphere->Modified();
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 0, 0 })) << "modified, but the same";
  sphere->GetPoints()->SetPoint(0, 0.0, 0.0, 1.1);
  sphere->GetPoints()->Modified();
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1, OneSample }));
}

TEST(FlowMatchingCaching, CorrectionsThatSuitTheModelAreNotMadeAgainByTheirNumber)
{
  const std::string model = WriteDeformer(
    "data.model", 1, [](FlowMatchingModel& made) { made.Prediction = surfsynth::FlowPrediction::Data; });
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), model);
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 1, OneSample + 2 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetNumberOfCorrections(2); }), (Cost{ 0, 0, 0 }));
}

TEST(FlowMatchingCaching, GoingThroughFlowTimeCostsNoEvaluation)
{
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), WriteDeformer("flow.model"));
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 1, OneSample }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->OutputTrajectoryOn(); }), (Cost{ 0, 0, OneSample }))
    << "the states between were not kept";
  EventRecorder events(filter);
  for (const double time : { 0.0, 0.25, 0.3, 1.0, 0.5 })
  {
    EXPECT_EQ(CostOf(filter, Unchanged, time), (Cost{ 0, 0, 0 })) << time;
  }
  EXPECT_EQ(events.Executions, 5);
  EXPECT_EQ(CostOf(filter, Unchanged, 0.5), (Cost{ 0, 0, 0 }));
  EXPECT_EQ(events.Executions, 5) << "the same time again";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->OutputTrajectoryOff(); }), (Cost{ 0, 0, 0 }));
}

TEST(FlowMatchingCaching, AnotherModelGivesItsOwnBits)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const auto filter = DeformerOn(sphere, WriteDeformer("first.model"));
  ASSERT_TRUE(Update(filter));
  const std::string second = WriteDeformer("second.model", 7);
  EXPECT_EQ(CostOf(filter, [&](Filter* f) { f->SetModelFileName(second.c_str()); }), (Cost{ 1, 1, OneSample }));
  const auto fresh = DeformerOn(sphere, second);
  ASSERT_TRUE(Update(fresh));
  EXPECT_TRUE(SameBits(PointsOf(filter), PointsOf(fresh)));
}

TEST(FlowMatchingCaching, AFileThatHasChangedIsReadAgain)
{
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), WriteDeformer("changing.model"));
  ASSERT_TRUE(Update(filter));
  const vtkSmartPointer<vtkDataArray> before = PointsOf(filter);
  WriteDeformer("changing.model", 5);
  const auto time = std::filesystem::last_write_time("changing.model");
  std::filesystem::last_write_time("changing.model", time + std::chrono::seconds(2));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 1, 1, OneSample }));
  EXPECT_FALSE(SameBits(PointsOf(filter), before));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 0, 0, 0 }));
}

TEST(FlowMatchingCaching, BlocksAreKeptOneByOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(2).ToPolyData());
  const auto filter = DeformerOn(blocks, WriteDeformer("kept_blocks.model"));
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 2, 2 * OneSample })) << "one model for all blocks";
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1, OneSample })) << "only the new block";
  blocks->SetBlock(1, nullptr);
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 0, 0 }));
}

TEST(FlowMatchingCaching, BitsDoNotDependOnThreads)
{
  const auto sphere = Icosphere(IsSanitized() ? 2 : 4).ToPolyData();
  const std::string model = WriteDeformer("threads.model");
  ExpectSameBitsForAllThreads([&] { return DeformerOn(sphere, model); }, PointsOf);
}

TEST(FlowMatchingCaching, TwoFiltersOnTwoThreadsDoNotDisturbEachOther)
{
  const std::string model = WriteDeformer("two_threads.model");
  const auto first = DeformerOn(Icosphere(3).ToPolyData(), model);
  const auto second = DeformerOn(Icosphere(2).ToPolyData(), model);
  const auto alone = DeformerOn(Icosphere(2).ToPolyData(), model);
  ExpectIndependence(first, second, alone, PointsOf);
}

TEST(FlowMatchingCaching, AbortEmptiesTheOutputAndTheNextUpdateIsComplete)
{
  for (const int samples : { 1, 2 })
  {
    for (const double place : { 0.0, 0.2, 0.7 })
    {
      const auto filter = LargeFilter();
      filter->SetNumberOfSamples(samples);
      ExpectAbort(filter, place);
      if (place > 0.5)
      {
        EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 0, OneSample })) << "what was finished survives";
        EXPECT_EQ(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT),
          samples * LargeSphere()->GetNumberOfPoints());
      }
    }
  }
}

TEST(FlowMatchingCaching, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  const auto filter = LargeFilter();
  filter->SetNumberOfSamples(2);
  ExpectSteadyProgress(filter);
}
