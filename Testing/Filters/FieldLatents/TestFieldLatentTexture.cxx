// SPDX-License-Identifier: BSD-3-Clause
//
// vtkFieldLatentTextureFilter: samples, guidance, triangulations, atlases, kept results, messages. Models have random
// weights: textures mean nothing, but all contracts hold.
#include "FieldLatentPipelines.h"
#include "FilterContract.h"
#include "RandomLatentDiffusion.h"
#include "RegularRings.h"
#include "SurfaceBridge.h"

#include "vtkFieldLatentTextureFilter.h"

#include "Core/Tangent/TangentHierarchy.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

using namespace surfsynth;
using namespace surfsynthtest;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{
constexpr int Steps = 4;

const std::string& Autoencoder()
{
  static const std::string model = WriteFieldLatentModel("texture.autoencoder");
  return model;
}

/// Writes a diffusion model whose predictions are about as large as the noise.
std::string WriteDiffusion(
  const std::string& name, const LatentDiffusionOptions& options, const std::string& fingerprint)
{
  LatentDiffusionModel model = surfsynth::test::RandomLatentDiffusion(options);
  for (float& value : model.Tensors["output.weight"].Values)
  {
    value *= 0.1F;
  }
  model.Autoencoder = fingerprint;
  model.TrainingPoints = 90;
  WriteLatentDiffusion(name, model);
  return name;
}

/// A model with labels and directions, of Autoencoder().
const std::string& Diffusion()
{
  static const std::string model = WriteDiffusion(
    "texture.diffusion", surfsynth::test::TinyLatentDiffusion(), Fingerprint(ReadFieldLatents(Autoencoder())));
  return model;
}

vtkSmartPointer<vtkFieldLatentTextureFilter> FilterOn(vtkDataObject* surface)
{
  auto filter = vtkSmartPointer<vtkFieldLatentTextureFilter>::New();
  filter->SetInputDataObject(surface);
  filter->SetModelFileName(Diffusion().c_str());
  filter->SetAutoencoderFileName(Autoencoder().c_str());
  filter->SetTriangulationToAsIs();
  filter->SetNumberOfSteps(Steps);
  filter->SetResolution(32, 32);
  return filter;
}

/// A hilly square without two rings of the same area, by which the levels of the network order vertices, and with
/// texture coordinates.
vtkSmartPointer<vtkPolyData> IrregularGrid(int n)
{
  auto grid = TexturedGrid(n);
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    double x[3];
    grid->GetPoint(p, x);
    const double shift = 0.2 / n;
    grid->GetPoints()->SetPoint(p, x[0] + shift * std::sin(37.0 * x[0] + 91.0 * x[1]),
      x[1] + shift * std::sin(53.0 * x[0] - 71.0 * x[1]), 0.1 * std::sin(5.0 * x[0] + 3.0 * x[1]));
  }
  return grid;
}

/// Such a square with labels 0 to 2, directions along x and colors.
vtkSmartPointer<vtkPolyData> GuidedGrid(int n = 8)
{
  auto grid = IrregularGrid(n);
  vtkNew<vtkIntArray> labels;
  labels->SetName("Part");
  vtkNew<vtkFloatArray> directions;
  directions->SetName("Along");
  directions->SetNumberOfComponents(3);
  vtkNew<vtkFloatArray> masks;
  masks->SetName("Kept");
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    double x[3];
    grid->GetPoint(p, x);
    labels->InsertNextValue(std::min(2, static_cast<int>(3.0 * x[0])));
    directions->InsertNextTuple3(7.0, 0.0, 0.0);
    masks->InsertNextValue(x[1] < 0.5 ? 1.0F : 0.0F);
  }
  grid->GetPointData()->AddArray(labels);
  grid->GetPointData()->AddArray(directions);
  grid->GetPointData()->AddArray(masks);
  AddColors(grid);
  return grid;
}

vtkPolyData* LatentsOf(vtkAlgorithm* filter) { return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(2)); }

vtkDataArray* FirstLatent(vtkAlgorithm* filter) { return LatentsOf(filter)->GetPointData()->GetArray("FieldLatent_0"); }

