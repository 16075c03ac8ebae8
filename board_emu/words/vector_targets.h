// Which of Highway's instruction sets are compiled: those whose vectors have a size, since vectors stand in records here. So
// NEON, but not SVE and RVV. Included before any of Highway's headers.
#pragma once

#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
