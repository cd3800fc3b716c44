// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericFaceStepKernels
#include "Inference/GeometricTexture/FaceStepKernelsImplementation.h"
