// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a mesh goes through before a network sees it. No torch.
#pragma once

#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <string>
#include <vector>

namespace surfsynth
{

/// The step from the caller's coordinates to the network's: normalised = (point - Centre) / Scale.
struct MeshNormalisation
{
  Eigen::RowVector3d Centre = Eigen::RowVector3d::Zero();
  double Scale = 1.0;
};

/// Centre and scale of @p mesh for @p normalisation. @throws InvalidInput when the mesh has no extent.
MeshNormalisation ComputeNormalisation(const TriangleMesh& mesh, InputNormalisation normalisation);

/// @p mesh in the network's coordinates.
TriangleMesh Normalised(TriangleMesh mesh, const MeshNormalisation& normalisation);

/// Sentences about what makes good answers of a PoissonNet unlikely: a closed mesh whose faces point inwards, an area
/// far from 1 which the model does not normalise. Empty when there is nothing to say.
std::vector<std::string> DescribeUnlikelyInput(
  const TriangleMesh& mesh, const MeshTopology& topology, InputNormalisation normalisation);

} // namespace surfsynth
