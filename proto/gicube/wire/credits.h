// Byte and slot credits of one direction of the data plane, kept by its sender and by its receiver.
//
// A sender may have at most the receiver's window in flight: `slots` frames and `bytes` of payload. The receiver hands
// credits back once it has consumed a frame, on any header it sends. kVersion and kCredit frames are free, so credit
// can always return; a request's response always has room because the requester reserved it. So neither side can be
// flooded and neither can wait for the other for ever.
#pragma once

#include <cstdint>

namespace gicube::wire {

class SendCredits {
 public:
  constexpr SendCredits(std::uint32_t slots, std::uint64_t bytes) : slots_(slots), bytes_(bytes) {}

  constexpr bool can_send(std::uint64_t payload) const { return slots_ > 0 && payload <= bytes_; }

  // Only after can_send().
  constexpr void take(std::uint64_t payload) {
    --slots_;
    bytes_ -= payload;
  }

  constexpr void give_back(std::uint32_t slots, std::uint64_t bytes) {
    slots_ += slots;
    bytes_ += bytes;
  }

 private:
  std::uint32_t slots_;
  std::uint64_t bytes_;
};

class ReceiveCredits {
 public:
  constexpr ReceiveCredits(std::uint32_t slots, std::uint64_t bytes) : window_slots_(slots), window_bytes_(bytes) {}

  // False if the peer sent more than it was granted: a protocol error.
  constexpr bool accept(std::uint64_t payload) {
    if (used_slots_ + 1 > window_slots_ || used_bytes_ + payload > window_bytes_) return false;
    ++used_slots_;
    used_bytes_ += payload;
    return true;
  }

  constexpr void consume(std::uint64_t payload) {
    ++consumed_slots_;
    consumed_bytes_ += payload;
  }

  // True when half the window waits to be returned: then a kCredit frame is due even if nothing else is sent.
  constexpr bool due() const {
    return 2 * std::uint64_t{consumed_slots_} >= window_slots_ || 2 * consumed_bytes_ >= window_bytes_;
  }

  // Consumed, and not given back.
  constexpr std::uint32_t consumed_slots() const { return consumed_slots_; }
  constexpr std::uint64_t consumed_bytes() const { return consumed_bytes_; }
  constexpr std::uint64_t window_bytes() const { return window_bytes_; }

  struct Returned {
    std::uint32_t slots;
    std::uint64_t bytes;
  };

  // What the next header carries back; the window is open again by that much.
  constexpr Returned give_back() {
    const Returned returned{consumed_slots_, consumed_bytes_};
    used_slots_ -= consumed_slots_;
    used_bytes_ -= consumed_bytes_;
    consumed_slots_ = 0;
    consumed_bytes_ = 0;
    return returned;
  }

 private:
  std::uint32_t window_slots_;
  std::uint64_t window_bytes_;
  std::uint32_t used_slots_ = 0;
  std::uint64_t used_bytes_ = 0;
  std::uint32_t consumed_slots_ = 0;
  std::uint64_t consumed_bytes_ = 0;
};

}  // namespace gicube::wire
