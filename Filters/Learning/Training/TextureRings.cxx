// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TextureRings.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterUniforms.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Pi = 3.14159265358979323846;

/// Streams of random numbers, and their places within the stream of a ring.
enum Stream : std::uint32_t
{
  PlacementStream = 1,
  EncoderStream,
  TargetStream
};
enum Place : std::int64_t
{
  ImagePlace,
  MeshPlace,
  RingPlace,
  AnglePlace,
  ScalePlace,
  ColumnPlace,
  RowPlace,
  AugmentationPlace,
  PermutationPlace,
  ColorRangePlace ///< the first of 6
};

NormalKey WithStream(NormalKey key, std::uint32_t stream)
{
  key.Stream = stream;
  return key;
}

/// Barycentric coordinates of a uniform point of a triangle.
Eigen::RowVector3d UniformInTriangle(double u, double v)
{
  const double root = std::sqrt(u);
  return { 1.0 - root, root * (1.0 - v), root * v };
}

/// Barycentric coordinates of a point of a triangle with density proportional to the power k of the @p heavy one: that
/// has the distribution Beta(k + 1, 2), a product of Beta(k + 1, 1) and Beta(k + 2, 1); the others share the rest evenly.
Eigen::RowVector3d WeightedInTriangle(double power, Eigen::Index heavy, double u, double v, double w)
{
  const double largest = std::pow(u, 1.0 / (power + 1.0)) * std::pow(v, 1.0 / (power + 2.0));
  Eigen::RowVector3d weights;
  weights[heavy] = largest;
  weights[(heavy + 1) % 3] = (1.0 - largest) * (1.0 - w);
  weights[(heavy + 2) % 3] = (1.0 - largest) * w;
  return weights;
}

/// Place of a vertex among the corners of one of its triangles.
Eigen::Index CornerOf(const PlanarMesh& mesh, Index triangle, Index vertex)
{
  Eigen::Index corner = 0;
  while (mesh.Triangles(triangle, corner) != vertex)
  {
    ++corner;
  }
  return corner;
}

Eigen::RowVector2d PointOf(const PlanarMesh& mesh, Index triangle, const Eigen::RowVector3d& barycentric)
{
  Eigen::RowVector2d point = Eigen::RowVector2d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k)
  {
    point += barycentric[k] * mesh.Points.row(mesh.Triangles(triangle, k));
  }
  return point;
}

double AreaOf(const PlanarMesh& mesh, Index triangle)
{
  const Eigen::RowVector2d u = mesh.Points.row(mesh.Triangles(triangle, 1)) -
    mesh.Points.row(mesh.Triangles(triangle, 0));
  const Eigen::RowVector2d v = mesh.Points.row(mesh.Triangles(triangle, 2)) -
    mesh.Points.row(mesh.Triangles(triangle, 0));
  return 0.5 * (u.x() * v.y() - u.y() * v.x());
}

/// Color between -1 and 1, interpolated bilinearly between the centers of pixels, (0, 0) to (width - 1, height - 1).
void ColorAt(const TextureImage& image, const Eigen::RowVector2d& pixel, float* color)
{
  const double x = std::clamp(pixel.x(), 0.0, static_cast<double>(image.Width - 1));
  const double y = std::clamp(pixel.y(), 0.0, static_cast<double>(image.Height - 1));
  const auto column = static_cast<std::int64_t>(x);
  const auto row = static_cast<std::int64_t>(y);
  const double s = x - static_cast<double>(column);
  const double t = y - static_cast<double>(row);
  const std::int64_t right = std::min(column + 1, image.Width - 1);
  const std::int64_t below = std::min(row + 1, image.Height - 1);
  for (std::int64_t c = 0; c < 3; ++c)
  {
    const auto at = [&](std::int64_t r, std::int64_t k) {
      return static_cast<double>(image.Pixels[static_cast<std::size_t>((r * image.Width + k) * 3 + c)]);
    };
    const double value = (1.0 - t) * ((1.0 - s) * at(row, column) + s * at(row, right)) +
      t * ((1.0 - s) * at(below, column) + s * at(below, right));
    color[c] = static_cast<float>(value / 127.5 - 1.0);
  }
}
} // namespace

TextureRings::Mesh TextureRings::Prepare(PlanarMesh planar)
{
  Mesh mesh;
  mesh.Interior = InteriorVertices(planar);
  mesh.Incident.resize(static_cast<std::size_t>(planar.Points.rows()));
  double area = 0.0;
  for (Index f = 0; f < static_cast<Index>(planar.Triangles.rows()); ++f)
  {
    bool inside = true;
    for (Eigen::Index k = 0; k < 3; ++k)
    {
      const Index v = planar.Triangles(f, k);
      mesh.Incident[static_cast<std::size_t>(v)].push_back(f);
      inside = inside && std::binary_search(mesh.Interior.begin(), mesh.Interior.end(), v);
    }
    area += AreaOf(planar, f);
    if (inside)
    {
      mesh.Triangles.push_back(f);
    }
  }
  const auto used = std::count_if(
    mesh.Incident.begin(), mesh.Incident.end(), [](const std::vector<Index>& around) { return !around.empty(); });
  mesh.AreaOfVertex = area / static_cast<double>(used);
  mesh.Planar = std::move(planar);
  return mesh;
}

