// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTextureSynthesizerInternals.h"

#include "GeometricTextureSurface.h"
#include "LevelList.h"
#include "Reporting.h"
#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/InstalledModels.h"

#include <vtkDataObject.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <string>
#include <utility>

using surfsynth::GeometricTextureRequest;
using surfsynth::GeometricTextureResult;
using surfsynth::GeometricTextureSettings;
using surfsynth::Surface;

namespace
{
/// Steps of an animation from seed to seed.
constexpr int SeedSteps = 20;
} // namespace

void vtkGeometricTextureSynthesizer::Internals::Begin(std::optional<double> time, bool fromTemplate)
{
  this->Time = time;
  this->FromTemplate = fromTemplate;
  this->Model.reset();
  this->Printability.Begin();
  this->CheckNames();
  if (std::isnan(this->Self->Strength))
  {
    throw surfsynth::InvalidInput("Strength is not a number; a number from 0 to 1e6 is needed.");
  }
  if (this->Self->Printable)
  {
    surfsynth::RequirePrintability();
  }
  this->WithoutNoise = surfsynth::ReadLevelList(this->Self->LevelsWithoutNoise, "LevelsWithoutNoise");
  this->Model = this->ReadModel();
  this->SecondModel = this->ReadSecondModel();
  static_cast<void>(this->Range(*this->Model)); // throws once, and not for each block
  this->Targets.Begin();
  this->Textures.Begin();
}

std::shared_ptr<const surfsynth::GeometricTextureModel> vtkGeometricTextureSynthesizer::Internals::ReadModel()
{
  if (this->Self->ModelFileName.empty())
  {
    throw surfsynth::InvalidInput("ModelFileName is empty; the path of a geometric texture model is needed.");
  }
  return this->File.Get(surfsynth::ModelPath(this->Self->ModelFileName));
}

/// Returns the model that is mixed with the first one; null without.
std::shared_ptr<const surfsynth::GeometricTextureModel> vtkGeometricTextureSynthesizer::Internals::ReadSecondModel()
{
  if (this->FromTemplate || this->Self->SecondModelFileName.empty())
  {
    return nullptr;
  }
  if (this->Self->BlendArrayName.empty())
  {
    throw surfsynth::InvalidInput(
      "SecondModelFileName is set and BlendArrayName is empty; the name of a point array with "
      "the share of the second model, from 0 to 1, is needed.");
  }
  return this->SecondFile.Get(surfsynth::ModelPath(this->Self->SecondModelFileName));
}

void vtkGeometricTextureSynthesizer::Internals::WriteModelWithStatistics(const std::string& fileName, int samples)
{
  constexpr int MostSamples = 1000;
  if (fileName.empty())
  {
    throw surfsynth::InvalidInput("The name of the file to write is empty; a path is needed.");
  }
  if (samples < 1 || samples > MostSamples)
  {
    throw surfsynth::InvalidInput("Statistics of " + std::to_string(samples) + " samples are asked for; 1 to " +
      std::to_string(MostSamples) + " are possible.");
  }
  surfsynth::GeometricTextureModel model = *this->ReadModel();
  model.Statistics = surfsynth::MeasureStatistics(model, samples);
  surfsynth::WriteGeometricTexture(fileName, model);
}

void vtkGeometricTextureSynthesizer::Internals::End()
{
  this->Targets.DropUnused();
  this->Textures.DropUnused();
}

void vtkGeometricTextureSynthesizer::Internals::CheckNames() const
{
  const std::string& displacement = this->Self->DisplacementArrayName;
  const std::string& level = this->Self->LevelArrayName;
  if (displacement.empty() || level.empty())
  {
    throw surfsynth::InvalidInput(std::string(displacement.empty() ? "DisplacementArrayName" : "LevelArrayName") +
      " is empty; a name for the array is needed.");
  }
  if (displacement == level)
  {
    throw surfsynth::InvalidInput(
      "LevelArrayName is \"" + level + "\", the name of another array of the output; different names are needed.");
  }
}

