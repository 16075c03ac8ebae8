// Closed forms of the host bus: how long one burst of dwords holds it.
//
// PCI, 33 1/3 MHz, 32 bit: a write burst of n dwords takes n + 3 clocks, a read n + 3 + L (address, turnaround, target
// latency). A burst is at most `max_burst_dwords` long, and at most `latency_timer_clocks` once somebody else asks.
// AGP: the card reads host memory in pipelined requests of up to 64 dwords (256 bytes, AGP 2.0's long read), each
// ceil(n / rate) + 2 clocks of 66 2/3 MHz: half the peak at 16 bytes and 80% at 64 bytes on 2x. What it writes to the
// host runs as PCI writes at the AGP clock, and so do register accesses (docs/reference/hardware.md, host bus).
#pragma once

#include <algorithm>
#include <cstdint>

#include "gicube/v1/board_config.pb.h"
#include "words/clock.h"

namespace gicube::emu {

enum class Direction : std::uint8_t { kDown, kUp };  // to the board, to the host

enum class TransferKind : std::uint8_t {
  kBulk,           // memory writes and commands down, results and images up
  kRegisterWrite,  // a processor's write of a few dwords
  kRegisterRead,   // the round trip of a processor's read
};

inline constexpr std::uint32_t kPciOverheadClocks = 3;
inline constexpr std::uint32_t kAgpRequestDwords = 64;
inline constexpr std::uint32_t kAgpRequestOverheadClocks = 2;  // chosen: meets 50-80% of peak on short reads
inline constexpr Picoseconds kPciClockPs = 30'000;             // 33 1/3 MHz
inline constexpr Picoseconds kAgpClockPs = 15'000;             // 66 2/3 MHz

struct BusTiming {
  Picoseconds clock_ps = kPciClockPs;
  std::uint32_t agp_rate = 0;  // dwords a clock of an AGP read: 1, 2, 4; 0 on PCI
  std::uint32_t max_burst_dwords = 256;
  std::uint32_t latency_timer_clocks = 64;
  std::uint32_t read_latency_clocks = 8;

  explicit BusTiming(const v1::BusConfig& config)
      : max_burst_dwords(config.max_burst_dwords()),
        latency_timer_clocks(config.latency_timer_clocks()),
        read_latency_clocks(config.read_latency_clocks()) {
    switch (config.model()) {
      case v1::agp1x: agp_rate = 1; break;
      case v1::agp2x: agp_rate = 2; break;
      case v1::agp4x: agp_rate = 4; break;
      default: break;
    }
    if (agp_rate != 0) clock_ps = kAgpClockPs;
  }

  bool agp_read(Direction direction, TransferKind kind) const {
    return agp_rate != 0 && direction == Direction::kDown && kind == TransferKind::kBulk;
  }

  // The longest burst of that kind when nobody else asks for the bus.
  std::uint32_t longest_burst(Direction direction, TransferKind kind) const {
    return agp_read(direction, kind) ? std::min(kAgpRequestDwords, max_burst_dwords) : max_burst_dwords;
  }

  std::uint32_t burst_clocks(Direction direction, TransferKind kind, std::uint32_t dwords) const {
    if (agp_read(direction, kind)) return (dwords + agp_rate - 1) / agp_rate + kAgpRequestOverheadClocks;
    const std::uint32_t latency = kind == TransferKind::kRegisterRead ? read_latency_clocks : 0;
    return dwords + kPciOverheadClocks + latency;
  }

  // How many dwords fit into a burst of at most `clocks`; at least one, as a granted burst moves something.
  std::uint32_t dwords_within(Direction direction, TransferKind kind, std::uint64_t clocks) const {
    const std::uint64_t overhead = burst_clocks(direction, kind, 1) - 1;
    const std::uint64_t data_clocks = clocks > overhead ? clocks - overhead : 1;
    const std::uint64_t dwords = agp_read(direction, kind) ? data_clocks * agp_rate : data_clocks;
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(dwords, longest_burst(direction, kind)));
  }
};

}  // namespace gicube::emu
