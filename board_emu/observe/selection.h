// Selects the events that an observer receives, by ray, part and cycle.
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
  // Rays of one pixel, rays with numbers in a range, or rays that meet both conditions. No rays if neither is set.
  std::optional<std::array<std::uint16_t, 2>> pixel{};
  std::optional<RayRange> rays{};
  std::optional<std::array<std::uint16_t, 2>> life{};  // pixel whose rays are written with their values, at every level
  CycleWindow cycles{};
  std::uint32_t steps = ~std::uint32_t{0};  // one bit per RayStep
  Cycle counters_every = 0;                 // interval; 0: no counters

  bool has(std::uint64_t ray, const wire::Ray& made) const {
    if (!pixel && !rays) return false;
    if (pixel && ((*pixel)[0] != made.u >> 4 || (*pixel)[1] != made.v >> 4)) return false;
    return !rays || (ray >= rays->begin && ray < rays->end);
  }
  bool has(const RayEvent& event) const {
    return (steps >> static_cast<unsigned>(event.step) & 1) != 0 && cycles.has(event.cycle);
  }
};

// Parses items separated by commas: pixel=X:Y, life=X:Y (which implies pixel=X:Y), rays=BEGIN:END, cycles=BEGIN:END,
// parts=PART+PART with the parts dsp, sorter, pipeline and links, and counters=CYCLES. END is exclusive. Throws
// std::invalid_argument, "... expected ..., got ...".
Selection parse_selection(std::string_view text);

// Parses "BEGIN:END" with BEGIN < END. Returns nothing for any other text.
std::optional<CycleWindow> parse_window(std::string_view text);

}  // namespace gicube::emu
