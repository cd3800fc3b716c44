// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Equilibria of many samples, in parallel. Private to the library.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Elasticity/ElasticMotion.h"

#include <functional>
#include <vector>

namespace surfsynth
{

/// Makes the equilibrium of sample @p k, counted from 0, on one thread.
using SampleMotion = std::function<ElasticEquilibrium(int k, const Progress& progress)>;

/// Equilibria of @p count samples.
/// @param first index of sample 0, for messages
/// @throws SolverFailure, which names the sample; Cancelled
std::vector<ElasticEquilibrium> SettleSamples(
  int count, int first, const SampleMotion& settle, const Progress& progress);

} // namespace surfsynth
