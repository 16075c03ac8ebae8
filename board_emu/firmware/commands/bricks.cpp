// Out-of-core volumes, with more blocks than the card stores. Rays wait for blocks, and continue when the host has
// written them.
#include "command_fault.h"
#include "commands.h"
#include "firmware/ray_sources/continued_rays.h"
#include "gicube/wire/coarse_block.h"
#include "gicube/wire/memory_map.h"

namespace gicube::emu {

namespace {

// One voxel of a coarse block. Its word stays in a register along a row of the cell; it is shifted to its position
// among 36-bit words and stored.
constexpr DspLoop kCopyVoxel{"voxel of a coarse block", 0, 3, 2};

}  // namespace

std::uint64_t DspCommands::capacity_blocks() const {
  const std::uint64_t edge = config_.asic().max_volume_voxels() / config_.asic().block_voxels();
  return edge * edge * edge;
}

void DspCommands::drop_blocks() {
  aperture_.drop_blocks();
  level_.volume_changed();
}

bool DspCommands::drop_block(std::uint32_t block) {
  if (block >= aperture_.volume().block_count()) return false;
  aperture_.drop_block(block);
  return true;
}

CommandResult DspCommands::load_coarse(std::span<const std::uint8_t> payload) {
  expect(payload.size() >= wire::kLoadCoarseHeaderBytes, "payload", "at least 12 bytes", payload.size());
  const auto header = wire::decode<wire::LoadCoarseHeader>(payload);
  check_volume();
  const std::size_t n = config_.asic().block_voxels(), f = std::size_t{1} << (header.level & 7);
  const VolumeMemory& volume = aperture_.volume();
  expect(header.block < volume.block_count(), "block", "one of the volume", header.block);
  expect(header.level >= 1 && header.level <= wire::kMaxCoarseLevel && 2 * f <= n, "level",
         "1..3 and cells of at most half a block", header.level);
  const std::size_t cells = n / f, count = cells * cells * cells, all = n * n * n;
  const std::size_t words = wire::packed36_bytes(count);
  const bool coloured = config_.asic().voxel_format() != v1::density;
  if (payload.size() != wire::kLoadCoarseHeaderBytes + words + (coloured ? wire::kColourBytes * count : 0)) {
    refuse("payload", "12 bytes and the words (and colours) of " + std::to_string(count) + " cells", payload.size());
  }
  const auto cell_words = payload.subspan(wire::kLoadCoarseHeaderBytes, words);
  const auto cell_colours = payload.subspan(wire::kLoadCoarseHeaderBytes + words);
  std::vector<std::uint8_t> block(wire::packed36_bytes(all)), colours(coloured ? wire::kColourBytes * all : 0);
  for (std::size_t i = 0; i < all; ++i) {
    const std::size_t x = i % n, y = i / n % n, z = i / (n * n);
    const std::size_t cell = x / f + cells * (y / f + cells * (z / f));
    wire::store36(block, i, wire::load36(cell_words, cell));
    for (std::size_t c = 0; coloured && c < wire::kColourBytes; ++c) {
      colours[wire::kColourBytes * i + c] = cell_colours[wire::kColourBytes * cell + c];
    }
  }
  const auto write = [&](const wire::MemoryRegion& region, const std::vector<std::uint8_t>& bytes) {
    switch (write_memory(region.base + std::uint64_t{header.block} * bytes.size(), bytes)) {
      case Acceptance::kTaken: return;
      case Acceptance::kOutOfRange: refuse("block: expected one for which the card has a place");
      case Acceptance::kTooMuchMemory: refuse("block: expected memory for it (gicube-board --max-memory)");
    }
  };
  write(wire::kVolume, block);
  if (coloured) write(wire::kColours, colours);
  CommandResult result;
  if (config_.ideal().dsp() == 0) result.dsp_cycles = kCopyVoxel.setup() + all * kCopyVoxel.interval();
  return result;
}

void DspCommands::check_all_there() const {
  if (aperture_.any_non_resident()) refuse("absent_flags: expected none set for this command, got some");
}

void DspCommands::drop_rays() {
  aperture_.host_deposits().begin();
  waiting_rays_.begin(WaitingKind::kPicture);
  aperture_.host_rays() = {};
}

// Allows the frame's rays to wait if blocks may be non-resident. Deposits in blocks with irradiance at the host go there.
void DspCommands::set_bricks(Frame& frame) {
  if (in_bricks() && (frame.lights() || frame.lit_by_irradiance)) {
    expect(frame.light_words == 1, "IRRADIANCE_WORDS", "1 for light in a volume with more blocks than the card stores",
           frame.light_words);
    set_irradiance_at_host(frame);
  }
  if (!aperture_.any_non_resident() && waiting_rays_.count() == 0 && waiting_rays_.continued().empty()) return;
  frame.non_resident.resize(frame.empty.size());
  for (std::size_t block = 0; block < frame.non_resident.size(); ++block) {
    frame.non_resident[block] = aperture_.is_non_resident(block) ? 1 : 0;
  }
  frame.waiting = &waiting_rays_;
}

void DspCommands::set_irradiance_at_host(Frame& frame) {
  const VolumeMemory& volume = aperture_.volume();
  std::uint64_t on_card = 0;
  std::vector<std::uint8_t> at_host(frame.empty.size());
  for (std::size_t block = 0; block < at_host.size(); ++block) {
    at_host[block] = aperture_.is_irradiance_at_host(block) ? 1 : 0;
    on_card += at_host[block] == 0 || volume.is_stored(block) ? 1 : 0;
  }
  if (on_card > capacity_blocks()) {
    refuse("dark_flags",
           "clear of at most " + std::to_string(capacity_blocks()) + " blocks, with those that are stored", on_card);
  }
  if (!frame.lights()) return;
  frame.irradiance_at_host = std::move(at_host);
  frame.host_deposits = &aperture_.host_deposits();
  if (!goes_on_) aperture_.host_deposits().begin();
}

// Appends the blocks for which rays wait and the number of host deposits to the result. Appends nothing if there are
// none.
void DspCommands::add_waiting(CommandResult& result) {
  HostDeposits& deposits = aperture_.host_deposits();
  deposits.settle();
  host_deposits_total_ += deposits.count();
  if (waiting_rays_.count() == 0 && deposits.count() == 0) return;
  const auto blocks = waiting_rays_.by_block();
  wire::append(result.payload, wire::WaitingHeader{static_cast<std::uint32_t>(blocks.size()),
                                                   static_cast<std::uint32_t>(waiting_rays_.count()),
                                                   static_cast<std::uint32_t>(deposits.count())});
  for (const wire::WaitingBlock& block : blocks) wire::append(result.payload, block);
  result.up_bytes = result.payload.size();
  const std::size_t added = waiting_rays_.added();
  waits_total_ += added;
  for (const wire::WaitingBlock& each : blocks) {
    min_block_loads_ += waiting_rays_.note_wait(each.block, aperture_.volume().block_count()) ? 1 : 0;
  }
  if (config_.ideal().dsp() == 0 && result.asic_ps == 0) result.dsp_cycles += added * kPassRay.interval();
}

// The frame of the commands whose rays wait.
Frame DspCommands::continued_frame() {
  if (waiting_rays_.kind() == WaitingKind::kHostRays) return trace_frame(waiting_rays_.header());
  Frame frame = this->frame();
  if (waiting_rays_.kind() == WaitingKind::kLight) {
    set_light(frame, waiting_rays_.header().rules);
  } else {
    frame.lamps = !lamps_.empty();
  }
  return frame;
}

CommandResult DspCommands::continue_rays(std::span<const std::uint8_t> payload, Progress& work) {
  expect(payload.size() == wire::kContinueCommandBytes, "payload", "8 bytes", payload.size());
  check_volume();
  if (!goes_on_ && waiting_rays_.count() == 0) refuse("no ray waits for a block");
  Frame frame = continued_frame();
  const std::uint32_t traps = waiting_rays_.trapped_tags();
  if (frame.scatter || frame.lights() || traps != 0) check_materials(false);
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    if ((traps >> tag & 1) == 0) continue;
    check_part("material", tag, [&] {
      const auto bsdf = static_cast<std::uint64_t>(frame.materials[tag].bsdf);
      expect(frame.materials[tag].bsdf == wire::Bsdf::kTrap, "bsdf", "6, since rays wait that it has trapped", bsdf);
    });
  }
  set_bricks(frame);
  expect_memory(frame);
  aperture_.decode(threads_, reads(frame));
  const auto ready = goes_on_ ? waiting_rays_.continued() : waiting_rays_.take_ready(frame);
  const bool picture = waiting_rays_.kind() == WaitingKind::kPicture;
  ContinuedRays::Ends ends;
  if (picture) {
    ends = {.framebuffer = &aperture_.framebuffer(), .lamps = &lamps_};
  } else {
    ends.host_rays = aperture_.host_rays();
  }
  if (!frame.lights()) ends.others = &waiting_rays_;
  ContinuedRays rays(ready, frame, ends);
  const RunResult ran = run_level(rays, frame, work);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  if (frame.lights()) add_ledger(result, ran.rays, false);
  if (picture && waiting_rays_.count() == 0) aperture_.resolve_framebuffer(threads_);
  add_waiting(result);
  return result;
}

}  // namespace gicube::emu
