// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Kernels that OpenBLAS has chosen for this processor.
#pragma once

#include <string>

namespace surfsynth
{

/// Value of the environment variable OPENBLAS_CORETYPE with which OpenBLAS would use AVX-512, where the processor has it and
/// OpenBLAS does not know the processor; else an empty string. Products of float32 matrices take half of the time with it
/// on Zen 5 and Debian 12's OpenBLAS 0.3.21. OpenBLAS reads the variable when it is loaded: results of one process do not
/// change.
std::string WiderBlasKernels();

} // namespace surfsynth
