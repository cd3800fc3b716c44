// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGeometricTextureFromExample: malformed inputs, executions, threads, abort, progress, blocks, messages.
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"
#include "MalformedCorpus.h"

#include "vtkGeometricTextureFromExample.h"

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

using namespace surfsynthtest;
using testing::HasSubstr;
using Filter = vtkGeometricTextureFromExample;

namespace
{
/// A ball with waves, and the ball; a coarse one, because most of the time is that of cutting it and of searching its patches.
struct Example
{
  vtkSmartPointer<vtkPolyData> Plain = Icosphere(1).ToPolyData();
  vtkSmartPointer<vtkPolyData> Textured = Icosphere(1).ToPolyData();

  Example()
  {
    vtkPoints* points = this->Textured->GetPoints();
    for (vtkIdType p = 0; p < points->GetNumberOfPoints(); ++p)
    {
      double x[3];
      points->GetPoint(p, x);
      const double radius = 1.0 + 0.05 * std::sin(9.0 * x[0]) * std::sin(9.0 * x[1]) * std::sin(9.0 * x[2]);
      points->SetPoint(p, radius * x[0], radius * x[1], radius * x[2]);
    }
  }
};

vtkSmartPointer<Filter> FilterOn(vtkDataObject* input)
{
  static const Example example;
  const auto filter = vtkSmartPointer<Filter>::New();
  filter->SetInputDataObject(input);
  filter->SetExampleData(example.Textured);
  filter->SetPlainExampleData(example.Plain);
  filter->SetNumberOfScales(1);
  filter->SetSubdivisions(0);
  return filter;
}

/// A filter with a second example, and the share of it on one half of the target.
vtkSmartPointer<Filter> BlendOn(vtkPolyData* target)
{
  static const Example second;
  AddPointField(target, "Share", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.5; });
  const auto filter = FilterOn(target);
  filter->SetSecondExampleData(second.Textured);
  filter->SetSecondPlainExampleData(second.Plain);
  filter->SetBlendArrayName("Share");
  return filter;
}

/// One filter for all malformed inputs: its example is cut once, and an input must not depend on the one before. Its output is
/// emptied: where VTK's executive refuses the type of an input, no filter is called, and the output stays as it was.
vtkSmartPointer<vtkAlgorithm> SharedFilter()
{
  static const vtkSmartPointer<Filter> filter = FilterOn(nullptr);
  if (vtkDataObject* output = filter->GetOutputDataObject(0))
  {
    output->Initialize();
  }
  return filter;
}

FilterTraits Traits()
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false; // consistent winding is needed
  return traits;
}

vtkDataArray* PointsOf(vtkAlgorithm* filter)
{
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetPoints()->GetData();
}

vtkTypeInt64 SynthesesOf(Filter* filter, const std::function<void(Filter*)>& change)
{
  change(filter);
  const vtkTypeInt64 before = filter->GetNumberOfSyntheses();
  EXPECT_TRUE(Update(filter));
  return filter->GetNumberOfSyntheses() - before;
}

/// The corpus; with sanitizers each sixth case, since each takes seconds there, without the one that takes half a minute.
std::vector<MalformedCase> Cases()
{
  std::vector<MalformedCase> cases;
  const std::vector<MalformedCase> all = MalformedCorpus();
  for (std::size_t k = 0; k < all.size(); k += IsSanitized() ? 6 : 1)
  {
    if (!IsSanitized() || all[k].Name != "MixedScales")
    {
      cases.push_back(all[k]);
    }
  }
  return cases;
}

class MalformedTarget : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOf(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST_P(MalformedTarget, ToTheFilter) { CheckAlone(GetParam(), SharedFilter, Traits()); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedTarget, ::testing::ValuesIn(Cases()), NameOf);

TEST(GeometricTextureFromExample, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.5; });
  const auto filter = FilterOn(target);
  ASSERT_TRUE(Update(filter));
  EventRecorder events(filter);
  const PropertyChanges<Filter> changes = {
    { "Seed", [](Filter* f) { f->SetSeed(3); } },
    { "TextureScale", [](Filter* f) { f->SetTextureScale(2.0); } },
    { "Subdivisions", [](Filter* f) { f->SetSubdivisions(1); } },
    { "NumberOfScales", [](Filter* f) { f->SetNumberOfScales(2); } },
    { "SmoothingLength", [](Filter* f) { f->SetSmoothingLength(0.3); } },
    { "SizeArrayName", [](Filter* f) { f->SetSizeArrayName("Mask"); } },
    { "SecondSmoothingLength", [](Filter* f) { f->SetSecondSmoothingLength(0.3); } },
    { "MaskArrayName", [](Filter* f) { f->SetMaskArrayName("Mask"); } },
    { "Strength", [](Filter* f) { f->SetStrength(1.5); } },
#ifdef SURFACE_SYNTHESIS_CGAL
    { "Printable", [](Filter* f) { f->SetPrintable(true); } },
#endif
    { "DisplacementArrayName", [](Filter* f) { f->SetDisplacementArrayName("A"); } },
  };
  ExpectOneExecutionEach(filter.Get(), changes, events);
}

