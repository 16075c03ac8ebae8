#include "block_store.h"

#include <fmt/format.h>

#include <string>

namespace gicube {

BlockStore::BlockStore(std::size_t blocks, std::size_t block_bytes, Place place)
    : block_bytes_(block_bytes), places_(blocks, -1) {
  if (place == Place::kFile) file_.emplace("a volume larger than the card");
}

void BlockStore::write(std::int64_t place, std::span<const std::uint8_t> bytes) {
  if (file_) return file_->write(static_cast<std::uint64_t>(place) * block_bytes_, bytes);
  memory_[static_cast<std::size_t>(place)].assign(bytes.begin(), bytes.end());
}

void BlockStore::add(std::size_t block, std::span<const std::uint8_t> bytes) {
  if (!file_) memory_.emplace_back();
  write(next_, bytes);
  places_[block] = next_++;
}

void BlockStore::put(std::size_t block, std::span<const std::uint8_t> bytes) {
  has(block) ? write(places_[block], bytes) : add(block, bytes);
}

void BlockStore::clear() {
  places_.assign(places_.size(), -1);
  next_ = 0;
  memory_.clear();
}

void BlockStore::state(Archive& archive) {
  std::vector<std::uint32_t> stored;
  for (std::size_t block = 0; block < count(); ++block) {
    if (has(block)) stored.push_back(static_cast<std::uint32_t>(block));
  }
  archive.list("blocks", stored);
  std::vector<std::uint8_t> bytes;
  for (const std::uint32_t block : stored) {
    const bool is_new = block < count() && !(archive.loads() && has(block));
    archive.expect(is_new, "blocks", fmt::format("each below {} once", count()), block);
    if (!archive.loads()) read(block, bytes);
    archive.bytes("block" + std::to_string(block), bytes, block_bytes_, block_bytes_);
    if (archive.loads()) add(block, bytes);
  }
}

void BlockStore::read(std::size_t block, std::vector<std::uint8_t>& out) const {
  const std::int64_t place = places_[block];
  if (!file_) {
    out = memory_[static_cast<std::size_t>(place)];
    return;
  }
  out.resize(block_bytes_);
  file_->read(static_cast<std::uint64_t>(place) * block_bytes_, out);
}

}  // namespace gicube
