// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_FILL_BLOCKS FillNormalBlocksAvx2
#include "Core/Random/NormalBlocksImplementation.h"
