#include "bricks.h"

#include <stdexcept>

#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"

namespace gicube {

void write_packed_block(Device& device, std::size_t block, std::size_t n, std::span<const std::uint8_t> packed) {
  const std::size_t words = bytes_of_words(n);
  device.write_memory(wire::kVolume.base + block * words, packed.first(words));
  if (packed.size() > words) {
    device.write_memory(wire::kColours.base + block * (packed.size() - words), packed.subspan(words));
  }
}

void Bricks::forget_blocks() {
  on_card_.assign(store_.count(), 0);
  count_on_card_ = 0;
  absent_.resize(store_.count());
  for (std::size_t block = 0; block < absent_.size(); ++block) absent_[block] = store_.has(block) ? 1 : 0;
}

void Bricks::state(Archive& archive) {
  archive("store", store_);
  const std::size_t count = store_.count();
  archive.bytes("on_card", on_card_, count, count);
  archive.bytes("absent", absent_, count, count);
  archive("unsure", unsure_);
  if (!archive.loads()) return;
  count_on_card_ = 0;
  for (std::size_t block = 0; block < count; ++block) {
    const bool fits = on_card_[block] <= 1 && absent_[block] <= 1 && (on_card_[block] == 0 || store_.has(block));
    archive.expect(fits, "on_card", "blocks that are kept", block);
    count_on_card_ += on_card_[block];
  }
}

void Bricks::begin(Device& device) {
  unsure_ = true;
  forget_blocks();
  device.write_register(wire::reg::kControl, wire::kControlDropBlocks);
  device.write_memory(wire::kAbsentFlags.base, pack_flags(absent_));
  unsure_ = false;
}

void Bricks::load(Device& device, const BlockOrder& order, std::span<const wire::WaitingBlock> waiting,
                  std::span<const std::uint8_t> leapt_over) {
  std::vector<std::uint8_t> chosen(store_.count());
  std::vector<std::size_t> ready, words;  // blocks to be sampled in, blocks whose words that takes
  std::size_t more = 0;                   // of those, not on the card
  for (const std::size_t block : order.reached_from(waiting)) {
    if (!store_.has(block) || (!leapt_over.empty() && leapt_over[block] != 0)) continue;
    const std::size_t before = words.size();
    for (const std::size_t each : blocks_sampled_in(block, blocks_)) {
      if (chosen[each] == 0 && store_.has(each)) words.push_back(each);
    }
    if (words.size() > capacity_) {
      words.resize(before);
      break;
    }
    for (std::size_t i = before; i < words.size(); ++i) {
      chosen[words[i]] = 1;
      more += on_card_[words[i]] == 0 ? 1 : 0;
    }
    ready.push_back(block);
  }
  unsure_ = true;
  if (count_on_card_ + more > capacity_) {
    forget_blocks();
    device.write_register(wire::reg::kControl, wire::kControlDropBlocks);
  }
  std::vector<std::uint8_t> bytes;
  for (const std::size_t block : words) {
    if (on_card_[block] != 0) continue;
    store_.read(block, bytes);
    write_packed_block(device, block, static_cast<std::size_t>(n_), bytes);
    on_card_[block] = 1;
    ++count_on_card_;
  }
  for (const std::size_t block : ready) absent_[block] = 0;
  device.write_memory(wire::kAbsentFlags.base, pack_flags(absent_));
  unsure_ = false;
}

std::vector<wire::WaitingBlock> decode_waiting(std::span<const std::uint8_t> payload, std::size_t blocks) {
  if (payload.empty()) return {};
  if (payload.size() < wire::kWaitingHeaderBytes) throw std::out_of_range("size");
  const auto header = wire::decode<wire::WaitingHeader>(payload);
  payload = payload.subspan(wire::kWaitingHeaderBytes);
  if (header.blocks == 0 || payload.size() != header.blocks * wire::kWaitingBlockBytes) throw std::out_of_range("size");
  std::vector<wire::WaitingBlock> out;
  for (std::size_t at = 0; at < payload.size(); at += wire::kWaitingBlockBytes) {
    out.push_back(wire::decode<wire::WaitingBlock>(payload.subspan(at)));
    if (out.back().block >= blocks) throw std::out_of_range("block");
  }
  return out;
}

}  // namespace gicube
