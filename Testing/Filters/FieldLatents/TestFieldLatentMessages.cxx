// SPDX-License-Identifier: BSD-3-Clause
//
// Each thing that can be wrong with a model file, a texture, codes, a mesh or a property, and the text that the user
// reads.
#include "FieldLatentPipelines.h"

#include "FilterContract.h"
#include "RandomGeometricTexture.h"

#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynth;
using namespace surfsynthtest;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{
const std::string& Model()
{
  static const std::string model = WriteFieldLatentModel("messages.model");
  return model;
}

vtkSmartPointer<vtkPolyData> CodedGrid() { return Encoded(TexturedGrid(4), Pattern(), Model()); }

/// The error of a decoder on a surface with codes after @p change.
template <typename Change>
std::string ErrorOfCodes(const Change& change)
{
  const auto coded = CodedGrid();
  change(coded->GetPointData());
  return ErrorOf(DecoderOn(coded, Model()));
}

/// Sets the texture coordinates of point 7, of cells 2, 3 and others, and returns the surface.
vtkSmartPointer<vtkPolyData> WithCoordinate(vtkSmartPointer<vtkPolyData> surface, double u, double v)
{
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->DeepCopy(surface->GetPointData()->GetTCoords());
  coordinates->SetTuple2(7, u, v);
  surface->GetPointData()->SetTCoords(coordinates);
  return surface;
}
} // namespace

TEST(FieldLatentMessages, ModelFiles)
{
  EXPECT_THAT(ErrorOf(EncoderOn(TexturedGrid(4), Pattern(), "")), HasSubstr("ModelFileName is empty"));
  EXPECT_THAT(ErrorOf(EncoderOn(TexturedGrid(4), Pattern(), "missing.model")),
    AllOf(HasSubstr("missing.model"), HasSubstr("cannot be read"), HasSubstr("field-latent model")));
  EXPECT_THAT(ErrorOf(DecoderOn(CodedGrid(), "")), HasSubstr("ModelFileName is empty"));
  EXPECT_THAT(ErrorOf(EncoderOn(TexturedGrid(4), Pattern(), "not_installed")),
    AllOf(HasSubstr("no installed model \"not_installed\""), HasSubstr("the path of a model file")));
  const std::string other = ModelFile("texture.model");
  WriteGeometricTexture(other, surfsynth::test::RandomGeometricTexture());
  EXPECT_THAT(ErrorOf(EncoderOn(TexturedGrid(4), Pattern(), other)),
    AllOf(HasSubstr("geometric_texture"), HasSubstr("field_latents")));
  EXPECT_THAT(ErrorOf(DecoderOn(CodedGrid(), other)), HasSubstr("field_latents"));
}

TEST(FieldLatentMessages, Names)
{
  const auto encoder = EncoderOn(TexturedGrid(4), Pattern(), Model());
  encoder->SetLatentArrayName("");
  EXPECT_THAT(ErrorOf(encoder), HasSubstr("LatentArrayName is empty"));
  const auto decoder = DecoderOn(CodedGrid(), Model());
  decoder->SetTextureArrayName(nullptr);
  EXPECT_THAT(ErrorOf(decoder), HasSubstr("TextureArrayName is empty"));
}

TEST(FieldLatentMessages, NamesOfOtherRoles)
{
  const auto decoder = DecoderOn(CodedGrid(), Model());
  for (const char* name : { "FieldLatent_0", "FieldLatentRadius", "FieldLatentDeviation" })
  {
    decoder->SetTextureArrayName(name);
    EXPECT_THAT(ErrorOf(decoder), AllOf(HasSubstr(name), HasSubstr("an array of field latents"))) << name;
  }
  decoder->SetTextureArrayName(CodedGrid()->GetPointData()->GetTCoords()->GetName());
  EXPECT_THAT(ErrorOf(decoder), HasSubstr("the name of the texture coordinates"));
  decoder->SetTextureArrayName("FieldLatent_");
  EXPECT_THAT(WarningsOf(decoder), IsEmpty());
  const auto colored = TexturedGrid(4);
  AddColors(colored);
  colored->GetPointData()->GetArray("Color")->SetName("FieldLatent_1");
  const auto encoder = EncoderOn(colored, nullptr, Model());
  encoder->SetColorArrayName("FieldLatent_1");
  EXPECT_THAT(
    ErrorOf(encoder), AllOf(HasSubstr("colors"), HasSubstr("\"FieldLatent_1\""), HasSubstr("LatentArrayName")));
  encoder->SetTextureData(Pattern());
  EXPECT_THAT(WarningsOf(encoder), IsEmpty()) << "then these are no colors";
  colored->GetPointData()->GetTCoords()->SetName("FieldLatent_0");
  EXPECT_THAT(ErrorOf(encoder), AllOf(HasSubstr("texture coordinates"), HasSubstr("\"FieldLatent_0\"")));
}

