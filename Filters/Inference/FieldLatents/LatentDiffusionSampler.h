// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sampling of field latents by denoising diffusion [Mitchel2024], sections 5, 6.4 and 9.2. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Inference/FieldLatents/LatentDiffusionNetwork.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Schedule of the forward process: step t adds noise of variance beta_t, which grows linearly with t.
class DiffusionSchedule
{
public:
  /// @param steps T, 1 or more
  /// @param firstVariance beta_1 @param lastVariance beta_T, each more than 0 and below 1
  /// @throws InvalidInput
  DiffusionSchedule(std::int64_t steps, double firstVariance, double lastVariance);

  /// Number of steps, T.
  int Steps() const { return static_cast<int>(this->Alphas.size()) - 1; }
  /// alpha_t of equation 8: the product of 1 - beta over the steps up to t; 1 for t = 0.
  double Alpha(int t) const { return this->Alphas[static_cast<std::size_t>(t)]; }
  /// Times T = t_1 > ... > t_N > 0 of a sampling in N steps, evenly spaced.
  /// @throws InvalidInput unless 1 <= N <= T.
  std::vector<int> Times(int numberOfSteps) const;

private:
  std::vector<double> Alphas; ///< [T + 1]
};

/// Coefficients of a step of the reverse process, Z_s = C1 Z_t + C2 epsilon + C3 noise (equation 11), for times s < t.
///
/// With the variance C3^2 = eta^2 (1 - alpha_s) / (1 - alpha_t) (1 - alpha_t / alpha_s), the data that the network sees,
/// Z = (Z_t - sqrt(1 - alpha_t) epsilon) / sqrt(alpha_t), are noised again to time s:
///   Z_s = sqrt(alpha_s) Z + sqrt(1 - alpha_s - C3^2) epsilon + C3 noise,
/// so C1 = sqrt(alpha_s / alpha_t) and
///   C2 = sqrt(1 - alpha_s - C3^2) - sqrt(alpha_s (1 - alpha_t) / alpha_t).
/// eta = 1 is the posterior of [Ho2020] (DDPM), where the first root is sqrt((1 - alpha_s)^2 alpha_t / (alpha_s (1 -
/// alpha_t))) and C2 = -(1 - alpha_t / alpha_s) C1 / sqrt(1 - alpha_t). Equation 30 of [Mitchel2024] prints the product of
/// the two roots, 1 - alpha_s, in place of their difference: the sign between them was lost, and with it the direction of
/// the step. Equations 29 and 31 are those of the posterior. eta = 0 is DDIM [Song2021].
struct ReverseStep
{
  double State; ///< C1
  double Noise; ///< C2
  double Fresh; ///< C3; 0 for the last step, to s = 0

  /// Computes the coefficients. @param eta 0 (DDIM) to 1 (DDPM)
  ReverseStep(const DiffusionSchedule& schedule, int t, int s, double eta);
};

/// Methods of the reverse process.
enum class DiffusionMethod
{
  Ddpm, ///< adds fresh noise in each step; made for all T steps
  Ddim  ///< deterministic after the first noise; 20 to 100 steps are enough
};

/// Sample to draw.
struct LatentSampleRequest
{
  std::uint64_t Seed = 0;                         ///< see NormalKey::Seed
  std::uint32_t Sample = 0;                       ///< number of the sample
  std::uint32_t Stream = 0;                       ///< see NormalKey::Stream
  DiffusionMethod Method = DiffusionMethod::Ddim; ///< method of the reverse process
  int NumberOfSteps = 50;                         ///< evaluations of the network, 1 to T
};

/// Returns independent N(0, 1) numbers, [V, 2 d]: a noise in the frames of the vertices. @param draw 0 for the first noise,
/// 2 t for that of the step to time t, 2 t + 1 for that of the kept latents at time t
using DiffusionNoise = std::function<FieldLatentMatrix(std::uint32_t draw)>;

/// Noise whose numbers are pure functions of seed, sample, component (draw and column) and vertex.
DiffusionNoise CounterNoise(const LatentSampleRequest& request, std::int64_t vertices, std::int64_t columns);

/// Latents to keep: equation 14.
struct LatentInpainting
{
  FieldLatentMatrix Latents; ///< [V, 2 d], in the units of the samples; not read where Mask is 0
  std::vector<float> Mask;   ///< [V], 1 where the latents are kept, 0 where they are made, or between
};

/// Predicts from a state and its time what @p target of ReverseDiffusion() says.
using Denoiser = std::function<FieldLatentMatrix(const FieldLatentMatrix& state, int time, const Progress& progress)>;
/// Receives the time and the state before each step, and 0 and the result; the reference is only valid during the call.
using DiffusionObserver = std::function<void(int time, const FieldLatentMatrix& state)>;

/// Carries a noise back from time T to 0 with any denoiser.
/// @param kept scaled latents to keep, or without a mask
/// @throws InvalidInput when the number of steps is out of range or a state is not finite; Cancelled.
FieldLatentMatrix ReverseDiffusion(const DiffusionSchedule& schedule, DiffusionTarget target, const Denoiser& denoiser,
  const DiffusionNoise& noise, const LatentSampleRequest& request, const LatentInpainting& kept = {},
  const DiffusionObserver& observe = {}, const Progress& progress = {});

/// Factors of equation 39, [d]: sqrt(pi / 2) over the mean length of each tangent vector; 1 where that is 0.
/// @param latents [V, 2 d]
std::vector<float> LatentScale(const FieldLatentMatrix& latents);

/// Sampler of one model on one surface: levels and transports are computed once.
///
/// A sample is a pure function of model, surface and request, with the same bits for every number of threads. It turns
/// with the frames when its noise does, and does not depend on the numbers of the vertices when its noise is carried along.
class LatentDiffusionSampler
{
public:
  /// Computes all that depends on the surface.
  /// @throws InvalidInput as CheckModel().
  LatentDiffusionSampler(const LatentDiffusionModel& model, const OneRings& rings);
  ~LatentDiffusionSampler();
  LatentDiffusionSampler(LatentDiffusionSampler&&) noexcept;
  LatentDiffusionSampler& operator=(LatentDiffusionSampler&&) noexcept;

  /// Network of the sampler.
  const LatentDiffusionNetwork& Network() const;
  /// Schedule of the model.
  const DiffusionSchedule& Schedule() const;

  /// Draws a sample.
  /// @param conditions what guides the sample
  /// @param kept latents to keep, or without a mask
  /// @param observe receives states in the units of the samples
  /// @param noise noise of the caller's choice; CounterNoise() when empty
  /// @return [V, 2 d], latents in the units of the autoencoder, in the frames of the surface.
  /// @throws InvalidInput when sizes do not fit, the number of steps is out of range or a state is not finite; Cancelled.
  FieldLatentMatrix Sample(const LatentSampleRequest& request, const LatentDiffusionConditions& conditions = {},
    const LatentInpainting& kept = {}, const DiffusionObserver& observe = {}, const Progress& progress = {},
    const DiffusionNoise& noise = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
