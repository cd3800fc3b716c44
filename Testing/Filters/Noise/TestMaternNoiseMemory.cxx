// SPDX-License-Identifier: BSD-3-Clause
//
// R11: no growth over many runs, and a failed allocation becomes an error. This executable replaces malloc() and its
// kin, on which operator new and Eigen rest, by versions that fail on request.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Common/Parallel.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <string>

using namespace surfsynthtest;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SURFSYNTH_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SURFSYNTH_SANITIZED
#endif
#endif

#if defined(__GLIBC__) && !defined(SURFSYNTH_SANITIZED)
#define SURFSYNTH_FAILING_MALLOC

namespace
{
/// Only allocations of at least this size are counted and can fail: arrays over points and triangles, not bookkeeping.
constexpr std::size_t Large = 16 * 1024;

std::atomic<long> FailAt{ 0 }; ///< the how manieth large allocation fails; 0: none
std::atomic<long> LargeCount{ 0 };

bool Fails(std::size_t size)
{
  const long failAt = FailAt.load(std::memory_order_relaxed);
  return size >= Large && failAt > 0 && LargeCount.fetch_add(1) + 1 == failAt;
}
} // namespace

// The implementation that glibc keeps for those who replace malloc().
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) { return Fails(size) ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) { return Fails(count * size) ? nullptr : __libc_calloc(count, size); }
void* realloc(void* old, std::size_t size) { return Fails(size) ? nullptr : __libc_realloc(old, size); }
void* aligned_alloc(std::size_t alignment, std::size_t size)
{
  return Fails(size) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size)
{
  void* memory = Fails(size) ? nullptr : __libc_memalign(alignment, size);
  if (!memory)
  {
    return ENOMEM;
  }
  *result = memory;
  return 0;
}
}

namespace
{
/// Updates @p make()'s filter again and again, each time with one more large allocation let through, until it succeeds.
/// @return the number of failed updates.
long CheckEveryFailure(const std::function<vtkSmartPointer<vtkMaternNoiseFilter>()>& make)
{
  for (long failAt = 1; failAt < 5000; ++failAt)
  {
    const auto filter = make();
    EventRecorder events(filter);
    LargeCount = 0;
    FailAt = failAt;
    const bool succeeded = Update(filter);
    FailAt = 0;
    const bool failed = LargeCount >= failAt;
    EXPECT_EQ(succeeded, events.Errors.empty());
    auto* output = filter->GetPolyDataOutput();
    EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), succeeded ? filter->GetNumberOfSamples() : 0);
    if (succeeded)
    {
      if (!failed)
      {
        return failAt - 1;
      }
      continue; // who asked for that memory could do without it
    }
    EXPECT_EQ(events.Errors.size(), 1u) << events.AllErrors();
    EXPECT_THAT(events.AllErrors(), ::testing::HasSubstr("memory")) << "allocation " << failAt;
    filter->Modified();
    events.Errors.clear();
    EXPECT_TRUE(Update(filter)) << "with memory it works again, after allocation " << failAt << events.AllErrors();
    if (::testing::Test::HasFailure())
    {
      break;
    }
  }
  return 0;
}

vtkSmartPointer<vtkMaternNoiseFilter> FilterOn(vtkDataObject* input, int model)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetNoiseModel(model);
  filter->SetCorrelationRange(2.0);
  filter->SetNumberOfEigenpairs(6);
  filter->SetNumberOfSamples(2);
  return filter;
}
} // namespace

TEST(MaternNoiseMemory, EveryFailedAllocationIsOneErrorThatNamesIt)
{
  const auto sphere = Icosphere(4).ToPolyData();
  for (int model = vtkMaternNoiseFilter::MATERN; model <= vtkMaternNoiseFilter::UNSCREENED; ++model)
  {
    const long failures = CheckEveryFailure([&] { return FilterOn(sphere, model); });
    EXPECT_GE(failures, 5) << "the test must have made allocations fail, model " << model;
  }
}

TEST(MaternNoiseMemory, FailedAllocationsOfTheEigenpairsAreErrors)
{
  const auto sphere = Icosphere(3).ToPolyData();
  EXPECT_GE(CheckEveryFailure([&] { return FilterOn(sphere, vtkMaternNoiseFilter::SPECTRAL); }), 5);
}

TEST(MaternNoiseMemory, FailedAllocationsOfPolygonsAreErrors)
{
  Soup soup = Grid(60, 4);
  soup.Lines = { { 0, 1 } };
  const auto input = soup.ToPolyData();
  EXPECT_GE(CheckEveryFailure([&] { return FilterOn(input, vtkMaternNoiseFilter::PER_VERTEX); }), 5);
}
#else
TEST(MaternNoiseMemory, EveryFailedAllocationIsOneErrorThatNamesIt)
{
  GTEST_SKIP() << "malloc() belongs to the sanitizer, or is not glibc's";
}
#endif

TEST(MaternNoiseMemory, ArraysThatCannotExistAreAnError)
{
  if (IsSanitized())
  {
    GTEST_SKIP() << "sanitizers treat such allocations as defects";
  }
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(4).ToPolyData());
  filter->SetCorrelationRange(1.0);
  filter->SetNumberOfComponents(VTK_INT_MAX); // 40 TB
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], ::testing::HasSubstr("(MemoryLimit)"));
  EXPECT_EQ(filter->GetPolyDataOutput()->GetNumberOfPoints(), 0);
}

TEST(MaternNoiseMemory, AHundredRunsDoNotGrow)
{
  if (IsSanitized())
  {
    GTEST_SKIP() << "sanitizers keep freed memory; leaks are LeakSanitizer's to find";
  }
  const auto run = [](int seed) {
    const auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
    filter->SetInputDataObject(Icosphere(4).ToPolyData());
    filter->SetCorrelationRange(1.0);
    filter->SetNumberOfSamples(4);
    filter->SetSeed(seed);
    ASSERT_TRUE(Update(filter));
    filter->SetCorrelationRange(1.5); // a second factor
    ASSERT_TRUE(Update(filter));
  };
  const auto hundredRuns = [&] {
    for (int k = 0; k < 100; ++k)
    {
      run(k);
    }
    return ResidentMemory();
  };
  std::int64_t before = 0;
  std::int64_t after = hundredRuns(); // fills the arenas of malloc, of which each thread has its own
  // A leak shows in each hundred runs; an arena that a thread fills later in one of them.
  for (int hundred = 0; hundred < 3 && after - before >= before / 100; ++hundred)
  {
    before = after;
    after = hundredRuns();
  }
  RecordProperty("GrowthInBytes", std::to_string(after - before));
  EXPECT_LT(after - before, before / 100) << "R11: of " << before << " bytes";
}