vtkSmartPointer<vtkInformation> vtkGeometricTextureSynthesizer::Internals::TemplateInformation(
  vtkInformation* requested) const
{
  if (this->Model->Template.NumberOfTriangles() == 0)
  {
    throw surfsynth::InvalidInput("There is no input, and the model has no template; a surface for the texture, "
                                  "or a model with a template, is needed.");
  }
  vtkNew<vtkPolyData> target;
  if (requested->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) <= 0)
  {
    surfsynth::SetGeometry(target, this->Model->Template, true);
  }
  auto information = vtkSmartPointer<vtkInformation>::New();
  information->Set(vtkDataObject::DATA_OBJECT(), target);
  return information;
}

void vtkGeometricTextureSynthesizer::Internals::Synthesize(
  const surfsynth::Block& block, const surfsynth::Progress& progress)
{
  vtkSmartPointer<vtkPolyData> input = vtkPolyData::SafeDownCast(block.Input);
  if (this->Remeshes())
  {
    input = this->Remesh(input, block, surfsynth::SubProgress(progress, 0.0, 0.3));
  }
  Surface surface = surfsynth::ConvertSurface(input);
  surface.FlatIndex = block.FlatIndex;
  surface.Where = block.Where;
  const GeometricTextureSettings settings = this->Settings(input, surface);
  const surfsynth::GeometricTextureAdjustment adjustment = this->Adjustment(input, surface);
  const double synthesized = adjustment.Printable ? 0.5 : 0.9;
  GeometricTextureResult* texture = this->Find(surface, settings);
  if (!texture)
  {
    this->Check(surface);
    texture = &this->Compute(
      surface, settings, surfsynth::SubProgress(progress, this->Remeshes() ? 0.3 : 0.0, synthesized));
  }
  texture->Adjust(surface.Mesh, adjustment, surfsynth::SubProgress(progress, synthesized, 0.9));
  const int present = this->StepAtTime(texture->NumberOfSteps());
  if (const auto printability = texture->Printability(present))
  {
    this->Printability.Add(this->Self, block.Where, *printability);
  }
  if (!this->Self->OutputLevels)
  {
    this->Fill(input, surface, *texture, present, vtkPolyData::SafeDownCast(block.Output));
    return;
  }
  for (int step = 0; step <= present; ++step)
  {
    this->Fill(
      input, surface, *texture, step, vtkPolyData::SafeDownCast(block.Outputs[static_cast<std::size_t>(step)]));
  }
}

void vtkGeometricTextureSynthesizer::Internals::Check(Surface& surface) const
{
  try
  {
    surfsynth::CheckSurface(surface, surfsynth::GeometricTextureSampler::Requirements());
  }
  catch (const surfsynth::InvalidInput& error)
  {
    if (!this->Remeshes())
    {
      throw;
    }
    throw surfsynth::InvalidInput(std::string("Once remeshed: ") + error.what());
  }
}

surfsynth::OutputSeries vtkGeometricTextureSynthesizer::Internals::Series() const
{
  if (!this->Self->OutputLevels)
  {
    return {};
  }
  const surfsynth::GeometricTextureLevelRange range = this->Range(*this->Model);
  return { range.First, range.Count(), "Level" };
}

std::vector<double> vtkGeometricTextureSynthesizer::Internals::AnimationTimes()
{
  std::vector<double> times;
  if (this->Self->Animation == SEEDS)
  {
    for (int k = 0; k <= SeedSteps; ++k)
    {
      times.push_back(static_cast<double>(k) / SeedSteps);
    }
    return times;
  }
  try
  {
    const auto model = this->File.Get(surfsynth::ModelPath(this->Self->ModelFileName));
    for (int k = 0; k <= this->Range(*model).Count(); ++k)
    {
      times.push_back(k);
    }
  }
  catch (const std::exception&)
  {
    times.clear();
  }
  return times;
}

/// Returns the levels of the synthesis.
surfsynth::GeometricTextureLevelRange vtkGeometricTextureSynthesizer::Internals::Range(
  const surfsynth::GeometricTextureModel& model) const
{
  return surfsynth::LevelsToSynthesize(this->Request(0, model), model.Options.Levels);
}

