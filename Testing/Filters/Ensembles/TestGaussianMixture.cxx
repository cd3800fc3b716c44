// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGaussianMixtureFilter: arrays, names, caching, messages. The mixtures themselves: Core/TestHeatGeodesics.cxx.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkGaussianMixtureFilter.h"

#include <vtkDataArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSMPTools.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using Mixture = vtkGaussianMixtureFilter;

namespace
{
/// The output for @p input, or null after an error.
vtkSmartPointer<vtkPolyData> OutputOf(Mixture* filter, vtkPolyData* input)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  if (!Update(filter) || !events.Errors.empty())
  {
    ADD_FAILURE() << events.AllErrors();
    return nullptr;
  }
  auto output = vtkSmartPointer<vtkPolyData>::New();
  output->ShallowCopy(filter->GetOutputDataObject(0));
  return output;
}

vtkDataArray* Array(vtkPolyData* surface, const char* name) { return surface->GetPointData()->GetArray(name); }

/// Runs the filter, which must give one error that holds @p part.
void ExpectRefusal(Mixture* filter, vtkDataObject* input, const std::string& part)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors();
  EXPECT_NE(events.Errors[0].find(part), std::string::npos) << events.Errors[0];
}
} // namespace

TEST(GaussianMixture, AddsOneArrayForEachSampleAndLeavesTheInput)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto sphere = Icosphere(3).ToPolyData(type);
    const std::uint64_t before = HashOf(sphere);
    vtkNew<Mixture> filter;
    auto output = OutputOf(filter, sphere);
    ASSERT_TRUE(output && Array(output, "Mixture"));
    EXPECT_EQ(Array(output, "Mixture")->GetNumberOfComponents(), 1);
    EXPECT_EQ(Array(output, "Mixture")->GetNumberOfTuples(), sphere->GetNumberOfPoints());
    EXPECT_EQ(output->GetPointData()->GetScalars(), Array(output, "Mixture"));
    filter->SetNumberOfSamples(3);
    filter->SetFirstSample(5);
    filter->SetOutputArrayName("g");
    output = OutputOf(filter, sphere);
    ASSERT_TRUE(output);
    EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 3);
    EXPECT_TRUE(Array(output, "g_5") && Array(output, "g_6") && Array(output, "g_7"));
    EXPECT_EQ(HashOf(sphere), before);
  }
}

TEST(GaussianMixture, ASampleHasTheSameBitsAloneInABatchAndForEveryNumberOfThreads)
{
  const auto sphere = Icosphere(3).ToPolyData();
  vtkNew<Mixture> filter;
  filter->SetSeed(-3);
  filter->SetNumberOfSamples(100);
  const auto all = OutputOf(filter, sphere);
  ASSERT_TRUE(all);
  for (const int threads : { 1, 4 })
  {
    vtkSMPTools::Initialize(threads);
    vtkNew<Mixture> other;
    other->SetSeed(-3);
    other->SetFirstSample(70);
    const auto one = OutputOf(other, sphere);
    ASSERT_TRUE(one);
    EXPECT_TRUE(SameBits(Array(one, "Mixture"), Array(all, "Mixture_70")));
  }
  vtkSMPTools::Initialize(0);
  EXPECT_FALSE(SameBits(Array(all, "Mixture_0"), Array(all, "Mixture_1")));
}

TEST(GaussianMixture, OnlyWhatTheMixturesDependOnIsFactoredAgain)
{
  const auto sphere = Icosphere(2).ToPolyData();
  vtkNew<Mixture> filter;
  ASSERT_TRUE(OutputOf(filter, sphere));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetSeed(8);
  filter->SetNumberOfSamples(4);
  ASSERT_TRUE(OutputOf(filter, sphere));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  ASSERT_TRUE(OutputOf(filter, Icosphere(3).ToPolyData()));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  EXPECT_GT(filter->GetStandardDeviation(), 0.08 * 3.5);
  EXPECT_LT(filter->GetStandardDeviation(), 0.08 * 3.6); // the area of a sphere is 3.545^2
}

TEST(GaussianMixture, BlocksGetDifferentMixtures)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(3).ToPolyData());
  blocks->SetBlock(1, Icosphere(3).ToPolyData());
  vtkNew<Mixture> filter;
  filter->SetInputDataObject(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  auto* first = vtkPolyData::SafeDownCast(output->GetBlock(0));
  auto* second = vtkPolyData::SafeDownCast(output->GetBlock(1));
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(SameBits(Array(first, "Mixture"), Array(second, "Mixture")));
}

TEST(GaussianMixture, SaysWhatIsWrong)
{
  vtkNew<Mixture> filter;
  const auto sphere = Icosphere(2).ToPolyData();
  filter->SetWidth(1.0);
  ExpectRefusal(filter, sphere, "no vertex is left for a centre of sample 0");
  filter->SetWidth(std::numeric_limits<double>::infinity()); // clamped to the largest number
  ExpectRefusal(filter, sphere, "no vertex is left for a centre of sample 0");
  Soup book;
  book.AddPoint(0, 0, 0);
  book.AddPoint(0, 0, 1);
  for (int page = 0; page < 3; ++page)
  {
    book.Polys.push_back({ 0, 1, book.AddPoint(std::cos(2.0 * page), std::sin(2.0 * page), 0.5) });
  }
  ExpectRefusal(filter, book.ToPolyData(), "vtkSurfaceRepairFilter");
  filter->SetWidth(0.08);
  filter->SetOutputArrayName("");
  ExpectRefusal(filter, sphere, "OutputArrayName is empty");
}

TEST(GaussianMixture, AnAbortLeavesNothingAndTheNextUpdateIsComplete)
{
  const auto sphere = Icosphere(4).ToPolyData();
  vtkNew<Mixture> filter;
  filter->SetNumberOfSamples(3000);
  filter->SetInputDataObject(sphere);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.3;
    Update(filter);
    EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
    EXPECT_LT(events.SecondsAfterAbort, 1.0);
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_EQ(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfPoints(), 0);
  }
  filter->SetNumberOfSamples(1);
  const auto output = OutputOf(filter, sphere);
  ASSERT_TRUE(output);
  EXPECT_TRUE(Array(output, "Mixture"));
}

TEST(GaussianMixture, FormerNamesOfCentersWork)
{
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  vtkNew<Mixture> filter;
  filter->SetNumberOfCentres(5);
  EXPECT_EQ(filter->GetNumberOfCenters(), 5);
  EXPECT_EQ(filter->GetNumberOfCentres(), 5);
#pragma GCC diagnostic pop
}

TEST(GaussianMixture, PrintsItsProperties)
{
  vtkNew<Mixture> filter;
  std::ostringstream text;
  filter->Print(text);
  for (const char* name : { "NumberOfCenters: 3", "Width: 0.08", "Separation: 4", "Seed: 0", "NumberOfSamples: 1",
         "FirstSample: 0", "OutputArrayName: Mixture", "StandardDeviation: 0", "NumberOfFactorizations: 0" })
  {
    EXPECT_NE(text.str().find(name), std::string::npos) << name;
  }
}
