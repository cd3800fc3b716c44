// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericGradientKernels
#include "Inference/PoissonNet/GradientKernelsImplementation.h"
