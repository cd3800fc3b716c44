// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericLatentDiffusionKernels
#include "Inference/FieldLatents/LatentDiffusionKernelsImplementation.h"
