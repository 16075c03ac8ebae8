// Messages waiting for a page that reads slowly, or not at all.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <utility>

#include "scene/names.h"
#include "view/viewer.h"

namespace gicube::samples::view {

class Outbox {
 public:
  bool empty() const { return packets_.empty(); }
  // False: the page is too slow, and should be disconnected.
  bool put(const Packet& packet) {
    if (!packet.kind.empty()) {
      std::erase_if(packets_, [&](const Packet& other) {
        const bool is_older = other.kind == packet.kind;
        if (is_older) bytes_ -= other.bytes->size();
        return is_older;
      });
    }
    packets_.push_back(packet);
    bytes_ += packet.bytes->size();
    return packets_.size() <= kMaxPackets && bytes_ <= kMaxBytes;
  }
  Packet take() {
    Packet packet = std::move(packets_.front());
    packets_.pop_front();
    bytes_ -= packet.bytes->size();
    return packet;
  }
  void clear() {
    packets_.clear();
    bytes_ = 0;
  }

 private:
  static constexpr std::size_t kMaxPackets = 256;  // chosen: far more than a page requests at the same time
  static constexpr std::size_t kMaxBytes = std::size_t{128} << 20;  // chosen: the largest picture and its slices

  std::deque<Packet> packets_;
  std::size_t bytes_ = 0;
};

}  // namespace gicube::samples::view
