// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Statistics/GeometricTextureFeatures.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/SurfaceSmoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr double LowQuantile = 0.05;
constexpr double HighQuantile = 0.95;
constexpr double RelativeRounding = 1e-6;       ///< of the longest side: below it relief is rounding
constexpr double RelativeSmoothingLength = 0.1; ///< of the root of the area

[[noreturn]] void Refuse(const std::string& found) { throw InvalidInput("MeasureGeometricTextureFeatures: " + found); }

void RequireInRange(const char* name, double value, double maximum)
{
  if (!(value >= 0.0 && value <= maximum) || !std::isfinite(value))
  {
    const std::string range = std::isfinite(maximum) ? "from 0 to " + FormatNumber(maximum) : "0 or more";
    Refuse(std::string("the ") + name + " is " + FormatNumber(value) + "; expected " + range + ".");
  }
}

void CheckOptions(const GeometricTextureFeatureOptions& options)
{
  const double any = std::numeric_limits<double>::infinity();
  RequireInRange("unit length", options.UnitLength, any);
  RequireInRange("minimum prominence", options.MinimumProminence, any);
  RequireInRange("smoothing length", options.SmoothingLength, any);
  RequireInRange("merged saddle", options.MergedSaddle, 1.0);
  RequireInRange("wall level", options.WallLevel, 1.0);
}

void CheckTriangles(const TriangleMesh& surface, const TriangleMesh* bare)
{
  if (surface.NumberOfTriangles() == 0)
  {
    Refuse("the surface has no triangle; expected at least one.");
  }
  if (!bare)
  {
    return;
  }
  const auto numbers = [](const TriangleMesh& mesh) {
    return std::to_string(mesh.NumberOfPoints()) + " points and " + std::to_string(mesh.NumberOfTriangles()) +
      " triangles";
  };
  if (bare->NumberOfPoints() != surface.NumberOfPoints() || bare->NumberOfTriangles() != surface.NumberOfTriangles())
  {
    Refuse("the bare surface has " + numbers(*bare) + "; expected those of the surface, " + numbers(surface) + ".");
  }
  if (bare->Triangles != surface.Triangles)
  {
    Refuse("the bare surface has other triangles than the surface; expected the same triangles with other points.");
  }
}

/// Heights of used vertices with their areas, in ascending order.
class HeightDistribution
{
public:
  HeightDistribution(const Eigen::VectorXd& heights, const Eigen::VectorXd& mass)
  {
    for (Eigen::Index v = 0; v < heights.size(); ++v)
    {
      if (mass[v] > 0.0)
      {
        this->Sorted.emplace_back(heights[v], mass[v]);
        this->Area += mass[v];
      }
    }
    std::sort(this->Sorted.begin(), this->Sorted.end());
    for (const auto& [height, weight] : this->Sorted)
    {
      this->Mean += weight / this->Area * height;
    }
    double variance = 0.0;
    for (const auto& [height, weight] : this->Sorted)
    {
      variance += weight / this->Area * (height - this->Mean) * (height - this->Mean);
    }
    this->Deviation = std::sqrt(variance);
  }

  /// Height that a share @p probability of the area does not exceed.
  double Quantile(double probability) const
  {
    double below = 0.0;
    for (const auto& [height, weight] : this->Sorted)
    {
      below += weight;
      if (below >= probability * this->Area)
      {
        return height;
      }
    }
    return this->Sorted.back().first;
  }

  double Area = 0.0;
  double Mean = 0.0;
  double Deviation = 0.0;

private:
  std::vector<std::pair<double, double>> Sorted;
};

/// Length of the isoline of heights that are linear on the triangles; a height on the level counts as above.
double IsolineLength(const TriangleMesh& mesh, const Eigen::VectorXd& heights, double level)
{
  double length = 0.0;
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    Eigen::RowVector3d ends[2];
    int found = 0;
    for (int k = 0; k < 3; ++k)
    {
      const Index a = mesh.Triangles(f, k), b = mesh.Triangles(f, (k + 1) % 3);
      if ((heights[a] >= level) != (heights[b] >= level) && found < 2)
      {
        const double share = (level - heights[a]) / (heights[b] - heights[a]);
        ends[found++] = (1.0 - share) * mesh.Points.row(a) + share * mesh.Points.row(b);
      }
    }
    length += found == 2 ? (ends[1] - ends[0]).stableNorm() : 0.0;
  }
  return length;
}

