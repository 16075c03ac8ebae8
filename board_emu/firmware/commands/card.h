// The card behind the bus: the DSP's memory, what its commands share, and their execution on a fidelity level.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/host_traps.h"
#include "datapath/ray_interval.h"
#include "datapath/waiting_rays.h"
#include "firmware/aperture.h"
#include "firmware/lamps.h"
#include "firmware/pixel_life.h"
#include "firmware/register_file.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/registers.h"
#include "levels/level.h"
#include "words/clock.h"
#include "words/words.h"

namespace gicube::emu {

using Payload = std::span<const std::uint8_t>;

// Result and cost of a command.
struct CommandResult {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::vector<std::uint8_t> payload{};  // of the completion; after an error: its text
  std::uint64_t dsp_cycles = 0;
  Picoseconds asic_ps = 0;     // working time of the ASIC; 0 at the functional level
  std::uint64_t up_bytes = 4;  // at least the completion word in the host's memory
  bool takes_rays = false;
  bool returns_rays = false;
  bool leaves_nothing = false;  // except its completion, so it may be undone
};

// Result of a posted write.
enum class Acceptance { kTaken, kOutOfRange, kTooMuchMemory };

class MemoryLimit {
 public:
  void set(std::uint64_t bytes) { max_ = bytes; }
  bool is_set() const { return max_ != kNone; }
  std::uint64_t max() const { return max_; }
  std::uint32_t max_mib() const {
    constexpr std::uint32_t kNoLimit = ~std::uint32_t{0};
    return is_set() ? static_cast<std::uint32_t>(std::min<std::uint64_t>(max_ >> 20, kNoLimit - 1)) : kNoLimit;
  }
  bool fits(std::uint64_t bytes) {
    if (bytes <= max_) return true;
    asked = bytes;
    return false;
  }
  std::uint32_t asked_mib() const { return static_cast<std::uint32_t>((asked + (1 << 20) - 1) >> 20); }

  std::uint64_t asked = 0;  // bytes that would have been needed for the last refused request

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t max_ = kNone;
};

// Tables that follow from the segmentation LUT, made when they are first needed after it was written.
class SegmentationTables {
 public:
  std::span<const float> wide_depths(const Aperture& aperture);  // wide datapath
  const DepthTable& depths(const Aperture& aperture);            // for lighting rays
  void clear() { wide_depths_of_ = depths_of_ = ~std::uint64_t{0}; }

 private:
  std::vector<float> wide_depths_;
  std::optional<DepthTable> depths_;
  std::uint64_t wide_depths_of_ = ~std::uint64_t{0}, depths_of_ = ~std::uint64_t{0};  // Aperture::segmentation_writes()
};

struct Card {
  // All parameters must outlive this object.
  Card(const v1::BoardConfig& board_config, const RegisterFile& board_registers, Level& its_level);

  CommandResult run(Payload payload, Progress& work);

  // See Board::add_memory_error().
  void add_memory_error(const MemoryError& error);
  // Called after a write to a register. A new volume size discards the volume.
  Acceptance accept_register(std::uint32_t offset);
  // Nothing is written unless the result is kTaken.
  Acceptance write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes);
  void clear_volume();
  void drop_blocks();
  // Returns false if the volume has no such block.
  bool drop_block(std::uint32_t block);
  void drop_rays();
  void clear_irradiance();
  void clear_accumulators();
  void reset();

  // Host memory that counts towards the limit; 0 without a limit.
  std::uint64_t limited_memory() const {
    return limit.is_set() ? aperture.volume_bytes() + aperture.image_bytes() + words_bytes + rays_bytes() : 0;
  }
  void count(std::vector<wire::Counter>& list) const;
  // The state except for the level's. When loading, `registers` must already be restored.
  void state(Archive& archive);

  // The following functions are for commands.

