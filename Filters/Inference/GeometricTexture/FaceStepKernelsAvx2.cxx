// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx2FaceStepKernels
#include "Inference/GeometricTexture/FaceStepKernelsImplementation.h"
