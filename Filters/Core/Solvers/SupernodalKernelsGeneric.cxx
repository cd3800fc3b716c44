// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_VECTOR_DOUBLES 2
#define SURFSYNTH_KERNELS GenericSupernodalKernels
#include "Core/Solvers/SupernodalKernelsImplementation.h"
