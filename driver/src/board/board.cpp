// Opening and reopening a board, its properties, its tables and empty flags.
#include "gicube/board.h"

#include <chrono>
#include <utility>

#include "encode/argument.h"
#include "encode/look_up_tables.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/wire/pci_config.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

namespace reg = wire::reg;
namespace pci = wire::pci;

OpenOptions checked(const OpenOptions& given) {
  constexpr std::chrono::hours kLongestWait{24 * 7};
  // A longer watchdog counts as none, so that it can't overflow the clock.
  constexpr std::chrono::hours kLongestWatchdog{24 * 365};
  OpenOptions options = given;
  expect(options.max_rays >= 4096, "max_rays", "at least 4096", options.max_rays);
  expect(options.max_waiting_rays >= 1024, "max_waiting_rays", "at least 1024", options.max_waiting_rays);
  const auto wait = options.wait_for_board;
  expect(wait.count() >= 0 && wait <= kLongestWait, "wait_for_board", "0 milliseconds to one week", wait.count());
  expect(options.reopen_attempts >= 0, "reopen_attempts", "0 or more", options.reopen_attempts);
  expect(options.watchdog.count() >= 0, "watchdog", "0 or more milliseconds", options.watchdog.count());
  if (options.watchdog > kLongestWatchdog) options.watchdog = {};
  return options;
}

bool has_agp_capability(Device& device) {
  std::uint32_t at = device.read_config(pci::kCapabilities) & 0xFC;
  // Each capability has its own dwords, so a longer list is circular.
  for (std::size_t steps = 0; at != 0 && steps < wire::kPciConfigBytes / 4; ++steps) {
    const std::uint32_t header = device.read_config(at);
    if ((header & 0xFF) == pci::kCapabilityAgp) return true;
    at = header >> 8 & 0xFC;
  }
  return false;
}

// Reads a register. Throws OpenFailed if the value is outside of low..high: sizes are computed from it.
int read_sane(Device& device, std::uint32_t offset, std::uint32_t low, std::uint32_t high) {
  const std::uint32_t value = device.read_register(offset);
  if (value >= low && value <= high) return static_cast<int>(value);
  throw OpenFailed(fmt::format("the board's register {} holds {}, expected {}..{}", wire::find_register(offset)->name,
                               value, low, high));
}

BoardInfo read_info(Device& device) {
  BoardInfo info;
  info.protocol_major = device.agreed().major;
  info.protocol_minor = device.agreed().minor;
  info.host_rays = (device.agreed().capabilities & wire::kHostRays) != 0;
  const std::uint32_t ids = device.read_config(pci::kIds);
  info.vendor_id = static_cast<std::uint16_t>(ids);
  info.device_id = static_cast<std::uint16_t>(ids >> 16);
  if (info.vendor_id != wire::kVendorId || info.device_id != wire::kDeviceId) {
    throw OpenFailed(fmt::format("expected a GI-Cube board with PCI ids {:04x}:{:04x}, got a device with {:04x}:{:04x}",
                                 wire::kVendorId, wire::kDeviceId, info.vendor_id, info.device_id));
  }
  info.agp = has_agp_capability(device);
  device.reset();
  read_sane(device, reg::kId, wire::kIdValue, wire::kIdValue);
  info.fidelity = static_cast<Fidelity>(read_sane(device, reg::kFidelity, 1, 3) - 1);  // the same order on the wire
  info.processors = read_sane(device, reg::kProcessors, 1, 1 << 16);
  info.block_voxels = read_sane(device, reg::kBlockVoxels, 2, 1024);
  info.max_volume_voxels = read_sane(device, reg::kMaxVolumeVoxels, 2, 1024);
  info.queue_rays = read_sane(device, reg::kQueueRays, 1, 1 << 30);
  info.core_khz = device.read_register(reg::kCoreKhz);
  info.wide = device.read_register(reg::kDatapath) == static_cast<std::uint32_t>(wire::Datapath::kWide);
  if (info.protocol_minor >= wire::kColoursMinor) {
    info.voxel_format = static_cast<VoxelFormat>(read_sane(device, reg::kVoxelFormat, 1, 3) - 1);  // the same order
    info.irradiance_words = read_sane(device, reg::kIrradianceWords, 1, 3);
  }
  const std::uint64_t hash_high = device.read_register(reg::kConfigHashHigh);
  info.config_hash = hash_high << 32 | device.read_register(reg::kConfigHashLow);
  return info;
}

}  // namespace

ValueRange VolumeStore::value_range() const {
  const auto lock = state_->begin();
  return state_->loaded("value_range()").range;
}

void LookUpTables::set_transfer_function(const TransferFunction& function, int tag) {
  const auto lock = state_->begin();
  check(function, tag);
  state_->tables.set_function(function, tag);
  if (!state_->volume) return;
  state_->tables.send_segmentation(state_->volume->range);
  state_->find_flags(*state_->volume);
  state_->check_fence();
}

