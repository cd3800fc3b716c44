// SPDX-License-Identifier: BSD-3-Clause
//
// Each thing that can be wrong with a model file, a target or a property of vtkGeometricTextureSynthesizer, and the
// text that the user reads.
#include "GeometricTexturePipelines.h"

#include "FileBytes.h"
#include "FilterContract.h"

#include "IO/Weights/SafetensorsWriter.h"

#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStructuredGrid.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
std::string ErrorOfModel(const std::string& path) { return ErrorOf(SynthesizerOn(Icosphere(1).ToPolyData(), path)); }

std::string ErrorOfMesh(const Soup& soup)
{
  return ErrorOf(SynthesizerOn(soup.ToPolyData(), WriteRandomGeometricTexture("mesh.model")));
}
} // namespace

// --- Model files ----------------------------------------------------------------------------------------------------

TEST(GeometricTextureMessages, NoFileName)
{
  EXPECT_THAT(ErrorOfModel(""), AllOf(HasSubstr("ModelFileName is empty"), HasSubstr("geometric texture model")));
}

TEST(GeometricTextureMessages, MissingFile)
{
  EXPECT_THAT(ErrorOfModel("nowhere/none.safetensors"),
    AllOf(HasSubstr("\"nowhere/none.safetensors\""), HasSubstr("No such file"), HasSubstr("geometric texture")));
}

TEST(GeometricTextureMessages, AFolder) { EXPECT_THAT(ErrorOfModel("."), HasSubstr(". is not a file")); }

TEST(GeometricTextureMessages, TruncatedFile)
{
  WriteRandomGeometricTexture("truncated.model");
  std::string bytes = BytesOf("truncated.model");
  bytes.resize(bytes.size() - 100);
  WriteBytes("truncated.model", bytes);
  EXPECT_THAT(ErrorOfModel("truncated.model"), AllOf(HasSubstr("truncated.model"), HasSubstr("safetensors rule 7")));
}

TEST(GeometricTextureMessages, AModelOfAnotherKind)
{
  WriteSafetensors("other.model", {}, { { "architecture", "poissonnet" }, { "format_version", "1" } });
  EXPECT_THAT(ErrorOfModel("other.model"), AllOf(HasSubstr("\"poissonnet\""), HasSubstr("geometric_texture")));
}

TEST(GeometricTextureMessages, OneErrorForACompositeInput)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  const auto filter = SynthesizerOn(blocks, "nowhere.model");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
  filter->OutputLevelsOn();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
}

TEST(GeometricTextureMessages, AGoodFileAfterABadOne)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), "nowhere.model");
  filter->SetAnimationToLevels();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("nowhere.model"));
  EXPECT_EQ(filter->GetModelDescription(), "");
  filter->SetModelFileName(WriteRandomGeometricTexture("good.model").c_str());
  OutputOf(filter);
  EXPECT_THAT(filter->GetModelDescription(), HasSubstr("pebbles"));
}

TEST(GeometricTextureMessages, WeightsThatSinglePrecisionCannotHold)
{
  WriteRandomGeometricTexture("wild.model", 1, [](GeometricTextureModel& wild) {
    for (auto& [name, tensor] : wild.Generator)
    {
      for (float& value : tensor.Values)
      {
        value = value < 0.0F ? -3e38F : 3e38F;
      }
    }
  });
  EXPECT_THAT(ErrorOfModel("wild.model"), HasSubstr("is not finite"));
}

// --- Targets --------------------------------------------------------------------------------------------------------

TEST(GeometricTextureMessages, NeitherInputNorTemplate)
{
  const std::string model = WriteRandomGeometricTexture("bare.model", 1, [](GeometricTextureModel& bare) {
    bare.Template = {};
    bare.ReconstructionNoise.resize(0, 3);
  });
  EXPECT_THAT(ErrorOf(SynthesizerOn(nullptr, model)), AllOf(HasSubstr("There is no input"), HasSubstr("template")));
}

TEST(GeometricTextureMessages, EmptyInputIsNoError)
{
  vtkNew<vtkPolyData> empty;
  const auto filter = SynthesizerOn(empty, WriteRandomGeometricTexture("onempty.model"));
  OutputOf(filter);
  EXPECT_EQ(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfPoints(), 0);
  filter->OutputLevelsOn();
  OutputOf(filter);
  EXPECT_EQ(vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfPoints(), 0);
}

TEST(GeometricTextureMessages, AnotherTypeOfInput)
{
  vtkNew<vtkStructuredGrid> grid;
  EXPECT_THAT(ErrorOf(SynthesizerOn(grid, WriteRandomGeometricTexture("any.model"))),
    AllOf(HasSubstr("vtkStructuredGrid"), HasSubstr("vtkPolyData")));
}

