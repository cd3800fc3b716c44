// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/ExampleSynthesis.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/ExampleBlend.h"
#include "Inference/GeometricTexture/PatchCenters.h"
#include "Inference/GeometricTexture/PatchMatching.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr int AutomaticSubdivisions = 2, MostSubdivisions = 8;
/// Longest mean edge over the spacing of a scale whose patches a mesh can hold.
constexpr double LongestEdge = 1.25;
/// Patches that cover a point in the mean: at the coarsest scale, the next one, and the others.
constexpr std::array<double, 3> Coverage = { 93.0, 46.0, 16.0 };
/// Iterations at these scales.
constexpr std::array<int, 3> DistributionIterations = { 400, 100, 0 }, NearestIterations = { 18, 18, 6 };
/// Most patches of a scale, 4 GB of samples, and triangles of the finest mesh, about 10 GB with tables.
constexpr double MostPatches = 1.2e6, MostTriangles = 3e7;
/// Length that the thresholds of blends are smoothed over, spacings of the coarsest scale: half of the width of a patch.
constexpr double ThresholdLength = 4.0;
constexpr std::uint32_t InitialNumbers = 4, CenterNumbers = 5,
                        ThresholdNumbers = 6; ///< components of the key, see PatchMatching.cxx

[[noreturn]] void Refuse(const std::string& problem) { throw InvalidInput("SynthesizeFromExample: " + problem); }

/// Target and its subdivisions.
class TargetLevels
{
public:
  explicit TargetLevels(const TriangleMesh& mesh) { this->Add(mesh); }

  void Subdivide()
  {
    SubdividedMesh finer = SubdivideAtMidpoints(this->Meshes.back());
    this->Add(std::move(finer.Mesh));
    this->Edges.push_back(std::move(finer.Parents));
  }

  int Last() const { return static_cast<int>(this->Meshes.size()) - 1; }
  double EdgeLength(int level) const { return this->EdgeLengths[static_cast<std::size_t>(level)]; }
  const TriangleMesh& Mesh(int level) const { return this->Meshes[static_cast<std::size_t>(level)]; }

  /// Interpolates rows at the points of a level linearly to a finer one.
  template <typename Rows>
  Rows Prolong(const Rows& rows, int from, int to) const
  {
    Rows finer = rows;
    for (int level = from; level < to; ++level)
    {
      finer = InterpolateAtMidpoints(std::move(finer), this->Edges[static_cast<std::size_t>(level)]);
    }
    return finer;
  }

  /// Ends of the edges that the points of each subdivision lie on.
  const SubdivisionParents& Parents() const { return this->Edges; }

private:
  void Add(TriangleMesh mesh)
  {
    this->EdgeLengths.push_back(MeanEdgeLength(mesh, MeshTopology(mesh)));
    this->Meshes.push_back(std::move(mesh));
  }

  std::vector<TriangleMesh> Meshes;
  std::vector<double> EdgeLengths; ///< means, world units
  SubdivisionParents Edges;
};

/// Returns the number of patches of an area in squares of the spacing. @throws InvalidInput when there are too many.
std::int64_t RequirePatches(double squares, double coverage)
{
  const double count = std::ceil(coverage * squares / TexturePatches::Samples) + 1.0;
  if (!(count <= MostPatches))
  {
    Refuse("the area is that of " + FormatNumber(squares) +
      " squared edges of the example at this scale; a larger scale, or a smaller target, is needed.");
  }
  return static_cast<std::int64_t>(count);
}

void CheckBlend(
  const GeometricTextureExample& example, const TriangleMesh& mesh, const ExampleSynthesisRequest& request)
{
  if ((request.Second != nullptr) != (request.Blend.size() > 0))
  {
    Refuse("only one of a second example and its share is given; both or none are needed.");
  }
  if (!request.Second)
  {
    return;
  }
  if (request.Blend.size() != mesh.NumberOfPoints() ||
    !(request.Blend.array() >= 0.0F && request.Blend.array() <= 1.0F).all())
  {
    Refuse("there are " + std::to_string(request.Blend.size()) +
      " shares of the second example, or one is not in [0, 1]; one for each of " +
      std::to_string(mesh.NumberOfPoints()) + " points is needed.");
  }
  if (request.Second->Scales().size() != example.Scales().size() ||
    request.Second->IsOriented() != example.IsOriented())
  {
    Refuse("the examples have " + std::to_string(example.Scales().size()) + " and " +
      std::to_string(request.Second->Scales().size()) +
      " scales, or only one has directions; the same number, and directions of both or none, are needed.");
  }
}

