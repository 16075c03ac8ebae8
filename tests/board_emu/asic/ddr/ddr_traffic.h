// Packets for tests of the DDR channel.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "asic/ddr/channel.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::ddr::test_traffic {

inline Location at(unsigned bank, unsigned row, unsigned column = 0, unsigned rank = 0) {
  return {static_cast<std::uint16_t>(rank), static_cast<std::uint16_t>(row), static_cast<std::uint8_t>(bank),
          static_cast<std::uint16_t>(column)};
}

inline v1::DdrConfig without_refresh() {
  v1::DdrConfig config;
  config.set_refresh_interval(0);
  return config;
}

// When the data of random packets begin: reads and writes, in bursts and after pauses, few rows so that some are open.
inline std::vector<Tcycle> random_traffic(Channel& channel, unsigned ranks, int packets, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&random](unsigned limit) { return static_cast<unsigned>(random() % limit); };
  std::vector<Tcycle> begins;
  Tcycle now = 0;
  while (packets > 0) {
    if (draw(8) == 0) now += draw(50);
    if (draw(400) == 0) now += 5'000;
    if (begins.size() > 32) now = std::max(now, begins[begins.size() - 32]);
    const bool write = draw(3) == 0;
    const Location first = at(draw(4), draw(3), draw(512), draw(ranks));
    for (unsigned n = draw(4); n-- > 0 && packets > 0; --packets) {
      begins.push_back((write ? channel.write(first, now) : channel.read(first, now)).data_begin);
      now += draw(2);
    }
  }
  return begins;
}

}  // namespace gicube::emu::ddr::test_traffic
