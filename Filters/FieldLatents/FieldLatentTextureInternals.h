// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Work of vtkFieldLatentTextureFilter on its blocks. Private to the module.
#pragma once

#include "vtkFieldLatentTextureFilter.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "InstalledModelList.h"
#include "LatentArrays.h"
#include "LatentGuidance.h"
#include "LatentModelPair.h"
#include "SampleOutputs.h"
#include "SampledTextures.h"
#include "SurfaceBridge.h"
#include "TextureColors.h"
#include "WeldedSurface.h"

#include <vtkSmartPointer.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

class vtkDataObject;
class vtkImageData;
class vtkInformationVector;
class vtkPolyData;

/// Models, triangulations and samples of the last update.
class vtkFieldLatentTextureFilter::Internals
{
public:
  /// Ports of the output after the first.
  static constexpr int ImagePort = 1;
  static constexpr int LatentPort = 2;

  explicit Internals(vtkFieldLatentTextureFilter* self)
    : Self(self)
  {}

  /// Checks the properties and reads the model files and the image. @throws the errors of the readers.
  void Begin(vtkInformationVector** inputVector, double time);

  /// Fills the further outputs, and forgets what the input no longer has.
  void End(vtkDataObject* input, vtkInformationVector* outputVector);

  /// Releases what only an update needs.
  void Release();

  /// Outputs of one surface, one for each sample.
  surfsynth::OutputSeries Series() const;

  void Synthesize(const surfsynth::Block& block, const surfsynth::Progress& progress);

  const std::shared_ptr<const surfsynth::LatentDiffusionModel>& Model() const { return this->Models.Diffusion(); }

  surfsynth::LatentModelPair Models; ///< of this update
  surfsynth::InstalledModelList InstalledModels;
  surfsynth::InstalledModelList InstalledAutoencoders;
  vtkTypeInt64 NumberOfVertices = 0;
  vtkTypeInt64 NumberOfTriangulations = 0;
  vtkTypeInt64 NumberOfEvaluations = 0;

private:
  void RequireNames() const;

  void ReadModels();

  /// Refuses a TextureArrayName that is the name of the texture coordinates.
  void RequireOtherName(vtkPolyData* shown) const;

  /// Refuses arrays that the model does not know.
  void RequireGuidance() const;

  /// Number of points of the triangulation; 0 for that of the surface.
  std::int64_t PointsOf(double inputPoints) const;

  /// Refuses sizes that do not fit into the limit of memory.
  void RequireMemory(vtkDataObject* input) const;

  /// Fills @p shown with the surface and its texture coordinates, and returns it converted.
  surfsynth::Surface Shown(const surfsynth::Block& block, vtkPolyData* shown, const surfsynth::Progress& progress);

  /// Returns the triangulation of this block, from an earlier update when nothing that it depends on has changed.
  surfsynth::PreparedTextures& Prepared(const surfsynth::Surface& surface, const surfsynth::Progress& progress);

  /// Finds the places of texels and points on the triangulation, where those held are not current.
  void PrepareAtlas(surfsynth::PreparedTextures& prepared, const surfsynth::Surface& surface,
    surfsynth::TextureCoordinates coordinates, const surfsynth::Progress& progress) const;

  /// Reads labels, directions and the latents to keep.
  surfsynth::LatentGuide Guide(vtkPolyData* shown, const surfsynth::Surface& surface,
    const surfsynth::LatentTriangulation& triangulation, const surfsynth::Progress& progress) const;

  /// Encodes the texture of the input at the vertices that keep it.
  surfsynth::FieldLatentMatrix Encoded(
    const surfsynth::GuidedSurface& guided, const std::vector<float>& mask, const surfsynth::Progress& progress) const;

  surfsynth::TextureColors Colors(const surfsynth::GuidedSurface& guided) const;

  surfsynth::LatentSampleRequest Request(unsigned int flatIndex) const;

  /// Draws a sample where it is not held, and puts it on the outputs.
  void AddSample(surfsynth::PreparedTextures& prepared, const surfsynth::LatentSampleRequest& request,
    vtkPolyData* shown, const std::pair<int, unsigned int>& place, vtkPolyData* output,
    const surfsynth::Progress& progress);

  void Warn(const std::string& where, const std::string& text) const;

  void Warn(const std::string& where, const std::vector<std::string>& texts) const;

  vtkFieldLatentTextureFilter* Self;
  double Time = 1.0;
  std::optional<surfsynth::ColorImage> Image; ///< during an update
  surfsynth::SampleResults Images;            ///< of this update
  surfsynth::SampleResults Latents;           ///< of this update
  surfsynth::BlockCache<surfsynth::PreparedTextures> Blocks;
  surfsynth::BlockCache<surfsynth::MadeAtlas> MadeAtlases;
};
