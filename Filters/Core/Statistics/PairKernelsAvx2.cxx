// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_ADD_UP_PAIR AddUpPairAvx2
#include "Core/Statistics/PairKernelsImplementation.h"
