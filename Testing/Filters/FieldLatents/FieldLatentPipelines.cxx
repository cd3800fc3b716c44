// SPDX-License-Identifier: BSD-3-Clause
#include "FieldLatentPipelines.h"

#include "RandomFieldLatents.h"

#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <unistd.h>

namespace surfsynthtest
{

using namespace surfsynth;

namespace
{
/// A folder that is removed at the end of the process.
struct TemporaryFolder
{
  TemporaryFolder() { std::filesystem::create_directories(this->Path); }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path Path = std::filesystem::path(testing::TempDir()) /
    ("surfsynth-field-latents-" + std::to_string(getpid()));
};
} // namespace

FieldLatentOptions SmallFieldLatents()
{
  FieldLatentOptions options;
  options.LatentDimension = 2;
  options.Channels = 4;
  options.EncoderLayers = 1;
  options.Heads = 2;
  options.SamplesPerRing = 12;
  options.DecoderLayers = 2;
  options.DecoderWidth = 8;
  return options;
}

std::string ModelFile(const std::string& name)
{
  static const TemporaryFolder folder;
  return (folder.Path / name).string();
}

std::string WriteFieldLatentModel(const std::string& name, const FieldLatentOptions& options, std::uint64_t seed)
{
  FieldLatentModel model = surfsynth::test::RandomFieldLatents(options, seed);
  const auto scale = [&](const std::string& tensor, float factor) {
    for (float& value : model.Tensors.at(tensor).Values)
    {
      value *= factor;
    }
  };
  scale("encoder.mean.out.weight", 4.0F);
  scale("decoder.layers." + std::to_string(options.DecoderLayers) + ".weight", 6.0F);
  const std::string path = ModelFile(name);
  WriteFieldLatents(path, model);
  return path;
}

void AddTextureCoordinates(vtkPolyData* surface, const PlaneMap& map, int type)
{
  const auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName("Coordinates");
  array->SetNumberOfComponents(2);
  array->SetNumberOfTuples(surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    std::array<double, 3> x{};
    surface->GetPoint(p, x.data());
    array->SetTuple(p, map(x[0], x[1], x[2]).data());
  }
  surface->GetPointData()->SetTCoords(array);
}

void AddColors(vtkPolyData* surface)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName("Color");
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    std::array<double, 3> x{};
    surface->GetPoint(p, x.data());
    array->SetTuple3(
      p, 0.5 + 0.5 * std::sin(5.0 * x[0]), 0.5 + 0.5 * std::cos(4.0 * x[1]), 0.5 + 0.5 * std::sin(6.0 * x[2]));
  }
  surface->GetPointData()->AddArray(array);
}

vtkSmartPointer<vtkPolyData> TexturedGrid(int n)
{
  auto grid = Grid(n).ToPolyData();
  AddTextureCoordinates(
    grid,
    [](double x, double y, double) {
      return std::array<double, 2>{ x, y };
    },
    VTK_DOUBLE);
  return grid;
}

vtkSmartPointer<vtkImageData> Pattern(int components, int type)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(48, 32, 1);
  image->AllocateScalars(type, components);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  const bool isFloating = type == VTK_FLOAT || type == VTK_DOUBLE;
  const double white = isFloating ? 1.0 : scalars->GetDataTypeMax();
  for (vtkIdType t = 0; t < scalars->GetNumberOfTuples(); ++t)
  {
    const double x = static_cast<double>(t % 48) / 48.0;
    const double y = static_cast<double>(t / 48) / 32.0;
    const double rgb[3] = { std::sin(9.0 * x), std::cos(7.0 * y), std::sin(6.0 * (x + y)) };
    for (int c = 0; c < components; ++c)
    {
      const bool isAlpha = components % 2 == 0 && c == components - 1;
      const double byte = std::floor(127.5 + 107.5 * rgb[components < 3 ? 0 : std::min(c, 2)]);
      scalars->SetComponent(t, c, isAlpha ? white : isFloating ? byte / 255.0 : std::round(byte * (white / 255.0)));
    }
  }
  return image;
}

vtkSmartPointer<vtkFieldLatentEncoder> EncoderOn(vtkDataObject* surface, vtkDataObject* image, const std::string& model)
{
  auto filter = vtkSmartPointer<vtkFieldLatentEncoder>::New();
  filter->SetInputDataObject(surface);
  if (image)
  {
    filter->SetTextureData(image);
  }
  else
  {
    filter->SetColorArrayName("Color");
  }
  filter->SetModelFileName(model.c_str());
  return filter;
}

vtkSmartPointer<vtkFieldLatentDecoder> DecoderOn(vtkDataObject* surface, const std::string& model)
{
  auto filter = vtkSmartPointer<vtkFieldLatentDecoder>::New();
  filter->SetInputDataObject(surface);
  filter->SetModelFileName(model.c_str());
  filter->SetResolution(64, 64);
  return filter;
}

vtkSmartPointer<vtkPolyData> Encoded(
  vtkDataObject* surface, vtkDataObject* image, const std::string& model, int samplesPerRing)
{
  const auto encoder = EncoderOn(surface, image, model);
  encoder->SetSamplesPerRing(samplesPerRing);
  return SurfaceOf(encoder);
}

vtkImageData* ImageOf(vtkAlgorithm* decoder)
{
  EXPECT_TRUE(Update(decoder));
  return vtkImageData::SafeDownCast(decoder->GetOutputDataObject(1));
}

vtkDataArray* TexelsOf(vtkAlgorithm* decoder)
{
  vtkImageData* image = ImageOf(decoder);
  return image ? image->GetPointData()->GetScalars() : nullptr;
}

} // namespace surfsynthtest
