// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_ADD_UP_PAIR AddUpPairGeneric
#include "Core/Statistics/PairKernelsImplementation.h"
