// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Former names of the normalization of a mesh, for one release. No torch.
#pragma once

#include "Inference/PoissonNet/MeshNormalization.h"

#include <utility>

namespace surfsynth
{

/// Former name of InputNormalization.
using InputNormalisation [[deprecated("use InputNormalization")]] = InputNormalization;

/// Former name of MeshNormalization.
using MeshNormalisation [[deprecated("use MeshNormalization")]] = MeshNormalization;

/// Former name of ComputeNormalization().
[[deprecated("use ComputeNormalization()")]] inline MeshNormalization ComputeNormalisation(
  const TriangleMesh& mesh, InputNormalization normalization)
{
  return ComputeNormalization(mesh, normalization);
}

/// Former name of Normalized().
[[deprecated("use Normalized()")]] inline TriangleMesh Normalised(
  TriangleMesh mesh, const MeshNormalization& normalization)
{
  return Normalized(std::move(mesh), normalization);
}

} // namespace surfsynth
