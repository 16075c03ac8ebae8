// Volumes with more blocks than the card stores: rays wait for blocks, and go on when the host has written them.
#include "command_fault.h"
#include "commands.h"
#include "firmware/ray_sources/continued_rays.h"

namespace gicube::emu {

std::uint64_t DspCommands::capacity_blocks() const {
  const std::uint64_t edge = config_.asic().max_volume_voxels() / config_.asic().block_voxels();
  return edge * edge * edge;
}

void DspCommands::drop_blocks() {
  aperture_.drop_blocks();
  level_.volume_changed();
}

void DspCommands::check_all_there() const {
  if (aperture_.any_absent()) refuse("absent_flags: expected none set for this command, got some");
}

// Lets the frame's rays wait, if there is anything that they could wait for.
void DspCommands::set_bricks(Frame& frame) {
  if (!aperture_.any_absent() && waiting_rays_.count() == 0 && waiting_rays_.continued().empty()) return;
  if (!frame.plain()) {
    refuse("PIPELINE: expected neither irradiance nor scattering while blocks are absent");
  }
  frame.absent.resize(frame.empty.size());
  for (std::size_t block = 0; block < frame.absent.size(); ++block) {
    frame.absent[block] = aperture_.absent(block) ? 1 : 0;
  }
  frame.waiting = &waiting_rays_;
}

// Ends a command whose rays end in the framebuffer, or wait.
void DspCommands::finish_picture(CommandResult& result) {
  if (waiting_rays_.count() == 0) return aperture_.resolve_framebuffer(threads_);
  const auto blocks = waiting_rays_.by_block();
  const auto rays = static_cast<std::uint32_t>(waiting_rays_.count());
  wire::append(result.payload, wire::WaitingHeader{static_cast<std::uint32_t>(blocks.size()), rays});
  for (const wire::WaitingBlock& block : blocks) wire::append(result.payload, block);
  result.up_bytes = result.payload.size();
  const std::size_t added = waiting_rays_.added();
  waits_total_ += added;
  if (config_.ideal().dsp() == 0 && result.asic_ps == 0) result.dsp_cycles += added * kPassRay.interval();
}

CommandResult DspCommands::continue_rays(std::span<const std::uint8_t> payload, Progress& work) {
  expect(payload.size() == wire::kContinueCommandBytes, "payload", "8 bytes", payload.size());
  check_volume();
  if (!goes_on_ && waiting_rays_.count() == 0) refuse("no ray waits for a block");
  Frame frame = this->frame();
  set_bricks(frame);
  expect_memory(frame);
  aperture_.decode(threads_, reads(frame));
  const auto ready = goes_on_ ? waiting_rays_.continued() : waiting_rays_.take_ready(frame);
  ContinuedRays rays(ready, aperture_.framebuffer());
  const RunResult ran = run_level(rays, frame, work);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  finish_picture(result);
  return result;
}

}  // namespace gicube::emu
