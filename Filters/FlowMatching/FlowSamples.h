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
#include <optional>
#include <vector>

namespace surfsynth
{

struct Surface;

/// Draws the samples of a filter, and keeps those of the last update: another flow time, number of samples or name of
/// an array costs no further network evaluation.
class FlowSamples
{
public:
  /// @throws the errors of FlowMatchingSampler.
  FlowSamples(std::shared_ptr<const FlowMatchingModel> model, const Surface& surface, const Progress& progress,
    const ComponentCoupling& coupling, const std::optional<MeshNormalization>& normalization);

  /// Returns the points that the samples have rows for.
  const UsedPoints& Points() const { return this->Used; }
  /// Returns the sampler of the surface.
  const FlowMatchingSampler& Sampler() const { return this->Flow; }

  /// Drops the samples with numbers outside [@p first, @p first + @p count), and all that were drawn with another seed,
  /// number of steps or corrections or integrator than @p request, or other noise than @p noise: the states at flow
  /// time 0 for Draw(), or an empty matrix for the noise of the request.
  void Keep(const FlowSampleRequest& request, FeatureMatrix noise, std::int64_t first, std::int64_t count);

  /// Returns true when At() has the sample: at flow times 0 and 1, or with @p everyStep at all times.
  bool Holds(std::uint32_t sample, bool everyStep) const;

  /// Draws the sample of @p request, which must belong to the series of the last Keep(), and holds its state at flow
  /// times 0 and 1, or with @p everyStep after every step.
  /// @throws the errors of FlowMatchingSampler::Integrate(); the sample is then not held.
  void Draw(const FlowSampleRequest& request, bool everyStep, const Progress& progress);

  /// Returns the state of a held sample at flow time @p time in [0, 1]: that after a step, or linear between two steps.
  FeatureMatrix At(std::uint32_t sample, double time) const;

private:
  using States = std::vector<FeatureMatrix>; ///< at equal distances in flow time from 0 to 1

  UsedPoints Used;
  FlowMatchingSampler Flow;
  FlowSampleRequest Series; ///< request of all held samples
  FeatureMatrix GivenNoise; ///< their states at flow time 0, or empty
  std::map<std::uint32_t, States> Samples;
};

/// Point arrays of one sample.
struct SampleArrays
{
  vtkSmartPointer<vtkDoubleArray> Signal;
  vtkSmartPointer<vtkDoubleArray> Noise;
};

/// Returns a sample that @p samples holds, at flow time @p time, and its noise: on all points of @p surface, zero at
/// those that no polygon uses, without names.
/// @param displacements true for a signal that is the displacement of the points of @p surface to those of the sample.
SampleArrays ArraysOf(
  const FlowSamples& samples, const Surface& surface, std::uint32_t sample, double time, bool displacements);

} // namespace surfsynth
