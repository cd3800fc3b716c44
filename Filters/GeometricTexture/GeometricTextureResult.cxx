// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTextureResult.h"

#include "GeometricTextureMask.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MidpointSubdivision.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Throws before memory is spent on all levels but the last.
void RequireCountableTriangles(const TriangleMesh& mesh, int subdivisions, int levels)
{
  const double finest = mesh.NumberOfTriangles() * std::pow(4.0, subdivisions + levels - 1);
  if (finest > std::numeric_limits<Index>::max())
  {
    throw InvalidInput("The surface has " + std::to_string(mesh.NumberOfTriangles()) + " triangles, which " +
      std::to_string(subdivisions) + " subdivisions and " + std::to_string(levels) + " levels make " +
      FormatNumber(finest) +
      "; at most 2147483647 are possible. Fewer levels, a larger TextureScale or a coarser surface are needed.");
  }
}

/// Cuts triangles into four and interpolates values at the points, where there are any.
void Subdivide(TriangleMesh& mesh, std::initializer_list<Eigen::VectorXf*> values)
{
  SubdividedMesh fine = SubdivideAtMidpoints(mesh);
  for (Eigen::VectorXf* value : values)
  {
    *value = InterpolateAtMidpoints(std::move(*value), fine.Parents);
  }
  mesh = std::move(fine.Mesh);
}

bool SameSynthesis(const GeometricTextureRequest& a, const GeometricTextureRequest& b)
{
  return a.StartLevel == b.StartLevel && a.EndLevel == b.EndLevel && a.Seed == b.Seed && a.SecondSeed == b.SecondSeed &&
    a.Interpolation == b.Interpolation && a.Stream == b.Stream && a.NoiseAmplitude == b.NoiseAmplitude &&
    a.Restarts == b.Restarts && a.Statistics == b.Statistics && a.SecondModel == b.SecondModel &&
    a.LevelsWithoutNoise == b.LevelsWithoutNoise;
}
} // namespace

GeometricTextureResult::GeometricTextureResult(std::shared_ptr<const GeometricTextureModel> model,
  const TriangleMesh& mesh, const GeometricTextureSettings& settings, const Progress& progress)
  : Model(std::move(model))
  , Settings(settings)
{
  const GeometricTextureLevelRange range = LevelsToSynthesize(settings.Request, this->Model->Options.Levels);
  this->FirstLevel = range.First;
  RequireCountableTriangles(mesh, settings.Subdivisions, range.Count());
  const auto keep = [this](const GeometricTextureLevel& level) {
    this->PointsOfStep.push_back(level.Mesh.NumberOfPoints());
    if (!this->Settings.AllLevels)
    {
      this->Levels.clear();
    }
    this->Levels.push_back(level);
  };
  const GeometricTextureSampler sampler(this->Model);
  if (settings.RandomFrom)
  {
    sampler.Generate(*settings.RandomFrom, settings.Request, keep, progress);
    return;
  }
  TriangleMesh target = UsedPoints(mesh).Compact(mesh);
  GeometricTextureRequest request = settings.Request;
  request.Mask = settings.Mask;
  request.Blend = settings.Blend;
  request.Sizes = settings.Sizes;
  SoftenMask(target, settings.MaskFalloff, request.Mask);
  for (int k = 0; k < settings.Subdivisions; ++k)
  {
    Subdivide(target, { &request.Mask, &request.Blend, &request.Sizes });
  }
  sampler.Synthesize(target, request, keep, progress);
}

bool GeometricTextureResult::Is(const GeometricTextureModel& model, const GeometricTextureSettings& settings) const
{
  const GeometricTextureSettings& mine = this->Settings;
  return &model == this->Model.get() && SameSynthesis(mine.Request, settings.Request) &&
    mine.Subdivisions == settings.Subdivisions && SameValues(mine.Mask, settings.Mask) &&
    SameValues(mine.Blend, settings.Blend) && SameValues(mine.Sizes, settings.Sizes) &&
    mine.MaskFalloff == settings.MaskFalloff && mine.RandomFrom == settings.RandomFrom &&
    (mine.AllLevels || !settings.AllLevels);
}

void GeometricTextureResult::Adjust(
  const TriangleMesh& mesh, const GeometricTextureAdjustment& adjustment, const Progress& progress)
{
  if (this->Adjustment == adjustment)
  {
    return;
  }
  this->Adjustment = {};
  this->AdjustedLevels.clear();
  this->Printabilities.clear();
  if (adjustment.IsNone())
  {
    return;
  }
  this->AdjustedLevels = this->Levels;
  try
  {
    this->Scale(mesh, adjustment);
    if (adjustment.Printable)
    {
      this->Separate(progress);
    }
  }
  catch (...)
  {
    this->AdjustedLevels.clear();
    this->Printabilities.clear();
    throw;
  }
  this->ComputeDisplacementsOfLevels();
  this->Adjustment = adjustment;
}

/// Multiplies the displacements by the strength.
void GeometricTextureResult::Scale(const TriangleMesh& mesh, const GeometricTextureAdjustment& adjustment)
{
  if (!adjustment.HasStrength())
  {
    return;
  }
  Eigen::VectorXf strength = adjustment.StrengthOfPoint;
  TriangleMesh target = strength.size() > 0 ? UsedPoints(mesh).Compact(mesh) : TriangleMesh();
  for (GeometricTextureLevel& level : this->AdjustedLevels)
  {
    while (strength.size() > 0 && target.NumberOfPoints() < level.Mesh.NumberOfPoints())
    {
      Subdivide(target, { &strength });
    }
    ScaleDisplacement(level, adjustment.Strength, strength);
  }
}

/// Makes each level printable.
void GeometricTextureResult::Separate(const Progress& progress)
{
  // Work is proportional to triangles, of which each level has four times as many.
  const auto done = [&](std::size_t k) {
    return (std::pow(4.0, k) - 1.0) / (std::pow(4.0, this->AdjustedLevels.size()) - 1.0);
  };
  for (std::size_t k = 0; k < this->AdjustedLevels.size(); ++k)
  {
    this->Printabilities.push_back(MakePrintable(this->AdjustedLevels[k], SubProgress(progress, done(k), done(k + 1))));
  }
}

/// Computes the way of the points at each adjusted level, from their places on the level before.
void GeometricTextureResult::ComputeDisplacementsOfLevels()
{
  for (std::size_t k = 0; k < this->AdjustedLevels.size(); ++k)
  {
    GeometricTextureLevel& level = this->AdjustedLevels[k];
    level.Displacement = level.Mesh.Points -
      (k == 0 ? level.Base : SubdivideAtMidpoints(this->AdjustedLevels[k - 1].Mesh).Mesh.Points);
  }
}

std::size_t GeometricTextureResult::PlaceOf(int step) const
{
  const int missing = this->NumberOfSteps() - static_cast<int>(this->Levels.size());
  return static_cast<std::size_t>(step - missing);
}

const GeometricTextureLevel& GeometricTextureResult::Level(int step) const
{
  return (this->AdjustedLevels.empty() ? this->Levels : this->AdjustedLevels).at(this->PlaceOf(step));
}

std::optional<GeometricTexturePrintability> GeometricTextureResult::Printability(int step) const
{
  if (this->Printabilities.empty())
  {
    return std::nullopt;
  }
  return this->Printabilities.at(this->PlaceOf(step));
}

int GeometricTextureResult::LevelOfPoint(Index point) const
{
  const auto step = std::upper_bound(this->PointsOfStep.begin(), this->PointsOfStep.end(), point);
  return this->FirstLevel + static_cast<int>(step - this->PointsOfStep.begin());
}

} // namespace surfsynth
