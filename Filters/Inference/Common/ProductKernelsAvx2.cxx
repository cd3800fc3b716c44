// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_LANES 8
#define SURFSYNTH_VECTORS 2
#define SURFSYNTH_KERNELS Avx2ProductKernels
#include "Inference/Common/ProductKernelsImplementation.h"
