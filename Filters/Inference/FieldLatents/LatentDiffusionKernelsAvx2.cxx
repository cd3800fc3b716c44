// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2LatentDiffusionKernels
#include "Inference/FieldLatents/LatentDiffusionKernelsImplementation.h"
