// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Fast evaluation of PoissonNet [Maesumi2025] on a mesh. No torch.
#pragma once

#include "Core/Common/Errors.h"
#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/PoissonNet/MeshNormalization.h"
#include "Inference/PoissonNet/PoissonNetModel.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace surfsynth
{

/// Features, one row for each vertex, face or row of gradients; float32.
using FeatureMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Error of a network whose output has a value that is not finite, because an input or a weight is too large.
class NonFiniteOutput : public InvalidInput
{
public:
  using InvalidInput::InvalidInput;
};

/// Input of one evaluation.
struct PoissonNetInput
{
  /// Vertex signal, [V, InputChannels]; empty for the positions of the (normalised) mesh itself.
  FeatureMatrix Signal;
  /// Condition: [1, ExtraFeatures] for all vertices alike or [V, ExtraFeatures]; empty when the model has none.
  FeatureMatrix Extra;
  /// With coupled components and a gradient-domain head, [V, 3]: signal whose differences at the coupled pairs the
  /// prediction takes; empty for Signal, so that what the network adds is alike at both ends of a pair.
  FeatureMatrix CoupledSignal = FeatureMatrix();
};

/// Prediction of a PoissonNet for a mesh.
struct PoissonNetPrediction
{
  PoissonNetDomain Domain = PoissonNetDomain::Vertices; ///< domain of Values
  FeatureMatrix Values;    ///< [V, C], [F, C] or [1, C], by Domain; log-probabilities of a classifier
  FeatureMatrix Gradients; ///< [2 F, 3] of a gradient-domain head, rows 2 f and 2 f + 1 of face f; else empty

  /// The most probable class of each row of Values, the first one where several are equal.
  std::vector<Index> Labels() const;
};

/// Evaluator of one network on one mesh: operators, factorisation and weights are prepared once, for many evaluations.
///
/// Gives the results of PoissonNet (LibTorch) to 1e-5, by other means: faces are processed in tiles that stay in cache,
/// affine maps are moved from faces to vertices where they commute with averages and divergences, complex products
/// take three real ones, and Poisson solves take all channels of a vertex together. Memory is bounded by about five
/// arrays of V x Width float32 numbers. Uses MaximumThreads() threads; results have the same bits for every number of
/// them. Evaluate() may be called from several threads.
class PoissonNetEvaluator
{
public:
  /// Checks and normalises the mesh, computes operators, and factors. O(V^1.5).
  /// @param model kept as long as this object lives.
  /// @param topology tables of the mesh when the caller has checked it with Requirements() already; else null.
  /// @param coupling of several components, its distance in the units of @p mesh
  /// @throws InvalidInput when the mesh does not meet Requirements() or the model is not complete, and as
  /// CouplingMatrix(); SolverFailure; Cancelled.
  PoissonNetEvaluator(std::shared_ptr<const PoissonNetModel> model, const TriangleMesh& mesh,
    const MeshTopology* topology = nullptr, const Progress& progress = {}, const ComponentCoupling& coupling = {});

  /// Constructs the evaluator with operators that were computed elsewhere, without a check of the mesh.
  /// @param points the network's input positions, [V, 3].
  PoissonNetEvaluator(
    std::shared_ptr<const PoissonNetModel> model, const PoissonOperators& operators, const PointMatrix& points);

  ~PoissonNetEvaluator();
  PoissonNetEvaluator(PoissonNetEvaluator&&) noexcept;
  PoissonNetEvaluator& operator=(PoissonNetEvaluator&&) noexcept;

  /// Evaluates the network.
  /// @throws InvalidInput when an input has the wrong shape, or the model wants other input channels than positions and
  /// none are given; NonFiniteOutput when numbers overflow; Cancelled.
  PoissonNetPrediction Evaluate(const PoissonNetInput& input = {}, const Progress& progress = {}) const;

  /// Requirements of the architecture on a mesh: finite, non-degenerate, manifold edges, consistent winding (the
  /// network is not mirror-invariant), one component (the Poisson equation leaves one constant for each) unless
  /// components are coupled.
  /// @param coupled true where several components are coupled
  static MeshRequirements Requirements(bool coupled = false);

  /// Warnings about the mesh, see DescribeUnlikelyInput().
  const std::vector<std::string>& Warnings() const;
  /// Map from the caller's coordinates to the network's.
  const MeshNormalization& Normalization() const;
  /// Model of the evaluator.
  const PoissonNetModel& Model() const;
  /// Operators of the normalised mesh.
  const PoissonOperators& Operators() const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Evaluates a model on a mesh once. Same errors as PoissonNetEvaluator.
PoissonNetPrediction EvaluatePoissonNet(const PoissonNetModel& model, const TriangleMesh& mesh,
  const PoissonNetInput& input = {}, const Progress& progress = {});

} // namespace surfsynth
