// SPDX-License-Identifier: BSD-3-Clause
#include "FilterContract.h"

#include "Core/Common/Parallel.h"

#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>

#include <algorithm>
#include <string>
#include <thread>

namespace surfsynthtest
{

void ExpectSameBitsForAllThreads(const FilterMaker& make, const FilterResult& resultOf)
{
  vtkSmartPointer<vtkDataArray> reference;
  for (int threads = 1; threads <= 4; ++threads)
  {
    vtkSMPTools::Initialize(threads);
    const surfsynth::ThreadScope scope(threads);
    ASSERT_EQ(vtkSMPTools::GetEstimatedNumberOfThreads(), threads);
    for (int repeat = 0; repeat < 3; ++repeat)
    {
      const auto filter = make();
      ASSERT_TRUE(Update(filter));
      reference = reference ? reference.Get() : resultOf(filter);
      EXPECT_TRUE(SameBits(resultOf(filter), reference)) << threads << " threads";
    }
  }
  vtkSMPTools::Initialize(0);
}

void ExpectIndependence(vtkAlgorithm* first, vtkAlgorithm* second, vtkAlgorithm* alone, const FilterResult& resultOf)
{
  bool firstDone = false;
  bool secondDone = false;
  std::thread one([&] { firstDone = Update(first); });
  std::thread two([&] { secondDone = Update(second); });
  one.join();
  two.join();
  ASSERT_TRUE(firstDone && secondDone);
  ASSERT_TRUE(Update(alone));
  EXPECT_TRUE(SameBits(resultOf(second), resultOf(alone)));
}

namespace
{
void ExpectEmptyOutput(vtkAlgorithm* filter)
{
  vtkDataObject* output = filter->GetOutputDataObject(0);
  EXPECT_TRUE(!output || output->GetNumberOfElements(vtkDataObject::POINT) == 0);
  auto* surface = vtkPolyData::SafeDownCast(output);
  EXPECT_TRUE(!surface || surface->GetPointData()->GetNumberOfArrays() == 0);
}

void ExpectStop(vtkAlgorithm* filter, double fraction, double seconds, EventRecorder& events)
{
  events.AbortAt = fraction;
  EXPECT_TRUE(Update(filter)) << "an abort is no failure";
  EXPECT_TRUE(events.Errors.empty()) << "an abort is no error: " << events.AllErrors();
  ASSERT_GE(events.SecondsAfterAbort, 0.0) << "the run was over before it could be stopped";
  EXPECT_LT(events.SecondsAfterAbort, seconds) << "R9";
  ExpectMonotone(events.Progress);
  EXPECT_LT(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread) << "R10";
  ExpectEmptyOutput(filter);
}
} // namespace

void ExpectAbort(vtkAlgorithm* filter, double fraction, double seconds)
{
  EventRecorder events(filter);
  ExpectStop(filter, fraction, seconds, events);
}

void ExpectAbortAndRecovery(vtkAlgorithm* filter, double fraction, double seconds)
{
  {
    EventRecorder events(filter);
    ExpectStop(filter, fraction, seconds, events);
    EXPECT_LT(events.LongestSilence, seconds) << "R9: no report, so no chance to stop";
    ::testing::Test::RecordProperty("SecondsAfterAbort", std::to_string(events.SecondsAfterAbort));
  }
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << "without any change of the filter";
  EXPECT_EQ(events.Executions, 1);
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  EXPECT_GT(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 1) << "and then it is up to date";
}

void ExpectMonotone(const std::vector<double>& progress)
{
  ASSERT_FALSE(progress.empty());
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end())) << "R10: progress went back";
  EXPECT_GE(progress.front(), 0.0);
  EXPECT_LE(progress.back(), 1.0);
}

void ExpectSteadyProgress(vtkAlgorithm* filter, double silence)
{
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  ExpectMonotone(events.Progress);
  ASSERT_GE(events.Progress.size(), 20u) << "R10";
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread) << "R10";
  EXPECT_LT(events.LongestSilence, silence);
}

std::string ErrorOf(vtkAlgorithm* filter)
{
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_EQ(events.Errors.size(), 1u) << ::testing::PrintToString(events.Errors);
  ExpectEmptyOutput(filter);
  return events.AllErrors();
}

std::vector<std::string> WarningsOf(vtkAlgorithm* filter)
{
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  return events.Warnings;
}

} // namespace surfsynthtest
