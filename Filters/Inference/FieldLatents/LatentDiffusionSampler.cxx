// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FieldLatents/LatentDiffusionSampler.h"

#include "Core/Common/Errors.h"
#include "Core/Random/CounterNormals.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
[[noreturn]] void Refuse(const std::string& function, const std::string& found, const std::string& expected)
{
  throw InvalidInput(function + ": " + found + "; expected " + expected + ".");
}

/// Turns a prediction into the noise that it means.
void ToNoise(DiffusionTarget target, double alpha, const FieldLatentMatrix& state, FieldLatentMatrix& prediction)
{
  const auto signal = static_cast<float>(std::sqrt(alpha));
  const auto noise = static_cast<float>(std::sqrt(1.0 - alpha));
  if (target == DiffusionTarget::Data)
  {
    prediction = (state - signal * prediction) / noise;
  }
  else if (target == DiffusionTarget::Velocity)
  {
    prediction = noise * state + signal * prediction;
  }
}

/// Equation 14 at time t.
void Keep(const LatentInpainting& kept, double alpha, const DiffusionNoise& noise, int t, FieldLatentMatrix& state)
{
  if (kept.Mask.empty())
  {
    return;
  }
  FieldLatentMatrix noised = static_cast<float>(std::sqrt(alpha)) * kept.Latents;
  if (alpha < 1.0)
  {
    noised += static_cast<float>(std::sqrt(1.0 - alpha)) * noise(2 * static_cast<std::uint32_t>(t) + 1);
  }
  for (Eigen::Index v = 0; v < state.rows(); ++v)
  {
    const float mask = kept.Mask[static_cast<std::size_t>(v)];
    if (mask > 0.0F)
    {
      state.row(v) = mask * noised.row(v) + (1.0F - mask) * state.row(v);
    }
  }
}

void CheckKept(const LatentInpainting& kept, const FieldLatentMatrix& state)
{
  const std::string function = "ReverseDiffusion";
  if (kept.Mask.empty())
  {
    return;
  }
  if (static_cast<Eigen::Index>(kept.Mask.size()) != state.rows() || kept.Latents.rows() != state.rows() ||
    kept.Latents.cols() != state.cols())
  {
    Refuse(function,
      "the mask has " + std::to_string(kept.Mask.size()) + " numbers and the latents are [" +
        std::to_string(kept.Latents.rows()) + ", " + std::to_string(kept.Latents.cols()) + "]",
      std::to_string(state.rows()) + " and [" + std::to_string(state.rows()) + ", " + std::to_string(state.cols()) +
        "]");
  }
  for (std::size_t v = 0; v < kept.Mask.size(); ++v)
  {
    if (!(kept.Mask[v] >= 0.0F && kept.Mask[v] <= 1.0F))
    {
      Refuse(function, "the mask is " + std::to_string(kept.Mask[v]) + " at vertex " + std::to_string(v), "0 to 1");
    }
    if (kept.Mask[v] > 0.0F && !kept.Latents.row(static_cast<Eigen::Index>(v)).allFinite())
    {
      Refuse(function, "the latents of vertex " + std::to_string(v) + " are not finite", "finite numbers");
    }
  }
}
} // namespace

DiffusionSchedule::DiffusionSchedule(std::int64_t steps, double firstVariance, double lastVariance)
{
  const auto valid = [](double variance) { return variance > 0.0 && variance < 1.0; };
  if (steps < 1 || !valid(firstVariance) || !valid(lastVariance))
  {
    Refuse("DiffusionSchedule",
      std::to_string(steps) + " steps with variances " + std::to_string(firstVariance) + " to " +
        std::to_string(lastVariance),
      "1 step or more, variances between 0 and 1");
  }
  this->Alphas = { 1.0 };
  for (std::int64_t t = 0; t < steps; ++t)
  {
    const double share = steps > 1 ? static_cast<double>(t) / static_cast<double>(steps - 1) : 0.0;
    this->Alphas.push_back(this->Alphas.back() * (1.0 - (firstVariance + share * (lastVariance - firstVariance))));
  }
}

std::vector<int> DiffusionSchedule::Times(int numberOfSteps) const
{
  if (numberOfSteps < 1 || numberOfSteps > this->Steps())
  {
    Refuse("DiffusionSchedule", std::to_string(numberOfSteps) + " steps of a sampling",
      "1 to " + std::to_string(this->Steps()));
  }
  std::vector<int> times;
  for (std::int64_t k = numberOfSteps; k > 0; --k)
  {
    times.push_back(static_cast<int>(k * this->Steps() / numberOfSteps));
  }
  return times;
}

ReverseStep::ReverseStep(const DiffusionSchedule& schedule, int t, int s, double eta)
{
  const double now = schedule.Alpha(t);
  const double next = schedule.Alpha(s);
  this->State = std::sqrt(next / now);
  this->Fresh = eta * std::sqrt((1.0 - next) / (1.0 - now) * (1.0 - now / next));
  this->Noise = std::sqrt(std::max(0.0, 1.0 - next - this->Fresh * this->Fresh)) - std::sqrt(next * (1.0 - now) / now);
}

DiffusionNoise CounterNoise(const LatentSampleRequest& request, std::int64_t vertices, std::int64_t columns)
{
  return [=](std::uint32_t draw) {
    FieldLatentMatrix noise(vertices, columns);
    std::vector<double> column(static_cast<std::size_t>(vertices));
    for (std::int64_t c = 0; c < columns; ++c)
    {
      const auto component = draw * static_cast<std::uint32_t>(columns) + static_cast<std::uint32_t>(c);
      FillNormals({ request.Seed, request.Sample, component, request.Stream }, 0, vertices, column.data());
      for (std::int64_t v = 0; v < vertices; ++v)
      {
        noise(v, c) = static_cast<float>(column[static_cast<std::size_t>(v)]);
      }
    }
    return noise;
  };
}