TEST(FieldLatentMessages, TextureCoordinates)
{
  EXPECT_THAT(ErrorOf(EncoderOn(Grid(4).ToPolyData(), Pattern(), Model())),
    AllOf(HasSubstr("no texture coordinates"), HasSubstr("vtkTextureAtlasFilter")));
  EXPECT_THAT(ErrorOf(EncoderOn(WithCoordinate(TexturedGrid(4), std::nan(""), 0.0), Pattern(), Model())),
    AllOf(HasSubstr("6 cell(s) with a NaN or infinite texture coordinate"), HasSubstr("first cell"),
      HasSubstr("vtkTextureAtlasFilter")));
  const auto without = CodedGrid();
  without->GetPointData()->SetTCoords(nullptr);
  EXPECT_THAT(ErrorOf(DecoderOn(without, Model())), HasSubstr("vtkTextureAtlasFilter"));
  EXPECT_THAT(ErrorOf(DecoderOn(WithCoordinate(CodedGrid(), 1.5, 0.5), Model())),
    AllOf(HasSubstr("6 cell(s) with texture coordinates outside [0, 1]"), HasSubstr("first cell")));
  EXPECT_THAT(WarningsOf(EncoderOn(WithCoordinate(TexturedGrid(4), 1.45, 0.42), Pattern(), Model())), IsEmpty())
    << "a repeated texture can be looked up";
  EXPECT_THAT(WarningsOf(DecoderOn(WithCoordinate(CodedGrid(), 0.91, 0.87), Model())),
    ElementsAre(AllOf(HasSubstr("texel(s) that several cells share"), HasSubstr("first the cells"))));
}

TEST(FieldLatentMessages, CellsWithoutAreaInTheTextureAreAWarning)
{
  const auto grid = TexturedGrid(4);
  AddTextureCoordinates(
    grid,
    [](double x, double y, double) {
      return std::array<double, 2>{ std::max(x, 0.25), y };
    },
    VTK_DOUBLE);
  EXPECT_THAT(WarningsOf(EncoderOn(grid, Pattern(), Model())),
    ElementsAre(AllOf(HasSubstr("8 cell(s) without area in the texture"), HasSubstr("first cell 0"))));
  EXPECT_THAT(WarningsOf(DecoderOn(Encoded(TexturedGrid(4), Pattern(), Model()), Model())), IsEmpty());
}

TEST(FieldLatentMessages, Images)
{
  const auto errorOf = [](vtkImageData* image) { return ErrorOf(EncoderOn(TexturedGrid(4), image, Model())); };
  vtkNew<vtkImageData> image;
  EXPECT_THAT(errorOf(image), HasSubstr("has 0 x 0 x 0 texels"));
  image->SetDimensions(4, 4, 2);
  EXPECT_THAT(errorOf(image), AllOf(HasSubstr("4 x 4 x 2"), HasSubstr("vtkExtractVOI")));
  image->SetDimensions(4, 4, 1);
  EXPECT_THAT(errorOf(image), HasSubstr("no active point scalars"));
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 5);
  EXPECT_THAT(errorOf(image), HasSubstr("5 components"));
  const auto notFinite = Pattern(3, VTK_FLOAT);
  notFinite->SetScalarComponentFromDouble(3, 0, 0, 1, std::nan(""));
  EXPECT_THAT(errorOf(notFinite), AllOf(HasSubstr("not finite"), HasSubstr("place 3")));
}

