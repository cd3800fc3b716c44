// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The Poisson equation solved by one matrix product, for small meshes on a GPU.
#pragma once

#include "Learning/Layers/MeshTensors.h"

namespace surfsynth
{

/// Gives @p mesh the dense matrix P (L + 1e-6 I)^-1 P, P = I - 1 1^T / V, [V, V], on its device: SolvePoisson() is then
/// one product. Right-hand sides that are divergences sum to zero, and constants are removed after the solve, so that P
/// changes nothing but that the matrix has no huge constant part to be rounded. 4 V^2 bytes; V solves.
void UseDenseInverse(MeshTensors& mesh);

} // namespace surfsynth