void CheckRequest(
  const GeometricTextureExample& example, const TriangleMesh& mesh, const ExampleSynthesisRequest& request)
{
  if (!(request.Scale >= 0.0) || !std::isfinite(request.Scale) || request.Subdivisions < -1 ||
    request.Subdivisions > MostSubdivisions)
  {
    Refuse("the scale is " + FormatNumber(request.Scale) + " with " + std::to_string(request.Subdivisions) +
      " subdivisions; a finite scale of at least 0 and -1 to 8 subdivisions are needed.");
  }
  if (request.Sizes.size() > 0 &&
    (request.Sizes.size() != mesh.NumberOfPoints() || !request.Sizes.allFinite() ||
      !(request.Sizes.array() > 0.0F).all()))
  {
    Refuse("there are " + std::to_string(request.Sizes.size()) +
      " sizes, or one is not above 0; one above 0 for each of " + std::to_string(mesh.NumberOfPoints()) +
      " points is needed.");
  }
  if (request.Directions.rows() > 0 &&
    (request.Directions.rows() != mesh.NumberOfPoints() || !request.Directions.allFinite()))
  {
    Refuse("there are " + std::to_string(request.Directions.rows()) +
      " directions, or one is not finite; one for each of " + std::to_string(mesh.NumberOfPoints()) +
      " points is needed.");
  }
  if ((request.Directions.rows() > 0) != example.IsOriented())
  {
    Refuse("only one of the target and the example has directions; both or none are needed.");
  }
  CheckBlend(example, mesh, request);
}

/// Checks sizes before any work: the triangles of the finest mesh, and the patches of the finest scale.
/// @param spacing of the finest grids, about, world units
void RequirePossible(const TriangleMesh& mesh, int subdivisions, double spacing)
{
  const double triangles = std::ldexp(static_cast<double>(mesh.NumberOfTriangles()), 2 * subdivisions);
  if (triangles > MostTriangles)
  {
    Refuse(std::to_string(subdivisions) + " subdivisions of " + std::to_string(mesh.NumberOfTriangles()) +
      " triangles make " + FormatNumber(triangles) + "; at most " + FormatNumber(MostTriangles) +
      " are possible. Fewer subdivisions, a larger scale or a coarser target are needed.");
  }
  RequirePatches(FaceAreas(mesh).sum() / (spacing * spacing), Coverage.back());
}

/// The work of a synthesis.
class Synthesizer
{
public:
  Synthesizer(const GeometricTextureExample& example, const TriangleMesh& mesh, const ExampleSynthesisRequest& request)
    : Request(request)
    , Levels(mesh)
  {
    const double edge = this->Levels.EdgeLength(0);
    double asked = request.Scale * example.MeanEdgeLength();
    if (request.Second)
    {
      asked = std::min(asked, request.Scale * request.Second->MeanEdgeLength());
    }
    int subdivisions = request.Subdivisions;
    if (subdivisions < 0)
    {
      const double halvings = asked > 0.0 ? std::log2(edge / (LongestEdge * asked)) : AutomaticSubdivisions;
      subdivisions = static_cast<int>(std::clamp(std::ceil(halvings), 0.0, static_cast<double>(MostSubdivisions)));
    }
    RequirePossible(mesh, subdivisions, asked > 0.0 ? asked : std::ldexp(edge, -subdivisions));
    for (int level = 0; level < subdivisions; ++level)
    {
      this->Levels.Subdivide();
    }
    for (const GeometricTextureExample* each : { &example, request.Second })
    {
      if (each)
      {
        const double spacing = asked > 0.0 ? request.Scale * each->MeanEdgeLength()
                                           : this->Levels.EdgeLength(subdivisions);
        this->Sources.push_back({ each, spacing });
      }
    }
  }

