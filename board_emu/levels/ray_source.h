// What a command asks of the DSP's ray engine: rays to make, and what to do with those that come back.
#pragma once

#include <cstdint>
#include <optional>

#include "datapath/ray_step.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

class RaySource {
 public:
  virtual ~RaySource() = default;

  virtual std::uint64_t count() const = 0;
  // Makes ray `i`; nothing if it misses the volume, and then it is dealt with already. Called once for each, in order.
  virtual std::optional<wire::Ray> make(std::uint64_t i) = 0;
  // A ray that is not made has cost the DSP nothing: it passes over whole faces that the light does not reach.
  virtual bool misses_are_free() const { return false; }
  // Takes ray `i` back. Called once for each ray that was made.
  virtual void take(std::uint64_t i, const RayState& ray) = 0;

  // DSP cycles of each.
  virtual std::uint32_t make_cycles() const = 0;
  virtual std::uint32_t take_cycles() const = 0;
  // Rays i .. row_end(i) - 1 lie in one row of the image: one differential leads from each to the next [P §3.6].
  virtual std::uint64_t row_end(std::uint64_t i) const = 0;
};

}  // namespace gicube::emu