/// The surface with its points and cells in reverse order, and its texture coordinates.
vtkSmartPointer<vtkPolyData> Reversed(vtkPolyData* surface)
{
  const vtkIdType last = surface->GetNumberOfPoints() - 1;
  auto other = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(2);
  for (vtkIdType p = last; p >= 0; --p)
  {
    points->InsertNextPoint(surface->GetPoint(p));
    coordinates->InsertNextTuple(surface->GetPointData()->GetTCoords()->GetTuple(p));
  }
  vtkNew<vtkCellArray> cells;
  for (vtkIdType c = surface->GetNumberOfCells() - 1; c >= 0; --c)
  {
    const vtkIdType* ids = nullptr;
    vtkIdType count = 0;
    surface->GetCellPoints(c, count, ids);
    const vtkIdType turned[3] = { last - ids[1], last - ids[2], last - ids[0] };
    cells->InsertNextCell(3, turned);
  }
  other->SetPoints(points);
  other->SetPolys(cells);
  other->GetPointData()->SetTCoords(coordinates);
  return other;
}
} // namespace

TEST(FieldLatentTexture, SampleHasImageColorsAndLatents)
{
  const auto grid = GuidedGrid();
  const std::uint64_t before = HashOf(grid);
  const auto filter = FilterOn(grid);
  const auto surface = SurfaceOf(filter);
  EXPECT_EQ(surface->GetNumberOfPoints(), grid->GetNumberOfPoints());
  EXPECT_STREQ(surface->GetPointData()->GetScalars()->GetName(), "Texture");
  EXPECT_TRUE(surface->GetPointData()->HasArray("Part"));
  ASSERT_TRUE(ImageOf(filter));
  EXPECT_EQ(ImageOf(filter)->GetDimensions()[0], 32);
  EXPECT_GT(TexelsOf(filter)->GetRange(0)[1], TexelsOf(filter)->GetRange(0)[0]);
  EXPECT_EQ(LatentsOf(filter)->GetNumberOfPoints(), grid->GetNumberOfPoints());
  EXPECT_EQ(filter->GetNumberOfVertices(), grid->GetNumberOfPoints());
  // The decoder makes the same image of the latents on the target.
  const auto decoder = DecoderOn(LatentsOf(filter), Autoencoder());
  decoder->SetTargetData(grid);
  decoder->SetResolution(32, 32);
  SurfaceOf(decoder);
  EXPECT_LE(LargestDifference(TexelsOf(decoder), TexelsOf(filter)), 1.0);
  EXPECT_EQ(HashOf(grid), before);
}

TEST(FieldLatentTexture, NumbersOfPointsAndCellsDoNotMatter)
{
  for (const int method : { vtkFieldLatentTextureFilter::DDIM, vtkFieldLatentTextureFilter::DDPM })
  {
    const auto a = FilterOn(IrregularGrid(7));
    const auto b = FilterOn(Reversed(IrregularGrid(7)));
    a->SetSampler(method);
    b->SetSampler(method);
    SurfaceOf(a);
    SurfaceOf(b);
    EXPECT_LE(LargestDifference(TexelsOf(a), TexelsOf(b)), 1.0);
    double largest = 0.0;
    const vtkIdType last = FirstLatent(a)->GetNumberOfTuples() - 1;
    for (vtkIdType p = 0; p <= last; ++p)
    {
      for (int c = 0; c < 3; ++c)
      {
        largest = std::max(
          largest, std::abs(FirstLatent(a)->GetComponent(p, c) - FirstLatent(b)->GetComponent(last - p, c)));
      }
    }
    EXPECT_LT(largest, 1e-4 * std::max(1.0, FirstLatent(a)->GetMaxNorm()));
  }
}