void LookUpTables::set_shading(const Shading& shading) {
  const auto lock = state_->begin();
  check(shading);
  state_->tables.set_shading(shading);
  if (!state_->volume) return;
  state_->tables.send_segmentation(state_->volume->range);  // the table contains ambient and knee
  state_->check_fence();
}

void LookUpTables::set_gradient_codebook(std::span<const Vec3> codebook) {
  const auto lock = state_->begin();
  GradientCodebook checked(codebook);
  if (state_->volume) throw Rejected("set_gradient_codebook() must precede load_volume(), which sends its codes");
  state_->tables.set_codebook(std::move(checked));
}

void VolumeStore::set_empty_flags(std::span<const std::uint8_t> flags) {
  const auto lock = state_->begin();
  LoadedVolume& volume = state_->loaded("set_empty_flags()");
  const std::size_t blocks = volume.statistics.size();
  expect(flags.size() == blocks, "flags", fmt::format("{} values, one per block", blocks), flags.size());
  volume.flags.assign(flags.begin(), flags.end());
  for (std::uint8_t& flag : volume.flags) flag = flag != 0 ? 1 : 0;
  state_->tables.send_flags(volume.flags);
  state_->check_fence();
}

std::vector<std::uint8_t> VolumeStore::empty_flags() const {
  const auto lock = state_->begin();
  return state_->loaded("empty_flags()").flags;
}

Dims VolumeStore::dims() const {
  const auto lock = state_->begin();
  return state_->loaded("dims()").dims;
}

Dims VolumeStore::blocks() const {
  const auto lock = state_->begin();
  return state_->loaded("blocks()").blocks;
}

Picoseconds Board::now() const {
  if (!state_->started.any() || state_->started.is_here() || state_->is_in_callback())
    return state_->device.clock().now();
  const auto lock = state_->lock();
  return state_->device.clock().now();
}

void Board::host_compute(Picoseconds duration) {
  const auto lock = state_->begin();
  state_->device.clock().work(duration);
}

Counters Board::counters() {
  const auto lock = state_->begin();
  return state_->device.counters();
}

Board Board::open(std::string_view text, const OpenOptions& options) {
  const Uri uri = parse_uri(text);
  auto state = std::make_shared<BoardState>(uri, checked(options));
  try {
    if (options.go_on || uri.restores) {
      state->go_on();
    } else {
      state->info = read_info(state->device);
      state->tables.set_wide(state->info.wide);
      state->tables.set_irradiance_words(state->info.irradiance_words);
    }
  } catch (const DeviceLost& error) {
    throw OpenFailed(error.what());
  } catch (const Rejected& error) {
    throw OpenFailed(error.what());
  }
  return Board(std::move(state));
}

// Restores what the driver knows. The rest is as on a board that was just opened.
void BoardState::restore() {
  if (!std::exchange(restoring, true)) registers_before = device.registers();
  const int block_voxels = info.block_voxels;
  info = read_info(device);  // resets the board
  for (const wire::RegisterInfo& each : wire::kRegisterTable) {
    const bool is_size = each.offset >= reg::kVolumeX && each.offset <= reg::kVolumeZ;
    const auto held = registers_before.find(each.offset);
    if (each.access != wire::Access::kReadWrite || is_size || held == registers_before.end()) continue;
    device.set_register(each.offset, held->second);
  }
  tables.restore();
  irradiance_unit = sum_unit = 0;
  framebuffer_size = {};
  const bool kept = blocks_are_kept || bricks;
  const bool same = info.block_voxels == block_voxels && (!bricks || bricks->capacity() == capacity_blocks());
  if (volume && (!kept || !same)) volume.reset();
  if (!volume) bricks.reset();
  batches_wait = !volume && !batches.empty();
  if (volume) {
    begin_volume(*volume);
    if (bricks) {
      bricks->light().clear();
      bricks->begin(device);
    }
    for (const auto& [block, bytes] : kept_blocks) {
      write_packed_block(device, block, static_cast<std::size_t>(info.block_voxels), bytes);
    }
    tables.send_segmentation(volume->range);
    tables.send_flags(volume->flags);
    check_fence();
    send_batches_again();
  }
  restoring = false;
}

Reopened Board::reopen() {
  const auto lock = state_->lock();
  const bool resumed = state_->device.reopen() && !state_->restoring;
  if (!resumed) state_->restore();
  return {resumed, state_->volume.has_value()};
}

Board::Board(std::shared_ptr<BoardState> state) : state_(std::move(state)) {}
Board::Board(Board&&) noexcept = default;
Board& Board::operator=(Board&& other) noexcept {
  Board taken(std::move(other));
  std::swap(state_, taken.state_);
  return *this;
}
// Another thread may be waiting on a handle of one of its batches: end() makes that wait throw.
Board::~Board() {
  if (state_) state_->end();
}

const BoardInfo& Board::info() const { return state_->info; }

}  // namespace gicube
