#include "card.h"

#include <algorithm>
#include <string>

#include "asic/memory_standards.h"
#include "command_fault.h"
#include "datapath/scattering.h"
#include "gicube/parallel_for.h"

namespace gicube::emu {

namespace {

namespace reg = wire::reg;

Aperture make_aperture(const v1::BoardConfig& config) {
  return Aperture(static_cast<int>(config.asic().block_voxels()),
                  static_cast<wire::VoxelFormat>(config.asic().voxel_format()), config.asic().irradiance_words(),
                  config.asic().datapath() == v1::wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost);
}

}  // namespace

Card::Card(const v1::BoardConfig& board_config, const RegisterFile& board_registers, Level& its_level)
    : config(board_config),
      registers(board_registers),
      level(its_level),
      threads(thread_count(config.threads())),
      aperture(make_aperture(config)) {}

std::array<int, 3> Card::volume_size() const {
  std::array<int, 3> size{};
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    size[axis] = static_cast<int>(registers.value(reg::kVolumeX + 4 * axis));
  return std::ranges::all_of(size, [](int edge) { return edge > 0; }) ? size : std::array<int, 3>{};
}

void Card::clear_volume() {
  aperture.resize_volume(volume_size());
  drop_rays();
  words_bytes = 0;
  level.volume_changed();
}

void Card::clear_irradiance() {
  aperture.clear_irradiance();
  level.deposits_cleared();
}

void Card::clear_accumulators() {
  aperture.accumulators().clear();
  level.deposits_cleared();
}

void Card::reset() {
  level.reset();
  host_traps.begin(false, {});
  drop_rays();
  memory_errors.clear();
  aperture.resize_volume({});  // done first, because there may not be memory for both
  words_bytes = 0;
  aperture = make_aperture(config);
  tables.clear();
}

// Checks the range of a register's value.
Acceptance Card::range_of(std::uint32_t offset) const {
  const std::uint32_t value = registers.value(offset);
  const auto within = [value](std::uint32_t low, std::uint32_t high) {
    return value >= low && value <= high ? Acceptance::kTaken : Acceptance::kOutOfRange;
  };
  switch (offset) {
    case reg::kVolumeX:
    case reg::kVolumeY:
    case reg::kVolumeZ: {
      const bool bricks = minor_version >= wire::kBricksMinor;
      return within(2, bricks ? wire::kMaxVolumeEdge : config.asic().max_volume_voxels());
    }
    case reg::kSpacingX:
    case reg::kSpacingY:
    case reg::kSpacingZ: return within(wire::kSpacingOne / 64, wire::kSpacingMax);
    case reg::kStep: return within(wire::kStepMin, wire::kStepMax);
    case reg::kOpacityThreshold: return within(0, wire::kOpacityOne);
    case reg::kPipeline: return within(0, wire::kPipelineBits);
    case reg::kLifetime: return within(0, wire::kLifetimeMax);
    case reg::kCutPlanes: return within(0, wire::kMaxCutPlanes);
    case reg::kBricks: return within(0, 1);
    default: return Acceptance::kTaken;
  }
}

Acceptance Card::accept_register(std::uint32_t offset) {
  const Acceptance accepted = range_of(offset);
  const bool is_size = offset == reg::kVolumeX || offset == reg::kVolumeY || offset == reg::kVolumeZ;
  if (accepted != Acceptance::kTaken || !is_size) return accepted;
  const std::uint64_t bytes =
      Aperture::bytes_of_blocks(volume_size(), config.asic().block_voxels(), config.asic().irradiance_words());
  if (!limit.fits(aperture.image_bytes() + bytes)) return Acceptance::kTooMuchMemory;
  clear_volume();
  return Acceptance::kTaken;
}

void Card::add_memory_error(const MemoryError& error) {
  if (error.detected) {
    memory_errors.push_back(error);
    return;
  }
  const auto place = aperture.volume().find_bit(error.block, error.bit);
  if (place) aperture.flip(*place);
}

// chosen: the first word that the command reads has the error, so nothing has changed.
void Card::report_memory_error() {
  const MemoryError error = memory_errors.front();
  memory_errors.pop_front();
  std::string text =
      std::string("the ") + memory_standard(config).label + " reported an error that it could not correct";
  const auto place = aperture.volume().find_bit(error.block, error.bit);
  if (place) {
    const std::size_t word_bits = 8 * aperture.volume().block_bytes();
    const bool is_colour = place->bit >= word_bits;
    const std::size_t voxel =
        is_colour ? (place->bit - word_bits) / (8 * wire::kColourBytes) : place->bit / wire::kVoxelBits;
    text += ": block " + std::to_string(place->block) + (is_colour ? ", colour " : ", word ") + std::to_string(voxel);
  }
  throw CommandFault{wire::ErrorCode::kMemory, text};
}

void Card::drop_blocks() {
  aperture.drop_blocks();
  level.volume_changed();
}

bool Card::drop_block(std::uint32_t block) {
  if (block >= aperture.volume().block_count()) return false;
  aperture.drop_block(block);
  return true;
}

void Card::check_all_there() const {
  if (aperture.any_non_resident()) refuse("absent_flags: expected none set for this command, got some");
}

void Card::drop_rays() {
  aperture.host_deposits().begin();
  waiting_rays.begin(WaitingKind::kPicture);
  aperture.host_rays() = {};
}

std::uint64_t Card::capacity_blocks() const {
  const std::uint64_t edge = config.asic().max_volume_voxels() / config.asic().block_voxels();
  return edge * edge * edge;
}

RunResult Card::run_level(RaySource& rays, const Frame& frame, Progress& work) {
  if (level_volume != aperture.volume_writes()) level.volume_changed();
  level_volume = aperture.volume_writes();
  RunResult ran = level.run(rays, frame, work);
  ran.dsp_cycles = dsp_cycles(ran.dsp_cycles);
  if (ran.cancelled) throw CommandFault{wire::ErrorCode::kCancelled, ""};
  ++answered[static_cast<std::size_t>(ran.answered)][opcode];
  return ran;
}

std::uint64_t Card::stored_words() {
  return aperture.stored_irradiance_bytes() + aperture.accumulators().stored_bytes();
}

Acceptance Card::write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  if (limit.is_set()) {
    const auto [volume, irradiance] = aperture.bytes_of_write(address, bytes.size());
    const std::uint64_t rest = aperture.volume_bytes() + aperture.image_bytes() + rays_bytes() + volume + irradiance;
    const bool more = volume + irradiance > 0;
    if (more && rest + words_bytes > limit.max()) {
      words_bytes = stored_words();  // earlier writes reserved more than they needed
      if (!limit.fits(rest + words_bytes)) return Acceptance::kTooMuchMemory;
    }
    words_bytes += irradiance;
  }
  if (!has_room(address, bytes.size())) return Acceptance::kOutOfRange;
  return aperture.write(address, bytes) ? Acceptance::kTaken : Acceptance::kOutOfRange;
}

