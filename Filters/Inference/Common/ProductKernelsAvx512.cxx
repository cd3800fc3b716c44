// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_LANES 16
#define SURFSYNTH_VECTORS 4
#define SURFSYNTH_KERNELS Avx512ProductKernels
#include "Inference/Common/ProductKernelsImplementation.h"
