// The DSP's commands: checks them, has their rays taken to their ends by the board's fidelity level, and says what they
// cost.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/ray_part.h"
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

// What a command brought about, and what it costs.
struct CommandResult {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::vector<std::uint8_t> payload{};  // of the completion; with an error: its text
  std::uint64_t dsp_cycles = 0;
  Picoseconds asic_ps = 0;     // how long the ASIC works at it; 0 at the functional level
  std::uint64_t up_bytes = 4;  // at least the completion word in the host's memory
  bool takes_rays = false;
  bool returns_rays = false;
  bool leaves_nothing = false;  // but what it returns: it may be taken back
};

// What became of a posted write.
enum class Acceptance { kTaken, kOutOfRange, kTooMuchMemory };

// Throws CommandFault that names a field, but count.
void check_trace_header(const wire::TraceHeader& header);

// Sets the frame for rays between two points that gather opacity alone, up to `opacity` (24 bits).
void set_opacity_rays(Frame& frame, std::uint32_t opacity);

class DspCommands {
 public:
  // All must outlive this.
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level);

  CommandResult run(std::span<const std::uint8_t> payload, Progress& work);

  // As Board::add_memory_error().
  void add_memory_error(const MemoryError& error);

  // Called after a write of a register. A new volume size drops the volume.
  Acceptance accept_register(std::uint32_t offset);
  // Nothing is written unless it is kTaken.
  Acceptance write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes);
  void clear_volume();
  void drop_blocks();
  // False if the volume has no such block.
  bool drop_block(std::uint32_t block);
  void drop_rays();
  void clear_irradiance();
  void clear_sums();
  void reset();

  // What volume, words and image may take of the host's memory. It is asked for before it is taken: register and memory writes
  // are refused, commands end with an error, and nothing else has changed.
  void set_max_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }
  // What counts towards it; 0 without a limit.
  std::uint64_t limited_memory() const {
    return is_limited() ? aperture_.volume_bytes() + aperture_.image_bytes() + words_bytes_ + rays_bytes() : 0;
  }
  std::uint32_t max_memory_mib() const;
  // What they would have taken together with the last thing that was refused.
  std::uint32_t memory_asked_mib() const;

  // For materials that trap; null: there is none. Must outlive this.
  void set_routines(const Routines* routines) { routines_ = routines; }
  // The minor version that the host speaks.
  void set_minor_version(std::uint16_t minor) { minor_version_ = minor; }

  // From now on the rays of that pixel of each picture are told.
  void set_explained(ExplainedPixel pixel) { explained_ = std::move(pixel); }

  Aperture& aperture() { return aperture_; }
  void count(std::vector<wire::Counter>& list) const;
  MachineLook look() const { return level_.look(); }
  // All but the level; of a checkpoint also what was in `registers`.
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
  std::uint64_t capacity_blocks() const;  // that the card stores
  bool in_bricks() const {
    return registers_.value(wire::reg::kBricks) != 0 || aperture_.volume().block_count() > capacity_blocks();
  }  // it stores not the whole volume, or is told to take it so
  void set_bricks(Frame& frame);
  void set_dark(Frame& frame);
  Frame continued_frame();
  void add_waiting(CommandResult& result);
  bool is_limited() const { return max_memory_bytes_ != kUnlimited; }
  bool fits(std::uint64_t bytes);
  bool has_room(std::uint64_t address, std::uint64_t length);
  std::uint64_t stored_words();  // bytes of irradiance and sums
  std::uint64_t rays_bytes() const { return waiting_rays_.memory_bytes() + aperture_.host_rays_bytes(); }
  // Throws CommandFault if there is no room for what the frame's rays read and leave, and for an image.
  void expect_memory(const Frame& frame, std::uint64_t pixels = 0);
  std::array<int, 3> volume_size() const;  // 0 in every direction until all are set
  Frame frame();
  Frame trace_frame(const wire::TraceHeader& header);
  std::span<wire::Ray> take_in(const wire::TraceHeader& header, std::span<wire::Ray> rays);
  void set_light(Frame& frame, wire::EnergyRules rules);
  // The picture by whole rays, or by their segments.
  RunResult render_rays(const wire::RenderCommand& command, const Frame& frame, Progress& work);
  RunResult render_segments(const wire::RenderCommand& command, Frame& frame, Progress& work);
  // Tells the rays of the pixel that explained_ names, of a picture that is in the framebuffer.
  void explain(const wire::RenderCommand& command, const Frame& frame, bool in_segments);
  void follow_pixel(const wire::RenderCommand& command, const Frame& frame, PixelLife& life);
  // The level's answer to a command. Throws CommandFault if it was cancelled.
  RunResult run_level(RaySource& rays, const Frame& frame, Progress& work);
  std::span<const float> current_wide_depths();
  // Throw CommandFault if there is none, or for what is wrong with what the host wrote.
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
  std::vector<float> wide_depths_;                    // of the segmentation LUT, on the wide datapath
  std::uint64_t wide_depths_of_ = ~std::uint64_t{0};  // Aperture::segmentation_writes()
  std::optional<DepthTable> depths_;                  // the same of the depths, for lighting rays
  std::uint64_t depths_of_ = 0;
  std::uint64_t max_memory_bytes_ = kUnlimited;
  std::uint64_t memory_asked_bytes_ = 0;
  std::uint64_t words_bytes_ = 0;  // of irradiance and sums, at most
  const Routines* routines_ = nullptr;
  std::uint16_t minor_version_ = wire::kMinorVersion;
  HostTraps host_traps_;
  Lamps lamps_;  // of the last image
  WaitingRays waiting_rays_;
  std::optional<ExplainedPixel> explained_;
  std::deque<MemoryError> memory_errors_;  // detected ones that no command has met yet
  std::vector<wire::Ray> host_ray_room_;   // of the command in work
  std::uint64_t level_volume_ = 0;         // Aperture::volume_writes() that the level knows of
  // Commands, by the level that answered them and their opcode.
  std::array<std::array<std::uint64_t, kOpcodes>, v1::FidelityLevel_ARRAYSIZE> answered_{};
  std::size_t opcode_ = 0;  // of the command in work
  bool goes_on_ = false;    // it is a checkpoint's: what it changes before its rays are made is changed
  std::uint64_t viewing_rays_ = 0;
  std::uint64_t host_rays_ = 0;
  std::uint64_t lighting_rays_ = 0;
  std::uint64_t pair_rays_ = 0;
  std::uint64_t host_traps_total_ = 0;
  std::uint64_t waits_total_ = 0;  // rays that came to wait for a block
  // Blocks whose words came to a card that does not store the whole volume; of those, that rays of a picture, a light or a series of
  // trace commands waited for, each once.
  std::uint64_t block_loads_ = 0, min_block_loads_ = 0;
  std::uint64_t host_deposits_total_ = 0;                // voxels of other blocks that got energy, each once a command
  std::uint64_t forwarded_rays_ = 0, arrived_rays_ = 0;  // off the card, and to it
};

}  // namespace gicube::emu
