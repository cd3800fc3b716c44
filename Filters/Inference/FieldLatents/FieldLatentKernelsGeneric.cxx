// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_KERNELS GenericFieldLatentKernels
#include "Inference/FieldLatents/FieldLatentKernelsImplementation.h"
