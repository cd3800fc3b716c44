// SPDX-License-Identifier: BSD-3-Clause
//
// Codes and textures of vtkFieldLatentEncoder and vtkFieldLatentDecoder: their values, and that they depend neither on
// numbers, position and bending of a surface nor on the seams of its texture.
#include "FieldLatentPipelines.h"

#include "FilterContract.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Tangent/OneRings.h"
#include "Core/Tangent/RingSamples.h"
#include "Core/Tangent/TangentVectors.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/FieldLatentModel.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

using namespace surfsynth;
using namespace surfsynthtest;
using testing::HasSubstr;

namespace
{
constexpr double Tolerance = 1e-4;

const std::string& Model()
{
  static const std::string model = WriteFieldLatentModel("filters.model");
  return model;
}

/// The surface with its points moved by @p move.
vtkSmartPointer<vtkPolyData> Moved(
  vtkPolyData* surface, const std::function<std::array<double, 3>(const double* x)>& move)
{
  auto moved = vtkSmartPointer<vtkPolyData>::New();
  moved->DeepCopy(surface);
  for (vtkIdType p = 0; p < moved->GetNumberOfPoints(); ++p)
  {
    double x[3];
    surface->GetPoint(p, x);
    moved->GetPoints()->SetPoint(p, move(x).data());
  }
  return moved;
}

/// The surface with its points and cells in reverse order.
vtkSmartPointer<vtkPolyData> Renumbered(vtkPolyData* surface)
{
  const vtkIdType last = surface->GetNumberOfPoints() - 1;
  auto other = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (vtkIdType p = last; p >= 0; --p)
  {
    points->InsertNextPoint(surface->GetPoint(p));
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
  return other;
}

void AddSquareCoordinates(vtkPolyData* surface)
{
  AddTextureCoordinates(
    surface,
    [](double x, double y, double) {
      return std::array<double, 2>{ x, y };
    },
    VTK_DOUBLE);
}

/// The texture that is decoded on a surface with codes.
vtkSmartPointer<vtkDataArray> Decoded(vtkPolyData* coded)
{
  const auto decoder = DecoderOn(coded, Model());
  SurfaceOf(decoder);
  return TexelsOf(decoder);
}

/// Expects bytes that differ by rounding only: by at most 1, in few places.
void ExpectSameTexture(vtkDataArray* a, vtkDataArray* b)
{
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->GetNumberOfTuples(), b->GetNumberOfTuples());
  double sum = 0.0;
  double largest = 0.0;
  for (vtkIdType t = 0; t < a->GetNumberOfTuples(); ++t)
  {
    for (int c = 0; c < 3; ++c)
    {
      const double difference = std::abs(a->GetComponent(t, c) - b->GetComponent(t, c));
      sum += difference;
      largest = std::max(largest, difference);
    }
  }
  EXPECT_LE(largest, 1.0);
  EXPECT_LE(sum / static_cast<double>(3 * a->GetNumberOfTuples()), 255.0 * Tolerance);
}

/// Expects that a texture shows something.
void ExpectContrast(vtkDataArray* texels)
{
  double range[2];
  texels->GetRange(range, 0);
  EXPECT_GT(range[1] - range[0], 20.0) << "a uniform texture would prove nothing";
}
} // namespace

// --- Codes -----------------------------------------------------------------------------------------------------------

