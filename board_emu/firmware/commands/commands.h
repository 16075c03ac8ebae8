// The DSP's firmware: runs its commands, and takes what changes the card between them.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "card.h"
#include "each_command.h"
#include "memory_errors.h"

namespace gicube::emu {

class DspCommands {
 public:
  // All parameters must outlive this object.
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level);

  CommandResult run(Payload payload, Progress& work);

  // See Board::add_memory_error().
  void add_memory_error(const MemoryError& error) { memory_errors_.add(error); }

  // Called after a write to a register. A new volume size discards the volume.
  Acceptance accept_register(std::uint32_t offset);
  // Nothing is written unless the result is kTaken.
  Acceptance write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes) {
    return card_.write_memory(address, bytes);
  }
  void clear_volume() { card_.clear_volume(); }
  void drop_blocks();
  // Returns false if the volume has no such block.
  bool drop_block(std::uint32_t block);
  void drop_rays() { card_.drop_rays(); }
  void clear_irradiance();
  void clear_accumulators();
  void reset();

  // Limits the host memory of volume, words and image. Allocations are checked in advance: register and memory writes
  // are refused, commands end with an error, and nothing else has changed.
  void set_max_memory(std::uint64_t bytes) { card_.limit.set(bytes); }
  const MemoryLimit& memory_limit() const { return card_.limit; }
  std::uint64_t limited_memory() const { return card_.limited_memory(); }

  // Routines for materials that trap; null: none. Must outlive this object.
  void set_routines(const Routines* routines) { card_.routines = routines; }
  // Minor protocol version of the host.
  void set_minor_version(std::uint16_t minor) { card_.minor_version = minor; }

  // Reports the rays of this pixel for each following image.
  void set_explained(ExplainedPixel pixel) { render_.set_explained(std::move(pixel)); }

  Aperture& aperture() { return card_.aperture; }
  void count(std::vector<wire::Counter>& list) const;
  MachineLook look() const { return card_.level.look(); }
  // The state except for the level's. When loading, `registers` must already be restored.
  void state(Archive& archive);

 private:
  Acceptance range_of(std::uint32_t offset) const;

  Card card_;
  MemoryErrors memory_errors_{card_};
  RenderImage render_{card_};
  TraceRays trace_{card_};
  IlluminateVolume illuminate_{card_};
  ResumeRays resume_{card_};
  VerifyBlocks verify_{card_};
  TracePairs pairs_{card_};
  ContinueRays continue_{card_};
  TakeRays take_rays_{card_};
  GiveRays give_rays_{card_};
  LoadCoarse load_coarse_{card_};
};

}  // namespace gicube::emu
