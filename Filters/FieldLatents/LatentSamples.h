// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Samples of a diffusion model on one triangulation, drawn once and kept.
#pragma once

#include "LatentTriangulation.h"

#include "Core/Common/Progress.h"
#include "Core/Tangent/TangentNoise.h"
#include "Inference/FieldLatents/LatentDiffusionSampler.h"

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Data beside the seed that samples depend on.
struct LatentGuide
{
  LatentDiffusionConditions Conditions; ///< labels and directions
  LatentInpainting Kept;                ///< latents to keep
};

/// Draws the samples of a filter, and keeps those of the last update: another time, number of samples or name of an array
/// costs no further evaluation of the network.
class LatentSamples
{
public:
  /// Builds the levels of the surface and its noise.
  /// @throws InvalidInput as LatentDiffusionSampler.
  LatentSamples(std::shared_ptr<const LatentDiffusionModel> model, const LatentTriangulation& triangulation);

  /// True when these are samples of @p model.
  bool IsOf(const std::shared_ptr<const LatentDiffusionModel>& model) const { return this->Model == model; }

  /// Drops the samples with numbers outside [@p first, @p first + @p count), and all that were drawn with another seed,
  /// method, number of steps or guide.
  void Keep(const LatentSampleRequest& request, LatentGuide guide, std::int64_t first, std::int64_t count);

  /// Returns true when At() has the sample: at time 1, or with @p everyStep at all times.
  bool Holds(std::uint32_t sample, bool everyStep) const;

  /// Draws the sample of @p request, which must belong to the series of the last Keep().
  /// @throws the errors of LatentDiffusionSampler::Sample(); the sample is then not held.
  void Draw(const LatentSampleRequest& request, bool everyStep, const Progress& progress);

  /// Returns the latents of a held sample, [V, 2 d]: linear between two steps, 0 for the first noise, 1 for the result.
  FieldLatentMatrix At(std::uint32_t sample, double time) const;

private:
  using States = std::vector<FieldLatentMatrix>; ///< at equal distances in time, the last one at 1

  std::shared_ptr<const LatentDiffusionModel> Model;
  TangentNoise Noise;
  LatentDiffusionSampler Sampler;
  LatentSampleRequest Series; ///< request of all held samples
  LatentGuide Guide;          ///< of all held samples
  std::map<std::uint32_t, States> Samples;
};

} // namespace surfsynth
