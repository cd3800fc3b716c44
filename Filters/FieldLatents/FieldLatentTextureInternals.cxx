// SPDX-License-Identifier: BSD-3-Clause
#include "FieldLatentTextureInternals.h"

#include "RegularRings.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "SurfaceArrays.h"
#include "SurfaceCoordinates.h"
#include "TextureDecoding.h"
#include "TextureEncoding.h"
#include "TextureImages.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <limits>

using surfsynth::Surface;

namespace
{
/// Fractions of the work on a surface after its atlas, after the triangulation and before the first sample, and of the
/// work on a sample after its latents.
constexpr double AfterAtlas = 0.05;
constexpr double AfterTriangulation = 0.12;
constexpr double BeforeSamples = 0.2;
constexpr double AfterLatents = 0.85;
/// Features of a channel that the network holds at once, float32, for each vertex: see LatentDiffusionNetwork.
constexpr double FeaturesOfChannel = 16.0;
constexpr const char* RemedyOfRegularVertices =
  "Triangulation REMESH, or points that lie a hundredth of an edge or more off the grid, are needed.";
} // namespace

void vtkFieldLatentTextureFilter::Internals::Begin(vtkInformationVector** inputVector, double time)
{
  this->Time = time;
  this->RequireNames();
  this->ReadModels();
  this->RequireMemory(vtkDataObject::GetData(inputVector[0]));
  this->Image.reset();
  if (this->Self->GetNumberOfInputConnections(1) > 0 && !this->Self->MaskArrayName.empty())
  {
    auto* image = vtkImageData::SafeDownCast(vtkDataObject::GetData(inputVector[1]));
    if (!image)
    {
      throw surfsynth::InvalidInput("The texture image on port 1 is missing; a vtkImageData is needed.");
    }
    this->Image.emplace(image);
    this->Warn("", this->Image->Colors.Remarks);
  }
  this->Images.clear();
  this->Latents.clear();
  this->Blocks.Begin();
  this->MadeAtlases.Begin();
}

void vtkFieldLatentTextureFilter::Internals::End(vtkDataObject* input, vtkInformationVector* outputVector)
{
  surfsynth::FillPort(
    input, this->Series(), "vtkImageData", this->Images, vtkDataObject::GetData(outputVector, ImagePort));
  surfsynth::FillPort(
    input, this->Series(), "vtkPolyData", this->Latents, vtkDataObject::GetData(outputVector, LatentPort));
  this->Blocks.DropUnused();
  this->MadeAtlases.DropUnused();
}

void vtkFieldLatentTextureFilter::Internals::Release()
{
  this->Image.reset();
  this->Images.clear();
  this->Latents.clear();
}

surfsynth::OutputSeries vtkFieldLatentTextureFilter::Internals::Series() const
{
  return { this->Self->FirstSample, this->Self->NumberOfSamples, this->Self->NumberOfSamples == 1 ? "" : "Sample" };
}

void vtkFieldLatentTextureFilter::Internals::Synthesize(
  const surfsynth::Block& block, const surfsynth::Progress& progress)
{
  vtkNew<vtkPolyData> shown;
  Surface surface = this->Shown(block, shown, surfsynth::SubProgress(progress, 0.0, AfterAtlas));
  surfsynth::TextureCoordinates coordinates = surfsynth::ReadTextureCoordinates(shown, surface);
  surfsynth::RequireAtlas(coordinates, surface);
  this->RequireOtherName(shown);
  this->Warn(surface.Where, surfsynth::DescribeDegenerateCoordinates(coordinates, surface));
  surfsynth::PreparedTextures& prepared = this->Prepared(
    surface, surfsynth::SubProgress(progress, AfterAtlas, AfterTriangulation));
  this->NumberOfVertices = prepared.Triangulation->NumberOfVertices();
  this->Warn(surface.Where,
    surfsynth::DescribeRegularVertices(
      prepared.Triangulation->NumberOfRegularVertices(), this->NumberOfVertices, RemedyOfRegularVertices));
  // Errors of guidance are reported before long work.
  surfsynth::LatentGuide guide = this->Guide(shown, surface, *prepared.Triangulation, progress);
  this->PrepareAtlas(
    prepared, surface, std::move(coordinates), surfsynth::SubProgress(progress, AfterTriangulation, BeforeSamples));
  this->Warn(surface.Where, prepared.Atlas->Warning);
  if (!prepared.Samples || !prepared.Samples->IsOf(this->Model()))
  {
    prepared.Samples.reset();
    prepared.Samples = std::make_unique<surfsynth::LatentSamples>(this->Model(), *prepared.Triangulation);
  }
  surfsynth::LatentSampleRequest request = this->Request(block.FlatIndex);
  const int count = this->Self->NumberOfSamples;
  prepared.Samples->Keep(request, std::move(guide), this->Self->FirstSample, count);
  for (int k = 0; k < count; ++k)
  {
    const double share = (1.0 - BeforeSamples) / count;
    request.Sample = static_cast<std::uint32_t>(this->Self->FirstSample + k);
    this->AddSample(prepared, request, shown, { k, block.FlatIndex },
      vtkPolyData::SafeDownCast(block.Outputs[static_cast<std::size_t>(k)]),
      surfsynth::SubProgress(progress, BeforeSamples + k * share, BeforeSamples + (k + 1) * share));
  }
}