  // Blocks that the card can store.
  std::uint64_t capacity_blocks() const;
  // The card does not store the whole volume, or BRICKS is set.
  bool in_bricks() const {
    return registers.value(wire::reg::kBricks) != 0 || aperture.volume().block_count() > capacity_blocks();
  }
  // Throws CommandFault if there is not enough memory for the data that the frame's rays read and write, and for the
  // image.
  void expect_memory(const Frame& frame, std::uint64_t pixels = 0);

  // These throw CommandFault if there is no volume, if a block is non-resident, or if a material is invalid.
  void check_volume() const;
  void check_all_there() const;
  void check_materials(bool host_answers = true) const;

  // The frame of viewing rays; of host rays; of the commands whose rays wait.
  Frame frame();
  Frame trace_frame(const wire::TraceHeader& header);
  Frame continued_frame();
  void set_light(Frame& frame, wire::EnergyRules rules);
  void set_bricks(Frame& frame);

  // `cycles` of the DSP, or 0 if it is ideal.
  std::uint64_t dsp_cycles(std::uint64_t cycles) const { return config.ideal().dsp() != 0 ? 0 : cycles; }
  // Runs the level. Throws CommandFault if the command was cancelled.
  RunResult run_level(RaySource& rays, const Frame& frame, Progress& work);

  void add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid) const;
  void add_trap_list(CommandResult& result, std::size_t max_rays);
  void add_waiting(CommandResult& result);

  const v1::BoardConfig& config;
  const RegisterFile& registers;
  Level& level;
  unsigned threads;
  OpacityCorrection opacity_correction;
  Aperture aperture;
  SegmentationTables tables;
  // Limits the host memory of volume, words and image. Allocations are checked in advance: register and memory writes
  // are refused, commands end with an error, and nothing else has changed.
  MemoryLimit limit;
  std::uint64_t words_bytes = 0;                      // bytes of irradiance and accumulators, upper limit
  const Routines* routines = nullptr;                 // for materials that trap; null: none. Must outlive the card
  std::uint16_t minor_version = wire::kMinorVersion;  // of the host's protocol
  std::optional<ExplainedPixel> explained;            // its rays are reported for each image
  std::deque<MemoryError> memory_errors;              // detected, and not yet reported by a command
  HostTraps host_traps;
  Lamps lamps;  // of the last image
  WaitingRays waiting_rays;
  std::vector<wire::Ray> host_ray_room;  // rays of the current trace command
  std::uint64_t level_volume = 0;        // Aperture::volume_writes() at the level's last update
  std::size_t opcode = 0;                // of the current command
  bool goes_on = false;  // the command resumes from a checkpoint: changes made before its rays are already done

  // Number of commands, by answering level and opcode.
  std::array<std::array<std::uint64_t, wire::kOpcodeNames.size()>, v1::FidelityLevel_ARRAYSIZE> answered{};
  std::uint64_t viewing_rays = 0, host_rays = 0, lighting_rays = 0, pair_rays = 0;
  std::uint64_t host_traps_total = 0;
  std::uint64_t waits_total = 0;  // rays that began to wait for a block
  // Blocks sent to a card that does not store the whole volume. The second counts those for which rays of an image, a
  // light or a series of trace commands waited, each once.
  std::uint64_t block_loads = 0, min_block_loads = 0;
  std::uint64_t host_deposits_total = 0;               // voxels of deposits for the host, each once per command
  std::uint64_t forwarded_rays = 0, arrived_rays = 0;  // sent from the card to others, and from others to it

 private:
  [[noreturn]] void report_memory_error();
  Acceptance range_of(std::uint32_t offset) const;
  std::uint64_t rays_bytes() const { return waiting_rays.memory_bytes() + aperture.host_rays_bytes(); }
  bool has_room(std::uint64_t address, std::uint64_t length);
  std::uint64_t stored_words();            // bytes of irradiance and accumulators
  std::array<int, 3> volume_size() const;  // 0 on all axes until all are set
  void set_irradiance_at_host(Frame& frame);
};

}  // namespace gicube::emu
