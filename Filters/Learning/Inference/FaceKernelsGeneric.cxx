// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericFaceKernels
#include "Learning/Inference/FaceKernelsImplementation.h"
