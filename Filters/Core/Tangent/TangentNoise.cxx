// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/TangentNoise.h"

#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"
#include "Core/Random/PlaceHash.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace surfsynth
{

namespace
{
/// Components of NormalKey that a drawing uses.
constexpr std::uint32_t ComponentsOfDraw = 256;

/// Share of an area in a cube.
struct Share
{
  std::int64_t Cube;
  double Area;
};

/// Number below 2^40 from three numbers.
std::int64_t NumberOf(const std::array<std::uint64_t, 3>& numbers)
{
  return static_cast<std::int64_t>(HashOfPlace(numbers) >> 24);
}

/// Number of the cube at a place.
std::int64_t NumberOfCube(const Eigen::RowVector3d& point, double side)
{
  std::array<std::uint64_t, 3> numbers{};
  for (int axis = 0; axis < 3; ++axis)
  {
    numbers[static_cast<std::size_t>(axis)] = static_cast<std::uint64_t>(
      static_cast<std::int64_t>(std::floor(point[axis] / side)));
  }
  return NumberOf(numbers);
}

/// Number of the bits of a position; 0 and -0 are the same.
std::int64_t NumberOfPosition(const Eigen::RowVector3d& point)
{
  std::array<std::uint64_t, 3> numbers{};
  for (int axis = 0; axis < 3; ++axis)
  {
    const double coordinate = point[axis] + 0.0;
    std::memcpy(&numbers[static_cast<std::size_t>(axis)], &coordinate, sizeof coordinate);
  }
  return NumberOf(numbers);
}

/// N(0, 1) numbers, [numbers, 3 vectors], of things with these numbers; 0 for -1. They are consecutive points of
/// FillNormals(), which are below 2^34: a part of the number of a thing chooses the points, the rest the component.
TangentNoise::Rows Normals(
  const std::vector<std::int64_t>& things, const NormalKey& key, std::int64_t vectors, std::uint32_t draw)
{
  const std::int64_t numbers = (3 * vectors + 3) / 4 * 4;
  const std::int64_t places = (std::int64_t(1) << 34) / numbers;
  TangentNoise::Rows values = TangentNoise::Rows::Zero(static_cast<Eigen::Index>(things.size()), 3 * vectors);
  ParallelFor(values.rows(), CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    Eigen::RowVectorXd normals(numbers);
    for (std::int64_t k = begin; k < end; ++k)
    {
      const std::int64_t thing = things[static_cast<std::size_t>(k)];
      if (thing < 0)
      {
        continue;
      }
      const std::uint32_t component = draw * ComponentsOfDraw + static_cast<std::uint32_t>(thing % ComponentsOfDraw);
      const std::int64_t place = thing / ComponentsOfDraw % places;
      FillNormals({ key.Seed, key.Sample, component, key.Stream }, place * numbers, numbers, normals.data());
      values.row(k) = normals.head(3 * vectors).cast<float>();
    }
  });
  return values;
}

/// Most patches along a side of a quadrilateral.
constexpr int MostPatches = 64;

/// Adds the shares of the quadrilateral v, middle of v a, center, middle of v b: a third of a triangle.
void AddCell(const Eigen::RowVector3d& v, const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, double side,
  std::vector<Share>& shares)
{
  const Eigen::RowVector3d corners[4] = { v, 0.5 * (v + a), (v + a + b) / 3.0, 0.5 * (v + b) };
  const double longest = std::max((a - v).norm(), (b - v).norm());
  const int count = std::clamp(static_cast<int>(std::ceil(0.5 * longest / side)), 1, MostPatches);
  const double area = (a - v).cross(b - v).norm() / 6.0;
  if (!(area > 0.0))
  {
    return;
  }
  double sum = 0.0;
  const std::size_t first = shares.size();
  for (int i = 0; i < count; ++i)
  {
    for (int j = 0; j < count; ++j)
    {
      const double s = (i + 0.5) / count;
      const double t = (j + 0.5) / count;
      const Eigen::RowVector3d alongS = (1.0 - t) * (corners[1] - corners[0]) + t * (corners[2] - corners[3]);
      const Eigen::RowVector3d alongT = (1.0 - s) * (corners[3] - corners[0]) + s * (corners[2] - corners[1]);
      const Eigen::RowVector3d place = (1.0 - s) * ((1.0 - t) * corners[0] + t * corners[3]) +
        s * ((1.0 - t) * corners[1] + t * corners[2]);
      shares.push_back({ NumberOfCube(place, side), alongS.cross(alongT).norm() });
      sum += shares.back().Area;
    }
  }
  for (std::size_t k = first; k < shares.size(); ++k)
  {
    shares[k].Area *= area / sum;
  }
}

/// Joins shares of the same cube, whose weights then have the squares' sum 1. The order of summation does not depend on
/// that of the triangles but for areas of the same cube, which are sorted.
void Join(std::vector<Share>& shares)
{
  std::sort(shares.begin(), shares.end(),
    [](const Share& a, const Share& b) { return std::make_pair(a.Cube, a.Area) < std::make_pair(b.Cube, b.Area); });
  std::size_t count = 0;
  for (const Share& share : shares)
  {
    if (count > 0 && shares[count - 1].Cube == share.Cube)
    {
      shares[count - 1].Area += share.Area;
    }
    else
    {
      shares[count++] = share;
    }
  }
  shares.resize(count);
  double squares = 0.0;
  for (const Share& share : shares)
  {
    squares += share.Area * share.Area;
  }
  for (Share& share : shares)
  {
    share.Area /= std::sqrt(squares);
  }
}
} // namespace