void vtkFieldLatentTextureFilter::Internals::RequireNames() const
{
  const vtkFieldLatentTextureFilter& self = *this->Self;
  if (self.ModelFileName.empty())
  {
    throw surfsynth::InvalidInput("ModelFileName is empty; the path of a diffusion model of field latents is needed.");
  }
  if (self.AutoencoderFileName.empty())
  {
    throw surfsynth::InvalidInput(
      "AutoencoderFileName is empty; the path of the autoencoder of the diffusion model's latents is needed.");
  }
  const std::pair<const std::string*, const char*> names[] = { { &self.LatentArrayName, "LatentArrayName" },
    { &self.TextureArrayName, "TextureArrayName" } };
  for (const auto& [name, property] : names)
  {
    if (name->empty())
    {
      throw surfsynth::InvalidInput(std::string(property) + " is empty; a name for the arrays is needed.");
    }
  }
}

void vtkFieldLatentTextureFilter::Internals::ReadModels()
{
  this->Models.Read(this->Self->ModelFileName, this->Self->AutoencoderFileName);
  this->RequireGuidance();
  if (this->Self->NumberOfSteps > this->Model()->Options.TimeSteps)
  {
    throw surfsynth::InvalidInput("NumberOfSteps is " + std::to_string(this->Self->NumberOfSteps) +
      ", and the model has " + std::to_string(this->Model()->Options.TimeSteps) +
      " time steps; at most as many are needed.");
  }
}

void vtkFieldLatentTextureFilter::Internals::RequireOtherName(vtkPolyData* shown) const
{
  const char* coordinates = shown->GetPointData()->GetTCoords()->GetName();
  if (coordinates && this->Self->TextureArrayName == coordinates)
  {
    throw surfsynth::InvalidInput("TextureArrayName is \"" + this->Self->TextureArrayName +
      "\", the name of the texture coordinates; another name is needed.");
  }
}

void vtkFieldLatentTextureFilter::Internals::RequireGuidance() const
{
  if (!this->Self->LabelArrayName.empty() && this->Model()->Options.NumberOfLabels == 0)
  {
    throw surfsynth::InvalidInput("LabelArrayName is \"" + this->Self->LabelArrayName +
      "\", and the model has no labels; a model that was trained with labels, or no name, is needed.");
  }
  if (!this->Self->DirectionArrayName.empty() && !this->Model()->Options.Directed)
  {
    throw surfsynth::InvalidInput("DirectionArrayName is \"" + this->Self->DirectionArrayName +
      "\", and the model is not directed; a model that was trained with directions, or no name, is needed.");
  }
}

std::int64_t vtkFieldLatentTextureFilter::Internals::PointsOf(double inputPoints) const
{
  if (this->Self->Triangulation == AS_IS)
  {
    return 0;
  }
  if (this->Self->NumberOfPoints > 0)
  {
    return this->Self->NumberOfPoints;
  }
  return this->Model()->TrainingPoints > 0 ? this->Model()->TrainingPoints : static_cast<std::int64_t>(inputPoints);
}

void vtkFieldLatentTextureFilter::Internals::RequireMemory(vtkDataObject* input) const
{
  const auto [blocks, points] = surfsynth::SizesOfBlocks(input);
  const surfsynth::LatentDiffusionOptions& options = this->Model()->Options;
  const double vertices = std::max(points > 0.0 ? static_cast<double>(this->PointsOf(points)) : 0.0,
    this->Self->Triangulation == AS_IS ? points : 0.0);
  const int* size = this->Self->Resolution;
  const double samples = this->Self->NumberOfSamples;
  const double states = this->Self->OutputTrajectory ? this->Self->NumberOfSteps + 1.0 : 1.0;
  const double images = blocks * size[0] * size[1] * (surfsynth::AtlasPlaces::BytesOfTexel + 3.0 * samples);
  const double latents = 4.0 * vertices *
    (FeaturesOfChannel * static_cast<double>(options.Channels + options.CoarseChannels) +
      blocks * samples * static_cast<double>(options.LatentDimension) * (2.0 * states + 3.0));
  const double limit = this->Self->MemoryLimit > 0 ? this->Self->MemoryLimit * 1048576.0
                                                   : static_cast<double>(surfsynth::DefaultMemoryLimit());
  if (limit > 0.0 && images + latents > limit)
  {
    throw surfsynth::InvalidInput("Images of " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
      " texels (Resolution) and latents of " + surfsynth::FormatNumber(vertices) + " vertices (NumberOfPoints) for " +
      std::to_string(this->Self->NumberOfSamples) + " sample(s) take about " +
      surfsynth::FormatNumber(std::ceil((images + latents) / 1048576.0)) + " MiB; at most " +
      surfsynth::FormatNumber(std::floor(limit / 1048576.0)) + " MiB are allowed (MemoryLimit).");
  }
}

