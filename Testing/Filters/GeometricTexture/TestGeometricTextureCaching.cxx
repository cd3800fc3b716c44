// SPDX-License-Identifier: BSD-3-Clause
//
// R5 (how often vtkGeometricTextureSynthesizer executes), what an execution costs, R7 (the same bits for every number
// of threads), R9 and R10 (abort and progress), R12 (two filters on two threads).
#include "GeometricTexturePipelines.h"

#include "FilterContract.h"
#include "RandomGeometricTexture.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <vector>

using namespace surfsynth;
using namespace surfsynthtest;
using Filter = vtkGeometricTextureSynthesizer;

namespace
{
/// Numbers of models read and of textures synthesized by one more update.
struct Cost
{
  vtkTypeInt64 Loads;
  vtkTypeInt64 Syntheses;
  bool operator==(const Cost& other) const { return this->Loads == other.Loads && this->Syntheses == other.Syntheses; }
};

std::ostream& operator<<(std::ostream& os, const Cost& cost)
{
  return os << cost.Loads << " loads, " << cost.Syntheses << " syntheses";
}

Cost CostOf(Filter* filter, const std::function<void(Filter*)>& change, double time = -1.0)
{
  change(filter);
  const Cost before{ filter->GetNumberOfModelLoads(), filter->GetNumberOfSyntheses() };
  EXPECT_TRUE(time < 0.0 ? Update(filter) : filter->UpdateTimeStep(time));
  return { filter->GetNumberOfModelLoads() - before.Loads, filter->GetNumberOfSyntheses() - before.Syntheses };
}

void Unchanged(Filter*) {}

vtkDataArray* PointsOf(vtkAlgorithm* filter)
{
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetPoints()->GetData();
}

/// A network of the published width, five levels on a ball: seconds of work.
vtkSmartPointer<Filter> LargeFilter()
{
  GeometricTextureOptions options;
  options.Levels = IsSanitized() ? 4 : 5; // instrumented, a sixteenth of the work takes as long
  WriteGeometricTexture("large.model", surfsynth::test::RandomGeometricTexture(options));
  return SynthesizerOn(Icosphere(IsSanitized() ? 3 : 4).ToPolyData(), "large.model");
}
} // namespace

TEST(GeometricTextureCaching, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto target = Icosphere(1).ToPolyData();
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("one.model"));
  ASSERT_TRUE(Update(filter));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  EXPECT_TRUE(filter->UpdateTimeStep(0.5));
  EXPECT_EQ(events.Executions, 0) << "without an animation, time is of no interest";
  WriteRandomGeometricTexture("two.model", 2);
  vtkNew<Filter> measuring;
  measuring->SetModelFileName("two.model");
  ASSERT_TRUE(measuring->WriteModelWithStatistics("two.model", 1));
  const PropertyChanges<Filter> changes = {
    { "ModelFileName", [](Filter* f) { f->SetModelFileName("two.model"); } },
    { "Seed", [](Filter* f) { f->SetSeed(3); } },
    { "SecondSeed", [](Filter* f) { f->SetSecondSeed(3); } },
    { "Interpolation", [](Filter* f) { f->SetInterpolation(0.5); } },
    { "NoiseAmplitude", [](Filter* f) { f->SetNoiseAmplitude(0.2); } },
    { "NormStatistics", [](Filter* f) { f->SetNormStatisticsToReference(); } },
    { "LevelsWithoutNoise", [](Filter* f) { f->SetLevelsWithoutNoise("0"); } },
    { "EndLevel", [](Filter* f) { f->SetEndLevel(1); } },
    { "StartLevel", [](Filter* f) { f->SetStartLevel(1); } },
    { "TargetPreparation", [](Filter* f) { f->SetTargetPreparationToSubdivide(); } },
    { "TextureScale", [](Filter* f) { f->SetTextureScale(0.5); } },
    { "MaskArrayName", [](Filter* f) { f->SetMaskArrayName("Mask"); } },
    { "MaskFalloff", [](Filter* f) { f->SetMaskFalloff(0.5); } },
#ifdef SURFACE_SYNTHESIS_CGAL
    { "Printable", [](Filter* f) { f->SetPrintable(true); } },
#endif
    { "SizeArrayName", [](Filter* f) { f->SetSizeArrayName("Mask"); } },
    { "BlendArrayName", [](Filter* f) { f->SetBlendArrayName("Mask"); } },
    { "SecondModelFileName", [](Filter* f) { f->SetSecondModelFileName("two.model"); } },
    { "Strength", [](Filter* f) { f->SetStrength(1.5); } },
    { "StrengthArrayName", [](Filter* f) { f->SetStrengthArrayName("Mask"); } },
    { "RandomFromLevel", [](Filter* f) { f->SetRandomFromLevel(1); } },
    { "DisplacementArrayName", [](Filter* f) { f->SetDisplacementArrayName("A"); } },
    { "LevelArrayName", [](Filter* f) { f->SetLevelArrayName("B"); } },
    { "Animation", [](Filter* f) { f->SetAnimationToLevels(); } },
    { "OutputLevels", [](Filter* f) { f->OutputLevelsOn(); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
}

TEST(GeometricTextureCaching, WhatIsTheSameIsNotSynthesizedAgain)
{
  const auto target = Icosphere(2).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("kept.model"));
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 1 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetDisplacementArrayName("Motion"); }), (Cost{ 0, 0 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetSeed(1); }), (Cost{ 0, 1 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetInterpolation(0.5); }), (Cost{ 0, 1 }));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetTextureScale(0.5); }), (Cost{ 0, 0 })) << "not used";
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  target->Modified();
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 0 })) << "another array, the same mesh";
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetMaskArrayName("Mask"); }), (Cost{ 0, 1 }));
  AddPointField(target, "Mask", [](const double* p) { return p[1] > 0.0 ? 1.0 : 0.0; });
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1 })) << "another mask of that name";
  target->GetPoints()->SetPoint(0, 0.0, 0.0, 1.1);
  target->GetPoints()->Modified();
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1 }));
}