TEST(FieldLatentTexture, SeedsSamplesAndBlocksDiffer)
{
  const auto make = [] { return vtkSmartPointer<vtkAlgorithm>(FilterOn(IrregularGrid(6))); };
  ExpectSameBitsForAllThreads(make, [](vtkAlgorithm* filter) { return FirstLatent(filter); });
  const auto one = FilterOn(IrregularGrid(6));
  SurfaceOf(one);
  const auto other = FilterOn(IrregularGrid(6));
  other->SetSeed(1);
  SurfaceOf(other);
  EXPECT_FALSE(SameBits(FirstLatent(one), FirstLatent(other)));
  one->SetFirstSample(2);
  SurfaceOf(one);
  const auto batch = FilterOn(IrregularGrid(6));
  batch->SetFirstSample(1);
  batch->SetNumberOfSamples(2);
  const auto blocks = OutputOf(batch);
  ASSERT_TRUE(vtkMultiBlockDataSet::SafeDownCast(blocks));
  auto* latents = vtkMultiBlockDataSet::SafeDownCast(batch->GetOutputDataObject(2));
  auto* images = vtkMultiBlockDataSet::SafeDownCast(batch->GetOutputDataObject(1));
  ASSERT_TRUE(latents && images);
  EXPECT_STREQ(images->GetMetaData(1u)->Get(vtkCompositeDataSet::NAME()), "Sample 2");
  EXPECT_TRUE(SameBits(PointArray(latents->GetBlock(1), "FieldLatent_0"), FirstLatent(one)));
  EXPECT_FALSE(SameBits(PointArray(latents->GetBlock(0), "FieldLatent_0"), FirstLatent(one)));
  vtkNew<vtkMultiBlockDataSet> two;
  two->SetBlock(0, IrregularGrid(6));
  two->SetBlock(1, IrregularGrid(6));
  const auto composite = FilterOn(two);
  OutputOf(composite);
  auto* parts = vtkMultiBlockDataSet::SafeDownCast(composite->GetOutputDataObject(2));
  EXPECT_FALSE(
    SameBits(PointArray(parts->GetBlock(0), "FieldLatent_0"), PointArray(parts->GetBlock(1), "FieldLatent_0")));
}

TEST(FieldLatentTexture, GuidanceChangesSamples)
{
  const auto plain = FilterOn(GuidedGrid());
  SurfaceOf(plain);
  const auto labels = FilterOn(GuidedGrid());
  labels->SetLabelArrayName("Part");
  SurfaceOf(labels);
  EXPECT_GT(LargestDifference(FirstLatent(plain), FirstLatent(labels)), 1e-3);
  const auto directed = FilterOn(GuidedGrid());
  directed->SetDirectionArrayName("Along");
  SurfaceOf(directed);
  EXPECT_GT(LargestDifference(FirstLatent(plain), FirstLatent(directed)), 1e-3);
}

TEST(FieldLatentTexture, MaskKeepsTheTexture)
{
  const auto grid = GuidedGrid();
  grid->GetPointData()->SetActiveScalars("Color");
  const auto filter = FilterOn(grid);
  filter->SetMaskArrayName("Kept");
  SurfaceOf(filter);
  const auto encoded = Encoded(grid, nullptr, Autoencoder(), 128);
  vtkDataArray* codes = encoded->GetPointData()->GetArray("FieldLatent_0");
  double kept = 0.0;
  double made = 0.0;
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    double& largest = grid->GetPoint(p)[1] < 0.5 ? kept : made;
    for (int c = 0; c < 3; ++c)
    {
      largest = std::max(largest, std::abs(codes->GetComponent(p, c) - FirstLatent(filter)->GetComponent(p, c)));
    }
  }
  EXPECT_LT(kept, 1e-5);
  EXPECT_GT(made, 1e-2);
  // The same colors as an image.
  const auto withImage = FilterOn(grid);
  withImage->SetTextureData(Pattern());
  withImage->SetMaskArrayName("Kept");
  SurfaceOf(withImage);
  EXPECT_GT(LargestDifference(FirstLatent(filter), FirstLatent(withImage)), 1e-3);
}

TEST(FieldLatentTexture, RegularGridsAreAWarning)
{
  const auto warnings = WarningsOf(FilterOn(TexturedGrid(6)));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("25 of 49 vertices"), HasSubstr("color is lost"), HasSubstr("REMESH")));
  EXPECT_THAT(WarningsOf(FilterOn(IrregularGrid(6))), IsEmpty());
}