GeometricTextureRequest vtkGeometricTextureSynthesizer::Internals::Request(
  unsigned int flatIndex, const surfsynth::GeometricTextureModel& model) const
{
  vtkGeometricTextureSynthesizer* self = this->Self;
  GeometricTextureRequest request;
  request.EndLevel = self->EndLevel;
  const int last = surfsynth::LevelsToSynthesize(request, model.Options.Levels).Last;
  const int automatic = std::min({ 1, self->GetNumberOfInputConnections(0), last });
  request.StartLevel = self->StartLevel >= 0 ? self->StartLevel : automatic;
  request.Seed = static_cast<std::uint64_t>(self->Seed);
  request.SecondSeed = static_cast<std::uint64_t>(self->SecondSeed);
  request.Interpolation = self->Animation == SEEDS && this->Time ? std::clamp(*this->Time, 0.0, 1.0)
                                                                 : self->Interpolation;
  request.Stream = flatIndex;
  request.NoiseAmplitude = self->NoiseAmplitude;
  request.Restarts = self->NumberOfRestarts;
  request.Statistics = self->NormStatistics == TARGET ? surfsynth::NormStatistics::Target
                                                      : surfsynth::NormStatistics::Reference;
  return request;
}

/// Returns the ratio of the edges of the prepared target to those of @p target.
double vtkGeometricTextureSynthesizer::Internals::TextureScale(const surfsynth::TriangleMesh& target) const
{
  if (std::isnan(this->Self->TextureScale))
  {
    throw surfsynth::InvalidInput("TextureScale is not a number; a number from 0.001 to 1000, or 0, is needed.");
  }
  return this->Self->TextureScale > 0.0 ? std::max(this->Self->TextureScale, 0.001)
                                        : surfsynth::AutomaticTextureScale(target);
}

/// Returns true for a target to remesh; the template stays as in the training.
bool vtkGeometricTextureSynthesizer::Internals::Remeshes() const
{
  return this->Self->TargetPreparation == REMESH && !this->FromTemplate;
}

/// Remeshes the target with even triangles and the arrays of @p input.
vtkSmartPointer<vtkPolyData> vtkGeometricTextureSynthesizer::Internals::Remesh(
  vtkPolyData* input, const surfsynth::Block& block, const surfsynth::Progress& progress)
{
  Surface surface = surfsynth::ConvertSurface(input);
  surface.FlatIndex = block.FlatIndex;
  // The check comes before any work, and uses the ids of the caller's points.
  const surfsynth::UsedPoints points(surface.Mesh);
  surfsynth::ReadGeometricTextureArray(input, points, this->Self->MaskArrayName, surfsynth::MaskArray);
  surfsynth::ReadGeometricTextureArray(input, points, this->Self->StrengthArrayName, surfsynth::StrengthArray);
  const Eigen::VectorXf sizes = surfsynth::ReadGeometricTextureArray(
    input, points, this->Self->SizeArrayName, surfsynth::SizeArray);
  if (this->SecondModel)
  {
    surfsynth::ReadGeometricTextureArray(input, points, this->Self->BlendArrayName, surfsynth::BlendArray);
  }
  const double scale = this->TextureScale(surface.Mesh);
  std::unique_ptr<surfsynth::RemeshedTarget>* target = this->Targets.Find(surface);
  if (!target || !(*target)->Is(input, surface, scale, sizes))
  {
    this->Targets.Drop(surface);
    auto made = std::make_unique<surfsynth::RemeshedTarget>(
      input, surface, scale, sizes, this->Range(*this->Model).Count(), progress);
    ++this->NumberOfRemeshings;
    target = &this->Targets.Insert(surface, std::move(made));
  }
  auto remeshed = vtkSmartPointer<vtkPolyData>::New();
  (*target)->Fill(input, surface, remeshed);
  return remeshed;
}