TEST(FieldLatentEncoder, CodesAreThoseOfTheLibrary)
{
  const auto surface = Icosphere(2).ToPolyData();
  AddColors(surface);
  vtkDataArray* colors = PointArray(surface, "Color");
  const auto output = Encoded(surface, nullptr, Model());

  TriangleMesh mesh;
  mesh.Points.resize(surface->GetNumberOfPoints(), 3);
  for (Index p = 0; p < mesh.NumberOfPoints(); ++p)
  {
    surface->GetPoint(p, mesh.Points.row(p).data());
  }
  mesh.Triangles.resize(surface->GetNumberOfCells(), 3);
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    const vtkIdType* ids = nullptr;
    vtkIdType count = 0;
    surface->GetCellPoints(f, count, ids);
    mesh.Triangles.row(f) << static_cast<Index>(ids[0]), static_cast<Index>(ids[1]), static_cast<Index>(ids[2]);
  }
  const OneRings rings(mesh);
  const RingSamples samples = SampleRingsUniformly(rings, 12);
  FieldLatentRings input;
  input.Offsets = samples.Offsets;
  input.Logarithms.resize(static_cast<Eigen::Index>(samples.Places.size()), 2);
  input.Colors.resize(input.Logarithms.rows(), 3);
  for (Index v = 0; v < rings.NumberOfPoints(); ++v)
  {
    for (std::int64_t s = samples.Offsets[v]; s < samples.Offsets[v + 1]; ++s)
    {
      const std::complex<double> z = samples.Logarithms[s] / rings.RingRadius(v);
      input.Logarithms.row(s) << static_cast<float>(z.real()), static_cast<float>(z.imag());
      Eigen::RowVector3d color = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 3; ++k)
      {
        Eigen::RowVector3d own;
        colors->GetTuple(mesh.Triangles(samples.Places[s].Triangle, k), own.data());
        color += samples.Places[s].Weights[k] * own;
      }
      input.Colors.row(s) = (2.0 * color.array() - 1.0).cast<float>();
    }
  }
  const FieldLatentCodes codes = surfsynth::FieldLatentEncoder(ReadFieldLatents(Model())).Encode(input);
  double largest = 0.0;
  for (int j = 0; j < 2; ++j)
  {
    Eigen::VectorXcd tangents(rings.NumberOfPoints());
    for (Index v = 0; v < rings.NumberOfPoints(); ++v)
    {
      tangents[v] = { codes.Mean(v, 2 * j), codes.Mean(v, 2 * j + 1) };
    }
    const PointMatrix expected = FromTangent(rings.Frames, tangents);
    vtkDataArray* found = PointArray(output, ("FieldLatent_" + std::to_string(j)).c_str());
    ASSERT_EQ(found->GetDataType(), VTK_FLOAT);
    for (Index v = 0; v < rings.NumberOfPoints(); ++v)
    {
      Eigen::RowVector3d vector;
      found->GetTuple(v, vector.data());
      EXPECT_LE((vector - expected.row(v)).cwiseAbs().maxCoeff(), 1e-5);
      largest = std::max(largest, vector.norm());
      EXPECT_NEAR(
        PointArray(output, "FieldLatentDeviation")->GetComponent(v, j), std::exp(codes.LogDeviation(v, j)), 1e-5);
      EXPECT_NEAR(PointArray(output, "FieldLatentRadius")->GetTuple1(v), rings.RingRadius(v), 1e-6);
    }
  }
  EXPECT_GT(largest, 0.05);
  EXPECT_EQ(output->GetPointData()->GetVectors(), PointArray(output, "FieldLatent_0"));
}

TEST(FieldLatentEncoder, AnImageAndThePointColorsThatItShowsGiveTheSameCodes)
{
  // Linear colors: interpolation by texels and by triangles agree away from the border.
  const auto grid = TexturedGrid(6);
  vtkNew<vtkDoubleArray> colors;
  colors->SetName("Color");
  colors->SetNumberOfTuples(grid->GetNumberOfPoints());
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    colors->SetValue(p, 0.1 + 0.8 * grid->GetPoint(p)[0]);
  }
  grid->GetPointData()->AddArray(colors);
  vtkNew<vtkImageData> image;
  image->SetDimensions(600, 1, 1);
  image->AllocateScalars(VTK_DOUBLE, 1);
  for (int i = 0; i < 600; ++i)
  {
    image->SetScalarComponentFromDouble(i, 0, 0, 0, 0.1 + 0.8 * (i + 0.5) / 600.0);
  }
  const auto a = Encoded(grid, nullptr, Model());
  const auto b = Encoded(grid, image, Model());
  EXPECT_LE(LargestDifference(PointArray(a, "FieldLatent_0"), PointArray(b, "FieldLatent_0")), 1e-3);
}