TEST(RegularRings, MoveWithinTheSurfaceUntilNoneIsLeft)
{
  Surface surface = ConvertSurface(TexturedGrid(8));
  const TriangleMesh source = surface.Mesh;
  EXPECT_EQ(RegularVertices(OneRings(source)).size(), 49U);
  std::vector<SurfacePlace> places(81);
  MoveRegularVertices(source, surface, places);
  EXPECT_TRUE(RegularVertices(OneRings(surface.Mesh)).empty());
  const Eigen::VectorXd moves = (surface.Mesh.Points - source.Points).rowwise().norm();
  for (Index v = 0; v < 81; ++v)
  {
    const bool inside = v % 9 > 0 && v % 9 < 8 && v / 9 > 0 && v / 9 < 8;
    EXPECT_EQ(moves[v] > 0.0, inside) << v;
    EXPECT_LT(moves[v], 3 * 0.25 * std::sqrt(2.0) / 8.0) << v;
    EXPECT_EQ(places[v].Triangle >= 0, inside) << v;
    if (inside)
    {
      const auto point = [&](int k) { return source.Points.row(source.Triangles(places[v].Triangle, k)); };
      const Eigen::RowVector3d at = places[v].Weights[0] * point(0) + places[v].Weights[1] * point(1) +
        places[v].Weights[2] * point(2);
      EXPECT_LT((at - surface.Mesh.Points.row(v)).norm(), 1e-12) << v;
    }
  }
  Surface again = ConvertSurface(TexturedGrid(8));
  MoveRegularVertices(source, again, places);
  EXPECT_EQ(again.Mesh.Points, surface.Mesh.Points);
  Surface irregular = ConvertSurface(IrregularGrid(8));
  const PointMatrix before = irregular.Mesh.Points;
  const std::vector<Index> central = CentralVertices(OneRings(irregular.Mesh), 0.05);
  MoveRegularVertices(TriangleMesh(irregular.Mesh), irregular, places);
  const PointMatrix far = irregular.Mesh.Points;
  EXPECT_TRUE(CentralVertices(OneRings(irregular.Mesh), 0.05).empty());
  MoveRegularVertices(TriangleMesh(irregular.Mesh), irregular, places);
  EXPECT_EQ(irregular.Mesh.Points, far) << "where no vertex is near its centroid, not a bit changes";
  EXPECT_LT(central.size(), 5U) << "few are by chance";
  EXPECT_GE((far - before).rowwise().norm().cwiseSign().sum(), static_cast<double>(central.size()));
}

TEST(RegularRings, VerticesOnCreasesStayOnThem)
{
  const auto grid = TexturedGrid(8);
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    double x[3];
    grid->GetPoint(p, x);
    grid->GetPoints()->SetPoint(p, std::min(x[0], 0.5), x[1], std::max(x[0] - 0.5, 0.0)); // a right angle at x = 0.5
  }
  Surface surface = ConvertSurface(grid);
  const TriangleMesh source = surface.Mesh;
  std::vector<SurfacePlace> places(81);
  MoveRegularVertices(source, surface, places);
  EXPECT_TRUE(RegularVertices(OneRings(surface.Mesh)).empty());
  for (Index v = 4 + 9; v < 4 + 9 * 8; v += 9)
  {
    EXPECT_NE(surface.Mesh.Points(v, 1), source.Points(v, 1)) << v;
    EXPECT_NEAR(surface.Mesh.Points(v, 0), 0.5, 1e-12) << v;
    EXPECT_NEAR(surface.Mesh.Points(v, 2), 0.0, 1e-12) << v;
  }
}

