// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx512ActivationKernels
#include "Inference/Common/ActivationKernelsImplementation.h"
