// SPDX-License-Identifier: BSD-3-Clause
//
// R5 (how often the filters execute), what an execution costs, R7 (the same bits for every number of threads), R9 and
// R10 (abort and progress), R12 (two filters on two threads).
#include "FieldLatentPipelines.h"

#include "FilterContract.h"

#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

using namespace surfsynth;
using namespace surfsynthtest;

namespace
{
vtkDataArray* CodesOf(vtkAlgorithm* filter) { return PointArray(filter->GetOutputDataObject(0), "FieldLatent_0"); }

/// Work of the updates so far.
struct Cost
{
  vtkTypeInt64 Loads;
  vtkTypeInt64 RingComputations;
  vtkTypeInt64 Rasterizations;
  bool operator==(const Cost& other) const
  {
    return this->Loads == other.Loads && this->RingComputations == other.RingComputations &&
      this->Rasterizations == other.Rasterizations;
  }
};

std::ostream& operator<<(std::ostream& os, const Cost& cost)
{
  return os << cost.Loads << " loads, " << cost.RingComputations << " ring computations, " << cost.Rasterizations
            << " rasterizations";
}

Cost CostOf(vtkFieldLatentDecoder* filter)
{
  EXPECT_TRUE(Update(filter));
  return { filter->GetNumberOfModelLoads(), filter->GetNumberOfRingComputations(),
    filter->GetNumberOfRasterizations() };
}

Cost CostOf(vtkFieldLatentEncoder* filter)
{
  EXPECT_TRUE(Update(filter));
  return { filter->GetNumberOfModelLoads(), filter->GetNumberOfRingComputations(), 0 };
}

/// A network with more work than the others have.
FieldLatentOptions LargerOptions()
{
  FieldLatentOptions options = SmallFieldLatents();
  options.Channels = 32;
  options.EncoderLayers = 2;
  options.SamplesPerRing = 32;
  options.DecoderWidth = 128;
  return options;
}

/// A sphere of 1,600 points with colors and texture coordinates in two halves of the square.
vtkSmartPointer<vtkPolyData> LargeSphere()
{
  const auto sphere = RingSphere(40, 40);
  AddColors(sphere);
  AddTextureCoordinates(sphere, [](double x, double y, double z) {
    return std::array<double, 2>{ (z > 0.0 ? 0.75 : 0.25) + 0.2 * x, 0.5 + 0.45 * y };
  });
  return sphere;
}

vtkSmartPointer<vtkFieldLatentEncoder> LargeEncoder()
{
  return EncoderOn(LargeSphere(), nullptr, WriteFieldLatentModel("larger.model", LargerOptions()));
}

vtkSmartPointer<vtkFieldLatentDecoder> LargeDecoder()
{
  const std::string model = WriteFieldLatentModel("larger.model", LargerOptions());
  const std::string quick = WriteFieldLatentModel("quick.model");
  const auto decoder = DecoderOn(Encoded(LargeSphere(), nullptr, quick), model);
  decoder->SetResolution(256, 256);
  return decoder;
}
} // namespace

TEST(FieldLatentCaching, UnchangedParametersCostNoExecutionAndEachChangeExactlyOne)
{
  const auto grid = TexturedGrid(4);
  AddColors(grid);
  const auto encoder = EncoderOn(grid, Pattern(), WriteFieldLatentModel("one.model"));
  WriteFieldLatentModel("two.model", SmallFieldLatents(), 2);
  ASSERT_TRUE(Update(encoder));
  {
    EventRecorder events(encoder);
    EXPECT_TRUE(Update(encoder));
    EXPECT_EQ(events.Executions, 0) << "nothing has changed";
    const PropertyChanges<vtkFieldLatentEncoder> changes = {
      { "ModelFileName", [](vtkFieldLatentEncoder* f) { f->SetModelFileName(ModelFile("two.model").c_str()); } },
      { "ColorArrayName", [](vtkFieldLatentEncoder* f) { f->SetColorArrayName("Color"); } },
      { "TextureWrap", [](vtkFieldLatentEncoder* f) { f->SetTextureWrapToRepeat(); } },
      { "SamplesPerRing", [](vtkFieldLatentEncoder* f) { f->SetSamplesPerRing(20); } },
      { "LatentArrayName", [](vtkFieldLatentEncoder* f) { f->SetLatentArrayName("A"); } },
    };
    ExpectOneExecutionEach(encoder.Get(), changes, events);
    encoder->SetLatentArrayName("FieldLatent");
  }
  const auto decoder = DecoderOn(SurfaceOf(encoder), ModelFile("one.model"));
  ASSERT_TRUE(Update(decoder));
  EventRecorder events(decoder);
  EXPECT_TRUE(Update(decoder));
  decoder->Update(1);
  EXPECT_EQ(events.Executions, 0) << "neither for the image";
  const PropertyChanges<vtkFieldLatentDecoder> changes = {
    { "ModelFileName", [](vtkFieldLatentDecoder* f) { f->SetModelFileName(ModelFile("two.model").c_str()); } },
    { "Resolution", [](vtkFieldLatentDecoder* f) { f->SetResolution(40, 20); } },
    { "GutterWidth", [](vtkFieldLatentDecoder* f) { f->SetGutterWidth(2); } },
    { "TextureArrayName", [](vtkFieldLatentDecoder* f) { f->SetTextureArrayName("B"); } },
    { "MemoryLimit", [](vtkFieldLatentDecoder* f) { f->SetMemoryLimit(100); } },
  };
  ExpectOneExecutionEach(decoder.Get(), changes, events);
}

