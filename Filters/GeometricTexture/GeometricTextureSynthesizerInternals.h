// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Algorithm of vtkGeometricTextureSynthesizer, block by block. Private to the filter.
#pragma once

#include "vtkGeometricTextureSynthesizer.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "FileCache.h"
#include "GeometricTextureMask.h"
#include "GeometricTextureResult.h"
#include "InstalledModelList.h"
#include "OutputSeries.h"
#include "PrintabilityCount.h"
#include "RemeshedTarget.h"
#include "SurfaceBridge.h"

#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <vtkInformation.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkPolyData;

/// Model and textures of the last update, and the work of this update.
class vtkGeometricTextureSynthesizer::Internals
{
public:
  explicit Internals(vtkGeometricTextureSynthesizer* self)
    : Self(self)
  {}

  /// Checks the properties and reads the model file where that is needed.
  /// @param time time of the animation, if requested. @throws the errors of the reader; InvalidInput.
  void Begin(std::optional<double> time, bool fromTemplate);

  /// Returns the template of the model as the target of the first piece; other pieces are empty.
  /// @throws InvalidInput for a model without a template.
  vtkSmartPointer<vtkInformation> TemplateInformation(vtkInformation* requested) const;

  /// Fills block.Output, or with OutputLevels those of block.Outputs whose level has begun. @throws the errors of the
  /// synthesis.
  void Synthesize(const surfsynth::Block& block, const surfsynth::Progress& progress);

  /// Drops the data that this update has not used.
  void End();

  /// Returns the outputs of one block: one for each level with OutputLevels, else one.
  /// @throws InvalidInput for levels that the model does not have.
  surfsynth::OutputSeries Series() const;

  /// Writes the model with statistics of its channels. @throws the errors of reading and writing; InvalidInput.
  void WriteModelWithStatistics(const std::string& fileName, int samples);

  /// Returns the times of the animation; none when the model cannot be read, which the next RequestData reports.
  std::vector<double> AnimationTimes();

  std::shared_ptr<const surfsynth::GeometricTextureModel> Model; ///< of this update
  surfsynth::FileCache<surfsynth::GeometricTextureModel> File{ surfsynth::ReadGeometricTexture,
    "A geometric texture in safetensors format is needed, as its training writes it." };
  surfsynth::FileCache<surfsynth::GeometricTextureModel> SecondFile{ surfsynth::ReadGeometricTexture,
    "SecondModelFileName needs a geometric texture in safetensors format, as its training writes it." };
  surfsynth::InstalledModelList Installed;
  vtkTypeInt64 NumberOfSyntheses = 0;
  vtkTypeInt64 NumberOfRemeshings = 0;
  surfsynth::PrintabilityCount Printability; ///< of this update

private:
  void CheckNames() const;
  std::shared_ptr<const surfsynth::GeometricTextureModel> ReadModel();
  std::shared_ptr<const surfsynth::GeometricTextureModel> ReadSecondModel();
  surfsynth::GeometricTextureLevelRange Range(const surfsynth::GeometricTextureModel& model) const;
  surfsynth::GeometricTextureRequest Request(
    unsigned int flatIndex, const surfsynth::GeometricTextureModel& model) const;
  void Check(surfsynth::Surface& surface) const;
  double TextureScale(const surfsynth::TriangleMesh& target) const;
  bool Remeshes() const;
  vtkSmartPointer<vtkPolyData> Remesh(
    vtkPolyData* input, const surfsynth::Block& block, const surfsynth::Progress& progress);
  surfsynth::GeometricTextureSettings Settings(vtkPolyData* input, const surfsynth::Surface& surface) const;
  surfsynth::GeometricTextureResult* Find(
    const surfsynth::Surface& surface, const surfsynth::GeometricTextureSettings& settings);
  surfsynth::GeometricTextureResult& Compute(const surfsynth::Surface& surface,
    const surfsynth::GeometricTextureSettings& settings, const surfsynth::Progress& progress);
  Eigen::VectorXf ReadArray(vtkPolyData* input, const surfsynth::Surface& surface, const std::string& name,
    const surfsynth::GeometricTextureArray& kind) const;
  surfsynth::GeometricTextureAdjustment Adjustment(vtkPolyData* input, const surfsynth::Surface& surface) const;
  double LevelsAtTime() const;
  int StepAtTime(int steps) const;
  void Fill(vtkPolyData* input, const surfsynth::Surface& surface, const surfsynth::GeometricTextureResult& texture,
    int step, vtkPolyData* output) const;

  vtkGeometricTextureSynthesizer* Self;
  surfsynth::BlockCache<std::unique_ptr<surfsynth::RemeshedTarget>> Targets; ///< with REMESH
  surfsynth::BlockCache<std::unique_ptr<surfsynth::GeometricTextureResult>> Textures;
  std::shared_ptr<const surfsynth::GeometricTextureModel> SecondModel; ///< of this update; null without
  std::optional<double> Time;
  bool FromTemplate = false;
  std::vector<int> WithoutNoise; ///< generator levels
};
