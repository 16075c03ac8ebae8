// libFuzzer's entry for one target. What leaves the target as an exception ends the program: that is the finding.
#include <cstddef>
#include <cstdint>

#include "targets.h"

#ifndef GICUBE_FUZZ_TARGET
#define GICUBE_FUZZ_TARGET board  // the build names each program's; this is for tools that read the file alone
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gicube::fuzz::GICUBE_FUZZ_TARGET({data, size});
  return 0;
}
