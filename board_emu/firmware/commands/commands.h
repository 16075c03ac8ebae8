// The DSP's commands: checks them, has their rays traced by the board's fidelity level, and reports their cost.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/ray_interval.h"
#include "firmware/aperture.h"
#include "firmware/bricks/waiting_rays.h"
#include "firmware/host_traps.h"
#include "firmware/lamps.h"
#include "firmware/pixel_life.h"
#include "firmware/register_file.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/forwarded_ray.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/registers.h"
#include "levels/level.h"
#include "words/clock.h"

namespace gicube::emu {

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

// Throws CommandFault with the faulty field's name. Does not check `count`.
void check_trace_header(const wire::TraceHeader& header);

// Configures the frame for rays between two points that gather only opacity, up to `opacity` (24 bits).
void set_opacity_rays(Frame& frame, std::uint32_t opacity);

class DspCommands {
 public:
  // All parameters must outlive this object.
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level);

  CommandResult run(std::span<const std::uint8_t> payload, Progress& work);

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

  // Limits the host memory of volume, words and image. Allocations are checked in advance: register and memory writes
  // are refused, commands end with an error, and nothing else has changed.
  void set_max_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }
  // Memory that counts towards the limit; 0 without a limit.
  std::uint64_t limited_memory() const {
    return is_limited() ? aperture_.volume_bytes() + aperture_.image_bytes() + words_bytes_ + rays_bytes() : 0;
  }
  std::uint32_t max_memory_mib() const;
  // Memory that would have been needed for the last refused request.
  std::uint32_t memory_asked_mib() const;

  // Routines for materials that trap; null: none. Must outlive this object.
  void set_routines(const Routines* routines) { routines_ = routines; }
  // Minor protocol version of the host.
  void set_minor_version(std::uint16_t minor) { minor_version_ = minor; }

  // Reports the rays of this pixel for each following image.
  void set_explained(ExplainedPixel pixel) { explained_ = std::move(pixel); }

  Aperture& aperture() { return aperture_; }
  void count(std::vector<wire::Counter>& list) const;
  MachineLook look() const { return level_.look(); }
  // The state except for the level's. When loading, `registers` must already be restored.
  void state(Archive& archive);

 private:
  CommandResult render(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult trace(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult illuminate(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult resume(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult verify(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult pairs(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult continue_rays(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult take_rays(std::span<const std::uint8_t> payload);
  CommandResult give_rays(std::span<const std::uint8_t> payload);
  CommandResult load_coarse(std::span<const std::uint8_t> payload);
  void begin_given(const wire::GiveRaysHeader& header);
  Acceptance range_of(std::uint32_t offset) const;
  Picoseconds reading_time(std::size_t first, std::size_t count) const;
  [[noreturn]] void meet_memory_error();
  void add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid) const;
  void add_trap_list(CommandResult& result, std::size_t max_rays);
  std::uint64_t capacity_blocks() const;  // blocks that the card can store
  bool in_bricks() const {
    return registers_.value(wire::reg::kBricks) != 0 || aperture_.volume().block_count() > capacity_blocks();
  }  // the card does not store the whole volume, or BRICKS is set
  void set_bricks(Frame& frame);
  void set_irradiance_at_host(Frame& frame);
  Frame continued_frame();
  void add_waiting(CommandResult& result);
  bool is_limited() const { return max_memory_bytes_ != kUnlimited; }
  bool fits(std::uint64_t bytes);
  bool has_room(std::uint64_t address, std::uint64_t length);
  std::uint64_t stored_words();  // bytes of irradiance and accumulators
  std::uint64_t rays_bytes() const { return waiting_rays_.memory_bytes() + aperture_.host_rays_bytes(); }
  // Throws CommandFault if there is not enough memory for the data that the frame's rays read and write, and for the
  // image.
  void expect_memory(const Frame& frame, std::uint64_t pixels = 0);
  std::array<int, 3> volume_size() const;  // 0 on all axes until all are set
  Frame frame();
  Frame trace_frame(const wire::TraceHeader& header);
  std::span<wire::Ray> take_in(const wire::TraceHeader& header, std::span<wire::Ray> rays);
  void set_light(Frame& frame, wire::EnergyRules rules);
  // Reports the rays of the pixel in explained_, for an image that is in the framebuffer.
  void explain(const wire::RenderCommand& command, const Frame& frame);
  void follow_pixel(const wire::RenderCommand& command, const Frame& frame, PixelLife& life);
  // Runs the level. Throws CommandFault if the command was cancelled.
  RunResult run_level(RaySource& rays, const Frame& frame, Progress& work);
  std::span<const float> current_wide_depths();
  // These throw CommandFault if there is no volume, if a block is non-resident, or if a material is invalid.
  void check_volume() const;
  void check_all_there() const;
  void check_materials(bool host_answers = true) const;

  static constexpr std::uint64_t kUnlimited = ~std::uint64_t{0};
  static constexpr std::size_t kOpcodes = wire::kOpcodeNames.size();

  const v1::BoardConfig& config_;
  const RegisterFile& registers_;
  Level& level_;
  unsigned threads_;
  OpacityCorrection opacity_correction_;
  Aperture aperture_;
  std::vector<float> wide_depths_;                    // opacity depths of the segmentation LUT, wide datapath
  std::uint64_t wide_depths_of_ = ~std::uint64_t{0};  // Aperture::segmentation_writes() at the time of wide_depths_
  std::optional<DepthTable> depths_;                  // the depths for lighting rays
  std::uint64_t depths_of_ = 0;
  std::uint64_t max_memory_bytes_ = kUnlimited;
  std::uint64_t memory_asked_bytes_ = 0;
  std::uint64_t words_bytes_ = 0;  // bytes of irradiance and accumulators, upper limit
  const Routines* routines_ = nullptr;
  std::uint16_t minor_version_ = wire::kMinorVersion;
  HostTraps host_traps_;
  Lamps lamps_;  // of the last image
  WaitingRays waiting_rays_;
  std::optional<ExplainedPixel> explained_;
  std::deque<MemoryError> memory_errors_;  // detected errors that no command has reported yet
  std::vector<wire::Ray> host_ray_room_;   // rays of the current command
  std::uint64_t level_volume_ = 0;         // Aperture::volume_writes() at the level's last update
  // Number of commands, by answering level and opcode.
  std::array<std::array<std::uint64_t, kOpcodes>, v1::FidelityLevel_ARRAYSIZE> answered_{};
  std::size_t opcode_ = 0;  // of the current command
  bool goes_on_ = false;    // the command resumes from a checkpoint: changes made before its rays are already done
  std::uint64_t viewing_rays_ = 0;
  std::uint64_t host_rays_ = 0;
  std::uint64_t lighting_rays_ = 0;
  std::uint64_t pair_rays_ = 0;
  std::uint64_t host_traps_total_ = 0;
  std::uint64_t waits_total_ = 0;  // rays that began to wait for a block
  // Blocks sent to a card that does not store the whole volume. The second counts those for which rays of an image, a
  // light or a series of trace commands waited, each once.
  std::uint64_t block_loads_ = 0, min_block_loads_ = 0;
  std::uint64_t host_deposits_total_ = 0;                // voxels of deposits for the host, each once per command
  std::uint64_t forwarded_rays_ = 0, arrived_rays_ = 0;  // sent from the card, and to it
};

}  // namespace gicube::emu