TEST(GeometricTextureMessages, InconsistentWinding)
{
  Soup sphere = Icosphere(2);
  std::swap(sphere.Polys[7][0], sphere.Polys[7][1]);
  EXPECT_THAT(ErrorOfMesh(sphere), AllOf(HasSubstr("3 edge(s)"), HasSubstr("vtkPolyDataNormals")));
}

TEST(GeometricTextureMessages, PointsOnly)
{
  Soup points;
  points.AddPoint(0, 0, 0);
  points.Verts.push_back({ 0 });
  EXPECT_THAT(ErrorOfMesh(points), HasSubstr("no polygon"));
}

TEST(GeometricTextureMessages, TooManyTriangles)
{
  const auto filter = SynthesizerOn(Icosphere(5).ToPolyData(), WriteRandomGeometricTexture("many.model"));
  filter->SetTargetPreparationToSubdivide();
  filter->SetTextureScale(0.001);
  const double begin = Now();
  EXPECT_THAT(
    ErrorOf(filter), AllOf(HasSubstr("20480 triangles"), HasSubstr("10 subdivisions"), HasSubstr("TextureScale")));
  EXPECT_LT(Now() - begin, 5.0) << "before any work";
}

// --- Properties -----------------------------------------------------------------------------------------------------

TEST(GeometricTextureMessages, NamesOfArrays)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("name.model"));
  filter->SetLevelArrayName("Displacement");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"Displacement\""), HasSubstr("different names")));
  filter->SetLevelArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("LevelArrayName is empty"));
  filter->SetLevelArrayName("Level");
  filter->SetDisplacementArrayName("");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("DisplacementArrayName is empty"));
}

TEST(GeometricTextureMessages, NumbersThatAreNone)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("nan.model"));
  filter->SetTargetPreparationToSubdivide();
  filter->SetTextureScale(NAN);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("TextureScale is not a number"));
  filter->SetTargetPreparationToAsIs();
  filter->SetInterpolation(NAN);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("the interpolation is nan"));
  filter->SetInterpolation(0.0);
  filter->SetNoiseAmplitude(NAN);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("the amplitude of the noise is nan"));
  filter->SetNoiseAmplitude(-1.0);
  filter->SetStrength(NAN);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("Strength is not a number"));
  filter->SetStrength(1.0);
  filter->SetMaskFalloff(NAN);
  OutputOf(filter);
}

TEST(GeometricTextureMessages, StartLevelsAboveTheLastNameTheLevelsOnce)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, Icosphere(1).ToPolyData());
  const auto filter = SynthesizerOn(blocks, WriteRandomGeometricTexture("levels.model"));
  filter->SetStartLevel(99);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("StartLevel is 99; expected 0 to 1, the levels of the model."));
  filter->SetStartLevel(1);
  filter->SetEndLevel(0);
  EXPECT_THAT(
    ErrorOf(filter), HasSubstr("StartLevel is 1; expected 0 to 0 (EndLevel); the model has the levels 0 to 1."));
  filter->SetStartLevel(-1);
  OutputOf(filter);
  filter->SetStartLevel(1);
  filter->SetEndLevel(99);
  OutputOf(filter);
}

TEST(GeometricTextureMessages, ListsOfLevels)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("list.model"));
  for (const char* bad : { "one", "-1", "1.5", "0 1x", "99999999999999999999" })
  {
    filter->SetLevelsWithoutNoise(bad);
    EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("LevelsWithoutNoise"), HasSubstr("numbers of levels")));
  }
}

TEST(GeometricTextureMessages, Masks)
{
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("masked.model"));
  filter->SetMaskArrayName("Mask");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"Mask\" is missing"), HasSubstr("42 points")));
  vtkNew<vtkFloatArray> vectors;
  vectors->SetName("Mask");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(target->GetNumberOfPoints());
  vectors->Fill(0.5);
  target->GetPointData()->AddArray(vectors);
  filter->Modified();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("42 tuples of 3 components"));
  for (const double bad : { -0.5, 1.5, static_cast<double>(NAN), static_cast<double>(INFINITY) })
  {
    AddPointField(target, "Mask", [bad](const double* p) { return p[2] > 0.95 ? bad : 1.0; });
    filter->Modified();
    EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"Mask\" is "), HasSubstr("at point "), HasSubstr("from 0")));
  }
  AddPointField(target, "Mask", [](const double*) { return 1.0; });
  filter->Modified();
  OutputOf(filter);
}
