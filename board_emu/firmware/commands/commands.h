// The DSP's commands: checks them, has them carried out by the fidelity level of the configuration, and says what they
// cost.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "approximate/pass_machine.h"
#include "board/board.h"
#include "cycle/machine.h"
#include "datapath/frame.h"
#include "firmware/aperture.h"
#include "firmware/host_traps.h"
#include "firmware/register_file.h"
#include "functional/simd/simd_tracer.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

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

// Sets the frame for rays between two points that gather opacity alone, up to `opacity` (24 bits).
void set_opacity_rays(Frame& frame, std::uint32_t opacity);

class DspCommands {
 public:
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers);

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
  // Of every machine from now on; null for none.
  void set_observer(Observer* observer) { observer_ = observer; }

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
  // Of the functional level, for so many rays; null if they go the plain way.
  const SimdTracer* packets(std::uint64_t rays, const Frame& frame);
  std::span<const float> current_wide_depths();
  std::optional<std::string> material_fault(bool host_answers = true) const;
  CommandResult cancelled();
  // Whether this frame's rays take the machine's cycles, or at the approximate level their turns. Neither: no time.
  bool in_cycles(const Frame& frame) const {
    return config_.fidelity() == v1::cycle || (config_.fidelity() == v1::approximate && !in_turns(frame));
  }
  bool in_turns(const Frame& frame) const {
    return config_.fidelity() == v1::approximate && frame.plain && PassMachine::covers(config_);
  }
  PassMachine& pass_machine();
  CommandResult timed(const RunResult& ran) const;
  // `sums`: its caches are to hold the sums' words.
  Machine& machine(bool sums = false);
  void drop_machine();
  bool has_volume() const { return aperture_.volume().block_count() > 0; }

  const v1::BoardConfig& config_;
  const RegisterFile& registers_;
  unsigned threads_;
  OpacityCorrection opacity_correction_;
  SimdTracer packets_{opacity_correction_};
  Aperture aperture_;
  std::vector<float> wide_depths_;                    // of the segmentation LUT, on the wide datapath
  std::uint64_t wide_depths_of_ = ~std::uint64_t{0};  // Aperture::segmentation_writes()
  Observer* observer_ = nullptr;
  const Routines* routines_ = nullptr;
  HostTraps host_traps_;
  std::deque<MemoryError> memory_errors_;      // detected ones that no command has met yet
  std::unique_ptr<Machine> machine_;           // of the cycle level, as long as the volume keeps its size
  std::vector<wire::Ray> host_ray_room_;       // of the command in work
  std::uint64_t cached_volume_ = 0;            // Aperture::volume_writes() that the machine's caches belong to
  std::unique_ptr<PassMachine> pass_machine_;  // of the approximate level, as long
  std::uint64_t turns_volume_ = 0;             // as cached_volume_, of it
  bool cached_sums_ = false;                   // they hold sums, not voxels
  std::vector<wire::Counter> past_;            // counters of machines that were dropped
  RayCounters rays_;                           // of the functional level and of machines that were dropped
  std::uint64_t viewing_rays_ = 0;
  std::uint64_t host_rays_ = 0;
  std::uint64_t lighting_rays_ = 0;
  std::uint64_t pair_rays_ = 0;
  std::uint64_t host_traps_total_ = 0;
};

}  // namespace gicube::emu