void SummarizePeaks(GeometricTextureFeatures& result, double mergedSaddle)
{
  const auto count = static_cast<Eigen::Index>(result.Peaks.Peaks.size());
  result.NumberOfPeaks = count;
  result.PeakDensity = static_cast<double>(count) / result.Area;
  result.RelativePeakDensity = static_cast<double>(count) / (result.Area / result.UnitLength / result.UnitLength);
  if (count == 0)
  {
    return;
  }
  Eigen::VectorXd heights(count);
  for (Eigen::Index k = 0; k < count; ++k)
  {
    heights[k] = result.Heights[result.Peaks.Peaks[static_cast<std::size_t>(k)]] - result.BaseLevel;
    result.NumberOfMergedPeaks += result.Peaks.SaddleRatios[k] > mergedSaddle ? 1 : 0;
  }
  std::sort(heights.begin(), heights.end()); // sums do not depend on ids
  const auto number = static_cast<double>(count);
  result.MeanPeakHeight = heights.sum() / number;
  const double variance = count > 1 ? (heights.array() - result.MeanPeakHeight).square().sum() / (number - 1.0) : 0.0;
  result.PeakHeightVariation = result.MeanPeakHeight > 0.0 ? std::sqrt(variance) / result.MeanPeakHeight : 0.0;
  result.MergedShare = static_cast<double>(result.NumberOfMergedPeaks) / number;
}

void MeasureWalls(GeometricTextureFeatures& result, const TriangleMesh& form)
{
  result.WallLength = 0.5 * IsolineLength(form, result.Heights, result.WallHeight);
  result.WallDensity = result.WallLength / result.Area;
  result.RelativeWallDensity = result.WallLength * result.UnitLength / result.Area;
}
} // namespace

TriangleMesh SmoothedForm(const TriangleMesh& mesh, const MeshTopology& topology, double length)
{
  const SurfaceSmoothing smoothing(mesh, topology, length);
  const BoundingBox box = ComputeBoundingBox(mesh);
  const Eigen::RowVector3d center = 0.5 * (box.Lower + box.Upper).transpose();
  const RowMatrix given = mesh.Points.rowwise() - center;
  TriangleMesh form = mesh;
  form.Points = smoothing.Apply(2.0 * given - smoothing.Apply(given)).rowwise() + center;
  return form;
}

Eigen::VectorXd HeightsOver(const TriangleMesh& surface, const TriangleMesh& bare, const MeshTopology& topology)
{
  const PointMatrix normals = TangentFrames(bare, topology).Normal;
  Eigen::VectorXd heights = Eigen::VectorXd::Zero(surface.Points.rows());
  for (Index v = 0; v < surface.NumberOfPoints(); ++v)
  {
    if (topology.VertexTriangleStart[v] < topology.VertexTriangleStart[v + 1])
    {
      heights[v] = (surface.Points.row(v) - bare.Points.row(v)).dot(normals.row(v));
    }
  }
  return heights;
}

GeometricTextureFeatures MeasureGeometricTextureFeatures(const TriangleMesh& surface, const TriangleMesh* bare,
  const GeometricTextureFeatureOptions& options, const Progress& progress)
{
  CheckOptions(options);
  CheckTriangles(surface, bare);
  const MeshTopology topology(surface);
  Report(progress, 0.1);
  TriangleMesh form;
  if (!bare)
  {
    const double length = options.SmoothingLength > 0.0 ? options.SmoothingLength
                                                        : RelativeSmoothingLength * std::sqrt(FaceAreas(surface).sum());
    form = SmoothedForm(surface, topology, length);
  }
  const TriangleMesh& ground = bare ? *bare : form;
  Report(progress, 0.5);
  GeometricTextureFeatures result;
  result.Heights = HeightsOver(surface, ground, topology);
  const HeightDistribution distribution(result.Heights, LumpedMass(ground, topology));
  if (!std::isfinite(distribution.Area) || !std::isfinite(distribution.Deviation))
  {
    Refuse("the area is " + FormatNumber(distribution.Area) + " and the deviation of the heights " +
      FormatNumber(distribution.Deviation) + "; expected finite numbers.");
  }
  result.Area = distribution.Area;
  result.UnitLength = options.UnitLength > 0.0 ? options.UnitLength : MeanEdgeLength(ground, topology);
  result.HeightDeviation = distribution.Deviation;
  result.BaseLevel = distribution.Quantile(LowQuantile);
  const double rounding = RelativeRounding * ComputeBoundingBox(surface).LongestSide();
  result.MinimumProminence = options.MinimumProminence > 0.0 ? options.MinimumProminence
                                                             : std::max(0.5 * distribution.Deviation, rounding);
  Report(progress, 0.6);
  result.Peaks = FindHeightPeaks(topology, result.Heights, result.MinimumProminence, result.BaseLevel);
  SummarizePeaks(result, options.MergedSaddle);
  Report(progress, 0.9);
  const double high = distribution.Quantile(HighQuantile);
  result.WallHeight = options.WallLevel > 0.0 ? result.BaseLevel + options.WallLevel * (high - result.BaseLevel)
                                              : distribution.Mean;
  if (distribution.Deviation > rounding)
  {
    MeasureWalls(result, ground);
  }
  Report(progress, 1.0);
  return result;
}

} // namespace surfsynth