TEST(FieldLatentMessages, WarningsOfImages)
{
  const auto warningsOf = [](vtkImageData* given) { return WarningsOf(EncoderOn(TexturedGrid(4), given, Model())); };
  EXPECT_THAT(warningsOf(Pattern(4)), IsEmpty());
  const auto translucent = Pattern(4);
  translucent->SetScalarComponentFromDouble(1, 0, 0, 3, 100.0);
  EXPECT_THAT(warningsOf(translucent), ElementsAre(AllOf(HasSubstr("alpha"), HasSubstr("1 of 1536"))));
  const auto bright = Pattern(3, VTK_FLOAT);
  bright->SetScalarComponentFromDouble(1, 0, 0, 0, 255.0);
  EXPECT_THAT(warningsOf(bright), ElementsAre(AllOf(HasSubstr("to 255"), HasSubstr("clamped"))));
  const auto dark = Pattern(3, VTK_INT);
  for (vtkIdType t = 0; t < dark->GetPointData()->GetScalars()->GetNumberOfTuples(); ++t)
  {
    dark->GetPointData()->GetScalars()->SetTuple3(t, 10.0, 200.0, 30.0);
  }
  EXPECT_THAT(warningsOf(dark), ElementsAre(AllOf(HasSubstr("nearly black"), HasSubstr("unsigned char"))));
}

TEST(FieldLatentMessages, PointColors)
{
  EXPECT_THAT(ErrorOf(EncoderOn(TexturedGrid(4), nullptr, Model())),
    AllOf(HasSubstr("\"Color\""), HasSubstr("ColorArrayName"), HasSubstr("port 1")));
  const auto encoder = EncoderOn(TexturedGrid(4), nullptr, Model());
  encoder->SetColorArrayName("");
  EXPECT_THAT(ErrorOf(encoder), HasSubstr("no active scalars"));
  const auto surface = TexturedGrid(4);
  AddColors(surface);
  surface->GetPointData()->GetArray("Color")->SetComponent(9, 1, std::nan(""));
  EXPECT_THAT(
    ErrorOf(EncoderOn(surface, nullptr, Model())), AllOf(HasSubstr("\"Color\""), HasSubstr("not finite at place 9")));
}

TEST(FieldLatentMessages, Codes)
{
  EXPECT_THAT(ErrorOf(DecoderOn(TexturedGrid(4), Model())),
    AllOf(HasSubstr("\"FieldLatent_0\""), HasSubstr("vtkFieldLatentEncoder")));
  EXPECT_THAT(ErrorOfCodes([](vtkPointData* data) { data->RemoveArray("FieldLatent_1"); }),
    AllOf(HasSubstr("1 point array"), HasSubstr("needs 2")));
  EXPECT_THAT(ErrorOfCodes([](vtkPointData* data) { data->RemoveArray("FieldLatentRadius"); }),
    HasSubstr("\"FieldLatentRadius\""));
  EXPECT_THAT(
    ErrorOfCodes([](vtkPointData* data) { data->GetArray("FieldLatent_1")->SetComponent(3, 0, std::nan("")); }),
    AllOf(HasSubstr("\"FieldLatent_1\""), HasSubstr("point 3")));
  EXPECT_THAT(ErrorOfCodes([](vtkPointData* data) { data->GetArray("FieldLatentRadius")->SetComponent(4, 0, 0.0); }),
    AllOf(HasSubstr("not larger than 0"), HasSubstr("point 4")));
  EXPECT_THAT(ErrorOfCodes([](vtkPointData* data) {
    vtkNew<vtkDoubleArray> other;
    other->SetName("FieldLatent_0");
    other->SetNumberOfComponents(2);
    other->SetNumberOfTuples(25);
    other->Fill(0.0);
    data->AddArray(other);
  }),
    AllOf(HasSubstr("\"FieldLatent_0\""), HasSubstr("2 components")));
  FieldLatentOptions options = SmallFieldLatents();
  options.LatentDimension = 1;
  EXPECT_THAT(
    ErrorOf(DecoderOn(CodedGrid(), WriteFieldLatentModel("one_vector.model", options))), HasSubstr("needs 1"));
}

