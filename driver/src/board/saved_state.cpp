// Board::save() and restore(). The driver's state is a part of the board's checkpoint.
#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>

#include "board/saved/saved_records.h"
#include "board/saved/state_fields.h"
#include "gicube/whole_file.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

constexpr std::uint32_t kVersion = 1;  // of the list of fields below

using Bytes = std::span<const std::uint8_t>;

// Saves, restores, or tries to restore. `kept`: as Remembered::state().
void state_of_all(Archive& archive, Device::Remembered& device, Tables& tables, Batches& batches, Remembered& rest,
                  bool kept) {
  std::uint32_t version = kVersion;
  archive("version", version);
  archive.expect(version == kVersion, "version", std::to_string(kVersion), version);
  archive("device", device);
  archive("tables", tables);
  archive("batches", batches);
  archive.within("board", [&] { rest.state(archive, kept); });
  for (const auto& [ticket, command] : device.commands) {
    archive.expect(ticket != 0, "device.commands", "tickets that are not 0", ticket);
  }
}

std::vector<std::uint8_t> read_whole(const std::string& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);  // of a regular file only
  std::vector<std::uint8_t> bytes(error ? 0 : static_cast<std::size_t>(size));
  std::ifstream in(file, std::ios::binary);
  if (error || !in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    throw BadArgument("file", "a file that can be read", file);
  }
  return bytes;
}

}  // namespace

void Remembered::state(Archive& archive, bool kept) {
  archive.field("info", [this](Archive::Record& record) {
    record(info.processors, info.block_voxels, info.max_volume_voxels, info.queue_rays, info.core_khz);
    record(info.vendor_id, info.device_id, info.wide);
    record.at_most(info.voxel_format, VoxelFormat::kRgba);
    record(info.irradiance_words);
  });
  const auto within = [&archive](const char* name, int value, int low, int high) {
    archive.expect(value >= low && value <= high, name, fmt::format("{}..{}", low, high),
                   static_cast<std::uint64_t>(value));
  };
  within("info.irradiance_words", info.irradiance_words, 1, 3);
  within("info.block_voxels", info.block_voxels, 2, 1024);
  within("info.max_volume_voxels", info.max_volume_voxels, info.block_voxels, 1024);
  archive.field("units", [this](Archive::Record& record) {
    record(time_limit, batches_wait, irradiance_unit, sum_unit, bright_flux, framebuffer_size);
  });
  within("framebuffer_size", framebuffer_size.first, 0, 4095);
  within("framebuffer_size", framebuffer_size.second, 0, 4095);
  state_of(archive, "sampling", sampling);
  bool has_volume = volume.has_value(), in_bricks = bricks != nullptr;
  archive("volume", has_volume);
  archive("in_bricks", in_bricks);
  archive.list("block_sums", block_sums);
  archive("blocks_are_kept", blocks_are_kept);
  state_of(archive, "kept_blocks", kept_blocks,
           [&](std::vector<std::uint8_t>& block) { archive.bytes("bytes", block, 1, std::uint64_t{1} << 32); });
  if (archive.loads() && !kept) {
    blocks_are_kept = false;
    kept_blocks.clear();
  }
  if (!has_volume) {
    volume.reset();
    bricks.reset();
    archive.expect(!in_bricks, "in_bricks", "a volume", 0);
    return;
  }
  if (!volume) volume.emplace();
  archive.within("volume", [&] {
    LoadedVolume& of = *volume;
    archive.field("shape", [&of](Archive::Record& record) {
      record(of.dims, of.blocks, of.range, of.relative_spacing, of.min_spacing, of.gradients);
    });
    if (info.voxel_format != VoxelFormat::kDensity) archive("coloured", of.coloured);
    std::uint64_t blocks = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      within("dims", of.dims[axis], 2, 1024);
      const int n = info.block_voxels;
      within("blocks", of.blocks[axis], (of.dims[axis] + n - 1) / n, (of.dims[axis] + n - 1) / n);
      blocks *= static_cast<std::uint64_t>(of.blocks[axis]);
    }
    archive.list("statistics", of.statistics);
    archive.bytes("flags", of.flags, blocks, blocks);
    archive.expect(of.statistics.size() == blocks, "statistics", std::to_string(blocks), of.statistics.size());
    archive.expect(in_bricks || block_sums.size() == blocks, "block_sums", std::to_string(blocks), block_sums.size());
    if (of.coloured && !in_bricks) {
      archive.list("colour_sums", colour_sums);
      archive.expect(colour_sums.size() == blocks, "colour_sums", std::to_string(blocks), colour_sums.size());
    }
    archive.expect(kept_blocks.empty() || kept_blocks.rbegin()->first < blocks, "kept_blocks",
                   fmt::format("numbers below {}", blocks), kept_blocks.empty() ? 0 : kept_blocks.rbegin()->first);
    if (!in_bricks) return bricks.reset();
    const auto n = static_cast<std::size_t>(info.block_voxels);
    const auto edge = static_cast<std::size_t>(info.max_volume_voxels) / n;
    if (archive.loads()) {
      BlockStore store(static_cast<std::size_t>(blocks), bytes_of_block(n, of.coloured), BlockStore::Place::kMemory);
      BrickLight light(static_cast<std::size_t>(blocks), info.block_voxels, max_irradiance(info),
                       BlockStore::Place::kMemory);
      bricks = std::make_unique<Bricks>(of.blocks, info.block_voxels, std::move(store), std::move(light),
                                        edge * edge * edge);
    }
    archive("bricks", *bricks);
  });
}