TEST(FieldLatentTexture, ResultsAreKept)
{
  const auto filter = FilterOn(GuidedGrid());
  SurfaceOf(filter);
  EXPECT_EQ(filter->GetNumberOfEvaluations(), Steps);
  filter->SetResolution(16, 16);
  filter->SetTextureArrayName("Bark");
  SurfaceOf(filter);
  EXPECT_EQ(filter->GetNumberOfEvaluations(), Steps);
  filter->SetSeed(5);
  SurfaceOf(filter);
  EXPECT_EQ(filter->GetNumberOfEvaluations(), 2 * Steps);
  filter->SetLabelArrayName("Part");
  SurfaceOf(filter);
  EXPECT_EQ(filter->GetNumberOfEvaluations(), 3 * Steps);
  EXPECT_EQ(filter->GetNumberOfTriangulations(), 1);
  EXPECT_EQ(filter->GetNumberOfModelLoads(), 1);
}

TEST(FieldLatentTexture, TrajectoryEndsAtTheSample)
{
  const auto end = FilterOn(IrregularGrid(6));
  SurfaceOf(end);
  const auto filter = FilterOn(IrregularGrid(6));
  filter->OutputTrajectoryOn();
  SurfaceOf(filter, 0.0);
  EXPECT_FALSE(SameBits(FirstLatent(filter), FirstLatent(end)));
  SurfaceOf(filter, 1.0);
  EXPECT_TRUE(SameBits(FirstLatent(filter), FirstLatent(end)));
  EXPECT_EQ(filter->GetNumberOfEvaluations(), Steps);
}

TEST(FieldLatentTexture, EmptyInputGivesEmptyOutput)
{
  const auto filter = FilterOn(vtkSmartPointer<vtkPolyData>::New());
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPoints(), 0);
  EXPECT_EQ(LatentsOf(filter)->GetNumberOfPoints(), 0);
}

TEST(FieldLatentTexture, StopsAndPrints)
{
  ExpectAbort(FilterOn(TexturedGrid(8)), 0.3);
  std::ostringstream text;
  FilterOn(TexturedGrid(2))->Print(text);
  EXPECT_THAT(text.str(), AllOf(HasSubstr("NumberOfSteps: 4"), HasSubstr("Resolution: 32 x 32")));
}

#ifdef SURFACE_SYNTHESIS_CGAL
TEST(FieldLatentTexture, RemeshesToTheNumberOfPoints)
{
  // The model knows 90 points; the surface has 289 and gets an atlas.
  const auto surface = Reversed(IrregularGrid(16));
  surface->GetPointData()->SetTCoords(nullptr);
  const auto filter = FilterOn(surface);
  filter->SetTriangulationToRemesh();
  const auto result = SurfaceOf(filter);
  EXPECT_TRUE(result->GetPointData()->GetTCoords());
  EXPECT_NEAR(static_cast<double>(filter->GetNumberOfVertices()), 90.0, 12.0);
  filter->SetNumberOfPoints(200);
  SurfaceOf(filter);
  EXPECT_NEAR(static_cast<double>(filter->GetNumberOfVertices()), 200.0, 20.0);
  EXPECT_EQ(filter->GetNumberOfTriangulations(), 2);
  filter->SetMaskArrayName("Kept");
  filter->SetTextureData(Pattern());
  EXPECT_THAT(ErrorOf(filter), HasSubstr("no texture coordinates"));
}

TEST(FieldLatentTexture, RemeshedRegularGridsAreNoLongerRegular)
{
  // Remeshing to about its own number of points leaves a regular grid as it is.
  const auto filter = FilterOn(TexturedGrid(12));
  filter->SetTriangulationToRemesh();
  filter->SetNumberOfPoints(169);
  SurfaceOf(filter);
  const Surface latents = ConvertSurface(LatentsOf(filter));
  EXPECT_THAT(RegularVertices(OneRings(latents.Mesh)), IsEmpty());
}

TEST(FieldLatentTexture, RemeshedSurfacesKeepTheirTextureAndGuidance)
{
  const auto grid = GuidedGrid(12);
  grid->GetPointData()->SetActiveScalars("Color");
  const auto filter = FilterOn(grid);
  filter->SetTriangulationToRemesh();
  filter->SetNumberOfPoints(120);
  filter->SetMaskArrayName("Kept");
  filter->SetLabelArrayName("Part");
  filter->SetDirectionArrayName("Along");
  SurfaceOf(filter);
  EXPECT_EQ(filter->GetNumberOfEvaluations(), Steps);
}
#endif

