// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2FaceKernels
#include "Inference/GeometricTexture/FaceKernelsImplementation.h"
