// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Normalisation of a mesh for a network. No torch.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/ComponentCoupling.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <string>
#include <vector>

namespace surfsynth
{

/// Map from the caller's coordinates to the network's: normalised = (point - Center) / Scale.
struct MeshNormalization
{
  Eigen::RowVector3d Center = Eigen::RowVector3d::Zero(); ///< world units
  double Scale = 1.0;                                     ///< world units, > 0

  /// True for the same map.
  bool operator==(const MeshNormalization& other) const
  {
    return this->Center == other.Center && this->Scale == other.Scale;
  }
};

/// Computes centre and scale of @p mesh for @p normalization.
/// @throws InvalidInput when the mesh has no extent.
MeshNormalization ComputeNormalization(const TriangleMesh& mesh, InputNormalization normalization);

/// Maps @p mesh to the network's coordinates.
TriangleMesh Normalized(TriangleMesh mesh, const MeshNormalization& normalization);

/// Maps the distance of a coupling to the network's coordinates.
ComponentCoupling ScaledCoupling(ComponentCoupling coupling, const MeshNormalization& normalization);

/// Describes inputs for which good predictions of a PoissonNet are unlikely, one sentence each: a closed mesh whose
/// faces point inwards, an area far from 1 that the model does not normalise. Empty for other inputs.
std::vector<std::string> DescribeUnlikelyInput(
  const TriangleMesh& mesh, const MeshTopology& topology, InputNormalization normalization);

} // namespace surfsynth
