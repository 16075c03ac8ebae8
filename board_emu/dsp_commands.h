// The DSP's commands at the functional level: checks them, carries them out, and says what they cost.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "aperture.h"
#include "board.h"
#include "bus/register_file.h"
#include "frame.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

struct CommandResult {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::vector<std::uint8_t> payload{};  // of the completion; with an error: its text
  std::uint64_t dsp_cycles = 0;
  std::uint64_t up_bytes = 4;  // at least the completion word in the host's memory
  bool returns_rays = false;
};

class DspCommands {
 public:
  DspCommands(const v1::BoardConfig& config, const RegisterFile& registers);

  CommandResult run(std::span<const std::uint8_t> payload, Work& work);

  // Called after a write of a register: false if its new value is out of range. A new volume size drops the volume.
  bool accept_register(std::uint32_t offset);
  void clear_volume();
  void reset();

  Aperture& aperture() { return aperture_; }
  void count(std::vector<wire::Counter>& list) const;

 private:
  CommandResult render(std::span<const std::uint8_t> payload, Work& work);
  CommandResult trace(std::span<const std::uint8_t> payload);
  Frame frame() const;
  bool has_volume() const { return aperture_.volume().block_count() > 0; }

  const v1::BoardConfig& config_;
  const RegisterFile& registers_;
  unsigned threads_;
  OpacityCorrection opacity_correction_;
  Aperture aperture_;
  RayCounters rays_;
  std::uint64_t viewing_rays_ = 0;
  std::uint64_t host_rays_ = 0;
};

}  // namespace gicube::emu