Surface vtkFieldLatentTextureFilter::Internals::Shown(
  const surfsynth::Block& block, vtkPolyData* shown, const surfsynth::Progress& progress)
{
  auto* input = vtkPolyData::SafeDownCast(block.Input);
  const auto convert = [&block](vtkPolyData* polydata) {
    Surface surface = surfsynth::ConvertSurface(polydata);
    surface.FlatIndex = block.FlatIndex;
    surface.Where = block.Where;
    return surface;
  };
  Surface surface = convert(input);
  if (input->GetPointData()->GetTCoords())
  {
    shown->ShallowCopy(input);
    return surface;
  }
  if (this->Image)
  {
    throw surfsynth::InvalidInput(
      "The surface has no texture coordinates, which the texture image on port 1 needs. Its "
      "own ones, or colors of points in place of the image, are needed.");
  }
  const int* size = this->Self->Resolution;
  const auto isCurrent = [size](const surfsynth::MadeAtlas& held) { return held.Is(size); };
  const surfsynth::MadeAtlas* atlas = this->MadeAtlases.Find(surface, isCurrent);
  if (!atlas)
  {
    const surfsynth::WeldedSurface check(surface);
    this->MadeAtlases.Drop(surface);
    atlas = &this->MadeAtlases.Insert(surface, surfsynth::MadeAtlas(input, surface, size, progress));
  }
  atlas->Fill(input, surface, shown);
  return convert(shown);
}

surfsynth::PreparedTextures& vtkFieldLatentTextureFilter::Internals::Prepared(
  const Surface& surface, const surfsynth::Progress& progress)
{
  const std::int64_t points = this->PointsOf(surface.Mesh.NumberOfPoints());
  const auto isCurrent = [points](const surfsynth::PreparedTextures& held) { return held.NumberOfPoints == points; };
  if (surfsynth::PreparedTextures* found = this->Blocks.Find(surface, isCurrent))
  {
    return *found;
  }
  this->Blocks.Drop(surface);
  surfsynth::PreparedTextures prepared;
  prepared.NumberOfPoints = points;
  prepared.Triangulation = std::make_unique<surfsynth::LatentTriangulation>(surface, points, progress);
  ++this->NumberOfTriangulations;
  return this->Blocks.Insert(surface, std::move(prepared));
}

void vtkFieldLatentTextureFilter::Internals::PrepareAtlas(surfsynth::PreparedTextures& prepared, const Surface& surface,
  surfsynth::TextureCoordinates coordinates, const surfsynth::Progress& progress) const
{
  const surfsynth::AtlasRasterOptions options = surfsynth::RasterOptionsOf(
    this->Self->Resolution, this->Self->GutterWidth);
  const bool isSource = !prepared.Triangulation->IsRemeshed();
  if (!prepared.Atlas || !prepared.Atlas->Is(surface, isSource, coordinates, options))
  {
    prepared.Atlas.reset();
    prepared.Atlas.emplace(
      prepared.Triangulation->Welded(), surface, isSource, std::move(coordinates), options, progress);
  }
}

surfsynth::LatentGuide vtkFieldLatentTextureFilter::Internals::Guide(vtkPolyData* shown, const Surface& surface,
  const surfsynth::LatentTriangulation& triangulation, const surfsynth::Progress& progress) const
{
  const vtkFieldLatentTextureFilter& self = *this->Self;
  const surfsynth::GuidedSurface guided{ shown, &surface, &triangulation };
  surfsynth::LatentGuide guide;
  if (!self.LabelArrayName.empty())
  {
    guide.Conditions.Labels = surfsynth::ReadLabels(guided, self.LabelArrayName, this->Model()->Options.NumberOfLabels);
  }
  if (!self.DirectionArrayName.empty())
  {
    guide.Conditions.Directions = surfsynth::ReadDirections(guided, self.DirectionArrayName);
  }
  if (!self.MaskArrayName.empty())
  {
    guide.Kept.Mask = surfsynth::ReadMask(guided, self.MaskArrayName);
    guide.Kept.Latents = this->Encoded(guided, guide.Kept.Mask, progress);
  }
  return guide;
}

