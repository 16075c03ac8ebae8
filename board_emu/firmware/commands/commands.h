// The DSP's commands: checks them, has their rays taken to their ends by the board's fidelity level, and says what they
// cost.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "command_result.h"
#include "datapath/frame.h"
#include "firmware/aperture.h"
#include "firmware/host_traps.h"
#include "firmware/register_file.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/level.h"
#include "memory/memory_error.h"

namespace gicube::emu {

// Sets the frame for rays between two points that gather opacity alone, up to `opacity` (24 bits).
void set_opacity_rays(Frame& frame, std::uint32_t opacity);

class DspCommands {
 public:
  // All must outlive this.
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level);

  CommandResult run(std::span<const std::uint8_t> payload, Progress& work);

  // As Board::add_memory_error().
  void add_memory_error(const MemoryError& error);

  // Called after a write of a register: false if its new value is out of range. A new volume size drops the volume.
  bool accept_register(std::uint32_t offset);
  void clear_volume();
  void clear_irradiance();
  void clear_sums();
  void reset();

  // For materials that trap; null: there is none. Must outlive this.
  void set_routines(const Routines* routines) { routines_ = routines; }

  Aperture& aperture() { return aperture_; }
  void count(std::vector<wire::Counter>& list) const;

 private:
  CommandResult render(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult trace(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult illuminate(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult resume(std::span<const std::uint8_t> payload, Progress& work);
  CommandResult verify(std::span<const std::uint8_t> payload);
  CommandResult pairs(std::span<const std::uint8_t> payload, Progress& work);
  Picoseconds reading_time(std::size_t first, std::size_t count) const;
  CommandResult meet_memory_error();
  static void add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid);
  void add_trap_list(CommandResult& result, std::size_t most);
  Frame frame();
  // The level's answer to a command.
  RunResult run_level(RaySource& rays, const Frame& frame, Progress& work);
  std::span<const float> current_wide_depths();
  std::optional<std::string> material_fault(bool host_answers = true) const;
  bool has_volume() const { return aperture_.volume().block_count() > 0; }

  const v1::BoardConfig& config_;
  const RegisterFile& registers_;
  Level& level_;
  unsigned threads_;
  OpacityCorrection opacity_correction_;
  Aperture aperture_;
  std::vector<float> wide_depths_;                    // of the segmentation LUT, on the wide datapath
  std::uint64_t wide_depths_of_ = ~std::uint64_t{0};  // Aperture::segmentation_writes()
  const Routines* routines_ = nullptr;
  HostTraps host_traps_;
  std::deque<MemoryError> memory_errors_;  // detected ones that no command has met yet
  std::vector<wire::Ray> host_ray_room_;   // of the command in work
  std::uint64_t level_volume_ = 0;         // Aperture::volume_writes() that the level knows of
  std::array<std::uint64_t, v1::FidelityLevel_ARRAYSIZE> answered_{};  // commands, by the level that answered them
  std::uint64_t viewing_rays_ = 0;
  std::uint64_t host_rays_ = 0;
  std::uint64_t lighting_rays_ = 0;
  std::uint64_t pair_rays_ = 0;
  std::uint64_t host_traps_total_ = 0;
};

}  // namespace gicube::emu
