// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Atlas/SurfaceAtlas.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"
#include "MeshProcessing/Atlas/ChartMaps.h"
#include "MeshProcessing/Atlas/ChartPacking.h"
#include "MeshProcessing/Atlas/SurfaceCharts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Most parts of a connected part of the surface at its first division.
constexpr std::size_t MostParts = 60;
/// Largest magnitude of the binary exponent of coordinates whose products stay well inside double precision.
constexpr int LargestExponent = 100;
/// Most connected pieces of a division in two.
constexpr std::size_t MostPiecesOfTwo = 4;

void RequireOptions(const SurfaceAtlasOptions& options)
{
  const auto require = [](bool holds, const std::string& found, const char* expected) {
    if (!holds)
    {
      throw InvalidInput("MakeSurfaceAtlas: " + found + "; expected " + expected + ".");
    }
  };
  const auto isSize = [](int size) { return size >= 16 && size <= 32768; };
  require(isSize(options.Width) && isSize(options.Height),
    "an image of " + std::to_string(options.Width) + " x " + std::to_string(options.Height) + " texels",
    "16 to 32768 along each axis");
  require(options.Margin >= 1 && options.Margin <= 256, "a margin of " + std::to_string(options.Margin) + " texels",
    "1 to 256");
  require(options.MaximumStretch > 1.0, "a maximum stretch of " + FormatNumber(options.MaximumStretch),
    "a number larger than 1");
}

MeshTopology RequireSurface(const TriangleMesh& mesh)
{
  MeshRequirements requirements;
  requirements.ManifoldVertices = true;
  requirements.ConsistentWinding = true;
  return RequireValidMesh(mesh, requirements);
}

/// Exponent of the power of two that brings coordinates near 1 when their third powers leave the range of double
/// precision; 0 otherwise.
int ExtremeExponent(const TriangleMesh& mesh)
{
  const double largest = mesh.Points.size() > 0 ? mesh.Points.cwiseAbs().maxCoeff() : 0.0;
  int exponent = 0;
  if (std::isfinite(largest) && largest > 0.0)
  {
    std::frexp(largest, &exponent);
  }
  return std::abs(exponent) > LargestExponent ? exponent : 0;
}

/// A chart and its place in the plane.
struct FlatChart
{
  SurfaceChart Chart;
  FlatPoints Points;
  ChartStretch Stretch;
};

/// Divides a surface into charts until each one can be flattened.
class ChartMaker
{
public:
  ChartMaker(const TriangleMesh& mesh, double maximumStretch, const std::atomic<bool>* stop)
    : Cutter(mesh, RequireSurface(mesh))
    , MaximumStretch(maximumStretch)
    , Stop(stop)
  {
    std::vector<Index> all(static_cast<std::size_t>(mesh.NumberOfTriangles()));
    std::iota(all.begin(), all.end(), 0);
    for (const std::vector<Index>& part : this->Cutter.ConnectedParts(all))
    {
      this->Make(part, MostParts);
    }
    std::sort(this->Charts.begin(), this->Charts.end(),
      [](const FlatChart& a, const FlatChart& b) { return a.Chart.Triangles.front() < b.Chart.Triangles.front(); });
  }

  std::vector<FlatChart> Charts;

private:
  void Make(std::vector<Index> triangles, std::size_t parts)
  {
    std::vector<std::pair<std::vector<Index>, std::size_t>> waiting;
    waiting.emplace_back(std::move(triangles), parts);
    while (!waiting.empty())
    {
      if (this->Stop != nullptr && *this->Stop)
      {
        throw Cancelled("MakeSurfaceAtlas: cancelled.");
      }
      const auto [at, mostParts] = std::move(waiting.back());
      waiting.pop_back();
      SurfaceChart chart = this->Cutter.Cut(at);
      if (this->Keep(chart))
      {
        continue;
      }
      for (std::vector<Index>& part : this->Divide(at, chart.Mesh, mostParts))
      {
        waiting.emplace_back(std::move(part), 2);
      }
    }
  }

