// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Dense solution of the Poisson equation by one matrix product, for small meshes on a GPU.
#pragma once

#include "Learning/Layers/MeshTensors.h"

namespace surfsynth
{

/// Computes the dense matrix P K^-1 P, K = L plus its shift, P = I - 1 1^T / V, [V, V], of @p mesh, on its device: SolvePoisson()
/// is then one product. Divergences, as right-hand sides, sum to zero, and constants are removed after the solve, so
/// that P changes no result; it removes a huge constant part of the matrix, which would be rounded. 4 V^2 bytes; V
/// solves.
void UseDenseInverse(MeshTensors& mesh);

} // namespace surfsynth