TEST(GeometricTextureFromExample, WhatIsTheSameIsNotSynthesizedAgain)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = FilterOn(target);
  EXPECT_EQ(SynthesesOf(filter, [](Filter*) {}), 1);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetStrength(2.0); }), 0);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetMaskArrayName("Mask"); }), 0);
  vtkPolyData* output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
  for (vtkIdType p = 0; p < target->GetNumberOfPoints(); ++p)
  {
    double before[3], after[3];
    target->GetPoint(p, before);
    output->GetPoint(p, after);
    if (before[2] <= 0.0)
    {
      EXPECT_TRUE(std::equal(before, before + 3, after)) << p;
    }
  }
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetSeed(1); }), 1);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetNumberOfScales(2); }), 1) << "another example";
}

TEST(GeometricTextureFromExample, BlendsNeedTwoExamplesAndAnArray)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Share", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  AddPointField(target, "Percent", [](const double*) { return 100.0; });
  const auto filter = FilterOn(target);
  filter->SetBlendArrayName("Share");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("BlendArrayName is set, but there is no second example on port 3"));
  const Example second;
  filter->SetSecondExampleData(second.Textured);
  EXPECT_EQ(SynthesesOf(filter, [](Filter*) {}), 1);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetStrength(2.0); }), 0);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetSecondSmoothingLength(0.5); }), 1) << "another second example";
  EXPECT_EQ(SynthesesOf(filter, [&](Filter* f) { f->SetSecondPlainExampleData(second.Plain); }), 1);
  filter->SetSecondPlainExampleData(Icosphere(3).ToPolyData());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The second plain example on port 4 has "));
  filter->SetSecondPlainExampleConnection(nullptr);
  filter->SetBlendArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("There is a second example on port 3, but BlendArrayName is empty"));
  filter->SetBlendArrayName("Percent");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The blend array \"Percent\""));
  filter->SetBlendArrayName("Share");
  vtkNew<vtkPolyData> empty;
  filter->SetSecondExampleData(empty);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The second example on port 3 is empty"));
  filter->SetSecondExampleConnection(nullptr);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetBlendArrayName(""); }), 1);
}

TEST(GeometricTextureFromExample, TwoExamplesHaveAsManyScalesAsFitOnBoth)
{
  const auto filter = BlendOn(Icosphere(2).ToPolyData());
  filter->SetNumberOfScales(0);
  ASSERT_TRUE(Update(filter));
  EXPECT_GE(filter->GetNumberOfScalesUsed(), 1);
  // An open square has no room for patches as wide as those of the ball.
  filter->SetSecondPlainExampleConnection(nullptr);
  filter->SetSecondExampleData(Grid(14).ToPolyData());
  filter->SetSecondSmoothingLength(0.02);
  ASSERT_TRUE(Update(filter));
  EXPECT_GE(filter->GetNumberOfScalesUsed(), 1);
  filter->SetNumberOfScales(8);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The second example on port 3: "));
  filter->SetSecondExampleConnection(nullptr);
  filter->SetBlendArrayName("");
  filter->SetSecondPlainExampleData(Icosphere(2).ToPolyData());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("There is a second plain example on port 4, but no second example"));
}

TEST(GeometricTextureFromExample, BitsDoNotDependOnThreads)
{
  const auto target = Icosphere(1).ToPolyData();
  if (!IsSanitized()) // the second does the same, and more
  {
    ExpectSameBitsForAllThreads([&] { return FilterOn(target); }, PointsOf);
  }
  ExpectSameBitsForAllThreads([&] { return BlendOn(target); }, PointsOf);
}

TEST(GeometricTextureFromExample, AbortsAndGoesOn)
{
  const auto filter = FilterOn(Icosphere(3).ToPolyData());
  ExpectAbortAndRecovery(filter, 0.4, 1.0);
  ExpectSteadyProgress(FilterOn(Icosphere(3).ToPolyData()));
  ExpectAbortAndRecovery(BlendOn(Icosphere(3).ToPolyData()), 0.4, 1.0);
  ExpectSteadyProgress(BlendOn(Icosphere(3).ToPolyData()));
}

TEST(GeometricTextureFromExample, BlocksDifferAndSameBlocksAreKept)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, Icosphere(2).ToPolyData());
  const auto filter = FilterOn(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  const auto points = [&](unsigned int k) {
    return vtkPolyData::SafeDownCast(output->GetBlock(k))->GetPoints()->GetData();
  };
  EXPECT_FALSE(SameBits(points(0), points(1)));
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  EXPECT_EQ(SynthesesOf(filter, [](Filter*) {}), 1);
}

TEST(GeometricTextureFromExample, FaultsAreNamed)
{
  const auto target = Icosphere(1).ToPolyData();
  auto filter = FilterOn(target);
  filter->SetPlainExampleData(Icosphere(3).ToPolyData());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("the same triangles with other points are needed"));
  filter = FilterOn(target);
  vtkNew<vtkPolyData> empty;
  filter->SetExampleData(empty);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The example on port 1 is empty"));
  filter = FilterOn(target);
  filter->SetOrientationArrayName("Fibres");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("ExampleOrientationArrayName are needed together"));
  filter->SetExampleOrientationArrayName("Fibres");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("Fibres"));
  filter = FilterOn(target);
  filter->SetMaskArrayName("Missing");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The mask array \"Missing\" is missing"));
  filter = FilterOn(target);
  filter->SetDisplacementArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("DisplacementArrayName is empty"));
}