  ExampleSynthesis Run(const Progress& progress)
  {
    const Source& first = this->Sources.front();
    const int count = static_cast<int>(first.Example->Scales().size());
    ExampleSynthesis result;
    for (int s = count - 1, step = 0; s >= 0; --s, ++step)
    {
      // Each scale has up to four times the patches of the one before, and fewer iterations.
      const double begin = step == 0 ? 0.0 : 1.0 - std::ldexp(1.0, -step),
                   end = 1.0 - (s > 0 ? std::ldexp(1.0, -step - 1) : 0.0);
      result.Mismatch = this->RunScale(static_cast<std::size_t>(s), step, SubProgress(progress, begin, end));
    }
    result.Scale = first.Spacing / first.Example->MeanEdgeLength();
    result.Level.Level = this->Levels.Last();
    result.Level.Mesh = this->Levels.Mesh(this->Levels.Last());
    result.Level.Base = result.Level.Mesh.Points;
    result.Parents = this->Levels.Parents();
    this->Displacement = this->Levels.Prolong(this->Displacement, this->Present, this->Levels.Last());
    if (!this->Displacement.allFinite())
    {
      Refuse("the displacement is not finite; the scale does not fit the mesh.");
    }
    result.Level.Displacement = this->Displacement.cast<double>();
    result.Level.Mesh.Points += result.Level.Displacement;
    return result;
  }

private:
  /// An example and the spacing of its finest grids on the target, world units.
  struct Source
  {
    const GeometricTextureExample* Example;
    double Spacing;

    double SpacingOf(std::size_t scale) const { return this->Spacing * this->Example->Scales()[scale].Spacing; }
  };
  /// Patches of the target that are to look like those of an example.
  struct SourcePatches
  {
    const Source* From;
    std::unique_ptr<TexturePatches> Patches;
  };

  /// Returns the coarsest level whose edges are short enough for patches of a spacing; else the finest.
  int LevelFor(double spacing) const
  {
    int level = this->Present;
    while (level < this->Levels.Last() && this->Levels.EdgeLength(level) > LongestEdge * spacing)
    {
      ++level;
    }
    return level;
  }

  NormalKey Key(int step, std::uint32_t component) const
  {
    return { this->Request.Seed, static_cast<std::uint32_t>(step), component, this->Request.Stream };
  }

