// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx512GradientKernels
#include "Inference/PoissonNet/GradientKernelsImplementation.h"