TextureRings::TextureRings(TextureDataset dataset, bool inTriangles)
  : Dataset(std::move(dataset))
{
  CheckDataset(this->Dataset);
  this->DatasetHash = ContentHash(this->Dataset);
  for (PlanarMesh& planar : this->Dataset.Meshes)
  {
    this->Meshes.push_back(Prepare(std::move(planar)));
    if (inTriangles && this->Meshes.back().Triangles.empty())
    {
      throw InvalidInput("TextureRings: mesh " + std::to_string(this->Meshes.size() - 1) +
        " has no triangle of three interior vertices; expected a larger mesh.");
    }
  }
  this->Dataset.Meshes.clear();
}

const TextureRings::Mesh& TextureRings::ChooseMesh(const NormalKey& key) const
{
  return this
    ->Meshes[static_cast<std::size_t>(UniformIndex(key, MeshPlace, static_cast<std::int64_t>(this->Meshes.size())))];
}

/// Lays the rings of @p vertices over an image, so that none leaves it; where they would, the scale is smaller.
TextureRings::Placement TextureRings::Place(
  const Mesh& mesh, const std::vector<Index>& vertices, const TextureRingSizes& sizes, NormalKey key) const
{
  key.Stream = PlacementStream;
  Placement placement;
  placement.Image = &this->Dataset.Images[static_cast<std::size_t>(
    UniformIndex(key, ImagePlace, static_cast<std::int64_t>(this->Dataset.Images.size())))];
  placement.Center = mesh.Planar.Points.row(vertices.front());
  const double angle = 2.0 * Pi * Uniform(key, AnglePlace);
  const double texels = sizes.MinimumTexels *
    std::pow(sizes.MaximumTexels / sizes.MinimumTexels, Uniform(key, ScalePlace));
  placement.Linear << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  Eigen::RowVector2d lowest = Eigen::RowVector2d::Zero();
  Eigen::RowVector2d highest = Eigen::RowVector2d::Zero();
  for (const Index vertex : vertices)
  {
    for (const Index triangle : mesh.Incident[static_cast<std::size_t>(vertex)])
    {
      for (Eigen::Index k = 0; k < 3; ++k)
      {
        const Eigen::RowVector2d point = (mesh.Planar.Points.row(mesh.Planar.Triangles(triangle, k)) -
                                           placement.Center) *
          placement.Linear;
        lowest = lowest.cwiseMin(point);
        highest = highest.cwiseMax(point);
      }
    }
  }
  const Eigen::RowVector2d room(
    static_cast<double>(placement.Image->Width - 1), static_cast<double>(placement.Image->Height - 1));
  const Eigen::RowVector2d extent = highest - lowest;
  const double scale = std::min(
    { std::sqrt(texels / mesh.AreaOfVertex), room.x() / extent.x(), room.y() / extent.y() });
  placement.Linear *= scale;
  const Eigen::RowVector2d free = (room - scale * extent).cwiseMax(0.0);
  placement.Offset = free.cwiseProduct(Eigen::RowVector2d(Uniform(key, ColumnPlace), Uniform(key, RowPlace))) -
    scale * lowest;
  if (Uniform(key, AugmentationPlace) < sizes.ColorAugmentation)
  {
    placement.AugmentColors(key);
  }
  return placement;
}

/// Draws a permutation of the channels, and for each the values that -1 and 1 become: cosines of uniform angles, which
/// are often near -1 and 1.
void TextureRings::Placement::AugmentColors(const NormalKey& key)
{
  for (auto k = UniformIndex(key, PermutationPlace, 6); k > 0; --k)
  {
    std::next_permutation(this->Channel.begin(), this->Channel.end());
  }
  for (Eigen::Index c = 0; c < 3; ++c)
  {
    const double first = std::cos(Pi * Uniform(key, ColorRangePlace + 2 * c));
    const double last = std::cos(Pi * Uniform(key, ColorRangePlace + 2 * c + 1));
    this->Scale[c] = 0.5 * (last - first);
    this->Shift[c] = 0.5 * (last + first);
  }
}

/// Color at a point of the mesh.
void TextureRings::Placement::ReadColor(const Eigen::RowVector2d& point, float* color) const
{
  float found[3];
  ColorAt(*this->Image, this->Offset + (point - this->Center) * this->Linear, found);
  for (Eigen::Index c = 0; c < 3; ++c)
  {
    const double value = found[this->Channel[static_cast<std::size_t>(c)]];
    color[c] = static_cast<float>(this->Shift[c] + this->Scale[c] * value);
  }
}

