// SPDX-License-Identifier: BSD-3-Clause
//
// vtkGeometricTextureFromExample: malformed inputs, executions, threads, abort, progress, blocks, messages.
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"
#include "MalformedCorpus.h"

#include "vtkGeometricTextureFromExample.h"

#include "IO/Weights/InstalledModels.h"
#include "Inference/GeometricTexture/TextureExampleFile.h"

#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

using namespace surfsynthtest;
using testing::AllOf;
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

vtkSmartPointer<vtkDataArray> CopyOfPoints(Filter* filter)
{
  const auto copy = vtkSmartPointer<vtkDataArray>::Take(PointsOf(filter)->NewInstance());
  copy->DeepCopy(PointsOf(filter));
  return copy;
}

/// Adds directions around the z axis at the points.
void AddTangents(vtkPolyData* mesh, const char* name)
{
  vtkNew<vtkDoubleArray> directions;
  directions->SetName(name);
  directions->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < mesh->GetNumberOfPoints(); ++p)
  {
    double x[3];
    mesh->GetPoint(p, x);
    directions->InsertNextTuple3(-x[1], x[0], 0.0);
  }
  mesh->GetPointData()->AddArray(directions);
}

/// The surface of an example file, with its direction as the array Along.
vtkSmartPointer<vtkPolyData> ToPolyData(const surfsynth::TextureExampleFile& file)
{
  const surfsynth::PointMatrix& points = file.Textured.Points;
  Soup soup;
  soup.Points.assign(points.data(), points.data() + points.size());
  for (Eigen::Index f = 0; f < file.Textured.Triangles.rows(); ++f)
  {
    const auto corners = file.Textured.Triangles.row(f);
    soup.Polys.push_back({ corners(0), corners(1), corners(2) });
  }
  auto surface = soup.ToPolyData();
  vtkNew<vtkDoubleArray> along;
  along->SetName("Along");
  along->SetNumberOfComponents(3);
  for (Eigen::Index p = 0; p < file.Directions.rows(); ++p)
  {
    along->InsertNextTuple3(file.Directions(p, 0), file.Directions(p, 1), file.Directions(p, 2));
  }
  surface->GetPointData()->AddArray(along);
  return surface;
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
    { "ExampleFileName", [](Filter* f) { f->SetExampleFileName("mane"); } }, // not used beside the port
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
  const auto filter = FilterOn(Icosphere(2).ToPolyData());
  ExpectAbortAndRecovery(filter, 0.4, 1.0);
  ExpectSteadyProgress(FilterOn(Icosphere(2).ToPolyData()));
  ExpectAbortAndRecovery(BlendOn(Icosphere(2).ToPolyData()), 0.4, 1.0);
  ExpectSteadyProgress(BlendOn(Icosphere(2).ToPolyData()));
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

TEST(GeometricTextureFromExample, InstalledExamplesAreKnownByTheirNames)
{
  vtkNew<Filter> filter;
  ASSERT_EQ(filter->GetInstalledExamples()->GetNumberOfValues(), 3);
  EXPECT_EQ(filter->GetInstalledExamples()->GetValue(1), "mane");
  EXPECT_THAT(filter->GetInstalledExamplesFolder(), HasSubstr("Models"));
  const auto target = Icosphere(1).ToPolyData();
  AddPointField(target, "Share", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  filter->SetInputData(target);
  filter->SetSubdivisions(0);
  filter->SetNumberOfScales(1);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("There is no example on port 1, and ExampleFileName is empty"));
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetExampleFileName("mane"); }), 1);
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetStrength(2.0); }), 0);
  const std::string path = std::string(filter->GetInstalledExamplesFolder()) + "/mane.safetensors";
  const auto byName = CopyOfPoints(filter);
  EXPECT_EQ(SynthesesOf(filter, [&](Filter* f) { f->SetExampleFileName(path.c_str()); }), 0) << "the same file";
  EXPECT_TRUE(SameBits(byName, PointsOf(filter)));
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetSmoothingLength(6.0); }), 1) << "in place of that of the file";
  filter->SetBlendArrayName("Share");
  EXPECT_THAT(
    ErrorOf(filter), HasSubstr("BlendArrayName is set, but there is no second example on port 3, and Second"));
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetSecondExampleFileName("mountains"); }), 1);
  filter->SetBlendArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("SecondExampleFileName is set, but BlendArrayName is empty"));
  filter->SetSecondExampleFileName("");
  const Example example;
  EXPECT_EQ(SynthesesOf(filter, [&](Filter* f) { f->SetExampleData(example.Textured); }), 1) << "port 1 comes first";
}

TEST(GeometricTextureFromExample, FilesHoldTheDirectionOfTheirTexture)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Share", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = vtkSmartPointer<Filter>::New();
  filter->SetInputData(target);
  filter->SetSubdivisions(0);
  filter->SetNumberOfScales(1);
  filter->SetExampleFileName("mane");
  ASSERT_TRUE(Update(filter));
  const auto without = CopyOfPoints(filter);
  AddTangents(target, "Way");
  EXPECT_EQ(SynthesesOf(filter, [](Filter* f) { f->SetOrientationArrayName("Way"); }), 1);
  EXPECT_FALSE(SameBits(without, PointsOf(filter)));
  const auto turned = CopyOfPoints(filter);
  filter->SetExampleFileName("cortex");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("ExampleFileName: \"cortex\" has no direction"));
  // The same surface on the port, with the same smoothing and direction, gives the same bits.
  const surfsynth::TextureExampleFile file = surfsynth::ReadTextureExample(surfsynth::ModelPath("mane"));
  const auto surface = ToPolyData(file);
  filter->SetExampleData(surface);
  filter->SetSmoothingLength(file.SmoothingLength);
  filter->SetExampleOrientationArrayName("Along");
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(SameBits(turned, PointsOf(filter)));
  filter->SetOrientationArrayName("");
  filter->SetExampleOrientationArrayName("");
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(SameBits(without, PointsOf(filter)));
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
  filter = FilterOn(target);
  filter->SetExampleConnection(nullptr);
  filter->SetExampleFileName("mane");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("There is a plain example on port 2, but no example on port 1"));
  filter->SetPlainExampleConnection(nullptr);
  filter->SetExampleFileName("nowhere");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"nowhere\""), HasSubstr("GetInstalledExamples()")));
  filter->SetExampleFileName("flow_spikes");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("an example of a geometric texture"));
}
