// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/ExampleSynthesis.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeDistances.h"
#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/PatchCenters.h"
#include "Inference/GeometricTexture/PatchMatching.h"
#include "Inference/GeometricTexture/TexturePatches.h"

#include <algorithm>
#include <array>
#include <cmath>
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
constexpr std::array<int, 3> DistributionIterations = { 400, 100, 0 }, NearestIterations = { 6, 6, 3 };
/// Most patches of a scale, 4 GB of samples, and triangles of the finest mesh, about 10 GB with tables.
constexpr double MostPatches = 1.2e6, MostTriangles = 3e7;
constexpr std::uint32_t InitialNumbers = 4, CenterNumbers = 5; ///< components of the key, see PatchMatching.cxx

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
    : Example(example)
    , Request(request)
    , Levels(mesh)
  {
    const double edge = this->Levels.EdgeLength(0), asked = request.Scale * example.MeanEdgeLength();
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
    this->Spacing = asked > 0.0 ? asked : this->Levels.EdgeLength(subdivisions);
  }

  ExampleSynthesis Run(const Progress& progress)
  {
    const auto& scales = this->Example.Scales();
    const int count = static_cast<int>(scales.size());
    ExampleSynthesis result;
    for (int s = count - 1, step = 0; s >= 0; --s, ++step)
    {
      // Each scale has up to four times the patches of the one before, and fewer iterations.
      const double begin = step == 0 ? 0.0 : 1.0 - std::ldexp(1.0, -step),
                   end = 1.0 - (s > 0 ? std::ldexp(1.0, -step - 1) : 0.0);
      result.Mismatch = this->RunScale(scales[static_cast<std::size_t>(s)], step, SubProgress(progress, begin, end));
    }
    result.Scale = this->Spacing / this->Example.MeanEdgeLength();
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

  double RunScale(const ExamplePatches& scale, int step, const Progress& progress)
  {
    const double spacing = this->Spacing * scale.Spacing;
    const int level = this->LevelFor(spacing);
    const PatchSurface surface(this->Levels.Mesh(level));
    const PointMatrix directions = this->Levels.Prolong(this->Request.Directions, 0, level);
    PatchDistribution distribution;
    distribution.Spacing = spacing;
    distribution.Sizes = this->Levels.Prolong(this->Request.Sizes, 0, level);
    distribution.Directions = directions.rows() > 0 ? &directions : nullptr;
    distribution.Key = this->Key(step, CenterNumbers);
    const auto place = static_cast<std::size_t>(std::min(step, 2));
    const std::int64_t count = RequirePatches(AreaInSquares(surface, distribution), Coverage[place]);
    const TexturePatches patches(surface, DrawPatchCenters(surface, distribution, count), progress);
    this->Displacement = step == 0 ? this->Initial(surface, scale, spacing)
                                   : this->Levels.Prolong(this->Displacement, this->Present, level);
    this->Present = level;
    MatchDistribution(patches, scale, this->Key(step, 0), spacing, DistributionIterations[place], this->Displacement,
      SubProgress(progress, 0.1, 0.5));
    return MatchNearest(surface, patches, scale, NearestIterations[place], this->Displacement,
      SubProgress(progress, DistributionIterations[place] > 0 ? 0.5 : 0.1, 1.0));
  }

  /// Returns normal numbers with the mean and the deviation of the heights of the example, along the normals.
  SinglePoints Initial(const PatchSurface& surface, const ExamplePatches& scale, double spacing) const
  {
    const Index points = surface.Mesh.NumberOfPoints();
    Eigen::VectorXd heights(points);
    FillNormals(this->Key(0, InitialNumbers), 0, points, heights.data());
    heights = spacing * (scale.MeanHeight + scale.HeightDeviation * heights.array());
    return (heights.asDiagonal() * surface.VertexNormals).cast<float>();
  }

  const GeometricTextureExample& Example;
  const ExampleSynthesisRequest& Request;
  TargetLevels Levels;
  double Spacing = 0.0;
  int Present = 0; ///< level of the displacement
  SinglePoints Displacement;
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
