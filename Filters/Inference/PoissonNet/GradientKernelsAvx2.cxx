// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2GradientKernels
#include "Inference/PoissonNet/GradientKernelsImplementation.h"