TEST(FieldLatentEncoder, ImagesOfAllTypesAndComponentsAgree)
{
  const auto grid = TexturedGrid(6);
  const auto expected = Encoded(grid, Pattern(), Model());
  const auto gray = Encoded(grid, Pattern(1), Model());
  for (const int type :
    { VTK_FLOAT, VTK_DOUBLE, VTK_SIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT, VTK_UNSIGNED_INT, VTK_LONG_LONG })
  {
    const double tolerance = type == VTK_SIGNED_CHAR ? 0.05 : 1e-3; // rounded to 127 levels
    EXPECT_LE(LargestDifference(PointArray(expected, "FieldLatent_1"),
                PointArray(Encoded(grid, Pattern(3, type), Model()), "FieldLatent_1")),
      tolerance)
      << type;
  }
  EXPECT_TRUE(
    SameBits(PointArray(expected, "FieldLatent_1"), PointArray(Encoded(grid, Pattern(4), Model()), "FieldLatent_1")));
  EXPECT_TRUE(
    SameBits(PointArray(gray, "FieldLatent_1"), PointArray(Encoded(grid, Pattern(2), Model()), "FieldLatent_1")));
  EXPECT_GT(LargestDifference(PointArray(expected, "FieldLatent_1"), PointArray(gray, "FieldLatent_1")), 0.01);
}

TEST(FieldLatentEncoder, ARepeatedTextureIsRepeatedAndCanBeClamped)
{
  const auto grid = TexturedGrid(6);
  const auto shifted = TexturedGrid(6);
  AddTextureCoordinates(
    shifted,
    [](double x, double y, double) {
      return std::array<double, 2>{ x + 2.0, y - 1.0 };
    },
    VTK_DOUBLE);
  const auto repeated = EncoderOn(grid, Pattern(), Model());
  repeated->SetTextureWrapToRepeat();
  const auto expected = SurfaceOf(repeated);
  const auto encoder = EncoderOn(shifted, Pattern(), Model());
  EXPECT_LE(
    LargestDifference(PointArray(SurfaceOf(encoder), "FieldLatent_0"), PointArray(expected, "FieldLatent_0")), 1e-5);
  encoder->SetTextureWrapToClamp();
  EXPECT_GT(
    LargestDifference(PointArray(SurfaceOf(encoder), "FieldLatent_0"), PointArray(expected, "FieldLatent_0")), 0.01);
  encoder->SetTextureWrapToAutomatic();
  encoder->SetInputDataObject(grid);
  const auto clamped = EncoderOn(grid, Pattern(), Model());
  clamped->SetTextureWrapToClamp();
  EXPECT_TRUE(
    SameBits(PointArray(SurfaceOf(encoder), "FieldLatent_0"), PointArray(SurfaceOf(clamped), "FieldLatent_0")));
}

TEST(FieldLatentEncoder, SeamsOfTextureCoordinatesDoNotShow)
{
  // The right half has points of its own at x = 1/2.
  Soup halves = Grid(6);
  std::vector<vtkIdType> twin(static_cast<std::size_t>(halves.NumberOfPoints()), -1);
  const vtkIdType whole = halves.NumberOfPoints();
  for (auto& triangle : halves.Polys)
  {
    double center = 0.0;
    for (const vtkIdType id : triangle)
    {
      center += halves.Points[static_cast<std::size_t>(3 * id)] / 3.0;
    }
    for (vtkIdType& id : triangle)
    {
      const double x = halves.Points[static_cast<std::size_t>(3 * id)];
      if (center > 0.5 && x == 0.5)
      {
        vtkIdType& other = twin[static_cast<std::size_t>(id)];
        if (other < 0)
        {
          other = halves.AddPoint(0.5, halves.Points[static_cast<std::size_t>(3 * id + 1)], 0.0);
        }
        id = other;
      }
    }
  }
  ASSERT_EQ(halves.NumberOfPoints(), whole + 7);
  const auto cut = halves.ToPolyData();
  AddSquareCoordinates(cut);
  const auto a = Encoded(TexturedGrid(6), Pattern(), Model());
  const auto b = Encoded(cut, Pattern(), Model());
  for (const char* name : { "FieldLatent_0", "FieldLatent_1", "FieldLatentDeviation", "FieldLatentRadius" })
  {
    vtkDataArray* expected = PointArray(a, name);
    vtkDataArray* found = PointArray(b, name);
    for (vtkIdType p = 0; p < found->GetNumberOfTuples(); ++p)
    {
      vtkIdType same = p;
      for (vtkIdType v = 0; p >= whole && v < whole; ++v)
      {
        same = twin[static_cast<std::size_t>(v)] == p ? v : same;
      }
      for (int c = 0; c < found->GetNumberOfComponents(); ++c)
      {
        EXPECT_NEAR(found->GetComponent(p, c), expected->GetComponent(same, c), 1e-5) << name << " " << p;
      }
    }
  }
  ExpectSameTexture(Decoded(a), Decoded(b));
}