TEST(FieldLatentTextureMessages, NameWhatIsWrong)
{
  const auto filter = FilterOn(GuidedGrid());
  const auto error = [&filter] { return ErrorOf(filter); };
  filter->SetModelFileName("");
  EXPECT_THAT(error(), HasSubstr("ModelFileName is empty"));
  filter->SetModelFileName(Autoencoder().c_str());
  EXPECT_THAT(error(), HasSubstr("field_latents"));
  filter->SetModelFileName(Diffusion().c_str());
  filter->SetAutoencoderFileName("");
  EXPECT_THAT(error(), HasSubstr("AutoencoderFileName is empty"));
  filter->SetAutoencoderFileName("nowhere.model");
  EXPECT_THAT(error(), AllOf(HasSubstr("nowhere.model"), HasSubstr("AutoencoderFileName")));
  filter->SetAutoencoderFileName(Autoencoder().c_str());
  filter->SetNumberOfSteps(101);
  EXPECT_THAT(error(), AllOf(HasSubstr("NumberOfSteps is 101"), HasSubstr("100 time steps")));
  filter->SetNumberOfSteps(Steps);
  filter->SetLabelArrayName("Color");
  EXPECT_THAT(error(), AllOf(HasSubstr("Color"), HasSubstr("LabelArrayName")));
  filter->SetLabelArrayName("Kept1");
  EXPECT_THAT(error(), AllOf(HasSubstr("Kept1"), HasSubstr("LabelArrayName")));
  filter->SetLabelArrayName("");
  filter->SetDirectionArrayName("Part");
  EXPECT_THAT(error(), AllOf(HasSubstr("Part"), HasSubstr("DirectionArrayName")));
  filter->SetDirectionArrayName("");
  filter->SetMaskArrayName("Part");
  EXPECT_THAT(error(), AllOf(HasSubstr("Part"), HasSubstr("MaskArrayName"), HasSubstr("from 0")));
  filter->SetMaskArrayName("");
  filter->SetMemoryLimit(1);
  filter->SetResolution(1024, 1024);
  EXPECT_THAT(error(), HasSubstr("MemoryLimit"));
}

TEST(FieldLatentTextureMessages, LabelsAreWholeNumbersOfTheModel)
{
  const auto grid = GuidedGrid();
  vtkNew<vtkFloatArray> halves;
  halves->SetName("Halves");
  halves->SetNumberOfTuples(grid->GetNumberOfPoints());
  halves->Fill(0.0);
  halves->SetValue(4, 0.5F);
  grid->GetPointData()->AddArray(halves);
  const auto filter = FilterOn(grid);
  filter->SetLabelArrayName("Halves");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"Halves\""), HasSubstr("0.5 at point 4"), HasSubstr("0 to 2")));
  halves->SetValue(4, 3.0F);
  halves->Modified();
  filter->Modified();
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("3 at point 4"), HasSubstr("0 to 2")));
  halves->SetValue(4, -1.0F);
  filter->Modified();
  SurfaceOf(filter);
}

TEST(FieldLatentTextureMessages, ModelsMustBelongTogether)
{
  const auto filter = FilterOn(GuidedGrid());
  filter->SetAutoencoderFileName(WriteFieldLatentModel("texture.other", SmallFieldLatents(), 9).c_str());
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("fingerprint"), HasSubstr("texture.other")));
  LatentDiffusionOptions options = surfsynth::test::TinyLatentDiffusion();
  options.NumberOfLabels = 0;
  options.Directed = false;
  filter->SetModelFileName(WriteDiffusion("texture.unguided", options, "").c_str());
  SurfaceOf(filter); // a model that knows no autoencoder takes any of its dimension
  filter->SetLabelArrayName("Part");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("no labels"));
  filter->SetLabelArrayName("");
  filter->SetDirectionArrayName("Along");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("not directed"));
  filter->SetDirectionArrayName("");
  options.LatentDimension = 3;
  filter->SetModelFileName(WriteDiffusion("texture.wide", options, "").c_str());
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("dimension 3"), HasSubstr("dimension 2")));
}
