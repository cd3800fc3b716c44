// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2FaceKernels
#include "Learning/Inference/FaceKernelsImplementation.h"