TEST(FieldLatentEncoder, StrayPointsGetNothing)
{
  Soup soup = Grid(4);
  const vtkIdType stray = soup.AddPoint(std::nan(""), 2.0, 3.0);
  const auto surface = soup.ToPolyData();
  AddTextureCoordinates(
    surface,
    [](double x, double y, double) {
      return std::array<double, 2>{ x, y };
    },
    VTK_DOUBLE);
  const auto output = Encoded(surface, Pattern(), Model());
  EXPECT_EQ(PointArray(output, "FieldLatentRadius")->GetTuple1(stray), 0.0);
  EXPECT_EQ(PointArray(output, "FieldLatent_0")->GetComponent(stray, 0), 0.0);
  const auto decoder = DecoderOn(output, Model());
  EXPECT_EQ(PointArray(SurfaceOf(decoder), "Texture")->GetComponent(stray, 0), 0.0);
}

// --- Equivariance ----------------------------------------------------------------------------------------------------

TEST(FieldLatentEquivariance, RenumberedSurfacesHaveTheSameTexture)
{
  const auto grid = TexturedGrid(6);
  const auto other = Renumbered(grid);
  AddSquareCoordinates(other);
  const auto a = Encoded(grid, Pattern(), Model());
  const auto b = Encoded(other, Pattern(), Model());
  const vtkIdType last = grid->GetNumberOfPoints() - 1;
  for (vtkIdType p = 0; p <= last; ++p)
  {
    for (int c = 0; c < 3; ++c)
    {
      EXPECT_NEAR(PointArray(a, "FieldLatent_0")->GetComponent(p, c),
        PointArray(b, "FieldLatent_0")->GetComponent(last - p, c), Tolerance);
    }
  }
  const auto texture = Decoded(a);
  ExpectContrast(texture);
  ExpectSameTexture(texture, Decoded(b));
}

TEST(FieldLatentEquivariance, CodesTurnWithTheSurface)
{
  const auto turn = [](const double* x) {
    const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d turned = rotation * Eigen::Map<const Eigen::Vector3d>(x);
    return std::array<double, 3>{ turned[0], turned[1], turned[2] };
  };
  const auto grid = TexturedGrid(6);
  const auto bumpy = Moved(grid, [](const double* x) {
    return std::array<double, 3>{ x[0], x[1], 0.1 * std::sin(7.0 * x[0]) * std::cos(5.0 * x[1]) };
  });
  const auto turned = Moved(bumpy, [&](const double* x) {
    auto y = turn(x);
    y[0] += 3.0;
    return y;
  });
  const auto a = Encoded(bumpy, Pattern(), Model());
  const auto b = Encoded(turned, Pattern(), Model());
  for (const char* name : { "FieldLatent_0", "FieldLatent_1" })
  {
    for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
    {
      const auto expected = turn(PointArray(a, name)->GetTuple3(p));
      for (int c = 0; c < 3; ++c)
      {
        EXPECT_NEAR(PointArray(b, name)->GetComponent(p, c), expected[c], Tolerance);
      }
    }
  }
  ExpectSameTexture(Decoded(a), Decoded(b));
  const auto large = Moved(bumpy, [](const double* x) {
    return std::array<double, 3>{ 50.0 * x[0], 50.0 * x[1], 50.0 * x[2] };
  });
  const auto c = Encoded(large, Pattern(), Model());
  EXPECT_LE(LargestDifference(PointArray(a, "FieldLatent_0"), PointArray(c, "FieldLatent_0")), Tolerance);
  ExpectSameTexture(Decoded(a), Decoded(c));
}

