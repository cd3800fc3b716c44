// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Sampling of a flow matching model on a mesh [Kuai2026]. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Inference/PoissonNet/MeshNormalization.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Integrator of the flow df/dt = v(f, t) [Hairer1993], with step h.
enum class FlowIntegrator
{
  Euler,      ///< one evaluation: f + h v(f, t); first order
  Midpoint,   ///< two: f + h v(f + h/2 v(f, t), t + h/2), as in [Kuai2026]; second order
  RungeKutta4 ///< four: the classical method of fourth order
};

/// Number of evaluations of the network in each step.
int EvaluationsPerStep(FlowIntegrator integrator);

/// Sample to draw, and parameters of its integration.
struct FlowSampleRequest
{
  std::uint64_t Seed = 0;                               ///< see NormalKey::Seed
  std::uint32_t Sample = 0;                             ///< number of the sample
  std::uint32_t Stream = 0;                             ///< see NormalKey::Stream
  int Steps = 20;                                       ///< number of steps of equal length, >= 1
  FlowIntegrator Integrator = FlowIntegrator::Midpoint; ///< method of each step
  int Corrections = 0; ///< number of corrections at the end, 0 to 20; see CorrectionTime() and SuitableCorrections()
  double Temperature =
    1.0; ///< factor of the noise that InitialNoise() draws, beside that of the model; finite, at least 0
};

/// Flow time t of correction @p k of @p corrections, 0 <= k < corrections, equally spaced between 1/2 and 1:
/// t = 1/2 + (k + 1) / (2 (corrections + 1)). A correction replaces the state f at the end of the flow with the data that
/// the model expects from the state t f at time t, where no noise is added:
///   f <- t f + (1 - t) v(t f, t).
/// A model that has learned to remove noise moves a state towards the data that it was trained on [Alain2014]: errors of
/// the integrated flow are taken for noise and removed.
double CorrectionTime(int k, int corrections);

/// Number of corrections that suits @p model: 2 for FlowPrediction::Data, else 0, as published.
int SuitableCorrections(const FlowMatchingModel& model);

/// Sampler of one model on one mesh. Operators, factors and the encoding, which depend on the mesh only, are computed
/// once; each step then costs only evaluations of the network.
///
/// A sample is a pure function of model, mesh and request, with the same bits for every number of threads. States are
/// signals in the network's units, [V, C] float32; ToSignal() gives them in the caller's.
class FlowMatchingSampler
{
public:
  /// Tolerance of the distance of second moments from those of the training, beyond their spread: a tenth of their
  /// trace. Surfaces beyond it get a warning.
  static constexpr double MomentTolerance = 0.1;

  /// Computes all that depends on the mesh.
  /// @param model kept as long as this object lives.
  /// @param mesh the source surface, in the caller's coordinates.
  /// @param topology tables of the mesh when the caller has checked it with Requirements() already; else null.
  /// @param coupling of several components, in noise and network: the differences of positions at the coupled pairs are
  /// led to those of @p mesh, and turn with the surface at the end (CoupledOffsets); differences of other signals are
  /// led to 0. Its distance is in the caller's units.
  /// @param normalization of the surface of which @p mesh is a part or a damaged copy, see FlowNormalization(); without one
  /// that of @p mesh. With a gradient-domain head the mean over @p mesh of positions is that of the source: a part keeps its
  /// place.
  /// @throws InvalidInput when the mesh does not meet Requirements() or the model is not complete, and as
  /// CouplingMatrix(); SolverFailure; Cancelled.
  FlowMatchingSampler(std::shared_ptr<const FlowMatchingModel> model, const TriangleMesh& mesh,
    const MeshTopology* topology = nullptr, const Progress& progress = {}, const ComponentCoupling& coupling = {},
    const std::optional<MeshNormalization>& normalization = {});
  ~FlowMatchingSampler();
  FlowMatchingSampler(FlowMatchingSampler&&) noexcept;
  FlowMatchingSampler& operator=(FlowMatchingSampler&&) noexcept;

  /// Samples the state at flow time 0. The mean over the surface of positions is removed: they are generated up to
  /// translation.
  /// @throws InvalidInput when Temperature is out of its range.
  FeatureMatrix InitialNoise(const FlowSampleRequest& request, const Progress& progress = {}) const;

  /// Receives the state at each flow time 0, 1 / Steps, ..., 1, the last one after its corrections and the turn of
  /// coupled offsets; the reference is only valid during the call.
  using Observer = std::function<void(double time, const FeatureMatrix& state)>;

  /// Carries @p noise from flow time 0 to 1, corrects the state there, and turns the offsets of coupled components.
  /// @throws InvalidInput when @p noise has the wrong shape, Steps is below 1 or Corrections out of its range, or when
  /// the state overflows: then the model does not fit the mesh; Cancelled.
  FeatureMatrix Integrate(FeatureMatrix noise, const FlowSampleRequest& request, const Observer& observe = {},
    const Progress& progress = {}) const;

  /// Evaluates v(state, time), [V, C], time in [0, 1].
  /// @throws InvalidInput when @p state has the wrong shape; NonFiniteOutput when the network overflows; Cancelled.
  FeatureMatrix Velocity(const FeatureMatrix& state, double time, const Progress& progress = {}) const;

  /// Converts a state to the caller's units, [V, C] float64: positions about the centroid of the source surface, or the
  /// values of another signal.
  Eigen::MatrixXd ToSignal(const FeatureMatrix& state) const;

  /// Converts a state to the caller's units without the row that ToSignal() adds (the centroid, or the mean of the
  /// training). Keeps its digits on surfaces far from the origin.
  Eigen::MatrixXd ToDeviation(const FeatureMatrix& state) const;

  /// Inverse of ToDeviation(), for noise of the caller's choice, such as that of a sample on another triangulation. The
  /// mean over the surface of positions is removed.
  /// @param deviation [V, C]
  FeatureMatrix FromDeviation(const Eigen::MatrixXd& deviation) const;

  /// Requirements of the model on a mesh; see PoissonNetEvaluator::Requirements().
  /// @param coupled true where several components are coupled
  static MeshRequirements Requirements(bool coupled = false);

  /// Warnings, one sentence each, about a surface unlike those of the training, a rotated one, or faces that point
  /// inwards: good samples are unlikely then. Empty without any.
  const std::vector<std::string>& Warnings() const;
  /// Model of the sampler.
  const FlowMatchingModel& Model() const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
