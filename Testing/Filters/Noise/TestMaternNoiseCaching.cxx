// SPDX-License-Identifier: BSD-3-Clause
//
// R5 (how often the filter executes) and what an execution costs.
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <functional>
#include <utility>

using namespace surfsynthtest;
using Noise = vtkMaternNoiseFilter;

namespace
{
/// Factorisations of one more update after @p change.
int CostOf(Noise* filter, const std::function<void(Noise*)>& change)
{
  change(filter);
  const vtkTypeInt64 before = filter->GetNumberOfFactorizations();
  EXPECT_TRUE(Update(filter));
  return static_cast<int>(filter->GetNumberOfFactorizations() - before);
}

vtkSmartPointer<Noise> FilterOn(vtkDataObject* input)
{
  auto filter = vtkSmartPointer<Noise>::New();
  filter->SetInputDataObject(input);
  filter->SetCorrelationRange(1.0);
  EXPECT_TRUE(Update(filter));
  EXPECT_GE(filter->GetNumberOfFactorizations(), 1);
  return filter;
}
} // namespace

TEST(MaternNoiseCaching, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto filter = FilterOn(Icosphere(2).ToPolyData());
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  const PropertyChanges<Noise> changes = {
    { "NoiseModel", [](Noise* f) { f->SetNoiseModelToPerVertex(); } },
    { "ScaleMode", [](Noise* f) { f->SetScaleModeToScreening(); } },
    { "CorrelationRange", [](Noise* f) { f->SetCorrelationRange(1.25); } },
    { "StandardDeviation", [](Noise* f) { f->SetStandardDeviation(2.0); } },
    { "Screening", [](Noise* f) { f->SetScreening(50.0); } },
    { "NormalizedScreening", [](Noise* f) { f->SetNormalizedScreening(0.1); } },
    { "NumberOfEigenpairs", [](Noise* f) { f->SetNumberOfEigenpairs(12); } },
    { "Seed", [](Noise* f) { f->SetSeed(1); } },
    { "NumberOfComponents", [](Noise* f) { f->SetNumberOfComponents(3); } },
    { "NumberOfSamples", [](Noise* f) { f->SetNumberOfSamples(2); } },
    { "FirstSample", [](Noise* f) { f->SetFirstSample(4); } },
    { "OutputArrayName", [](Noise* f) { f->SetOutputArrayName("Bumps"); } },
    { "GatherPieces", [](Noise* f) { f->GatherPiecesOff(); } },
    { "CoherentNoise", [](Noise* f) { f->CoherentNoiseOn(); } },
    { "ObservationArray", [](Noise* f) { f->SetObservationArray("Value"); } },
    { "ObservationDeviationArray", [](Noise* f) { f->SetObservationDeviationArray("Error"); } },
    { "Tolerance", [](Noise* f) { f->SetTolerance(0.5); } },
    { "PosteriorMean", [](Noise* f) { f->PosteriorMeanOn(); } },
    { "PosteriorStandardDeviation", [](Noise* f) { f->PosteriorStandardDeviationOn(); } },
    { "OperatorPower", [](Noise* f) { f->SetOperatorPower(3); } },
    { "OperatorPower between integers", [](Noise* f) { f->SetOperatorPower(2.5); } },
    { "VarianceCorrection", [](Noise* f) { f->VarianceCorrectionOn(); } },
    { "BoundaryCondition", [](Noise* f) { f->SetBoundaryConditionToRobin(); } },
    { "RobinCoefficient", [](Noise* f) { f->SetRobinCoefficient(2.0); } },
    { "AnisotropyRatio", [](Noise* f) { f->SetAnisotropyRatio(3.0); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
}

TEST(MaternNoiseCaching, OnlyWhatChangesTheFactorCostsAFactorization)
{
  const auto filter = FilterOn(Icosphere(3).ToPolyData());
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetSeed(1); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetNumberOfSamples(3); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetFirstSample(3); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetNumberOfComponents(2); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetStandardDeviation(2.0); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetOutputArrayName("Bumps"); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetScreening(3.0); }), 0) << "not used in this mode";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetNumberOfEigenpairs(9); }), 0) << "not used by this model";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetRobinCoefficient(2.0); }), 0) << "not used by this condition";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetAnisotropyRatio(2.0); }), 0) << "not used without directions";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetOperatorPower(4); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->VarianceCorrectionOn(); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetSeed(2); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetStandardDeviation(3.0); }), 0);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetBoundaryConditionToDirichlet(); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetCorrelationRange(0.9); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetScaleModeToScreening(); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetCorrelationRange(0.7); }), 0) << "not used in this mode";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetScreening(4.0); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetScaleModeToNormalizedScreening(); }), 1);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetNoiseModelToUnscreened(); }), 1);
}

TEST(MaternNoiseCaching, MovedPointsAndOtherCellsCostOneFactorization)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto filter = FilterOn(sphere);
  sphere->GetPoints()->SetPoint(0, 0.0, 0.0, 1.3);
  sphere->GetPoints()->Modified();
  sphere->Modified();
  EXPECT_EQ(CostOf(filter, [](Noise*) {}), 1);
  sphere->Modified();
  EXPECT_EQ(CostOf(filter, [](Noise*) {}), 0) << "modified, but the same";
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetInputDataObject(Icosphere(2).ToPolyData()); }), 1);
}

TEST(MaternNoiseCaching, ACachedFieldGivesTheSameBits)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto filter = FilterOn(sphere);
  CostOf(filter, [](Noise* f) { f->SetSeed(9); });
  const auto fresh = vtkSmartPointer<Noise>::New();
  fresh->SetInputDataObject(sphere);
  fresh->SetCorrelationRange(1.0);
  fresh->SetSeed(9);
  ASSERT_TRUE(Update(fresh));
  EXPECT_TRUE(SameBits(filter->GetPolyDataOutput()->GetPointData()->GetScalars(),
    fresh->GetPolyDataOutput()->GetPointData()->GetScalars()));
}

TEST(MaternNoiseCaching, BlocksAreKeptOneByOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, Icosphere(3).ToPolyData());
  const auto filter = FilterOn(blocks);
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  EXPECT_EQ(CostOf(filter, [](Noise* f) { f->SetSeed(5); }), 0);
  blocks->SetBlock(1, Grid(12).ToPolyData());
  EXPECT_EQ(CostOf(filter, [](Noise*) {}), 1) << "only the new block";
  blocks->SetBlock(1, nullptr);
  EXPECT_EQ(CostOf(filter, [](Noise*) {}), 0);
  blocks->SetBlock(1, Grid(12).ToPolyData());
  EXPECT_EQ(CostOf(filter, [](Noise*) {}), 1) << "a block that was gone for an update is not kept";
}