TEST(FieldLatentEquivariance, BendingDoesNotChangeTheTexture)
{
  // Strips of the patch become the sides of a prism: an isometry of the triangles.
  constexpr int Cells = 8;
  const auto grid = TexturedGrid(Cells);
  const auto rolled = Moved(grid, [](const double* x) {
    constexpr double Bend = 0.5;
    const int strip = static_cast<int>(std::lround(x[0] * Cells));
    std::array<double, 3> y{ 0.0, x[1], 0.0 };
    for (int k = 0; k < strip; ++k)
    {
      y[0] += std::cos(Bend * k) / Cells;
      y[2] += std::sin(Bend * k) / Cells;
    }
    return y;
  });
  const auto a = Encoded(grid, Pattern(), Model());
  const auto b = Encoded(rolled, Pattern(), Model());
  EXPECT_LE(LargestDifference(PointArray(a, "FieldLatentDeviation"), PointArray(b, "FieldLatentDeviation")), Tolerance);
  EXPECT_GT(LargestDifference(PointArray(a, "FieldLatent_0"), PointArray(b, "FieldLatent_0")), 0.01)
    << "vectors bend with the surface";
  const auto texture = Decoded(a);
  ExpectContrast(texture);
  ExpectSameTexture(texture, Decoded(b));
}

// --- Textures --------------------------------------------------------------------------------------------------------

TEST(FieldLatentDecoder, ColorsOfPointsAreThoseOfTheTexture)
{
  const auto coded = Encoded(TexturedGrid(5), Pattern(), Model());
  const auto decoder = DecoderOn(coded, Model());
  decoder->SetResolution(500, 250);
  const auto output = SurfaceOf(decoder);
  vtkImageData* image = ImageOf(decoder);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->GetDimensions()[0], 500);
  EXPECT_EQ(image->GetDimensions()[1], 250);
  vtkDataArray* colors = output->GetPointData()->GetScalars();
  ASSERT_TRUE(vtkUnsignedCharArray::SafeDownCast(colors));
  EXPECT_STREQ(colors->GetName(), "Texture");
  EXPECT_STREQ(image->GetPointData()->GetScalars()->GetName(), "Texture");
  EXPECT_EQ(colors->GetNumberOfComponents(), 3);
  EXPECT_TRUE(output->GetPointData()->GetTCoords());
  EXPECT_TRUE(output->GetPointData()->HasArray("FieldLatent_0"));
  ExpectContrast(colors);
  double sum = 0.0;
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double* x = output->GetPoint(p);
    const int i = std::min(499, static_cast<int>(500.0 * x[0]));
    const int j = std::min(249, static_cast<int>(250.0 * x[1]));
    for (int c = 0; c < 3; ++c)
    {
      sum += std::abs(colors->GetComponent(p, c) - image->GetScalarComponentAsDouble(i, j, 0, c));
    }
  }
  EXPECT_LE(sum / static_cast<double>(3 * output->GetNumberOfPoints()), 2.0);
}