TEST(FieldLatentMessages, SurfacesThatWereScaledOrTurnedAfterEncodingAreAWarning)
{
  const auto bumpy = [](double scale, double angle) {
    const auto grid = TexturedGrid(5);
    for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
    {
      double x[3];
      grid->GetPoint(p, x);
      const double z = 0.1 * std::sin(6.0 * x[0]) * std::cos(5.0 * x[1]);
      grid->GetPoints()->SetPoint(p, scale * x[0], scale * (std::cos(angle) * x[1] - std::sin(angle) * z),
        scale * (std::sin(angle) * x[1] + std::cos(angle) * z));
    }
    return grid;
  };
  const auto coded = Encoded(bumpy(1.0, 0.0), Pattern(), Model());
  const auto warningsAfter = [&](double scale, double angle) {
    vtkNew<vtkPolyData> moved;
    moved->ShallowCopy(coded);
    moved->SetPoints(bumpy(scale, angle)->GetPoints());
    return WarningsOf(DecoderOn(moved, Model()));
  };
  EXPECT_THAT(warningsAfter(1.0, 0.0), IsEmpty());
  EXPECT_THAT(warningsAfter(2.5, 0.0),
    ElementsAre(AllOf(HasSubstr("2.5 times the radius"), HasSubstr("FieldLatentRadius"), HasSubstr("scaled after"))));
  EXPECT_THAT(warningsAfter(1.0, 0.5), ElementsAre(AllOf(HasSubstr("tangent planes"), HasSubstr("turned or bent"))));
  coded->GetPointData()->GetArray("FieldLatentRadius")->SetComponent(3, 0, 0.5);
  EXPECT_THAT(warningsAfter(2.5, 0.5), IsEmpty()) << "other radii are those of another triangulation";
}

TEST(FieldLatentMessages, Meshes)
{
  Soup flipped = Grid(4);
  std::swap(flipped.Polys[5][0], flipped.Polys[5][1]);
  const auto surface = flipped.ToPolyData();
  AddColors(surface);
  EXPECT_THAT(ErrorOf(EncoderOn(surface, nullptr, Model())), HasSubstr("vtkSurfaceRepairFilter"));
  vtkNew<vtkPolyData> points;
  points->SetPoints(Grid(2).ToPolyData()->GetPoints());
  EXPECT_THAT(ErrorOf(EncoderOn(points, Pattern(), Model())), HasSubstr("polygon"));
}

TEST(FieldLatentMessages, Targets)
{
  const auto decoder = DecoderOn(CodedGrid(), Model());
  decoder->SetTargetData(Grid(3).ToPolyData());
  EXPECT_THAT(ErrorOf(decoder), HasSubstr("vtkTextureAtlasFilter"));
  vtkNew<vtkPolyData> points;
  points->SetPoints(Grid(2).ToPolyData()->GetPoints());
  decoder->SetTargetData(points);
  EXPECT_THAT(ErrorOf(decoder), HasSubstr("The target on port 1"));
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, CodedGrid());
  decoder->SetInputDataObject(blocks);
  decoder->SetTargetData(TexturedGrid(3));
  EXPECT_THAT(ErrorOf(decoder), HasSubstr("composite dataset"));
}

TEST(FieldLatentMessages, AResolutionBeyondTheMemoryNamesOneThatFits)
{
  const auto decoder = DecoderOn(CodedGrid(), Model());
  decoder->SetResolution(2048, 1024);
  decoder->SetMemoryLimit(1);
  EXPECT_THAT(ErrorOf(decoder), AllOf(HasSubstr("MemoryLimit"), HasSubstr("176 x 88 texels fit")));
  decoder->SetResolution(176, 88);
  EXPECT_THAT(WarningsOf(decoder), IsEmpty());
}
