// SPDX-License-Identifier: BSD-3-Clause
#include "LatentDatasets.h"

#include "LatentGuidance.h"
#include "LatentTriangulation.h"
#include "RegularRings.h"
#include "SurfaceBridge.h"
#include "SurfaceCoordinates.h"
#include "TextureColors.h"
#include "TextureEncoding.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// Numbers of labels that a dataset may have.
constexpr std::int64_t MaximumLabels = 65536;
/// Half of the range of the numbers of vertices, over their mean.
constexpr double Spread = 0.15;
/// Stream of the random numbers that vary the edge lengths; that of the numbers of vertices is 0.
constexpr std::uint32_t VariationStream = 1;
/// Part of the work on a triangulation that remeshing takes.
constexpr double AfterRemeshing = 0.5;

/// Numbers of vertices of the triangulations.
std::vector<std::int64_t> NumbersOfPoints(const LatentDatasetRequest& request)
{
  std::vector<std::int64_t> order(static_cast<std::size_t>(request.NumberOfTriangulations));
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t k = order.size(); k > 1; --k)
  {
    const NormalKey key{ request.Seed, 0, 0, 0 };
    std::swap(order[k - 1],
      order[static_cast<std::size_t>(UniformIndex(key, static_cast<std::int64_t>(k), static_cast<std::int64_t>(k)))]);
  }
  const auto count = static_cast<double>(order.size());
  std::vector<std::int64_t> numbers;
  for (const std::int64_t k : order)
  {
    const double place = (static_cast<double>(k) + 0.5) / count; // 0.5 for a single one
    numbers.push_back(std::llround(request.NumberOfPoints * (1.0 + Spread * (2.0 * place - 1.0))));
  }
  return numbers;
}

/// Colors of the surface.
class SourceColors
{
public:
  SourceColors(const LatentDatasetRequest& request, const Surface& surface)
  {
    if (!request.Image)
    {
      this->Colors.emplace(request.Mesh, surface, request.ColorArrayName);
      this->Warn(request, this->Colors->Remarks);
      return;
    }
    this->Image.emplace(request.Image);
    this->Warn(request, this->Image->Colors.Remarks);
    TextureCoordinates coordinates = ReadTextureCoordinates(request.Mesh, surface);
    const TextureWrap wrap = IsRepeated(coordinates, surface) ? TextureWrap::Repeat : TextureWrap::Clamp;
    this->Colors.emplace(*this->Image, wrap, std::move(coordinates));
  }

  const TextureColors& operator*() const { return *this->Colors; }

private:
  static void Warn(const LatentDatasetRequest& request, const std::vector<std::string>& texts)
  {
    for (const std::string& text : texts)
    {
      if (request.Warn)
      {
        request.Warn(text);
      }
    }
  }

  std::optional<ColorImage> Image;
  std::optional<TextureColors> Colors;
};

/// One triangulation with its latents. @param regular to which the number of vertices in regular parts is added
LatentSurface MakeSurface(const LatentDatasetRequest& request, const Surface& surface, const TextureColors& colors,
  const FieldLatentEncoder& encoder, std::int64_t points, const NormalKey& variation, std::int64_t& regular,
  const Progress& progress)
{
  const LatentTriangulation triangulation(surface, points, SubProgress(progress, 0.0, AfterRemeshing), variation);
  regular += triangulation.NumberOfRegularVertices();
  const WeldedSurface& welded = triangulation.Welded();
  const FieldLatentCodes codes = EncodeColors(encoder, welded, ColorsOfNearest(welded.Mesh, surface.Mesh, colors),
    VerticesOf(welded), DiffusionSamplesPerRing(encoder), SubProgress(progress, AfterRemeshing, 1.0));
  const GuidedSurface guided{ request.Mesh, &surface, &triangulation };
  LatentSurface made;
  made.Mesh = welded.Mesh;
  made.Means = codes.Mean;
  made.Deviations = codes.LogDeviation.array().min(80.0F).exp();
  if (!request.LabelArrayName.empty())
  {
    made.Labels = ReadLabels(guided, request.LabelArrayName, MaximumLabels);
  }
  if (!request.DirectionArrayName.empty())
  {
    made.Directions = ReadDirections(guided, request.DirectionArrayName);
  }
  return made;
}
} // namespace

LatentDataset MakeLatentDataset(const LatentDatasetRequest& request, const Progress& progress)
{
  const Surface surface = ConvertSurface(request.Mesh);
  const SourceColors colors(request, surface);
  const FieldLatentEncoder encoder(*request.Autoencoder);
  LatentDataset dataset;
  dataset.Autoencoder = Fingerprint(*request.Autoencoder);
  const std::vector<std::int64_t> numbers = NumbersOfPoints(request);
  std::int64_t regular = 0;
  std::int64_t vertices = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k)
  {
    const auto count = static_cast<double>(numbers.size());
    const Progress part = SubProgress(progress, static_cast<double>(k) / count, static_cast<double>(k + 1) / count);
    const NormalKey variation{ request.Seed, static_cast<std::uint32_t>(k), 0, VariationStream };
    dataset.Surfaces.push_back(MakeSurface(request, surface, *colors, encoder, numbers[k], variation, regular, part));
    vertices += dataset.Surfaces.back().Mesh.NumberOfPoints();
    Report(part, 1.0);
  }
  if (request.Warn && regular > 0)
  {
    request.Warn(DescribeRegularVertices(
      regular, vertices, "Another number of points, or points of the surface off the grid, are needed."));
  }
  return dataset;
}

} // namespace surfsynth