TEST(FieldLatentDecoder, ATargetGetsTheTextureOfTheNearestPlaces)
{
  const auto coded = Encoded(TexturedGrid(5), Pattern(), Model());
  const auto own = Decoded(coded);
  const auto target = Grid(7, 4).ToPolyData();
  AddTextureCoordinates(
    target,
    [](double x, double y, double) {
      return std::array<double, 2>{ 1.0 - x, y };
    },
    VTK_DOUBLE);
  const auto decoder = DecoderOn(coded, Model());
  decoder->SetTargetData(target);
  const auto output = SurfaceOf(decoder);
  EXPECT_EQ(output->GetNumberOfCells(), 49) << "the target's own cells";
  EXPECT_FALSE(output->GetPointData()->HasArray("FieldLatent_0"));
  const vtkSmartPointer<vtkDataArray> mirrored = TexelsOf(decoder);
  const vtkSmartPointer<vtkDataArray> turned = vtkSmartPointer<vtkDataArray>::Take(mirrored->NewInstance());
  turned->DeepCopy(mirrored);
  for (vtkIdType t = 0; t < mirrored->GetNumberOfTuples(); ++t)
  {
    turned->SetTuple(t / 64 * 64 + 63 - t % 64, mirrored->GetTuple(t));
  }
  ExpectSameTexture(own, turned);
  decoder->SetTargetData(TexturedGrid(5));
  SurfaceOf(decoder);
  ExpectSameTexture(own, TexelsOf(decoder));
}

TEST(FieldLatentDecoder, GuttersAreFilledFromTheNearestTexels)
{
  const auto grid = TexturedGrid(4);
  AddTextureCoordinates(
    grid,
    [](double x, double y, double) {
      return std::array<double, 2>{ 0.25 + 0.5 * x, 0.25 + 0.5 * y };
    },
    VTK_DOUBLE);
  const auto decoder = DecoderOn(Encoded(grid, Pattern(), Model()), Model());
  const auto texel = [&](int i, int j) {
    vtkDataArray* texels = TexelsOf(decoder);
    return std::array<double, 3>{ texels->GetComponent(64 * j + i, 0), texels->GetComponent(64 * j + i, 1),
      texels->GetComponent(64 * j + i, 2) };
  };
  const std::array<double, 3> black{};
  EXPECT_EQ(texel(2, 32), black) << "beyond the gutter";
  EXPECT_EQ(texel(9, 32), texel(14, 32)) << "in the gutter";
  EXPECT_NE(texel(20, 32), black);
  decoder->SetGutterWidth(-1);
  EXPECT_EQ(texel(2, 32), texel(14, 32));
  EXPECT_NE(texel(0, 0), black);
}

TEST(FieldLatentDecoder, BlocksAreIndependentAndABadOneIsLeftEmpty)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  const auto first = Encoded(TexturedGrid(4), Pattern(), Model());
  blocks->SetBlock(0, first);
  blocks->SetBlock(1, TexturedGrid(4)); // without codes
  blocks->SetBlock(2, Encoded(TexturedGrid(5), Pattern(), Model()));
  const auto decoder = DecoderOn(blocks, Model());
  EventRecorder events(decoder);
  EXPECT_TRUE(Update(decoder));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.AllErrors(), HasSubstr("Block 2"));
  auto* images = vtkMultiBlockDataSet::SafeDownCast(decoder->GetOutputDataObject(1));
  ASSERT_TRUE(images);
  EXPECT_FALSE(images->GetBlock(1));
  auto* image = vtkImageData::SafeDownCast(images->GetBlock(0));
  ASSERT_TRUE(image);
  EXPECT_TRUE(SameBits(image->GetPointData()->GetScalars(), Decoded(first)));
  EXPECT_TRUE(vtkImageData::SafeDownCast(images->GetBlock(2)));
}

// --- Input and output ------------------------------------------------------------------------------------------------

TEST(FieldLatentFilters, EmptyInputGivesEmptyOutput)
{
  vtkNew<vtkPolyData> empty;
  EXPECT_EQ(Encoded(empty, Pattern(), Model())->GetNumberOfPoints(), 0);
  const auto decoder = DecoderOn(empty, Model());
  EXPECT_EQ(SurfaceOf(decoder)->GetNumberOfPoints(), 0);
  EXPECT_EQ(ImageOf(decoder)->GetNumberOfPoints(), 0);
  {
    EventRecorder events(decoder);
    decoder->Update();
    decoder->Update(1);
    EXPECT_EQ(events.Executions, 0) << "nothing has changed";
    decoder->SetInputDataObject(Encoded(TexturedGrid(4), Pattern(), Model()));
    decoder->Update();
    EXPECT_TRUE(TexelsOf(decoder)) << "an image when there is a surface";
    EXPECT_EQ(events.Executions, 1);
    decoder->SetInputDataObject(empty);
    decoder->Update();
    decoder->Update(1);
    EXPECT_EQ(events.Executions, 2);
  }
  const auto ontoNothing = DecoderOn(Encoded(TexturedGrid(4), Pattern(), Model()), Model());
  ontoNothing->SetTargetData(empty);
  EXPECT_EQ(SurfaceOf(ontoNothing)->GetNumberOfPoints(), 0);
}

