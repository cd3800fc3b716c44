// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Noise at the begin of a flow [Kuai2026]. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Noise/MaternField.h"
#include "Core/Solvers/CholeskySolver.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"

#include <Eigen/Core>

#include <optional>

namespace surfsynth
{

/// Noise of a flow matching model on one mesh: a MaternField f or, with FlowNoise::Smoothing s > 0, the solution g of
/// (M + s L) g = M f, whose spectral coefficients are those of f times 1 / (1 + s lambda), for each kind of noise.
///
/// The values of Matérn noise do not depend on the triangulation, but a PoissonNet sees gradients: their mean square,
/// the sum of lambda / (lambda + tau)^2 over the spectrum, increases with the logarithm of the number of vertices, so
/// that a network gets larger gradients on a fine triangulation than on the coarse one of its training. Smoothed, the
/// sum converges.
class FlowNoiseField
{
public:
  /// Factors the equations.
  /// @param mesh in the network's coordinates (area 1).
  /// @param topology the tables of @p mesh
  /// @param coupling of the components, in all equations
  /// @throws InvalidInput, SolverFailure, Cancelled as MaternField.
  FlowNoiseField(TriangleMesh mesh, const MeshTopology& topology, const FlowNoise& noise, const Progress& progress = {},
    const ComponentCoupling& coupling = {});

  /// Draws samples like MaternField::SampleInto(): their bits depend on the request's numbers and the mesh alone. The
  /// request's Scale is applied, that of FlowNoise is not. Same errors.
  void SampleInto(
    const SampleRequest& request, const MaternField::Destination& destination, const Progress& progress = {}) const;

private:
  Eigen::VectorXd Mass;
  std::optional<CholeskySolver> Smoother; ///< M + s L
  MaternField Field;
};

} // namespace surfsynth
