#include "ray_queue.h"

#include <algorithm>

#include "gicube/wire/forwarded_ray.h"

namespace gicube {

std::vector<wire::WaitingBlock> RayQueue::by_block() const {
  std::vector<wire::WaitingBlock> out;
  for (const auto& [block, rays] : blocks_) {
    out.push_back({block, static_cast<std::uint32_t>(rays.count), rays.importance});
  }
  return out;
}

void RayQueue::add(std::uint32_t block, std::uint64_t importance, std::span<const std::uint8_t> records) {
  Rays& rays = blocks_[block];
  rays.count += records.size() / wire::kForwardedRayBytes;
  rays.importance += importance;
  rays.in_memory.insert(rays.in_memory.end(), records.begin(), records.end());
  bytes_in_memory_ += records.size();
  while (bytes_in_memory_ > max_in_memory_ * wire::kForwardedRayBytes) write_largest();
}

void RayQueue::write_largest() {
  Rays& rays =
      std::ranges::max_element(blocks_, {}, [](const auto& each) { return each.second.in_memory.size(); })->second;
  if (!file_) file_.emplace("rays that wait for blocks of a volume larger than the card");
  file_->write(file_end_, rays.in_memory);
  rays.in_file.push_back({file_end_, rays.in_memory.size()});
  ++pieces_;
  file_end_ += rays.in_memory.size();
  bytes_in_memory_ -= rays.in_memory.size();
  rays.in_memory = {};
}

std::vector<std::uint8_t> RayQueue::take(std::uint32_t block, std::size_t most) {
  const auto found = blocks_.find(block);
  if (found == blocks_.end()) return {};
  Rays& rays = found->second;
  const std::size_t wanted = std::min(most, rays.count) * wire::kForwardedRayBytes;
  std::vector<std::uint8_t> out;
  while (out.size() < wanted && !rays.in_file.empty()) {
    Piece& piece = rays.in_file.back();
    const std::size_t bytes = std::min(piece.bytes, wanted - out.size());
    out.resize(out.size() + bytes);
    file_->read(piece.at + piece.bytes - bytes, std::span(out).last(bytes));
    piece.bytes -= bytes;
    if (piece.bytes > 0) continue;
    rays.in_file.pop_back();
    if (--pieces_ == 0) file_end_ = 0;
  }
  const std::size_t rest = wanted - out.size();
  const auto last = rays.in_memory.end();
  out.insert(out.end(), last - static_cast<std::ptrdiff_t>(rest), last);
  rays.in_memory.erase(last - static_cast<std::ptrdiff_t>(rest), last);
  bytes_in_memory_ -= rest;
  const std::size_t taken = wanted / wire::kForwardedRayBytes;
  rays.importance -= rays.importance / rays.count * taken;
  rays.count -= taken;
  if (rays.count == 0) blocks_.erase(found);
  return out;
}

void RayQueue::clear() {
  blocks_.clear();
  bytes_in_memory_ = pieces_ = 0;
  file_end_ = 0;
}

}  // namespace gicube