GeometricTextureSettings vtkGeometricTextureSynthesizer::Internals::Settings(
  vtkPolyData* input, const Surface& surface) const
{
  const vtkGeometricTextureSynthesizer* self = this->Self;
  GeometricTextureSettings settings;
  settings.Request = this->Request(surface.FlatIndex, *this->Model);
  const surfsynth::GeometricTextureLevelRange range = this->Range(*this->Model);
  for (int level = range.First; level <= range.Last; ++level)
  {
    settings.Request.LevelsWithoutNoise.push_back(
      std::count(this->WithoutNoise.begin(), this->WithoutNoise.end(), level) > 0);
  }
  settings.AllLevels = self->OutputLevels || self->Animation == LEVELS;
  if (this->FromTemplate)
  {
    settings.RandomFrom = std::min(self->RandomFromLevel, static_cast<int>(this->Model->Options.Levels));
    return settings;
  }
  if (self->TargetPreparation == SUBDIVIDE)
  {
    settings.Subdivisions = std::max(0, static_cast<int>(std::lround(-std::log2(this->TextureScale(surface.Mesh)))));
  }
  settings.Mask = this->ReadArray(input, surface, self->MaskArrayName, surfsynth::MaskArray);
  settings.MaskFalloff = self->MaskFalloff;
  if (this->Remeshes())
  {
    settings.Sizes = this->ReadArray(input, surface, self->SizeArrayName, surfsynth::SizeArray);
  }
  if (this->SecondModel)
  {
    settings.Request.SecondModel = this->SecondModel;
    settings.Blend = this->ReadArray(input, surface, self->BlendArrayName, surfsynth::BlendArray);
  }
  return settings;
}

/// Finds the texture of this block from an earlier update with the same mesh and settings; null otherwise.
GeometricTextureResult* vtkGeometricTextureSynthesizer::Internals::Find(
  const Surface& surface, const GeometricTextureSettings& settings)
{
  std::unique_ptr<GeometricTextureResult>* found = this->Textures.Find(surface);
  return found && (*found)->Is(*this->Model, settings) ? found->get() : nullptr;
}

GeometricTextureResult& vtkGeometricTextureSynthesizer::Internals::Compute(
  const Surface& surface, const GeometricTextureSettings& settings, const surfsynth::Progress& progress)
{
  this->Textures.Drop(surface);
  auto texture = std::make_unique<GeometricTextureResult>(this->Model, surface.Mesh, settings, progress);
  ++this->NumberOfSyntheses;
  return *this->Textures.Insert(surface, std::move(texture));
}

/// Reads a point array of the prepared target.
Eigen::VectorXf vtkGeometricTextureSynthesizer::Internals::ReadArray(vtkPolyData* input, const Surface& surface,
  const std::string& name, const surfsynth::GeometricTextureArray& kind) const
{
  const surfsynth::UsedPoints points(surface.Mesh);
  return this->Remeshes() ? surfsynth::ReadInterpolatedArray(input, points, name, kind)
                          : surfsynth::ReadGeometricTextureArray(input, points, name, kind);
}

surfsynth::GeometricTextureAdjustment vtkGeometricTextureSynthesizer::Internals::Adjustment(
  vtkPolyData* input, const Surface& surface) const
{
  surfsynth::GeometricTextureAdjustment adjustment;
  adjustment.Strength = this->Self->Strength;
  if (!this->FromTemplate)
  {
    adjustment.StrengthOfPoint = this->ReadArray(
      input, surface, this->Self->StrengthArrayName, surfsynth::StrengthArray);
  }
  adjustment.Printable = this->Self->Printable;
  return adjustment;
}

/// Returns the number of finished levels: all, except in an animation of levels.
double vtkGeometricTextureSynthesizer::Internals::LevelsAtTime() const
{
  const bool animated = this->Self->Animation == LEVELS && this->Time;
  return animated ? std::max(0.0, *this->Time) : std::numeric_limits<double>::infinity();
}

/// Returns the current step, or the last one.
int vtkGeometricTextureSynthesizer::Internals::StepAtTime(int steps) const
{
  return static_cast<int>(std::clamp(std::ceil(this->LevelsAtTime()) - 1.0, 0.0, steps - 1.0));
}

void vtkGeometricTextureSynthesizer::Internals::Fill(vtkPolyData* input, const Surface& surface,
  const GeometricTextureResult& texture, int step, vtkPolyData* output) const
{
  surfsynth::FillGeometricTextureSurface(input, surface, texture, step,
    std::clamp(this->LevelsAtTime() - step, 0.0, 1.0),
    { this->Self->DisplacementArrayName, this->Self->LevelArrayName }, output);
}
