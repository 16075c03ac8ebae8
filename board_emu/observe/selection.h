// Which events an observer is told: of which rays, of which parts, in which cycles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "asic/sim/ray_event.h"
#include "cycle/observer.h"
#include "gicube/wire/ray.h"
#include "levels/ray_source.h"

namespace gicube::emu {

struct Selection {
  // Rays: of one pixel, of numbers in a range, or both; neither: none.
  std::optional<std::array<std::uint16_t, 2>> pixel{};
  std::optional<RayRange> rays{};
  std::optional<std::array<std::uint16_t, 2>> life{};  // of this pixel's rays, with their values at every level
  CycleWindow cycles{};
  std::uint32_t steps = ~std::uint32_t{0};  // a bit for each RayStep
  Cycle counters_every = 0;                 // 0: no counters

  bool has(std::uint64_t ray, const wire::Ray& made) const {
    if (!pixel && !rays) return false;
    if (pixel && ((*pixel)[0] != made.u >> 4 || (*pixel)[1] != made.v >> 4)) return false;
    return !rays || (ray >= rays->begin && ray < rays->end);
  }
  bool has(const RayEvent& event) const {
    return (steps >> static_cast<unsigned>(event.step) & 1) != 0 && cycles.has(event.cycle);
  }
};

// From items with commas between: pixel=X:Y, life=X:Y (which is pixel=X:Y too), rays=BEGIN:END, cycles=BEGIN:END, parts=PART+PART with the parts dsp, sorter,
// pipeline and links, counters=CYCLES. Ends are left out. Throws std::invalid_argument, "... expected ..., got ...".
Selection parse_selection(std::string_view text);

// "BEGIN:END" with BEGIN < END; nothing if it is not that.
std::optional<CycleWindow> parse_window(std::string_view text);

}  // namespace gicube::emu
