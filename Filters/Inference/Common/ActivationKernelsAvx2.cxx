// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2ActivationKernels
#include "Inference/Common/ActivationKernelsImplementation.h"
