// SPDX-License-Identifier: BSD-3-Clause
#include "FlowSamples.h"

#include "NewArray.h"
#include "SurfaceBridge.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace surfsynth
{

namespace
{
/// Distance in steps below which a flow time is that of a step: times reach the filter as k / NumberOfSteps, rounded.
constexpr double SameStep = 1e-9;

/// Fraction of a sample's cost for its noise: one solve, beside the evaluations of the network.
constexpr double NoiseShare = 0.02;

FlowMatchingSampler MakeSampler(std::shared_ptr<const FlowMatchingModel> model, const Surface& surface,
  const UsedPoints& points, const Progress& progress, const ComponentCoupling& coupling,
  const std::optional<MeshNormalization>& normalization)
{
  // The tables that the check has made hold for the whole mesh, stray points included.
  const MeshTopology* topology = surface.Topology && points.All() ? &*surface.Topology : nullptr;
  return FlowMatchingSampler(
    std::move(model), points.Compact(surface.Mesh), topology, progress, coupling, normalization);
}

/// Makes an array on all points from rows of the used points.
vtkSmartPointer<vtkDoubleArray> PointArray(
  const Surface& surface, const UsedPoints& points, const Eigen::MatrixXd& rows)
{
  const auto components = static_cast<int>(rows.cols());
  auto array = NewArray<vtkDoubleArray>("", surface.Mesh.NumberOfPoints(), components);
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
  {
    for (int c = 0; c < components; ++c)
    {
      array->SetTypedComponent(points.Id(static_cast<Index>(k)), c, rows(k, c));
    }
  }
  return array;
}
} // namespace

FlowSamples::FlowSamples(std::shared_ptr<const FlowMatchingModel> model, const Surface& surface,
  const Progress& progress, const ComponentCoupling& coupling, const std::optional<MeshNormalization>& normalization)
  : Used(surface.Mesh)
  , Flow(MakeSampler(std::move(model), surface, this->Used, progress, coupling, normalization))
{}

void FlowSamples::Keep(const FlowSampleRequest& request, FeatureMatrix noise, std::int64_t first, std::int64_t count)
{
  const bool sameNoise = noise.size() == this->GivenNoise.size() && noise == this->GivenNoise;
  if (!sameNoise || request.Seed != this->Series.Seed || request.Stream != this->Series.Stream ||
    request.Steps != this->Series.Steps || request.Integrator != this->Series.Integrator ||
    request.Corrections != this->Series.Corrections || request.Temperature != this->Series.Temperature)
  {
    this->Samples.clear();
  }
  this->Series = request;
  this->GivenNoise = std::move(noise);
  for (auto sample = this->Samples.begin(); sample != this->Samples.end();)
  {
    const std::int64_t number = sample->first;
    sample = number >= first && number < first + count ? std::next(sample) : this->Samples.erase(sample);
  }
}

bool FlowSamples::Holds(std::uint32_t sample, bool everyStep) const
{
  const auto found = this->Samples.find(sample);
  return found != this->Samples.end() &&
    (!everyStep || found->second.size() == static_cast<std::size_t>(this->Series.Steps) + 1);
}

void FlowSamples::Draw(const FlowSampleRequest& request, bool everyStep, const Progress& progress)
{
  this->Samples.erase(request.Sample);
  States states;
  FeatureMatrix noise = this->GivenNoise.size() > 0
    ? this->GivenNoise
    : this->Flow.InitialNoise(request, SubProgress(progress, 0.0, NoiseShare));
  const auto keep = [&](double time, const FeatureMatrix& state) {
    if (everyStep || time == 0.0 || time == 1.0)
    {
      states.push_back(state);
    }
  };
  this->Flow.Integrate(std::move(noise), request, keep, SubProgress(progress, NoiseShare, 1.0));
  this->Samples[request.Sample] = std::move(states);
}

FeatureMatrix FlowSamples::At(std::uint32_t sample, double time) const
{
  const States& states = this->Samples.at(sample);
  const auto last = static_cast<double>(states.size() - 1);
  const double place = std::clamp(time, 0.0, 1.0) * last;
  const double nearest = std::round(place);
  if (std::abs(place - nearest) < SameStep)
  {
    return states[static_cast<std::size_t>(nearest)];
  }
  const auto before = static_cast<std::size_t>(place);
  const auto part = static_cast<float>(place - static_cast<double>(before));
  return (1.0F - part) * states[before] + part * states[before + 1];
}

SampleArrays ArraysOf(
  const FlowSamples& samples, const Surface& surface, std::uint32_t sample, double time, bool displacements)
{
  const FlowMatchingSampler& flow = samples.Sampler();
  Eigen::MatrixXd signal = flow.ToSignal(samples.At(sample, time));
  for (Eigen::Index k = 0; displacements && k < signal.rows(); ++k)
  {
    signal.row(k) -= surface.Mesh.Points.row(samples.Points().Id(static_cast<Index>(k)));
  }
  const Eigen::MatrixXd noise = flow.ToDeviation(samples.At(sample, 0.0));
  return { PointArray(surface, samples.Points(), signal), PointArray(surface, samples.Points(), noise) };
}

} // namespace surfsynth
