// Seeds of random tests: all where GICUBE_ALL_SEEDS is set, as script/check and script/mutate do, else a tenth of them,
// but at least four. A failure names its seed.
#pragma once

#include "test.h"

namespace gicube {

// From 1 to `count`.
inline auto seeds(unsigned count) {
  const bool all = std::getenv("GICUBE_ALL_SEEDS") != nullptr;
  return testing::Range(1u, 1 + (all ? count : std::min(count, std::max(4u, count / 10))));
}

}  // namespace gicube
