// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericFaceKernels
#include "Inference/GeometricTexture/FaceKernelsImplementation.h"