TEST(FieldLatentCaching, RingsDependOnTheMeshOnly)
{
  const auto grid = TexturedGrid(4);
  AddColors(grid);
  const auto encoder = EncoderOn(grid, Pattern(), WriteFieldLatentModel("kept.model"));
  EXPECT_EQ(CostOf(encoder), (Cost{ 1, 1, 0 }));
  encoder->SetSamplesPerRing(30);
  EXPECT_EQ(CostOf(encoder), (Cost{ 1, 1, 0 }));
  encoder->SetTextureData(nullptr);
  encoder->SetColorArrayName("Color");
  EXPECT_EQ(CostOf(encoder), (Cost{ 1, 1, 0 })) << "other colors";
  encoder->SetModelFileName(WriteFieldLatentModel("kept_two.model", SmallFieldLatents(), 3).c_str());
  EXPECT_EQ(CostOf(encoder), (Cost{ 2, 1, 0 }));
  grid->GetPoints()->SetPoint(0, -0.1, 0.0, 0.3);
  grid->GetPoints()->Modified();
  EXPECT_EQ(CostOf(encoder), (Cost{ 2, 2, 0 }));
}

TEST(FieldLatentCaching, PlacesOfTexelsDependOnMeshesCoordinatesAndResolution)
{
  const std::string model = WriteFieldLatentModel("places.model");
  const auto coded = Encoded(TexturedGrid(4), Pattern(), model);
  const auto decoder = DecoderOn(coded, model);
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 1 }));
  coded->GetPointData()->GetArray("FieldLatent_0")->SetComponent(5, 0, 0.5);
  coded->GetPointData()->GetArray("FieldLatent_0")->Modified();
  coded->Modified();
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 1 })) << "other codes";
  decoder->SetResolution(32, 48);
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 2 }));
  coded->GetPointData()->GetTCoords()->SetComponent(0, 0, 0.01);
  coded->Modified();
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 3 }));
  const auto target = TexturedGrid(3);
  decoder->SetTargetData(target);
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 4 }));
  target->GetPoints()->SetPoint(0, -0.1, 0.0, 0.0);
  target->GetPoints()->Modified();
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 5 }));
  decoder->SetTextureArrayName("Other");
  EXPECT_EQ(CostOf(decoder), (Cost{ 1, 1, 5 }));
}

TEST(FieldLatentCaching, BitsDoNotDependOnThreads)
{
  const std::string model = WriteFieldLatentModel("threads.model");
  const auto sphere = Icosphere(IsSanitized() ? 2 : 4).ToPolyData();
  AddColors(sphere);
  ExpectSameBitsForAllThreads([&] { return EncoderOn(sphere, nullptr, model); }, CodesOf);
  const auto coded = Encoded(TexturedGrid(12), Pattern(), model);
  const auto target = TexturedGrid(5);
  ExpectSameBitsForAllThreads([&] { return DecoderOn(coded, model); }, TexelsOf);
  ExpectSameBitsForAllThreads(
    [&] {
      const auto decoder = DecoderOn(coded, model);
      decoder->SetTargetData(target);
      return decoder;
    },
    TexelsOf);
}

TEST(FieldLatentCaching, TwoFiltersOnTwoThreadsDoNotDisturbEachOther)
{
  const std::string model = WriteFieldLatentModel("two_threads.model");
  const auto make = [&] { return EncoderOn(TexturedGrid(12), Pattern(), model); };
  ExpectIndependence(make(), make(), make(), CodesOf);
  const auto decode = [&] { return DecoderOn(Encoded(TexturedGrid(6), Pattern(), model), model); };
  ExpectIndependence(decode(), decode(), decode(), TexelsOf);
}

TEST(FieldLatentCaching, AbortEmptiesTheOutputAndTheNextUpdateIsComplete)
{
  for (const double place : { 0.0, 0.5 })
  {
    ExpectAbortAndRecovery(LargeEncoder(), place, 1.0);
    const auto decoder = LargeDecoder();
    ExpectAbort(decoder, place);
    EXPECT_EQ(decoder->GetOutputDataObject(1)->GetNumberOfElements(vtkDataObject::POINT), 0);
    EXPECT_TRUE(Update(decoder));
    EXPECT_TRUE(TexelsOf(decoder));
  }
}

TEST(FieldLatentCaching, ProgressIsMonotoneFrequentAndOnTheCallingThread)
{
  ExpectSteadyProgress(LargeEncoder());
  ExpectSteadyProgress(LargeDecoder());
}
