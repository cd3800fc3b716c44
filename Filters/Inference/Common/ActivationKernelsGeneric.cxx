// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericActivationKernels
#include "Inference/Common/ActivationKernelsImplementation.h"
