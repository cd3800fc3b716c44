// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_VECTOR_DOUBLES 4
#define SURFSYNTH_KERNELS Avx2SupernodalKernels
#include "Core/Solvers/SupernodalKernelsImplementation.h"
