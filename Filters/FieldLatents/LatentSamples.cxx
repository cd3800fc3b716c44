// SPDX-License-Identifier: BSD-3-Clause
#include "LatentSamples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace surfsynth
{

namespace
{
bool IsEqual(const FieldLatentMatrix& a, const FieldLatentMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() && std::equal(a.data(), a.data() + a.size(), b.data());
}

bool IsEqual(const LatentGuide& a, const LatentGuide& b)
{
  return a.Conditions.Labels == b.Conditions.Labels && IsEqual(a.Conditions.Directions, b.Conditions.Directions) &&
    a.Kept.Mask == b.Kept.Mask && IsEqual(a.Kept.Latents, b.Kept.Latents);
}
} // namespace

LatentSamples::LatentSamples(
  std::shared_ptr<const LatentDiffusionModel> model, const LatentTriangulation& triangulation)
  : Model(std::move(model))
  , Noise(triangulation.Welded().Mesh, triangulation.Welded().Rings)
  , Sampler(*this->Model, triangulation.Welded().Rings)
{}

void LatentSamples::Keep(const LatentSampleRequest& request, LatentGuide guide, std::int64_t first, std::int64_t count)
{
  const bool isSame = request.Seed == this->Series.Seed && request.Stream == this->Series.Stream &&
    request.Method == this->Series.Method && request.NumberOfSteps == this->Series.NumberOfSteps &&
    IsEqual(guide, this->Guide);
  for (auto sample = this->Samples.begin(); sample != this->Samples.end();)
  {
    const bool isIn = isSame && sample->first >= first && sample->first < first + count;
    sample = isIn ? std::next(sample) : this->Samples.erase(sample);
  }
  this->Series = request;
  this->Guide = std::move(guide);
}

bool LatentSamples::Holds(std::uint32_t sample, bool everyStep) const
{
  const auto found = this->Samples.find(sample);
  return found != this->Samples.end() && (!everyStep || found->second.size() > 1);
}

void LatentSamples::Draw(const LatentSampleRequest& request, bool everyStep, const Progress& progress)
{
  States states;
  DiffusionObserver observe;
  if (everyStep)
  {
    observe = [&states](int time, const FieldLatentMatrix& state) {
      if (time > 0)
      {
        states.push_back(state);
      }
    };
  }
  const NormalKey key{ request.Seed, request.Sample, 0, request.Stream };
  const std::int64_t dimension = this->Model->Options.LatentDimension;
  // The first noise sets the texture; those of later steps need not be alike on other triangulations.
  const DiffusionNoise noise = [&](std::uint32_t draw) {
    return draw == 0 ? this->Noise.Draw(key, dimension) : this->Noise.DrawAtVertices(key, dimension, draw);
  };
  states.push_back(this->Sampler.Sample(request, this->Guide.Conditions, this->Guide.Kept, observe, progress, noise));
  this->Samples[request.Sample] = std::move(states);
}

FieldLatentMatrix LatentSamples::At(std::uint32_t sample, double time) const
{
  const States& states = this->Samples.at(sample);
  const double step = std::clamp(time, 0.0, 1.0) * static_cast<double>(states.size() - 1);
  const auto before = std::min(static_cast<std::size_t>(step), states.size() - 1);
  const auto share = static_cast<float>(step - static_cast<double>(before));
  if (share == 0.0F || before + 1 == states.size())
  {
    return states[before];
  }
  return (1.0F - share) * states[before] + share * states[before + 1];
}

} // namespace surfsynth