  /// Parts of a chart. Where the chart is nearly flat, normals do not say where to divide it: then it is halved.
  std::vector<std::vector<Index>> Divide(
    const std::vector<Index>& triangles, const TriangleMesh& chart, std::size_t mostParts)
  {
    std::vector<std::vector<Index>> parts = this->Cutter.ConnectedParts(triangles, DivideChart(chart, mostParts));
    const auto largest = std::max_element(
      parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    if (mostParts == 2 && (parts.size() > MostPiecesOfTwo || 10 * largest->size() > 9 * triangles.size()))
    {
      return this->Cutter.ConnectedParts(triangles, HalveChart(chart));
    }
    return parts;
  }

  /// Keeps a chart that can be flattened well enough.
  bool Keep(SurfaceChart& chart)
  {
    if (!chart.IsDisk)
    {
      return false;
    }
    for (const auto flatten : { FlattenConformally, FlattenByProjection })
    {
      FlatPoints flat = flatten(chart.Mesh);
      if (flat.rows() > 0)
      {
        const ChartStretch stretch = MeasureStretch(chart.Mesh, flat);
        if (stretch.Largest <= this->MaximumStretch)
        {
          this->Charts.push_back({ std::move(chart), std::move(flat), stretch });
          return true;
        }
      }
    }
    return false;
  }

  ChartCutter Cutter;
  double MaximumStretch;
  const std::atomic<bool>* Stop;
};

ChartPacking PackFlatCharts(std::vector<FlatChart>& charts, const SurfaceAtlasOptions& options)
{
  std::vector<ChartShape> shapes;
  for (FlatChart& chart : charts)
  {
    TurnToSmallestBox(chart.Points);
    shapes.push_back({ &chart.Points, &chart.Chart.Mesh.Triangles });
  }
  ChartPacking packing = PackCharts(shapes, options.Width, options.Height, options.Margin);
  if (packing.Scale == 0.0)
  {
    throw InvalidInput("MakeSurfaceAtlas: " + std::to_string(charts.size()) + " charts with margins of " +
      std::to_string(options.Margin) + " texels do not fit into an image of " + std::to_string(options.Width) + " x " +
      std::to_string(options.Height) + " texels; a larger image, a smaller margin or a larger maximum stretch fits.");
  }
  for (std::size_t k = 0; k < charts.size(); ++k)
  {
    FlatPoints& points = charts[k].Points;
    if (packing.IsTurned[k])
    {
      const Eigen::RowVector2d size = points.colwise().maxCoeff();
      points = (-points).rowwise() + size;
    }
  }
  return packing;
}
} // namespace

SurfaceAtlas MakeSurfaceAtlas(
  const TriangleMesh& mesh, const SurfaceAtlasOptions& options, const std::atomic<bool>* stop)
{
  RequireOptions(options);
  const int exponent = ExtremeExponent(mesh);
  if (exponent != 0)
  {
    TriangleMesh scaled = mesh;
    scaled.Points = mesh.Points.unaryExpr([exponent](double x) { return std::ldexp(x, -exponent); });
    SurfaceAtlas atlas = MakeSurfaceAtlas(scaled, options, stop);
    atlas.TexelsPerLength = std::ldexp(atlas.TexelsPerLength, -exponent);
    return atlas;
  }
  std::vector<FlatChart> charts = std::move(ChartMaker(mesh, options.MaximumStretch, stop).Charts);
  SurfaceAtlas atlas;
  if (charts.empty())
  {
    return atlas;
  }
  const ChartPacking packing = PackFlatCharts(charts, options);
  atlas.Coordinates.resize(3 * std::int64_t(mesh.NumberOfTriangles()), 2);
  atlas.ChartOfTriangle.resize(static_cast<std::size_t>(mesh.NumberOfTriangles()));
  atlas.NumberOfCharts = static_cast<Index>(charts.size());
  atlas.TexelsPerLength = packing.Scale;
  ChartStretch total;
  for (std::size_t k = 0; k < charts.size(); ++k)
  {
    const FlatChart& chart = charts[k];
    for (std::size_t f = 0; f < chart.Chart.Triangles.size(); ++f)
    {
      const Index triangle = chart.Chart.Triangles[f];
      atlas.ChartOfTriangle[triangle] = static_cast<Index>(k);
      for (int corner = 0; corner < 3; ++corner)
      {
        const Index point = chart.Chart.Mesh.Triangles(static_cast<Eigen::Index>(f), corner);
        const Eigen::Vector2d texel = packing.Corners[k] + packing.Scale * chart.Points.row(point).transpose();
        atlas.Coordinates.row(3 * std::int64_t(triangle) + corner) << texel.x() / options.Width,
          texel.y() / options.Height;
      }
    }
    total.Area += chart.Stretch.Area;
    total.SquaredStretch += chart.Stretch.SquaredStretch;
    total.Largest = std::max(total.Largest, chart.Stretch.Largest);
  }
  atlas.Coverage = total.Area * packing.Scale * packing.Scale / (static_cast<double>(options.Width) * options.Height);
  atlas.RootMeanStretch = std::sqrt(total.SquaredStretch / total.Area);
  atlas.LargestStretch = total.Largest;
  return atlas;
}

} // namespace surfsynth
