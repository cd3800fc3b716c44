// SPDX-License-Identifier: BSD-3-Clause
#include "TextureDecoding.h"

#include "NewArray.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace surfsynth
{

namespace
{
/// Texels that are decoded at once.
constexpr std::size_t TexelsOfTile = 32768;
/// Fraction of the work on a texture after its texels.
constexpr double AfterTexels = 0.95;

/// Turns a color of the network into a byte.
unsigned char ToByte(float value)
{
  return static_cast<unsigned char>(std::floor(std::clamp(0.5F * (value + 1.0F), 0.0F, 1.0F) * 255.0F + 0.5F));
}

/// Returns the texels of a tile as the decoder takes them.
FieldLatentTexels TexelsOf(const LatentField& field, const WeldedSurface& welded, const std::vector<SurfacePlace>& tile)
{
  const auto count = static_cast<Eigen::Index>(tile.size());
  std::vector<std::complex<double>> logarithms(tile.size() * 3);
  welded.Rings.CornerLogarithms(tile.data(), count, logarithms.data());
  FieldLatentTexels texels;
  texels.Corners.resize(count, 3);
  texels.Logarithms.resize(count, 6);
  texels.Barycentric.resize(count, 3);
  ParallelFor(count, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t q = begin; q < end; ++q)
    {
      const SurfacePlace& place = tile[static_cast<std::size_t>(q)];
      for (int k = 0; k < 3; ++k)
      {
        const Index v = welded.Mesh.Triangles(place.Triangle, k);
        const std::complex<double> z = logarithms[static_cast<std::size_t>(3 * q + k)] /
          field.Radii[static_cast<std::size_t>(v)];
        texels.Corners(q, k) = v;
        texels.Logarithms(q, 2 * k) = static_cast<float>(z.real());
        texels.Logarithms(q, 2 * k + 1) = static_cast<float>(z.imag());
        texels.Barycentric(q, k) = static_cast<float>(place.Weights[k]);
      }
    }
  });
  return texels;
}
} // namespace

void DecodeColors(const FieldLatentDecoder& decoder, const LatentField& field, const WeldedSurface& welded,
  const DecodedPlaces& places, unsigned char* out, const Progress& progress)
{
  const std::size_t count = places.Decoded.size();
  const auto share = [count](std::size_t k) { return static_cast<double>(k) / static_cast<double>(count); };
  std::vector<SurfacePlace> tile;
  for (std::size_t begin = 0; begin < count; begin += TexelsOfTile)
  {
    const std::size_t end = std::min(count, begin + TexelsOfTile);
    tile.clear();
    for (std::size_t k = begin; k < end; ++k)
    {
      tile.push_back(places.Places[places.Decoded[k]]);
    }
    const FieldLatentMatrix colors = decoder.Decode(
      field.Latents, TexelsOf(field, welded, tile), SubProgress(progress, share(begin), share(end)));
    for (std::size_t k = begin; k < end; ++k)
    {
      unsigned char* color = out + 3 * static_cast<std::size_t>(places.Decoded[k]);
      std::transform(colors.row(static_cast<Eigen::Index>(k - begin)).data(),
        colors.row(static_cast<Eigen::Index>(k - begin)).data() + 3, color, ToByte);
    }
  }
}

vtkSmartPointer<vtkImageData> DecodeTexture(const FieldLatentDecoder& decoder, const LatentField& field,
  const WeldedSurface& welded, const AtlasPlaces& atlas, const std::string& name, const int size[2],
  vtkPolyData* output, const Progress& progress)
{
  const auto texture = NewArray<vtkUnsignedCharArray>(name, static_cast<vtkIdType>(size[0]) * size[1], 3);
  unsigned char* texels = texture->GetPointer(0);
  DecodeColors(decoder, field, welded, atlas.Texels, texels, SubProgress(progress, 0.0, AfterTexels));
  for (const auto& [texel, source] : atlas.Gutters)
  {
    std::copy_n(texels + 3 * static_cast<std::size_t>(source), 3, texels + 3 * static_cast<std::size_t>(texel));
  }
  const auto colors = NewArray<vtkUnsignedCharArray>(name, output->GetNumberOfPoints(), 3);
  DecodeColors(decoder, field, welded, atlas.Points, colors->GetPointer(0), SubProgress(progress, AfterTexels, 1.0));
  output->GetPointData()->AddArray(colors);
  output->GetPointData()->SetActiveScalars(name.c_str()); // SetScalars() would remove the active ones of the input
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(size[0], size[1], 1);
  image->GetPointData()->SetScalars(texture);
  return image;
}

} // namespace surfsynth
