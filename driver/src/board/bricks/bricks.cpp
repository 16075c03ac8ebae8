#include "bricks.h"

#include <algorithm>
#include <stdexcept>

#include "encode/volume/block_order.h"
#include "encode/volume/coarse_block.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"

namespace gicube {
namespace {

// Sends one flag per block if they differ from those that were `sent` last.
void send_flags(Device& device, const wire::MemoryRegion& region, std::span<const std::uint8_t> flags,
                std::vector<std::uint8_t>& sent) {
  std::vector<std::uint8_t> packed = pack_flags(flags);
  if (packed == sent) return;
  sent.clear();
  device.write_memory(region.base, packed);
  sent = std::move(packed);
}

}  // namespace

void write_packed_block(Device& device, std::size_t block, std::size_t n, std::span<const std::uint8_t> packed) {
  const std::size_t words = bytes_of_words(n);
  device.write_memory(wire::kVolume.base + block * words, packed.first(words));
  if (packed.size() > words) {
    device.write_memory(wire::kColours.base + block * (packed.size() - words), packed.subspan(words));
  }
}

void Bricks::state(Archive& archive) {
  archive("store", store_);
  archive.within("light", [&] { light_.state(archive); });
  const std::size_t count = store_.count();
  archive.bytes("has_place", has_place_, count, count);
  archive.bytes("on_card", on_card_, count, count);
  archive.list("needed_in", needed_in_, count);
  archive.list("errors", error_, count);
  archive("loads", loads_);
  archive.bytes("absent_flags", absent_, 0, (count + 7) / 8);
  archive.bytes("dark_flags", dark_, 0, (count + 7) / 8);
  if (!archive.loads()) return;
  archive.expect(needed_in_.size() == count, "needed_in", "one per block", needed_in_.size());
  archive.expect(error_.size() == count, "errors", "one per block", error_.size());
  for (std::size_t block = 0; block < count; ++block) {
    const bool fits = has_place_[block] <= 1 && on_card_[block] <= has_place_[block] * (1 + wire::kMaxCoarseLevel) &&
                      (on_card_[block] == 0 || store_.has(block)) && (has_place_[block] != 0 || !light_.on_card(block));
    archive.expect(fits, "on_card", "blocks that are kept", block);
  }
}

void Bricks::begin(Device& device) {
  has_place_.assign(store_.count(), 0);
  on_card_.assign(store_.count(), 0);
  needed_in_.assign(store_.count(), 0);
  error_.assign(store_.count(), 0);
  light_.leave_card();
  absent_.clear();
  dark_.clear();
  device.write_register(wire::reg::kControl, wire::kControlDropBlocks);
  prepare(device, {});
}

// Whether the card has everything that samples in the block read or deposit into.
bool Bricks::can_be_sampled(std::size_t block, const BrickNeeds& needs) const {
  const LightUse light = needs.light;
  if (light == LightUse::kLeft && !light_.on_card(block)) return false;
  bool all = true;
  for_each_sampled_in(block, blocks_, [&](std::size_t each) {
    if (store_.has(block) && store_.has(each) && !has_words(each, needs)) all = false;
    if (light == LightUse::kSeen && light_.may_have(each) && !light_.on_card(each)) all = false;
  });
  return all;
}

void Bricks::prepare(Device& device, const BrickNeeds& needs) {
  std::vector<std::uint8_t> absent(store_.count());
  for (std::size_t block = 0; block < absent.size(); ++block) absent[block] = can_be_sampled(block, needs) ? 0 : 1;
  send_flags(device, wire::kAbsentFlags, absent, absent_);
  if (needs.light != LightUse::kNone) send_flags(device, wire::kDarkFlags, light_.dark(), dark_);
}

// Calls use(each, voxels, irradiance) for each block that samples in `block` need; the flags say which parts of it.
template <typename Use>
void Bricks::for_each_need(std::size_t block, LightUse light, const Use& use) const {
  const bool stored = store_.has(block);
  for_each_sampled_in(block, blocks_, [&](std::size_t each) {
    const bool voxels = stored && store_.has(each);
    const bool irradiance =
        light == LightUse::kLeft ? each == block || voxels : light == LightUse::kSeen && light_.may_have(each);
    if (voxels || irradiance) use(each, voxels, irradiance);
  });
}

Bricks::Choice Bricks::choose(std::span<const std::size_t> wanted, const BrickNeeds& needs) const {
  Choice out;
  for (auto* const flags : {&out.chosen, &out.voxels, &out.light}) flags->resize(store_.count());
  for (const std::size_t block : wanted) {
    if (!needs.leapt_over.empty() && needs.leapt_over[block] != 0) continue;
    std::size_t more = 0;
    for_each_need(block, needs.light, [&](std::size_t each, bool, bool) { more += out.chosen[each] == 0 ? 1 : 0; });
    if (out.blocks.size() + more > capacity_) break;
    for_each_need(block, needs.light, [&](std::size_t each, bool voxels, bool irradiance) {
      if (out.chosen[each] == 0) out.blocks.push_back(each);
      out.chosen[each] = 1;
      if (voxels) out.voxels[each] = 1;
      if (irradiance) out.light[each] = 1;
    });
  }
  return out;
}

std::vector<std::size_t> Bricks::by_importance(std::span<const wire::WaitingBlock> waiting, LightUse light) const {
  std::vector<wire::WaitingBlock> left(waiting.begin(), waiting.end());
  std::vector<std::uint8_t> chosen(store_.count());
  std::vector<std::size_t> out;
  for (std::size_t places = 0; !left.empty();) {
    std::size_t best = left.size();
    double most = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      std::size_t more = 0, sent = 0;
      for_each_need(left[i].block, light, [&](std::size_t each, bool, bool) {
        more += chosen[each] == 0 ? 1 : 0;
        sent += chosen[each] == 0 && has_place_[each] == 0 ? 1 : 0;
      });
      const double gain = static_cast<double>(left[i].importance + 1) / static_cast<double>(1 + sent);
      if (places + more > capacity_ || gain <= most) continue;
      most = gain;
      best = i;
    }
    if (best == left.size()) break;
    for_each_need(left[best].block, light, [&](std::size_t each, bool, bool) {
      places += chosen[each] == 0 ? 1 : 0;
      chosen[each] = 1;
    });
    out.push_back(left[best].block);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return out;
}

void Bricks::drop(Device& device, std::size_t block) {
  if (light_.on_card(block)) light_.fetch(device, block);
  on_card_[block] = 0;
  device.write_register(wire::reg::kDropBlock, static_cast<std::uint32_t>(block));
  has_place_[block] = 0;
}

void Bricks::make_room(Device& device, const Choice& choice) {
  std::size_t taken = choice.blocks.size();
  std::vector<std::size_t> others;  // on the card
  for (std::size_t block = 0; block < has_place_.size(); ++block) {
    if (has_place_[block] != 0 && choice.chosen[block] == 0) others.push_back(block);
  }
  taken += others.size();
  std::ranges::stable_sort(others, {}, [this](std::size_t block) { return needed_in_[block]; });
  for (std::size_t i = 0; taken > capacity_; ++i, --taken) drop(device, others[i]);
}

void Bricks::load(Device& device, std::span<const std::size_t> wanted, const BrickNeeds& needs) {
  const Choice choice = choose(wanted, needs);
  ++loads_;
  make_room(device, choice);
  std::vector<std::uint32_t> commands;
  for (const std::size_t block : choice.blocks) {
    needed_in_[block] = loads_;
    has_place_[block] = 1;
    if (choice.voxels[block] != 0 && !has_words(block, needs)) send(device, block, needs.level(block), commands);
    if (choice.light[block] != 0 && !light_.on_card(block)) light_.send(device, block);
  }
  for (const std::uint32_t command : commands) device.finish_or_throw(command);
  prepare(device, needs);
}

void Bricks::send(Device& device, std::size_t block, int level, std::vector<std::uint32_t>& commands) {
  const auto bytes = read(block);
  const auto n = static_cast<std::size_t>(n_);
  on_card_[block] = 0;
  error_[block] = 0;
  if (level == 0) {
    write_packed_block(device, block, n, bytes);
  } else {
    const Dims at = position_of(block, blocks_);
    Dims inside{};
    for (std::size_t axis = 0; axis < 3; ++axis) inside[axis] = std::min(n_, dims_[axis] - n_ * at[axis]);
    const CoarseBlock coarse = coarse_block(bytes, n, inside, coloured_, level, *codebook_);
    std::vector<std::uint8_t> command =
        wire::encoded(wire::LoadCoarseHeader{static_cast<std::uint32_t>(block), static_cast<std::uint8_t>(level)});
    command.insert(command.end(), coarse.packed.begin(), coarse.packed.end());
    commands.push_back(device.command(wire::share(std::move(command))));
    error_[block] = static_cast<std::uint16_t>(coarse.largest_error);
  }
  on_card_[block] = static_cast<std::uint8_t>(1 + level);
  ++sent_[static_cast<std::size_t>(level)];
  largest_error_ = std::max(largest_error_, int{error_[block]});
}

void Bricks::clear_detail(const BrickNeeds& needs) {
  sent_ = {};
  largest_error_ = 0;
  for (std::size_t block = 0; block < on_card_.size(); ++block) {
    if (on_card_[block] == 0 || !has_words(block, needs)) continue;
    ++sent_[on_card_[block] - 1u];
    largest_error_ = std::max(largest_error_, int{error_[block]});
  }
}

Bricks::Detail Bricks::detail() const { return {sent_, largest_error_}; }

std::vector<std::uint8_t> Bricks::read(std::size_t block) const {
  const auto n = static_cast<std::size_t>(n_);
  std::vector<std::uint8_t> bytes(n * n * n * wire::kVoxelBits / 8);
  if (store_.has(block)) store_.read(block, bytes);
  return bytes;
}

Waiting decode_waiting(std::span<const std::uint8_t> payload, std::size_t blocks) {
  Waiting out;
  if (payload.empty()) return out;
  if (payload.size() < wire::kWaitingHeaderBytes) throw std::out_of_range("size");
  const auto header = wire::decode<wire::WaitingHeader>(payload);
  payload = payload.subspan(wire::kWaitingHeaderBytes);
  if (payload.size() != std::uint64_t{header.blocks} * wire::kWaitingBlockBytes) throw std::out_of_range("size");
  out.host_deposits = header.host_deposits;
  for (std::size_t at = 0; at < payload.size(); at += wire::kWaitingBlockBytes) {
    out.blocks.push_back(wire::decode<wire::WaitingBlock>(payload.subspan(at)));
    if (out.blocks.back().block >= blocks) throw std::out_of_range("block");
  }
  return out;
}

}  // namespace gicube
