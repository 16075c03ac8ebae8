#include "brick_light.h"

#include <algorithm>
#include <stdexcept>

#include "gicube/wire/memory_map.h"

namespace gicube {

std::vector<std::uint8_t> BrickLight::dark() const {
  std::vector<std::uint8_t> out(on_card_.size());
  std::ranges::transform(on_card_, out.begin(), [](std::uint8_t there) { return there == 0 ? 1 : 0; });
  return out;
}

void BrickLight::clear() {
  store_.clear();
  std::ranges::fill(changed_, std::uint8_t{0});
}

void BrickLight::leave_card() {
  std::ranges::fill(on_card_, std::uint8_t{0});
  std::ranges::fill(changed_, std::uint8_t{0});
}

std::uint64_t BrickLight::address(std::size_t block) const {
  return wire::kIrradiance.base + std::uint64_t{block} * words_ * wire::kIrradianceBytes;
}

std::vector<std::uint8_t> BrickLight::kept(std::size_t block) const {
  std::vector<std::uint8_t> bytes(bytes_of_block());
  if (store_.has(block)) store_.read(block, bytes);
  return bytes;
}

void BrickLight::send(Device& device, std::size_t block) {
  if (store_.has(block)) device.write_memory(address(block), kept(block));
  on_card_[block] = 1;
}

std::vector<std::uint8_t> BrickLight::read(Device& device, std::size_t block) {
  if (changed_[block] == 0) return kept(block);
  return device.read_memory(address(block), bytes_of_block(), wire::kIrradianceBytes);
}

void BrickLight::fetch(Device& device, std::size_t block) {
  if (changed_[block] != 0) {
    const auto bytes = read(device, block);
    const bool has_light = std::ranges::any_of(bytes, [](std::uint8_t byte) { return byte != 0; });
    if (has_light || store_.has(block)) store_.put(block, bytes);
  }
  on_card_[block] = changed_[block] = 0;
}

void BrickLight::deposited() { changed_ = on_card_; }

BrickLight::Added BrickLight::add(std::span<const wire::HostDeposit> deposits) {
  Added sum;
  for (std::size_t i = 0; i < deposits.size();) {
    const std::uint64_t block = deposits[i].word / words_;
    if (block >= on_card_.size() || on_card_[block] != 0) throw std::out_of_range("word");
    std::vector<std::uint8_t> bytes = kept(block);
    for (; i < deposits.size() && deposits[i].word / words_ == block; ++i) {
      const std::size_t at = deposits[i].word % words_ * wire::kIrradianceBytes;
      const auto old = wire::load<std::uint32_t>(bytes, at);
      const std::uint64_t more = std::min<std::uint64_t>(deposits[i].units, most_ - std::min(old, most_));
      wire::store(std::span(bytes), at, static_cast<std::uint32_t>(old + more));
      sum.kept += more;
      sum.clipped += deposits[i].units - more;
    }
    store_.put(block, bytes);
  }
  return sum;
}

void BrickLight::write(Device& device, std::size_t block, std::size_t at, std::span<const std::uint8_t> bytes) {
  if (on_card(block)) {
    device.write_memory(address(block) + at, bytes);
    changed_[block] = 1;
    return;
  }
  std::vector<std::uint8_t> all = kept(block);
  std::ranges::copy(bytes, all.begin() + static_cast<std::ptrdiff_t>(at));
  store_.put(block, all);
}

std::uint64_t BrickLight::add_words(Device& device, std::size_t block, std::span<const std::uint8_t> more) {
  std::vector<std::uint8_t> bytes = read(device, block);
  std::uint64_t clipped = 0;
  for (std::size_t at = 0; at < bytes.size(); at += wire::kIrradianceBytes) {
    const std::uint64_t sum = std::uint64_t{wire::load<std::uint32_t>(bytes, at)} + wire::load<std::uint32_t>(more, at);
    clipped += sum - std::min<std::uint64_t>(sum, most_);
    wire::store(std::span(bytes), at, static_cast<std::uint32_t>(std::min<std::uint64_t>(sum, most_)));
  }
  write(device, block, 0, bytes);
  return clipped;
}

void BrickLight::state(Archive& archive) {
  archive("store", store_);
  archive.bytes("on_card", on_card_, on_card_.size(), on_card_.size());
  archive.bytes("changed", changed_, on_card_.size(), on_card_.size());
  for (std::size_t block = 0; archive.loads() && block < on_card_.size(); ++block) {
    archive.expect(on_card_[block] <= 1 && changed_[block] <= on_card_[block], "changed", "blocks on the card", block);
  }
}

}  // namespace gicube
