// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_VECTOR_DOUBLES 8
#define SURFSYNTH_KERNELS Avx512SupernodalKernels
#include "Core/Solvers/SupernodalKernelsImplementation.h"