FieldLatentMatrix ReverseDiffusion(const DiffusionSchedule& schedule, DiffusionTarget target, const Denoiser& denoiser,
  const DiffusionNoise& noise, const LatentSampleRequest& request, const LatentInpainting& kept,
  const DiffusionObserver& observe, const Progress& progress)
{
  const std::vector<int> times = schedule.Times(request.NumberOfSteps);
  const double eta = request.Method == DiffusionMethod::Ddpm ? 1.0 : 0.0;
  FieldLatentMatrix state = noise(0);
  CheckKept(kept, state);
  Keep(kept, schedule.Alpha(times.front()), noise, times.front(), state);
  for (std::size_t k = 0; k < times.size(); ++k)
  {
    const int t = times[k];
    const int s = k + 1 < times.size() ? times[k + 1] : 0;
    if (observe)
    {
      observe(t, state);
    }
    const double begin = static_cast<double>(k) / static_cast<double>(times.size());
    const double end = static_cast<double>(k + 1) / static_cast<double>(times.size());
    FieldLatentMatrix prediction = denoiser(state, t, SubProgress(progress, begin, end));
    ToNoise(target, schedule.Alpha(t), state, prediction);
    const ReverseStep step(schedule, t, s, eta);
    state = static_cast<float>(step.State) * state + static_cast<float>(step.Noise) * prediction;
    if (step.Fresh > 0.0)
    {
      state += static_cast<float>(step.Fresh) * noise(2 * static_cast<std::uint32_t>(s));
    }
    Keep(kept, schedule.Alpha(s), noise, s, state);
    if (!state.allFinite())
    {
      Refuse("ReverseDiffusion", "the state at time " + std::to_string(s) + " is not finite",
        "a denoiser that fits the noise");
    }
    Report(progress, end);
  }
  if (observe)
  {
    observe(0, state);
  }
  return state;
}

std::vector<float> LatentScale(const FieldLatentMatrix& latents)
{
  const double mean = std::sqrt(std::acos(-1.0) / 2.0);
  std::vector<float> scale;
  for (Eigen::Index j = 0; j + 1 < latents.cols(); j += 2)
  {
    double sum = 0.0;
    for (Eigen::Index v = 0; v < latents.rows(); ++v)
    {
      sum += std::hypot(static_cast<double>(latents(v, j)), static_cast<double>(latents(v, j + 1)));
    }
    scale.push_back(sum > 0.0 ? static_cast<float>(mean * static_cast<double>(latents.rows()) / sum) : 1.0F);
  }
  return scale;
}

class LatentDiffusionSampler::Internals
{
public:
  Internals(const LatentDiffusionModel& model, const OneRings& rings)
    : Network(model, std::make_shared<const TangentHierarchy>(rings))
    , Schedule(model.Options.TimeSteps, model.Options.FirstVariance, model.Options.LastVariance)
    , Scale(2 * model.Options.LatentDimension)
  {
    const std::vector<float>& scale = model.Tensors.at("latent_scale").Values;
    for (Eigen::Index j = 0; j < this->Scale.size(); ++j)
    {
      this->Scale[j] = scale[static_cast<std::size_t>(j / 2)];
    }
  }

  FieldLatentMatrix Unscaled(const FieldLatentMatrix& state) const
  {
    return state.array().rowwise() / this->Scale.transpose().array();
  }

  LatentDiffusionNetwork Network;
  DiffusionSchedule Schedule;
  Eigen::VectorXf Scale; ///< [2 d]
};

LatentDiffusionSampler::LatentDiffusionSampler(const LatentDiffusionModel& model, const OneRings& rings)
{
  CheckModel(model);
  this->Impl = std::make_unique<Internals>(model, rings);
}

LatentDiffusionSampler::~LatentDiffusionSampler() = default;
LatentDiffusionSampler::LatentDiffusionSampler(LatentDiffusionSampler&&) noexcept = default;
LatentDiffusionSampler& LatentDiffusionSampler::operator=(LatentDiffusionSampler&&) noexcept = default;

const LatentDiffusionNetwork& LatentDiffusionSampler::Network() const { return this->Impl->Network; }

const DiffusionSchedule& LatentDiffusionSampler::Schedule() const { return this->Impl->Schedule; }

FieldLatentMatrix LatentDiffusionSampler::Sample(const LatentSampleRequest& request,
  const LatentDiffusionConditions& conditions, const LatentInpainting& kept, const DiffusionObserver& observe,
  const Progress& progress, const DiffusionNoise& noise) const
{
  const Internals& internals = *this->Impl;
  const std::int64_t vertices = internals.Network.Surface().Fine.NumberOfVertices();
  LatentInpainting scaled = kept;
  if (kept.Latents.cols() == internals.Scale.size())
  {
    scaled.Latents = kept.Latents.array().rowwise() * internals.Scale.transpose().array();
  }
  const Denoiser denoiser = [&](const FieldLatentMatrix& state, int time, const Progress& part) {
    return internals.Network.Evaluate(state, time, conditions, part);
  };
  DiffusionObserver unscaled;
  if (observe)
  {
    unscaled = [&](int time, const FieldLatentMatrix& state) { observe(time, internals.Unscaled(state)); };
  }
  return internals.Unscaled(ReverseDiffusion(internals.Schedule, internals.Network.Options().Target, denoiser,
    noise ? noise : CounterNoise(request, vertices, internals.Scale.size()), request, scaled, unscaled, progress));
}

} // namespace surfsynth