void BoardState::save(const std::function<void(Bytes)>& sink) {
  need_all_blocks("save()");
  const std::uint32_t last_id = device.last_id();
  device.begin_checkpoint();
  FieldWriter writer;
  Device::Remembered remembered = device.remembered();
  remembered.last_id = last_id;  // as before this call
  state_of_all(writer, remembered, tables, batches, *this, keep_volume);
  device.take_checkpoint(writer.take(), sink);
  device.set_last_id(last_id);
}

void BoardState::remember(Bytes part, const wire::WentOn& now) {
  FieldReader reader(part);
  Device::Remembered remembered;
  state_of_all(reader, remembered, tables, batches, *this, keep_volume);
  device.remember(std::move(remembered));
  info.protocol_major = device.agreed().major;
  info.protocol_minor = device.agreed().minor;
  info.host_rays = (device.agreed().capabilities & wire::kHostRays) != 0;
  info.fidelity = static_cast<Fidelity>(now.fidelity - 1);  // the same order on the wire
  info.config_hash = now.config_hash;
  info.agp = now.agp != 0;
  scattering_routine = {};
  time_per_scattering = 0;
}

namespace {

// Does what remember() does, on temporary objects. Throws CheckpointFault.
void try_to_remember(Bytes part, Device& device, bool kept) {
  FieldReader reader(part);
  Device::Remembered remembered;
  Tables tables(device);
  Batches batches(device, {});
  Remembered rest;
  state_of_all(reader, remembered, tables, batches, rest, kept);
  reader.end();
}

}  // namespace

void BoardState::go_on(Bytes checkpoint) {
  Bytes part;
  try {
    part = driver_part(checkpoint);
    try_to_remember(part, device, keep_volume);
  } catch (const CheckpointFault& fault) {
    throw BadArgument("checkpoint." + fault.field(), fault.expected(), fault.got());
  }
  remember(part, device.go_on(checkpoint));
}

void BoardState::go_on() {
  try {
    const wire::WentOn now = device.go_on({});
    const std::vector<std::uint8_t> part = device.read_driver_part(now.driver_bytes);
    if (part.empty()) {
      throw CheckpointFault("host.driver", "the state of a driver (Board::save())", "none");
    }
    try_to_remember(part, device, keep_volume);
    remember(part, now);
  } catch (const CheckpointFault& fault) {
    throw OpenFailed(fault.what());
  } catch (const Unsupported& fault) {
    throw OpenFailed(fault.what());
  }
}

std::vector<std::byte> Board::save() {
  const auto lock = state_->begin();
  std::vector<std::byte> bytes;
  state_->save([&bytes](Bytes more) {
    const auto these = std::as_bytes(more);
    bytes.insert(bytes.end(), these.begin(), these.end());
  });
  return bytes;
}

void Board::save(const std::string& file) {
  const auto lock = state_->begin();
  try {
    constexpr unsigned kOwnersAlone = 0600;
    WholeFile out(file, kOwnersAlone);
    state_->save([&out](Bytes more) { out.write(more); });
    out.commit();
  } catch (const std::system_error& error) {
    throw Error(error.what());
  }
}

void Board::restore(std::span<const std::byte> checkpoint) {
  const auto lock = state_->begin();
  state_->go_on({reinterpret_cast<const std::uint8_t*>(checkpoint.data()), checkpoint.size()});
}

void Board::restore(const std::string& file) {
  const auto lock = state_->begin();
  state_->go_on(read_whole(file));
}

}  // namespace gicube
