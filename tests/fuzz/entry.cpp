// libFuzzer's entry for one target. What leaves the target as an exception ends the program: that is the finding.
#include <cstddef>
#include <cstdint>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gicube::fuzz::GICUBE_FUZZ_TARGET({data, size});
  return 0;
}
