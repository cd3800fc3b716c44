// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Samples of a flow matching model on a mesh. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Inference/PoissonNet/MeshNormalisation.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// How the flow df/dt = v(f, t) is integrated. With step h and v_k the velocities:
enum class FlowIntegrator
{
  Euler,      ///< one evaluation: f + h v(f, t); first order
  Midpoint,   ///< two: f + h v(f + h/2 v(f, t), t + h/2), the paper's; second order
  RungeKutta4 ///< four: the classical method of fourth order
};

/// Evaluations of the network in each step.
int EvaluationsPerStep(FlowIntegrator integrator);

/// Which sample to draw, and how.
struct FlowSampleRequest
{
  std::uint64_t Seed = 0;
  std::uint32_t Sample = 0;
  std::uint32_t Stream = 0; ///< see NormalKey::Stream
  int Steps = 20;           ///< >= 1, of equal length
  FlowIntegrator Integrator = FlowIntegrator::Midpoint;
};

/// Draws samples of one model on one mesh: what depends on the mesh (operators, factors, the encoding) is computed once,
/// an evaluation of the network is all that a step costs.
///
/// A sample is a pure function of model, mesh and request, with the same bits for every number of threads. States are
/// signals in the network's units, [V, C] float32; ToSignal() gives them in the caller's.
class FlowMatchingSampler
{
public:
  /// @param mesh the source surface, in the caller's coordinates. @param topology its tables when the caller has checked
  /// it with Requirements() already; else null.
  /// @throws InvalidInput when the mesh does not meet Requirements() or the model is not complete; SolverFailure;
  /// Cancelled.
  FlowMatchingSampler(std::shared_ptr<const FlowMatchingModel> model, const TriangleMesh& mesh,
    const MeshTopology* topology = nullptr, const Progress& progress = {});
  ~FlowMatchingSampler();
  FlowMatchingSampler(FlowMatchingSampler&&) noexcept;
  FlowMatchingSampler& operator=(FlowMatchingSampler&&) noexcept;

  /// The state at flow time 0. Of positions its mean over the surface is removed: they are generated up to translation.
  FeatureMatrix InitialNoise(const FlowSampleRequest& request, const Progress& progress = {}) const;

  /// Receives the state at each flow time 0, 1 / Steps, ..., 1; the reference is only valid during the call.
  using Observer = std::function<void(double time, const FeatureMatrix& state)>;

  /// Carries @p noise from flow time 0 to 1.
  /// @throws InvalidInput when @p noise has the wrong shape or Steps is below 1, or the state overflows, which tells of a
  /// model that does not fit the mesh; Cancelled.
  FeatureMatrix Integrate(FeatureMatrix noise, const FlowSampleRequest& request, const Observer& observe = {},
    const Progress& progress = {}) const;

  /// v(state, time), [V, C].
  FeatureMatrix Velocity(const FeatureMatrix& state, double time, const Progress& progress = {}) const;

  /// A state in the caller's units, [V, C] float64: positions with the centroid of the source surface where it was, or the
  /// values of another signal.
  Eigen::MatrixXd ToSignal(const FeatureMatrix& state) const;

  /// The same without what ToSignal() adds to every row (the centroid, or the mean of the training): a state in the caller's
  /// units about 0. Keeps its digits on surfaces far from the origin.
  Eigen::MatrixXd ToDeviation(const FeatureMatrix& state) const;

  /// The state that ToDeviation() gives as @p deviation, [V, C]: noise of the caller's choice, such as that of a sample on
  /// another triangulation. Of positions its mean over the surface is removed.
  FeatureMatrix FromDeviation(const Eigen::MatrixXd& deviation) const;

  /// What the model asks of a mesh; see PoissonNetEvaluator::Requirements().
  static MeshRequirements Requirements();

  /// Sentences about what makes good samples unlikely: a surface unlike those of the training, or one that is turned;
  /// faces that point inwards. Empty when there is nothing to say.
  const std::vector<std::string>& Warnings() const;
  const FlowMatchingModel& Model() const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

} // namespace surfsynth