TEST(FieldLatentFilters, InputsAreNotModifiedAndArraysPassThrough)
{
  const auto grid = TexturedGrid(4);
  AddColors(grid);
  grid->GetPointData()->SetActiveScalars("Color");
  const auto image = Pattern();
  const std::uint64_t hashes[] = { HashOf(grid), HashOf(image) };
  const auto coded = Encoded(grid, image, Model());
  EXPECT_EQ(coded->GetPoints(), grid->GetPoints());
  EXPECT_STREQ(coded->GetPointData()->GetScalars()->GetName(), "Color");
  const std::uint64_t before = HashOf(coded);
  const auto decoder = DecoderOn(coded, Model());
  const auto target = TexturedGrid(3);
  const std::uint64_t targetBefore = HashOf(target);
  EXPECT_TRUE(SurfaceOf(decoder)->GetPointData()->HasArray("Color"));
  decoder->SetTargetData(target);
  SurfaceOf(decoder);
  EXPECT_EQ(HashOf(grid), hashes[0]);
  EXPECT_EQ(HashOf(image), hashes[1]);
  EXPECT_EQ(HashOf(coded), before);
  EXPECT_EQ(HashOf(target), targetBefore);
}

TEST(FieldLatentFilters, FloatAndDoublePointsAgree)
{
  Soup soup = Grid(4);
  const auto fine = soup.ToPolyData(VTK_DOUBLE);
  const auto single = soup.ToPolyData(VTK_FLOAT);
  AddSquareCoordinates(fine);
  AddSquareCoordinates(single);
  EXPECT_LE(LargestDifference(PointArray(Encoded(fine, Pattern(), Model()), "FieldLatent_0"),
              PointArray(Encoded(single, Pattern(), Model()), "FieldLatent_0")),
    Tolerance);
}

TEST(FieldLatentFilters, NamesOfArraysAreProperties)
{
  const auto encoder = EncoderOn(TexturedGrid(4), Pattern(), Model());
  encoder->SetLatentArrayName("Code");
  const auto coded = SurfaceOf(encoder);
  EXPECT_TRUE(PointArray(coded, "Code_1") && PointArray(coded, "CodeDeviation") && PointArray(coded, "CodeRadius"));
  const auto decoder = DecoderOn(coded, Model());
  decoder->SetLatentArrayName("Code");
  decoder->SetTextureArrayName("Paint");
  EXPECT_TRUE(PointArray(SurfaceOf(decoder), "Paint"));
  EXPECT_STREQ(TexelsOf(decoder)->GetName(), "Paint");
}

TEST(FieldLatentFilters, PrintAndRanges)
{
  vtkNew<vtkFieldLatentEncoder> encoder;
  vtkNew<vtkFieldLatentDecoder> decoder;
  std::ostringstream text;
  encoder->Print(text);
  decoder->Print(text);
  EXPECT_THAT(text.str(), HasSubstr("SamplesPerRing: 0"));
  EXPECT_THAT(text.str(), HasSubstr("Resolution: 1024 x 1024"));
  encoder->SetSamplesPerRing(100000);
  EXPECT_EQ(encoder->GetSamplesPerRing(), 4096);
  decoder->SetResolution(1, 1 << 20);
  EXPECT_EQ(decoder->GetResolution()[0], 16);
  EXPECT_EQ(decoder->GetResolution()[1], 16384);
  decoder->SetGutterWidth(-7);
  EXPECT_EQ(decoder->GetGutterWidth(), -1);
}
