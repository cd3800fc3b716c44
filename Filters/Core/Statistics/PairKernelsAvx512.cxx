// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_ADD_UP_PAIR AddUpPairAvx512
#include "Core/Statistics/PairKernelsImplementation.h"
