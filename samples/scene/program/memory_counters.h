// Under which name the board counts what its memories do.
#pragma once

#include <cctype>
#include <string>

#include "gicube/counters.h"

namespace gicube::samples {

// The memory's standard, as "rdram" or "ddr": the sums over all channels are "rdram.reads" and so on, those of channel 0
// "rdram0.reads". Empty if the board counts none.
inline std::string memory_of(const Counters& counters) {
  const std::string end = ".data_busy";
  for (const Counter& counter : counters.list()) {
    if (!counter.name.ends_with(end)) continue;
    const std::string name = counter.name.substr(0, counter.name.size() - end.size());
    if (!name.empty() && std::isdigit(static_cast<unsigned char>(name.back())) == 0) return name;
  }
  return {};
}

}  // namespace gicube::samples
