// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS Avx512FaceStepKernels
#include "Inference/GeometricTexture/FaceStepKernelsImplementation.h"
