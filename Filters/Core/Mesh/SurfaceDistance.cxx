// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/SurfaceDistance.h"

#include "Core/Common/AvailableMemory.h"
#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Random/CounterNormals.h"
#include "Core/Random/CounterUniforms.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace surfsynth
{

namespace
{
/// Places that are measured between two reports of progress.
constexpr std::int64_t PlacesAtATime = 1 << 16;
/// Steps of the additive recurrence in two dimensions: 1 / g and 1 / g^2 with g^3 = g + 1.
constexpr double FirstStep = 0.7548776662466927;
constexpr double SecondStep = 0.5698402909980532;

/// Sums of the areas of the triangles up to each. @throws InvalidInput for a surface without area
std::vector<double> AreasUpTo(const TriangleMesh& mesh, const char* name)
{
  std::vector<double> sums;
  double sum = 0.0;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    const Eigen::Vector3d a = mesh.Points.row(mesh.Triangles(f, 0)), b = mesh.Points.row(mesh.Triangles(f, 1)),
                          c = mesh.Points.row(mesh.Triangles(f, 2));
    sum += 0.5 * (b - a).cross(c - a).norm();
    sums.push_back(sum);
  }
  if (!(sum > 0.0) || !std::isfinite(sum))
  {
    throw InvalidInput(std::string("ComputeSurfaceDistance: the ") + name + " surface has the area " +
      std::to_string(sum) + "; expected triangles with finite points and an area.");
  }
  return sums;
}

double Fraction(double number) { return number - std::floor(number); }

/// Places @p begin to @p end of one in each of @p count equal parts of the area.
/// @param triangles filled with the triangle of each place, unless null
PointMatrix SamplePlaces(const TriangleMesh& mesh, const std::vector<double>& areas, std::int64_t count,
  std::uint64_t seed, std::int64_t begin, std::int64_t end, std::vector<Index>* triangles = nullptr)
{
  PointMatrix places(end - begin, 3);
  double shift[3];
  for (std::uint32_t c = 0; c < 3; ++c)
  {
    NormalKey key;
    key.Seed = seed;
    key.Component = c;
    shift[c] = Uniform(key, 0);
  }
  for (std::int64_t k = begin; k < end; ++k)
  {
    const auto number = static_cast<double>(k);
    const double first = Fraction(shift[1] + number * FirstStep), second = Fraction(shift[2] + number * SecondStep);
    const double place = areas.back() * (number + shift[0]) / static_cast<double>(count);
    const auto found = std::upper_bound(areas.begin(), areas.end() - 1, place);
    const Eigen::Index f = found - areas.begin();
    if (triangles)
    {
      triangles->push_back(static_cast<Index>(f));
    }
    const double root = std::sqrt(first);
    places.row(k - begin) = (1.0 - root) * mesh.Points.row(mesh.Triangles(f, 0)) +
      root * (1.0 - second) * mesh.Points.row(mesh.Triangles(f, 1)) +
      root * second * mesh.Points.row(mesh.Triangles(f, 2));
  }
  return places;
}

/// Corners of triangles, each once.
PointMatrix VerticesOf(const TriangleMesh& mesh)
{
  std::vector<Index> used(mesh.Triangles.data(), mesh.Triangles.data() + mesh.Triangles.size());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  PointMatrix points(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t k = 0; k < used.size(); ++k)
  {
    points.row(static_cast<Eigen::Index>(k)) = mesh.Points.row(used[k]);
  }
  return points;
}

/// Distances of @p count points, of which pointsAt(begin, end) makes those from begin to end.
template <typename Points>
Eigen::VectorXd DistancesInParts(const TriangleMesh& mesh, std::int64_t count, const Points& pointsAt,
  const PlaceFinder& find, const Progress& progress)
{
  Eigen::VectorXd distances(count);
  for (std::int64_t begin = 0; begin < count; begin += PlacesAtATime)
  {
    Report(progress, static_cast<double>(begin) / static_cast<double>(count));
    const std::int64_t end = std::min(begin + PlacesAtATime, count);
    distances.segment(begin, end - begin) = DistancesTo(mesh, pointsAt(begin, end), find);
  }
  return distances;
}

/// @param sorted distances of samples in ascending order
/// @param farthest largest distance of a vertex
DistanceSummary SummarizeDistances(const Eigen::VectorXd& sorted, double farthest)
{
  DistanceSummary summary;
  const auto count = static_cast<double>(sorted.size());
  summary.Mean = sorted.mean();
  summary.RMS = std::sqrt(sorted.squaredNorm() / count);
  summary.Percentile95 = sorted[std::min<Eigen::Index>(static_cast<Eigen::Index>(0.95 * count), sorted.size() - 1)];
  summary.Maximum = std::max(farthest, sorted[sorted.size() - 1]);
  return summary;
}

/// The unit normal of triangle @p f; 0 without area.
Eigen::Vector3d UnitNormal(const TriangleMesh& mesh, Index f)
{
  const Eigen::Vector3d normal = AreaVector(mesh, f);
  const double length = normal.norm();
  return length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}
} // namespace

