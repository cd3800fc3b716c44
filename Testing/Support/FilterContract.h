// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Properties that all filters share: executions, threads, abort, progress.
#pragma once

#include "FilterChecks.h"

#include <vtkAlgorithm.h>
#include <vtkSmartPointer.h>

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace surfsynthtest
{

/// Named changes of one property each.
template <typename Filter>
using PropertyChanges = std::vector<std::pair<const char*, std::function<void(Filter*)>>>;

/// Expects one execution after each change, and none when it is repeated. @p events observe @p filter, which is up to
/// date.
template <typename Filter>
void ExpectOneExecutionEach(Filter* filter, const PropertyChanges<Filter>& changes, EventRecorder& events)
{
  for (const auto& change : changes)
  {
    events.Executions = 0;
    change.second(filter);
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(events.Executions, 1) << change.first;
    change.second(filter);
    EXPECT_TRUE(Update(filter));
    EXPECT_EQ(events.Executions, 1) << change.first << " set to what it is";
  }
}

/// Makes a filter that is ready for its first update.
using FilterMaker = std::function<vtkSmartPointer<vtkAlgorithm>()>;

/// The array of an updated filter that is compared.
using FilterResult = std::function<vtkDataArray*(vtkAlgorithm*)>;

/// Expects the same bits in three updates with each number of threads from 1 to 4.
void ExpectSameBitsForAllThreads(const FilterMaker& make, const FilterResult& resultOf);

/// Updates two filters on two threads. Expects that the second gives the bits of @p alone, which has the same input.
void ExpectIndependence(vtkAlgorithm* first, vtkAlgorithm* second, vtkAlgorithm* alone, const FilterResult& resultOf);

/// Asks the filter to stop at @p fraction of its progress. Expects the end of the update within @p seconds, without an
/// error, and an empty output.
void ExpectAbort(vtkAlgorithm* filter, double fraction, double seconds = 1.0);

/// The same, with reports at least every @p seconds; then expects one execution in the next update.
void ExpectAbortAndRecovery(vtkAlgorithm* filter, double fraction, double seconds);

/// Expects that fractions of progress lie in [0, 1] and never decrease.
void ExpectMonotone(const std::vector<double>& progress);

/// Updates the filter. Expects at least 20 reports of monotone progress on the calling thread, the last of 1, and at
/// most @p silence seconds between two of them.
void ExpectSteadyProgress(vtkAlgorithm* filter, double silence = 1e9);

/// The only error of an update, which must fail and leave the output empty.
std::string ErrorOf(vtkAlgorithm* filter);

/// The warnings of an update, which must succeed without an error.
std::vector<std::string> WarningsOf(vtkAlgorithm* filter);

} // namespace surfsynthtest
