#include "scene/program/bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

namespace gicube::samples {
namespace {

// Causes of the pipelines' cycles (docs/reference/counters.md), and the part of the board that limits each.
struct Cause {
  const char* part;
  const char* does;
  std::vector<std::string_view> counters;
};
const std::array<Cause, 8>& causes() {
  static const std::array<Cause, 8> kAll{{
      {"the pipelines", "take samples", {"busy"}},
      {"the pipelines", "skip empty blocks", {"leap"}},
      {"rays in flight", "wait for rays that are in the pipeline", {"latency", "sorter"}},
      {"idle processors", "have no ray, as others have them", {"queue_empty"}},
      {"the links", "wait for links", {"link"}},
      {"the DSP", "wait for rays of the DSP", {"dsp_compute", "sdram", "ray_bus"}},
      {"the caches", "wait for the cache", {"cache_fill", "cache_miss", "splat"}},
      {"the memory", "wait for memory banks", {"memory_bank", "refresh"}},
  }};
  return kAll;
}

double share(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

}  // namespace

std::string what_bounds(Picoseconds whole, const Counters& counters, const BoardInfo& board, std::size_t boards) {
  if (whole == 0) return "";
  const auto value = [&](const std::string& name) { return static_cast<double>(counters.value(name)); };
  const double all = static_cast<double>(whole) * static_cast<double>(std::max<std::size_t>(boards, 1));
  const double bus = share(value("bus.down.busy_ps") + value("bus.up.busy_ps"), all);
  const double dsp = share(value("dsp.busy_ps"), all);
  const double asic = share(value("asic.cycles") * 1e9 / std::max<double>(board.core_khz, 1), all);
  std::vector<std::pair<double, const Cause*>> shares;
  double cycles = 0;
  for (const Cause& cause : causes()) {
    double sum = 0;
    for (const std::string_view name : cause.counters) sum += value("processor.cycles." + std::string(name));
    shares.emplace_back(sum, &cause);
    cycles += sum;
  }
  if (cycles == 0) {
    return bus >= dsp
               ? fmt::format("bounded by the host bus, busy {:.0f}% of the time; the ASIC has no time at this level",
                             bus)
               : fmt::format("bounded by the DSP, busy {:.0f}% of the time; the ASIC has no time at this level", dsp);
  }
  std::ranges::stable_sort(shares, std::greater<>(), [](const auto& each) { return each.first; });
  const auto& [first, cause] = shares[0];
  const auto& [second, other] = shares[1];
  const std::string pipelines = fmt::format("{:.0f}% of the pipelines' cycles {}, {:.0f}% {}", share(first, cycles),
                                            cause->does, share(second, cycles), other->does);
  const std::string times = fmt::format("bus {:.0f}%, ASIC {:.0f}%, DSP {:.0f}% of the time", bus, asic, dsp);
  if (bus > asic) return fmt::format("bounded by the host bus; {}; {}", times, pipelines);
  return fmt::format("bounded by {}: {}; {}", cause->part, pipelines, times);
}

}  // namespace gicube::samples