  double RunScale(std::size_t scale, int step, const Progress& progress)
  {
    double finest = this->Sources.front().SpacingOf(scale), coarsest = finest;
    for (const Source& source : this->Sources)
    {
      finest = std::min(finest, source.SpacingOf(scale));
      coarsest = std::max(coarsest, source.SpacingOf(scale));
    }
    const int level = this->LevelFor(finest);
    const PatchSurface surface(this->Levels.Mesh(level));
    if (this->Sources.size() > 1)
    {
      this->Shares = this->Levels.Prolong(this->Request.Blend, 0, level);
      this->Thresholds = step == 0 ? this->DrawThresholds(surface, coarsest, level)
                                   : this->Levels.Prolong(this->Thresholds, this->Present, level);
    }
    this->Displacement = step == 0 ? this->Initial(surface, scale)
                                   : this->Levels.Prolong(this->Displacement, this->Present, level);
    this->Present = level;
    const std::vector<SourcePatches> sets = this->DrawPatches(surface, scale, step, SubProgress(progress, 0.0, 0.1));
    const auto place = static_cast<std::size_t>(std::min(step, 2));
    const double middle = DistributionIterations[place] > 0 ? 0.5 : 0.1;
    std::vector<PatchShare> shares;
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
      const ExamplePatches& patches = sets[k].From->Example->Scales()[scale];
      const double width = (middle - 0.1) / static_cast<double>(sets.size()),
                   begin = 0.1 + static_cast<double>(k) * width;
      MatchDistribution(*sets[k].Patches, patches, this->Key(step, 0), sets[k].From->SpacingOf(scale),
        DistributionIterations[place], this->Displacement, SubProgress(progress, begin, begin + width));
      shares.push_back({ *sets[k].Patches, patches });
    }
    return MatchNearest(
      surface, shares, NearestIterations[place], this->Displacement, SubProgress(progress, middle, 1.0));
  }

  /// Draws the thresholds of a blend: islands as wide as a feature where sizes are what they are in the mean.
  Eigen::VectorXf DrawThresholds(const PatchSurface& surface, double spacing, int level) const
  {
    const Eigen::VectorXf sizes = this->Levels.Prolong(this->Request.Sizes, 0, level);
    double size = 1.0;
    if (sizes.size() > 0)
    {
      const Eigen::VectorXd mass = LumpedMass(surface.Mesh, surface.Topology);
      size = mass.dot(sizes.cast<double>()) / mass.sum();
    }
    return BlendThresholds(surface, ThresholdLength * spacing * size, this->Key(0, ThresholdNumbers));
  }

  /// Draws the patches of each example that has some; all of the last one where chance has given neither any.
  std::vector<SourcePatches> DrawPatches(
    const PatchSurface& surface, std::size_t scale, int step, const Progress& progress) const
  {
    const PointMatrix directions = this->Levels.Prolong(this->Request.Directions, 0, this->Present);
    std::vector<SourcePatches> sets;
    for (std::size_t k = 0; k < this->Sources.size(); ++k)
    {
      PatchDistribution distribution;
      distribution.Spacing = this->Sources[k].SpacingOf(scale);
      distribution.Sizes = this->Levels.Prolong(this->Request.Sizes, 0, this->Present);
      distribution.Directions = directions.rows() > 0 ? &directions : nullptr;
      distribution.Key = this->Key(step, CenterNumbers);
      const std::int64_t count = RequirePatches(
        AreaInSquares(surface, distribution), Coverage[static_cast<std::size_t>(std::min(step, 2))]);
      const std::vector<PatchCenter> all = DrawPatchCenters(surface, distribution, count);
      std::vector<PatchCenter> centers = all;
      if (this->Sources.size() > 1)
      {
        centers = CentersOfShare(surface, all, this->Thresholds, this->Shares, k > 0);
      }
      const bool isLast = k + 1 == this->Sources.size();
      if (centers.empty() && isLast && sets.empty())
      {
        centers = all;
      }
      if (!centers.empty())
      {
        sets.push_back({ &this->Sources[k], std::make_unique<TexturePatches>(surface, centers, progress) });
      }
    }
    return sets;
  }

  /// Returns normal numbers with the mean and the deviation of the heights of the examples, along the normals.
  SinglePoints Initial(const PatchSurface& surface, std::size_t scale) const
  {
    const Index points = surface.Mesh.NumberOfPoints();
    Eigen::VectorXd numbers(points), heights = Eigen::VectorXd::Zero(points);
    FillNormals(this->Key(0, InitialNumbers), 0, points, numbers.data());
    for (std::size_t k = 0; k < this->Sources.size(); ++k)
    {
      const ExamplePatches& patches = this->Sources[k].Example->Scales()[scale];
      Eigen::ArrayXd share = Eigen::ArrayXd::Ones(points);
      if (this->Sources.size() > 1)
      {
        share = this->Shares.cast<double>().array();
        share = k > 0 ? share : 1.0 - share;
      }
      heights.array() += share * this->Sources[k].SpacingOf(scale) *
        (patches.MeanHeight + patches.HeightDeviation * numbers.array());
    }
    return (heights.asDiagonal() * surface.VertexNormals).cast<float>();
  }

  const ExampleSynthesisRequest& Request;
  TargetLevels Levels;
  std::vector<Source> Sources; ///< one or two
  int Present = 0;             ///< level of the displacement, the thresholds and the shares
  SinglePoints Displacement;
  Eigen::VectorXf Thresholds; ///< [V] of a blend
  Eigen::VectorXf Shares;     ///< [V] of the second example
};
} // namespace

ExampleSynthesis SynthesizeFromExample(const GeometricTextureExample& example, const TriangleMesh& mesh,
  const ExampleSynthesisRequest& request, const Progress& progress)
{
  RequireValidMesh(mesh, GeometricTextureExample::Requirements());
  if (mesh.NumberOfTriangles() == 0)
  {
    Refuse("the mesh has no triangle.");
  }
  CheckRequest(example, mesh, request);
  const SingleThreadedBlas limit;
  return Synthesizer(example, mesh, request).Run(progress);
}

} // namespace surfsynth
