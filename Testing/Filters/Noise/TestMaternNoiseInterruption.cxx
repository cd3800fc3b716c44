// SPDX-License-Identifier: BSD-3-Clause
//
// R9 and R10: progress and abort of long runs, on a surface of 300,000 points.
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace surfsynthtest;

namespace
{
/// Seconds within which an abort must end the run; a sanitizer slows everything down.
const double AbortLimit = IsSanitized() ? 15.0 : 1.0;

vtkSmartPointer<vtkPolyData> LargeSphere()
{
  static const vtkSmartPointer<vtkPolyData> sphere = IsSanitized() ? RingSphere(120, 120) : RingSphere(550, 550);
  return sphere;
}

vtkSmartPointer<vtkMaternNoiseFilter> LargeFilter(int samples)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(LargeSphere());
  filter->SetNumberOfSamples(samples);
  return filter;
}

vtkDataArray* LastSample(vtkMaternNoiseFilter* filter)
{
  vtkPointData* data = filter->GetPolyDataOutput()->GetPointData();
  return data->GetArray(data->GetNumberOfArrays() - 1);
}

/// Aborts at @p fraction, then expects that the next update is complete.
void CheckAbort(vtkMaternNoiseFilter* filter, double fraction)
{
  ExpectAbortAndRecovery(filter, fraction, AbortLimit);
  EXPECT_EQ(filter->GetPolyDataOutput()->GetPointData()->GetNumberOfArrays(), filter->GetNumberOfSamples());
}
} // namespace

TEST(MaternNoiseInterruption, AbortDuringTheFactorization)
{
  const auto filter = LargeFilter(1);
  CheckAbort(filter, 0.5);
  const auto undisturbed = LargeFilter(1);
  ASSERT_TRUE(Update(undisturbed));
  EXPECT_TRUE(SameBits(LastSample(filter), LastSample(undisturbed)));
}

TEST(MaternNoiseInterruption, AbortAtTheFirstReport) { CheckAbort(LargeFilter(1), 0.0); }

TEST(MaternNoiseInterruption, AbortWhileSampling)
{
  const auto filter = LargeFilter(1);
  ASSERT_TRUE(Update(filter));
  filter->SetNumberOfSamples(40);
  CheckAbort(filter, 0.3);
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1) << "the factor survives an abort while sampling";
}

TEST(MaternNoiseInterruption, AbortEmptiesACompositeOutput)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, LargeSphere());
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(blocks);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.5;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, AbortLimit) << "R9";
  }
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  EXPECT_EQ(output->GetNumberOfPoints(), 0);
  EXPECT_TRUE(Update(filter));
  output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  for (unsigned int k = 0; k < 2; ++k)
  {
    auto* block = vtkPolyData::SafeDownCast(output->GetBlock(k));
    ASSERT_TRUE(block);
    EXPECT_TRUE(block->GetPointData()->GetArray("MaternNoise"));
  }
}

TEST(MaternNoiseInterruption, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  ExpectSteadyProgress(LargeFilter(80), AbortLimit);
}

TEST(MaternNoiseInterruption, ProgressOfBlocksFollowsTheirShareOfTheCells)
{
  const auto sphere = Icosphere(4).ToPolyData();
  vtkNew<vtkMultiBlockDataSet> blocks;
  for (unsigned int k = 0; k < 4; ++k)
  {
    blocks->SetBlock(k, sphere);
  }
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(blocks);
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  ExpectMonotone(events.Progress);
  for (const double share : { 0.25, 0.5, 0.75 })
  {
    const bool reported = std::any_of(events.Progress.begin(), events.Progress.end(),
      [share](double fraction) { return std::abs(fraction - share) < 1e-9; });
    EXPECT_TRUE(reported) << share;
  }
}
