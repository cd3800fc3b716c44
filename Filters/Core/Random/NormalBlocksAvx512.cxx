// SPDX-License-Identifier: BSD-3-Clause
#define SURFSYNTH_FILL_BLOCKS FillNormalBlocksAvx512
#include "Core/Random/NormalBlocksImplementation.h"