surfsynth::FieldLatentMatrix vtkFieldLatentTextureFilter::Internals::Encoded(
  const surfsynth::GuidedSurface& guided, const std::vector<float>& mask, const surfsynth::Progress& progress) const
{
  const Surface& surface = *guided.Converted;
  const surfsynth::WeldedSurface& welded = guided.Triangulation->Welded();
  const surfsynth::TextureColors colors = this->Colors(guided);
  std::vector<surfsynth::Index> kept;
  for (std::size_t v = 0; v < mask.size(); ++v)
  {
    if (mask[v] > 0.0F)
    {
      kept.push_back(static_cast<surfsynth::Index>(v));
    }
  }
  const surfsynth::ColorSource source = guided.Triangulation->IsRemeshed()
    ? surfsynth::ColorsOfNearest(welded.Mesh, surface.Mesh, colors)
    : surfsynth::ColorsOn(colors);
  return surfsynth::EncodeColors(this->Models.Encoder(), welded, source, kept,
    surfsynth::DiffusionSamplesPerRing(this->Models.Encoder()),
    surfsynth::SubProgress(progress, AfterTriangulation, AfterTriangulation))
    .Mean;
}

surfsynth::TextureColors vtkFieldLatentTextureFilter::Internals::Colors(const surfsynth::GuidedSurface& guided) const
{
  if (!this->Image)
  {
    surfsynth::TextureColors colors(guided.Arrays, *guided.Converted, this->Self->ColorArrayName);
    this->Warn(guided.Converted->Where, colors.Remarks);
    return colors;
  }
  surfsynth::TextureCoordinates coordinates = surfsynth::ReadTextureCoordinates(guided.Arrays, *guided.Converted);
  return { *this->Image, surfsynth::TextureWrap::Clamp, std::move(coordinates) };
}

surfsynth::LatentSampleRequest vtkFieldLatentTextureFilter::Internals::Request(unsigned int flatIndex) const
{
  surfsynth::LatentSampleRequest request;
  request.Seed = static_cast<std::uint64_t>(this->Self->Seed);
  request.Stream = flatIndex;
  request.Method = this->Self->Sampler == DDPM ? surfsynth::DiffusionMethod::Ddpm : surfsynth::DiffusionMethod::Ddim;
  request.NumberOfSteps = this->Self->NumberOfSteps;
  return request;
}

void vtkFieldLatentTextureFilter::Internals::AddSample(surfsynth::PreparedTextures& prepared,
  const surfsynth::LatentSampleRequest& request, vtkPolyData* shown, const std::pair<int, unsigned int>& place,
  vtkPolyData* output, const surfsynth::Progress& progress)
{
  if (!prepared.Samples->Holds(request.Sample, this->Self->OutputTrajectory))
  {
    prepared.Samples->Draw(request, this->Self->OutputTrajectory, surfsynth::SubProgress(progress, 0.0, AfterLatents));
    this->NumberOfEvaluations += this->Self->NumberOfSteps;
  }
  const surfsynth::WeldedSurface& welded = prepared.Triangulation->Welded();
  surfsynth::FieldLatentCodes codes;
  codes.Mean = prepared.Samples->At(request.Sample, this->Time);
  codes.LogDeviation = surfsynth::FieldLatentMatrix::Constant(
    codes.Mean.rows(), codes.Mean.cols() / 2, -std::numeric_limits<float>::infinity());
  vtkNew<vtkPolyData> latents;
  surfsynth::SetGeometry(latents, welded.Mesh, surfsynth::HasDoublePoints(shown));
  surfsynth::AddLatentArrays(welded, codes, this->Self->LatentArrayName, latents);
  surfsynth::LatentField field;
  field.Latents = std::move(codes.Mean);
  for (surfsynth::Index v = 0; v < welded.Rings.NumberOfPoints(); ++v)
  {
    field.Radii.push_back(welded.Rings.RingRadius(v));
  }
  output->ShallowCopy(shown);
  this->Images[place] = surfsynth::DecodeTexture(this->Models.Decoder(), field, welded, *prepared.Atlas,
    this->Self->TextureArrayName, this->Self->Resolution, output, surfsynth::SubProgress(progress, AfterLatents, 1.0));
  this->Latents[place] = latents;
}

void vtkFieldLatentTextureFilter::Internals::Warn(const std::string& where, const std::string& text) const
{
  if (!text.empty())
  {
    surfsynth::ReportWarning(this->Self, where, text);
  }
}

void vtkFieldLatentTextureFilter::Internals::Warn(const std::string& where, const std::vector<std::string>& texts) const
{
  for (const std::string& text : texts)
  {
    this->Warn(where, text);
  }
}