void TextureRings::SampleRing(const Mesh& mesh, Index vertex, const Placement& placement, const NormalKey& key,
  double power, std::int64_t count, float* logarithms, float* colors)
{
  const std::vector<Index>& around = mesh.Incident[static_cast<std::size_t>(vertex)];
  std::vector<double> areas; // of the triangles up to each
  double area = 0.0;
  for (const Index triangle : around)
  {
    area += AreaOf(mesh.Planar, triangle);
    areas.push_back(area);
  }
  const double radius = std::sqrt(area / Pi);
  const Eigen::RowVector2d center = mesh.Planar.Points.row(vertex);
  for (std::int64_t k = 0; k < count; ++k, logarithms += 2, colors += 3)
  {
    const double chosen = area * Uniform(key, 3 * k);
    const auto found = std::min(std::upper_bound(areas.begin(), areas.end(), chosen), areas.end() - 1);
    const Index triangle = around[static_cast<std::size_t>(found - areas.begin())];
    const double u = Uniform(key, 3 * k + 1);
    const double v = Uniform(key, 3 * k + 2);
    const Eigen::RowVector3d weights = power == 0.0
      ? UniformInTriangle(u, v)
      : WeightedInTriangle(power, CornerOf(mesh.Planar, triangle, vertex), u, v, Uniform(key, 3 * count + k));
    const Eigen::RowVector2d point = PointOf(mesh.Planar, triangle, weights);
    logarithms[0] = static_cast<float>((point.x() - center.x()) / radius);
    logarithms[1] = static_cast<float>((point.y() - center.y()) / radius);
    placement.ReadColor(point, colors);
  }
}

void TextureRings::SampleTriangle(const Mesh& mesh, Index triangle, const Placement& placement, const NormalKey& key,
  std::int64_t count, float* barycentric, float* colors)
{
  for (std::int64_t k = 0; k < count; ++k, barycentric += 3, colors += 3)
  {
    const Eigen::RowVector3d weights = UniformInTriangle(Uniform(key, 2 * k), Uniform(key, 2 * k + 1));
    Eigen::Map<Eigen::RowVector3f>(barycentric, 3) = weights.cast<float>();
    const Eigen::RowVector2d point = PointOf(mesh.Planar, triangle, weights);
    placement.ReadColor(point, colors);
  }
}

/// Draws one ring, or the three of a triangle. @param key its component is the number of the @p first ring
void TextureRings::DrawRings(
  const TextureRingSizes& sizes, const NormalKey& key, std::int64_t first, TextureRingBatch& batch) const
{
  const NormalKey choice = WithStream(key, PlacementStream);
  const Mesh& mesh = this->ChooseMesh(choice);
  const std::vector<Index>& candidates = sizes.InTriangles ? mesh.Triangles : mesh.Interior;
  const Index chosen =
    candidates[static_cast<std::size_t>(UniformIndex(choice, RingPlace, static_cast<std::int64_t>(candidates.size())))];
  std::vector<Index> vertices = { chosen };
  if (sizes.InTriangles)
  {
    const auto corners = mesh.Planar.Triangles.row(chosen);
    vertices = { corners(0), corners(1), corners(2) };
  }
  const Placement placement = this->Place(mesh, vertices, sizes, key);
  const std::int64_t at = first * sizes.Samples;
  for (std::size_t k = 0; k < vertices.size(); ++k)
  {
    NormalKey own = WithStream(key, EncoderStream);
    own.Component += static_cast<std::uint32_t>(k);
    const std::int64_t place = at + static_cast<std::int64_t>(k) * sizes.Samples;
    SampleRing(mesh, vertices[k], placement, own, 0.0, sizes.Samples, batch.Logarithms.data() + 2 * place,
      batch.Colors.data() + 3 * place);
  }
  const NormalKey target = WithStream(key, TargetStream);
  float* colors = batch.TargetColors.data() + 3 * at;
  if (sizes.InTriangles)
  {
    SampleTriangle(mesh, chosen, placement, target, 3 * sizes.Samples, batch.Barycentric.data() + 3 * at, colors);
  }
  else
  {
    float* logarithms = batch.TargetLogarithms.data() + 2 * at;
    SampleRing(mesh, chosen, placement, target, sizes.TargetPower, sizes.Samples, logarithms, colors);
  }
}

TextureRingBatch TextureRings::Draw(const TextureRingSizes& sizes, std::uint64_t seed, std::int64_t iteration) const
{
  const auto points = static_cast<std::size_t>(sizes.Rings * sizes.Samples);
  TextureRingBatch batch;
  batch.Logarithms.resize(2 * points);
  batch.Colors.resize(3 * points);
  batch.TargetColors.resize(3 * points);
  batch.TargetLogarithms.resize(sizes.InTriangles ? 0 : 2 * points);
  batch.Barycentric.resize(sizes.InTriangles ? 3 * points : 0);
  NormalKey key;
  key.Seed = seed;
  key.Sample = static_cast<std::uint32_t>(iteration);
  for (std::int64_t first = 0; first < sizes.Rings; first += sizes.InTriangles ? 3 : 1)
  {
    key.Component = static_cast<std::uint32_t>(first);
    this->DrawRings(sizes, key, first, batch);
  }
  return batch;
}

} // namespace surfsynth
