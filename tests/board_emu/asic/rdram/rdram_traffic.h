// Packets for tests of the RDRAM channel.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "asic/rdram/channel.h"

namespace gicube::emu::rdram::test_traffic {

inline Location at(unsigned bank, unsigned row, unsigned column = 0, unsigned device = 0) {
  return {static_cast<std::uint16_t>(device), static_cast<std::uint16_t>(row), static_cast<std::uint8_t>(bank),
          static_cast<std::uint8_t>(column)};
}

inline v1::RdramConfig without_refresh() {
  v1::RdramConfig config;
  config.set_refresh_interval(0);
  return config;
}

// When the data of random packets begin: reads and writes, in bursts and after pauses, few rows so that some are open.
inline std::vector<Tcycle> random_traffic(Channel& channel, unsigned devices, int packets, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&random](unsigned limit) { return static_cast<unsigned>(random() % limit); };
  std::vector<Tcycle> begins;
  Tcycle now = 0;
  while (packets > 0) {
    if (draw(8) == 0) now += draw(200);
    if (draw(400) == 0) now += 10'000;
    if (begins.size() > 32) now = std::max(now, begins[begins.size() - 32]);
    const bool write = draw(3) == 0;
    const Location first = at(draw(32), draw(3), draw(64), draw(devices));
    for (unsigned n = draw(4); n-- > 0 && packets > 0; --packets) {
      begins.push_back((write ? channel.write(first, now) : channel.read(first, now)).data_begin);
      now += draw(2) * 4;
    }
  }
  return begins;
}

}  // namespace gicube::emu::rdram::test_traffic
