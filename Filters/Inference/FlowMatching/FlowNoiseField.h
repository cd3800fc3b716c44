// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The noise that a flow begins with. No torch.
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

/// Draws the noise of a flow matching model on one mesh: a MaternField f and, with FlowNoise::Smoothing s, what
/// (M + s L) g = M f makes of it, each spectral coefficient times 1 / (1 + s lambda).
///
/// The values of Matérn noise do not depend on the triangulation, but a PoissonNet sees gradients: their mean square, the
/// sum of lambda / (lambda + tau)^2 over the spectrum, grows with the logarithm of the number of vertices, so that a network
/// meets larger gradients on a fine triangulation than on the coarse one of its training. Smoothed, the sum converges.
class FlowNoiseField
{
public:
  /// @param mesh in the network's coordinates (area 1). @throws what MaternField throws.
  FlowNoiseField(
    TriangleMesh mesh, const MeshTopology& topology, const FlowNoise& noise, const Progress& progress = {});

  /// Like MaternField::SampleInto(): the bits of a sample depend on the request's numbers and the mesh alone. The request's
  /// Scale is applied, that of FlowNoise is not.
  void SampleInto(
    const SampleRequest& request, const MaternField::Destination& destination, const Progress& progress = {}) const;

private:
  Eigen::VectorXd Mass;
  std::optional<CholeskySolver> Smoother; ///< M + s L
  MaternField Field;
};

} // namespace surfsynth
