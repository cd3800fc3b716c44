// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Samples of a flow matching model on one surface, drawn once and kept.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/UsedPoints.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <vtkDoubleArray.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace surfsynth
{

struct Surface;

/// Draws the samples that a filter is asked for, and keeps those of the last update, so that what was drawn once costs
/// no network evaluation again: neither another flow time nor another number of samples nor another name of an array.
class FlowSamples
{
public:
  /// @throws what FlowMatchingSampler throws.
  FlowSamples(std::shared_ptr<const FlowMatchingModel> model, const Surface& surface, const Progress& progress);

  /// The points that the samples have rows for.
  const UsedPoints& Points() const { return this->Used; }
  const FlowMatchingSampler& Sampler() const { return this->Flow; }

  /// Forgets the samples with numbers outside [@p first, @p first + @p count), and all that were drawn with another
  /// seed, number of steps or integrator than those of @p request, or other noise than @p noise: states at flow time 0
  /// that Draw() begins with, or an empty matrix for the noise of the request.
  void Keep(const FlowSampleRequest& request, FeatureMatrix noise, std::int64_t first, std::int64_t count);

  /// True when At() knows the sample: at flow times 0 and 1, or with @p everyStep at all times.
  bool Holds(std::uint32_t sample, bool everyStep) const;

  /// Draws the sample of @p request, which must be of the series that Keep() was told, and holds its state at flow
  /// times 0 and 1, or with @p everyStep after every step.
  /// @throws what FlowMatchingSampler::Integrate() throws; then nothing is held of it.
  void Draw(const FlowSampleRequest& request, bool everyStep, const Progress& progress);

  /// The state of a sample that is held at flow time @p time in [0, 1]: as it was after a step, or linear between two
  /// steps.
  FeatureMatrix At(std::uint32_t sample, double time) const;

private:
  using States = std::vector<FeatureMatrix>; ///< at equal distances in flow time from 0 to 1

  UsedPoints Used;
  FlowMatchingSampler Flow;
  FlowSampleRequest Series; ///< what all samples that are held have in common
  FeatureMatrix GivenNoise; ///< and this: what they begin with, or empty
  std::map<std::uint32_t, States> Samples;
};

/// The point arrays of one sample.
struct SampleArrays
{
  vtkSmartPointer<vtkDoubleArray> Signal;
  vtkSmartPointer<vtkDoubleArray> Noise;
};

/// A sample that @p samples holds, at flow time @p time, and its noise: on all points of @p surface, zero at those that
/// no polygon uses, without names.
/// @param displacements whether the signal is the way from the points of @p surface to where the sample has them.
SampleArrays ArraysOf(
  const FlowSamples& samples, const Surface& surface, std::uint32_t sample, double time, bool displacements);

} // namespace surfsynth
