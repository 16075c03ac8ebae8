// The host bus as its closed forms see it [H1101-H1110], written out apart from the board's
// own code.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gicube::bandwidth {

inline constexpr double kDwordsPerRay = 8;        // 32 bytes, each way
inline constexpr double kDspPsPerRay = 80'000;    // 16 DSP cycles of 5 ns, there and back
inline constexpr double kDspPsPerBatch = 70'000;  // 14, to begin with the loop

// The longest burst of one direction.
struct Burst {
  double dwords = 0;
  double clocks = 0;

  double clocks_per_dword() const { return clocks / dwords; }
};

struct BusForm {
  double clock_ps = 0;
  double agp_rate = 0;  // dwords a clock on the way down; 0: PCI writes both ways
  Burst down, up;       // of a transfer that has the bus for itself
  // While both directions ask they take turns of one burst, and the latency timer ends it at 64 clocks.
  Burst down_shared, up_shared;

  double down_clocks(double dwords) const { return agp_rate == 0 ? dwords + 3 : std::ceil(dwords / agp_rate) + 2; }
  double up_clocks(double dwords) const { return dwords + 3; }

  // A whole transfer in bursts of at most `longest`: picoseconds.
  double down_ps(double dwords, const Burst& longest) const {
    const double whole = std::floor(dwords / longest.dwords), rest = dwords - whole * longest.dwords;
    return (whole * longest.clocks + (rest > 0 ? down_clocks(rest) : 0)) * clock_ps;
  }
  double up_ps(double dwords, const Burst& longest) const {
    const double whole = std::floor(dwords / longest.dwords), rest = dwords - whole * longest.dwords;
    return (whole * longest.clocks + (rest > 0 ? up_clocks(rest) : 0)) * clock_ps;
  }
};

inline BusForm bus_form(const std::string& name) {
  // PCI: a burst of n dwords takes n + 3 clocks; 256 dwords, or as many as 64 clocks hold.
  const Burst pci{256, 259}, pci_shared{61, 64};
  if (name == "pci33") return {30'000, 0, pci, pci, pci_shared, pci_shared};
  // AGP: requests of up to 64 dwords take n / rate + 2 clocks down; what goes up runs as on PCI, at the AGP clock.
  if (name == "agp1x") return {15'000, 1, {64, 66}, pci, {62, 64}, pci_shared};
  if (name == "agp2x") return {15'000, 2, {64, 34}, pci, {64, 34}, pci_shared};
  if (name == "agp4x") return {15'000, 4, {64, 18}, pci, {64, 18}, pci_shared};
  throw std::invalid_argument("bus: expected pci33, agp1x, agp2x or agp4x, got " + name);
}

// Rays down and the same number up again, which saturate the bus; the first ray is ready to go up `lead_ps` after the
// first one has begun to come down.
//
//   time ──────────────────────────────────────────────────>
//   down  [alone, lead][ shared                  ]
//   up                 [ shared                  ][ alone ]
//
// For `lead_ps` the way down has the bus for itself and brings a = lead / c_d dwords, c_d the time of one alone. The
// D - a dwords that are left take turns with the way up: bursts of s_d dwords down and s_u up, together t long, so they
// take (D - a) t / s_d, in which (D - a) s_u / s_d dwords go up. What is then left of them goes up alone at c_u each.
inline double flooded_ps(const BusForm& bus, double dwords, double lead_ps) {
  const double alone_down = bus.down.clocks_per_dword() * bus.clock_ps;
  const double alone_up = bus.up.clocks_per_dword() * bus.clock_ps;
  const double turn = (bus.down_shared.clocks + bus.up_shared.clocks) * bus.clock_ps;
  const double shared_down = dwords - lead_ps / alone_down;
  const double shared_up = std::min(dwords, shared_down * bus.up_shared.dwords / bus.down_shared.dwords);
  return lead_ps + shared_down / bus.down_shared.dwords * turn + (dwords - shared_up) * alone_up;
}

}  // namespace gicube::bandwidth
