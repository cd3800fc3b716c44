// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2FieldLatentKernels
#include "Inference/FieldLatents/FieldLatentKernelsImplementation.h"