TEST(GeometricTextureCaching, TheFormerNameOfTheCountAnswers)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("former.model"));
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfSyntheses(), 1);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  EXPECT_EQ(filter->GetNumberOfGrowths(), 1);
#pragma GCC diagnostic pop
}

TEST(GeometricTextureCaching, GoingThroughLevelsCostsNoSynthesis)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("flow.model"));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->SetAnimationToLevels(); }), (Cost{ 1, 1 }));
  EventRecorder events(filter);
  for (const double time : { 0.0, 0.25, 1.0, 2.0, 1.5 })
  {
    EXPECT_EQ(CostOf(filter, Unchanged, time), (Cost{ 0, 0 })) << time;
  }
  EXPECT_EQ(events.Executions, 5);
  EXPECT_EQ(CostOf(
              filter, [](Filter* f) { f->OutputLevelsOn(); }, 1.5),
    (Cost{ 0, 0 }));
  EXPECT_EQ(CostOf(filter,
              [](Filter* f) {
                f->OutputLevelsOff();
                f->SetAnimationToNoAnimation();
              }),
    (Cost{ 0, 0 }));
  EXPECT_EQ(CostOf(
              filter, [](Filter* f) { f->SetAnimationToSeeds(); }, 0.5),
    (Cost{ 0, 1 }));
}

TEST(GeometricTextureCaching, AFileThatHasChangedIsReadAgain)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("changing.model"));
  ASSERT_TRUE(Update(filter));
  const vtkSmartPointer<vtkDataArray> before = PointsOf(filter);
  WriteRandomGeometricTexture("changing.model", 5);
  const auto time = std::filesystem::last_write_time("changing.model");
  std::filesystem::last_write_time("changing.model", time + std::chrono::seconds(2));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 1, 1 }));
  EXPECT_FALSE(SameBits(PointsOf(filter), before));
  EXPECT_EQ(CostOf(filter, [](Filter* f) { f->Modified(); }), (Cost{ 0, 0 }));
}

TEST(GeometricTextureCaching, BlocksAreKeptOneByOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(2).ToPolyData());
  const auto filter = SynthesizerOn(blocks, WriteRandomGeometricTexture("kept_blocks.model"));
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 1, 2 })) << "one model for all blocks";
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1 })) << "only the new block";
  blocks->SetBlock(1, nullptr);
  EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 0 }));
}

TEST(GeometricTextureCaching, BitsDoNotDependOnThreads)
{
  const auto target = Icosphere(IsSanitized() ? 2 : 4).ToPolyData();
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const std::string model = WriteRandomGeometricTexture("threads.model");
  const auto make = [&] {
    const auto filter = SynthesizerOn(target, model);
    filter->SetMaskArrayName("Mask");
    filter->SetMaskFalloff(0.5);
    return filter;
  };
  ExpectSameBitsForAllThreads(make, PointsOf);
}

TEST(GeometricTextureCaching, TwoFiltersOnTwoThreadsDoNotDisturbEachOther)
{
  const std::string model = WriteRandomGeometricTexture("two_threads.model");
  const auto first = SynthesizerOn(Icosphere(3).ToPolyData(), model);
  const auto second = SynthesizerOn(Icosphere(2).ToPolyData(), model);
  const auto alone = SynthesizerOn(Icosphere(2).ToPolyData(), model);
  ExpectIndependence(first, second, alone, PointsOf);
}

TEST(GeometricTextureCaching, AbortEmptiesTheOutputAndTheNextUpdateIsComplete)
{
  for (const bool levels : { false, true })
  {
    for (const double place : { 0.0, 0.2, 0.6 })
    {
      const auto filter = LargeFilter();
      filter->SetOutputLevels(levels);
      ExpectAbort(filter, place);
      if (place > 0.5)
      {
        EXPECT_EQ(CostOf(filter, Unchanged), (Cost{ 0, 1 }));
        EXPECT_GT(
          filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), IsSanitized() ? 37500 : 600000);
      }
    }
  }
}

TEST(GeometricTextureCaching, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  const auto filter = LargeFilter();
  ExpectSteadyProgress(filter);
}