// Returns whether the card can store the written blocks. Counts newly loaded blocks.
bool Card::has_room(std::uint64_t address, std::uint64_t length) {
  const VolumeMemory& volume = aperture.volume();
  const std::uint64_t offset = address - wire::kVolume.base;
  if (address < wire::kVolume.base || length == 0 || offset + length > volume.bytes()) return true;
  const std::uint64_t first = offset / volume.block_bytes(), last = (offset + length - 1) / volume.block_bytes();
  std::uint64_t more = 0;
  for (std::uint64_t block = first; block <= last; ++block) more += volume.is_stored(block) ? 0 : 1;
  if (volume.stored_blocks() + more > capacity_blocks()) return false;
  for (std::uint64_t block = first; in_bricks() && block <= last; ++block) {
    if (volume.is_stored(block)) continue;
    ++block_loads;
    min_block_loads += waiting_rays.note_load(block, volume.block_count()) ? 1 : 0;
  }
  return true;
}

void Card::expect_memory(const Frame& frame, std::uint64_t pixels) {
  if (!limit.is_set()) return;
  const bool accumulates = frame.accumulators != nullptr,
             deposits = frame.lights() || (frame.backprojects() && !accumulates);
  words_bytes = stored_words();
  const std::uint64_t more_words = (deposits ? aperture.free_irradiance_bytes(capacity_blocks()) : 0) +
                                   (accumulates ? aperture.accumulators().free_bytes() : 0);
  const std::uint64_t decoded = frame.backprojects() ? 0 : aperture.volume().bytes_to_decode(reads(frame));
  const std::uint64_t image = pixels > 0 ? Aperture::bytes_of_image(pixels) : aperture.image_bytes();
  const std::uint64_t taken = aperture.volume_bytes() + words_bytes + more_words + decoded + image;
  if (!limit.fits(taken + rays_bytes())) {
    refuse("memory: expected at most " + std::to_string(limit.max_mib()) +
           " MiB for volume, words and image (gicube-board --max-memory), got " + std::to_string(limit.asked_mib()) +
           " MiB");
  }
  words_bytes += more_words;
  waiting_rays.set_room(limit.max() - taken - aperture.host_rays_bytes());
}

void Card::check_volume() const {
  if (aperture.volume().block_count() == 0) refuse("no volume: VOLUME_X, VOLUME_Y and VOLUME_Z are not all set");
}

void Card::check_materials(bool host_answers) const {
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    const wire::Material& material = aperture.materials()[tag];
    check_part("material", tag, [&] {
      expect(material.bsdf <= wire::Bsdf::kTrap, "bsdf", "0..6", static_cast<std::uint64_t>(material.bsdf));
      expect(material.parameter_count <= wire::kMaterialParameters, "parameters", "at most 32",
             material.parameter_count);
      if (material.bsdf != wire::Bsdf::kTrap) return;
      if (material.routine == wire::kHostRoutine) {
        if (!host_answers)
          refuse(
              "routine 255 (the host's): expected one of the board for a trace command, for light in three irradiance "
              "words, and while blocks are absent");
        return;
      }
      expect(routines != nullptr && routines->has(material.routine), "routine",
             "the number of a routine that the board has", material.routine);
      const auto parameters = std::span(material.parameters).first(material.parameter_count);
      if (const auto what = routines->fault(material.routine, parameters)) refuse(*what);
    });
  }
}

}  // namespace gicube::emu
