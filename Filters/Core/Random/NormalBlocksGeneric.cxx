// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_FILL_BLOCKS FillNormalBlocksGeneric
#include "Core/Random/NormalBlocksImplementation.h"
