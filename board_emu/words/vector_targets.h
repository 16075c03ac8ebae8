// Selects the instruction sets of Highway that are compiled. Records here contain vectors, so these must have a fixed
// size: NEON qualifies, SVE and RVV do not. Processors of x86 without SSE 4.1, made before 2008, take the scalar code.
// Include this before any header of Highway.
#pragma once

#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSSE3)