TangentNoise::TangentNoise(const TriangleMesh& mesh, const OneRings& rings)
  : Frames(rings.Frames)
  , Start(1, 0)
{
  const double quarter = MeanRingRadius(rings) / 4.0;
  this->Side = quarter > 0.0 && std::isfinite(quarter) ? std::exp2(std::floor(std::log2(quarter))) : 0.0;
  std::vector<std::int64_t> members;
  std::vector<Share> shares;
  for (Index vertex = 0; vertex < rings.NumberOfPoints(); ++vertex)
  {
    shares.clear();
    for (Index k = rings.RingStart[vertex]; this->Side > 0.0 && k < rings.RingStart[vertex + 1]; ++k)
    {
      const Index corner = rings.RingCorners[k];
      const int at = static_cast<int>(corner % 3);
      const Index triangle = corner / 3;
      AddCell(mesh.Points.row(vertex), mesh.Points.row(mesh.Triangles(triangle, (at + 1) % 3)),
        mesh.Points.row(mesh.Triangles(triangle, (at + 2) % 3)), this->Side, shares);
    }
    const bool isUsed = rings.RingStart[vertex] < rings.RingStart[vertex + 1];
    this->Vertices.push_back(isUsed ? NumberOfPosition(mesh.Points.row(vertex)) : -1);
    Join(shares);
    for (const Share& share : shares)
    {
      members.push_back(share.Cube);
      this->Weights.push_back(static_cast<float>(share.Area));
    }
    this->Start.push_back(members.size());
  }
  this->Cubes = members;
  std::sort(this->Cubes.begin(), this->Cubes.end());
  this->Cubes.erase(std::unique(this->Cubes.begin(), this->Cubes.end()), this->Cubes.end());
  this->Members.reserve(members.size());
  for (const std::int64_t cube : members)
  {
    this->Members.push_back(
      static_cast<std::uint32_t>(std::lower_bound(this->Cubes.begin(), this->Cubes.end(), cube) - this->Cubes.begin()));
  }
}

TangentNoise::Rows TangentNoise::Draw(const NormalKey& key, std::int64_t vectors, std::uint32_t draw) const
{
  const Rows values = Normals(this->Cubes, key, vectors, draw);
  const auto vertices = static_cast<std::int64_t>(this->Start.size()) - 1;
  Rows sums = Rows::Zero(vertices, values.cols());
  ParallelFor(vertices, CoarseGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v)
    {
      for (std::size_t k = this->Start[v]; k < this->Start[v + 1]; ++k)
      {
        sums.row(static_cast<Eigen::Index>(v)) += this->Weights[k] * values.row(this->Members[k]);
      }
    }
  });
  return this->Project(sums);
}

TangentNoise::Rows TangentNoise::DrawAtVertices(const NormalKey& key, std::int64_t vectors, std::uint32_t draw) const
{
  return this->Project(Normals(this->Vertices, key, vectors, draw));
}

TangentNoise::Rows TangentNoise::Project(const Rows& vectors) const
{
  Rows noise = Rows::Zero(vectors.rows(), vectors.cols() / 3 * 2);
  for (Eigen::Index v = 0; v < noise.rows(); ++v)
  {
    for (Eigen::Index j = 0; j < noise.cols() / 2; ++j)
    {
      const Eigen::RowVector3d vector = vectors.row(v).segment<3>(3 * j).cast<double>();
      noise(v, 2 * j) = static_cast<float>(vector.dot(this->Frames.X.row(v)));
      noise(v, 2 * j + 1) = static_cast<float>(vector.dot(this->Frames.Y.row(v)));
    }
  }
  return noise;
}

} // namespace surfsynth
