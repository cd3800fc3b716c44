// SPDX-License-Identifier: BSD-3-Clause
//
// R7: the same seed gives the same bits, whatever the number of threads and however the samples are asked for.
// R12: two filters on two threads do not disturb each other (run this under ThreadSanitizer too).
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Common/Parallel.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSMPTools.h>

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

using namespace surfsynthtest;
using Noise = vtkMaternNoiseFilter;
using Arrays = std::vector<vtkSmartPointer<vtkDataArray>>;

namespace
{
Arrays NoiseArrays(Noise* filter)
{
  Arrays arrays;
  if (Update(filter))
  {
    vtkPointData* data = filter->GetPolyDataOutput()->GetPointData();
    for (int k = 0; k < data->GetNumberOfArrays(); ++k)
    {
      arrays.emplace_back(data->GetArray(k));
    }
  }
  return arrays;
}

/// Samples of a filter that has computed nothing before.
Arrays FreshNoise(vtkDataObject* input, int model, int firstSample, int samples, int components, int seed = 3)
{
  vtkNew<Noise> filter;
  filter->SetInputDataObject(input);
  filter->SetNoiseModel(model);
  filter->SetCorrelationRange(1.0);
  filter->SetNumberOfEigenpairs(16);
  filter->SetSeed(seed);
  filter->SetFirstSample(firstSample);
  filter->SetNumberOfSamples(samples);
  filter->SetNumberOfComponents(components);
  return NoiseArrays(filter);
}

void ExpectSame(const Arrays& a, const Arrays& b, const std::string& what)
{
  ASSERT_FALSE(a.empty());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
  {
    EXPECT_TRUE(SameBits(a[k], b[k])) << what << ", array " << k;
  }
}
} // namespace

TEST(MaternNoiseReproducibility, BitsDoNotDependOnThreadsInTenRepeats)
{
  const auto sphere = Icosphere(IsSanitized() ? 3 : 5).ToPolyData();
  const Arrays reference = FreshNoise(sphere, Noise::MATERN, 0, 12, 3);
  for (int threads = 1; threads <= 4; ++threads)
  {
    vtkSMPTools::Initialize(threads);
    const surfsynth::ThreadScope scope(threads);
    ASSERT_EQ(vtkSMPTools::GetEstimatedNumberOfThreads(), threads);
    for (int repeat = 0; repeat < (IsSanitized() ? 2 : 10); ++repeat)
    {
      ExpectSame(FreshNoise(sphere, Noise::MATERN, 0, 12, 3), reference, std::to_string(threads) + " threads");
    }
  }
  vtkSMPTools::Initialize(0);
}

TEST(MaternNoiseReproducibility, BitsOfEveryModelDoNotDependOnThreads)
{
  const auto sphere = Icosphere(3).ToPolyData();
  for (int model = Noise::MATERN; model <= Noise::SPECTRAL; ++model)
  {
    const surfsynth::ThreadScope one(1);
    const Arrays reference = FreshNoise(sphere, model, 0, 40, 1);
    for (const int threads : { 2, 3 })
    {
      vtkSMPTools::Initialize(threads);
      const surfsynth::ThreadScope scope(threads);
      ExpectSame(FreshNoise(sphere, model, 0, 40, 1), reference,
        "model " + std::to_string(model) + " on " + std::to_string(threads) + " threads");
    }
  }
  vtkSMPTools::Initialize(0);
}

TEST(MaternNoiseReproducibility, ASampleIsTheSameAloneAndInABatch)
{
  const auto sphere = Icosphere(3).ToPolyData();
  for (int model = Noise::MATERN; model <= Noise::SPECTRAL; ++model)
  {
    const Arrays batch = FreshNoise(sphere, model, 0, 70, 2);
    ASSERT_EQ(batch.size(), 70u);
    for (const int k : { 0, 1, 15, 16, 31, 33, 69 })
    {
      const Arrays alone = FreshNoise(sphere, model, k, 1, 2);
      ASSERT_EQ(alone.size(), 1u);
      EXPECT_TRUE(SameBits(alone[0], batch[k])) << "model " << model << " sample " << k;
    }
    const Arrays tail = FreshNoise(sphere, model, 65, 5, 2);
    ASSERT_EQ(tail.size(), 5u);
    EXPECT_TRUE(SameBits(tail[4], batch[69])) << "FirstSample continues the series";
    EXPECT_FALSE(SameBits(batch[0], batch[1]));
  }
}

TEST(MaternNoiseReproducibility, SeedsComponentsAndSamplesDiffer)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const Arrays a = FreshNoise(sphere, Noise::MATERN, 0, 2, 2, 1);
  const Arrays b = FreshNoise(sphere, Noise::MATERN, 0, 2, 2, -1);
  ASSERT_EQ(a.size(), 2u);
  ASSERT_EQ(b.size(), 2u);
  EXPECT_FALSE(SameBits(a[0], b[0]));
  EXPECT_FALSE(SameBits(a[0], a[1]));
  EXPECT_NE(a[0]->GetComponent(0, 0), a[0]->GetComponent(0, 1));
}

TEST(MaternNoiseReproducibility, TheSeedGivesTheSamePatternAtOtherComponents)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const Arrays one = FreshNoise(sphere, Noise::MATERN, 0, 1, 1);
  const Arrays three = FreshNoise(sphere, Noise::MATERN, 0, 1, 3);
  ASSERT_EQ(one.size() + three.size(), 2u);
  for (vtkIdType p = 0; p < one[0]->GetNumberOfTuples(); ++p)
  {
    ASSERT_EQ(one[0]->GetComponent(p, 0), three[0]->GetComponent(p, 0));
  }
}

TEST(MaternNoiseReproducibility, TwoFiltersOnTwoThreadsGiveWhatEachGivesAlone)
{
  // Each has its own copy: VTK data objects are not made to be read by two pipelines at a time.
  const auto sphere = Icosphere(IsSanitized() ? 3 : 4).ToPolyData();
  const Arrays expected[2] = { FreshNoise(sphere, Noise::MATERN, 0, 4, 1),
    FreshNoise(sphere, Noise::UNSCREENED, 2, 4, 1) };
  vtkNew<vtkPolyData> copies[2];
  Arrays found[2][3];
  std::vector<std::thread> threads;
  for (int t = 0; t < 2; ++t)
  {
    copies[t]->DeepCopy(sphere);
    threads.emplace_back([&, t] {
      for (Arrays& arrays : found[t])
      {
        arrays = FreshNoise(copies[t], t == 0 ? Noise::MATERN : Noise::UNSCREENED, t == 0 ? 0 : 2, 4, 1);
      }
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  for (int t = 0; t < 2; ++t)
  {
    for (const Arrays& arrays : found[t])
    {
      ExpectSame(arrays, expected[t], "thread " + std::to_string(t));
    }
  }
}