double MeanNormalAngle(const TriangleMesh& first, const TriangleMesh& second, const PlaceFinder& find,
  std::int64_t samples, std::uint64_t seed)
{
  const TriangleMesh* meshes[2] = { &first, &second };
  const char* names[2] = { "first", "second" };
  double sum = 0.0;
  for (int side = 0; side < 2; ++side)
  {
    const TriangleMesh& from = *meshes[side];
    const TriangleMesh& to = *meshes[1 - side];
    std::vector<Index> triangles;
    const PointMatrix points = SamplePlaces(from, AreasUpTo(from, names[side]), samples, seed, 0, samples, &triangles);
    const std::vector<SurfacePlace> places = find(to, points);
    for (std::size_t k = 0; k < places.size(); ++k)
    {
      const double cosine = UnitNormal(from, triangles[k]).dot(UnitNormal(to, places[k].Triangle));
      sum += std::acos(std::clamp(cosine, -1.0, 1.0));
    }
  }
  return sum / (2.0 * static_cast<double>(samples)) * 180.0 / std::acos(-1.0);
}

Eigen::VectorXd DistancesTo(const TriangleMesh& mesh, const PointMatrix& points, const PlaceFinder& find)
{
  const std::vector<SurfacePlace> places = find(mesh, points);
  Eigen::VectorXd distances(points.rows());
  for (Eigen::Index k = 0; k < points.rows(); ++k)
  {
    distances[k] = (points.row(k).transpose() - PositionOf(mesh, places[static_cast<std::size_t>(k)])).norm();
  }
  return distances;
}

SurfaceDistance ComputeSurfaceDistance(const TriangleMesh& first, const TriangleMesh& second, const PlaceFinder& find,
  std::int64_t samples, std::uint64_t seed, const Progress& progress)
{
  if (samples < 1)
  {
    throw InvalidInput("ComputeSurfaceDistance: found " + std::to_string(samples) + " samples; expected at least 1.");
  }
  const double needed = 4.0 * sizeof(double) * static_cast<double>(samples); // distances of both sides, and all of them
  if (needed > static_cast<double>(AvailableMemory()))
  {
    throw InvalidInput("ComputeSurfaceDistance: " + std::to_string(samples) + " samples need " +
      FormatNumber(needed / (1 << 30)) + " GiB, more than there is; expected fewer samples.");
  }
  const TriangleMesh* meshes[2] = { &first, &second };
  const char* names[2] = { "first", "second" };
  std::vector<double> areas[2] = { AreasUpTo(first, names[0]), AreasUpTo(second, names[1]) };
  DistanceSummary summaries[2];
  Eigen::VectorXd all(2 * samples);
  for (int side = 0; side < 2; ++side)
  {
    const TriangleMesh& from = *meshes[side];
    const TriangleMesh& to = *meshes[1 - side];
    const Progress part = SubProgress(progress, 0.5 * side, 0.5 * side + 0.5);
    const auto samplesAt = [&](std::int64_t begin, std::int64_t end) {
      return SamplePlaces(from, areas[side], samples, seed, begin, end);
    };
    Eigen::VectorXd distances = DistancesInParts(to, samples, samplesAt, find, SubProgress(part, 0.0, 0.7));
    const PointMatrix vertices = VerticesOf(from);
    const auto verticesAt = [&](std::int64_t begin, std::int64_t end) {
      return PointMatrix(vertices.middleRows(begin, end - begin));
    };
    const double farthest =
      DistancesInParts(to, vertices.rows(), verticesAt, find, SubProgress(part, 0.7, 1.0)).maxCoeff();
    std::sort(distances.begin(), distances.end());
    summaries[side] = SummarizeDistances(distances, farthest);
    all.segment(side * samples, samples) = distances;
  }
  std::sort(all.begin(), all.end());
  SurfaceDistance result{ summaries[0], summaries[1], {} };
  result.Symmetric = SummarizeDistances(all, std::max(summaries[0].Maximum, summaries[1].Maximum));
  Report(progress, 1.0);
  return result;
}

} // namespace surfsynth
