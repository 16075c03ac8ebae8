// One end of the bus's reliable transport, for driver and board. Numbered frames are delivered exactly once, in order
// and complete, over any number of connections (docs/reference/protocol.md).
//
// Sent frames are kept until the peer returns their credit. If the connection breaks, the handshake of the next one
// states what each side has taken, and resume() sends the rest again. Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "gicube/wire/frame.h"

namespace gicube::wire {

// Payload of a frame, shared by all that may have to send it again. Never null.
using Payload = std::shared_ptr<const std::vector<std::uint8_t>>;

inline Payload share(std::vector<std::uint8_t> bytes) {
  return std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
}

inline const Payload& no_payload() {
  // Never destroyed: the destructor of an application's static object may close a board.
  static const Payload& kNone = *new Payload(share({}));
  return kNone;
}

inline Payload version_payload(const VersionInfo& info, std::string_view token = {}) {
  std::vector<std::uint8_t> bytes(kVersionBytes);
  encode(info, std::span(bytes).first<kVersionBytes>());
  bytes.insert(bytes.end(), token.begin(), token.end());
  return share(std::move(bytes));
}

// Credits of one direction. A sender may have at most the receiver's window in flight: `slots` frames and `bytes` of
// payload. After consuming a frame, the receiver returns its credit in any header that it sends. kVersion and kCredit
// frames need no credit, so credit can always be returned. The response to a request always has room, because the
// requester reserved it. So neither side can be flooded, and deadlock is impossible.
struct Credit {
  std::uint32_t slots = 0;  // frames
  std::uint64_t bytes = 0;  // of the frames' payloads

  constexpr void operator+=(const Credit& more) {
    slots += more.slots;
    bytes += more.bytes;
  }
  constexpr void operator-=(const Credit& less) {
    slots -= less.slots;
    bytes -= less.bytes;
  }
};

class SendCredits {
 public:
  constexpr explicit SendCredits(const Credit& window) : left_(window) {}

  constexpr bool can_send(std::uint64_t payload) const { return left_.slots > 0 && payload <= left_.bytes; }
  // Call only after can_send().
  constexpr void take(std::uint64_t payload) { left_ -= {1, payload}; }
  constexpr void give_back(const Credit& credit) { left_ += credit; }

 private:
  Credit left_;
};

class ReceiveCredits {
 public:
  constexpr explicit ReceiveCredits(const Credit& window) : window_(window) {}

  // Returns false if the peer sent more than its credit, which is a protocol error.
  constexpr bool accept(std::uint64_t payload) {
    if (used_.slots + 1 > window_.slots || used_.bytes + payload > window_.bytes) return false;
    used_ += {1, payload};
    return true;
  }
  constexpr void consume(std::uint64_t payload) { consumed_ += {1, payload}; }

  // True when half the window is waiting to be returned. A kCredit frame is then due even if nothing else is sent.
  constexpr bool due() const {
    return 2 * std::uint64_t{consumed_.slots} >= window_.slots || 2 * consumed_.bytes >= window_.bytes;
  }
  constexpr const Credit& consumed() const { return consumed_; }
  constexpr const Credit& window() const { return window_; }

  // Returns the credit for the next header, and reopens the window by as much.
  constexpr Credit give_back() {
    used_ -= consumed_;
    return std::exchange(consumed_, {});
  }

 private:
  Credit window_, used_, consumed_;
};

class ReliableWindow {
 public:
  struct Sent {
    FrameHeader header;
    Payload payload;
  };

  // `mine`: the limits that this side grants its peer.
  explicit ReliableWindow(const VersionInfo& mine) : receive_({mine.window_slots, mine.window_bytes}) {}

  // ---- sending, after open() with the peer's version

  void open(const VersionInfo& theirs) {
    peer_ = {theirs.window_slots, theirs.window_bytes};
    send_ = SendCredits(peer_);
  }
  bool can_send(std::uint64_t payload) const { return send_.can_send(payload); }
  // Takes credit for a frame, assigns its number and keeps it. Call only after can_send().
  Sent keep(FrameHeader header, Payload payload) {
    send_.take(payload->size());
    header.sequence = ++sent_;
    kept_bytes_ += payload->size();
    kept_.push_back({header, std::move(payload)});
    return kept_.back();
  }
  // Returns all consumed credit to the peer, in a header that is about to be sent.
  void put_credit(FrameHeader& header) {
    const auto returned = receive_.give_back();
    returned_ += returned.slots;
    header.credit_slots = returned.slots;
    header.credit_bytes = returned.bytes;
  }
  // A frame that carries only credit and the last number used.
  FrameHeader credit_frame(std::uint16_t flags) {
    FrameHeader header{FrameType::kCredit, flags, sent_};
    put_credit(header);
    return header;
  }
  std::uint32_t sent() const { return sent_; }
  std::size_t kept_frames() const { return kept_.size(); }
  std::uint64_t kept_bytes() const { return kept_bytes_; }

  // ---- receiving

  enum class Arrival { kNext, kAgain, kGap };
  // Classifies a frame by its number. A frame without one is kNext. A credit frame carries the last number used before
  // it.
  Arrival arrival(const FrameHeader& header) const {
    if (header.type == FrameType::kCredit) return sequence_step(taken_, header.id) > 0 ? Arrival::kGap : Arrival::kNext;
    if (is_free(header.type)) return Arrival::kNext;
    const std::int32_t step = sequence_step(taken_, header.sequence);
    return step == 1 ? Arrival::kNext : step < 1 ? Arrival::kAgain : Arrival::kGap;
  }
  // Call when the next numbered frame has arrived.
  void take() { ++taken_; }
  std::uint32_t taken() const { return taken_; }

  // Returns false if the peer sent more than its credit.
  bool accept(std::uint64_t payload) { return receive_.accept(payload); }
  void consume(std::uint64_t payload) { receive_.consume(payload); }
  // Whether credit is waiting to be returned: enough for a separate frame; any; so much that `payload` might not fit.
  bool credit_is_due() const { return receive_.due(); }
  bool owes_credit() const { return receive_.consumed().slots > 0; }
  bool may_keep_out(std::uint64_t payload) const {
    return receive_.consumed().bytes + payload > receive_.window().bytes;
  }

  // Credit returns in the order of sending, so the acknowledged frames need not be kept. Returns false if it exceeds
  // what was sent.
  bool take_credit(const FrameHeader& header) {
    if (header.credit_slots > kept_.size() || header.credit_bytes != bytes_of(header.credit_slots)) return false;
    forget(header.credit_slots);
    send_.give_back({header.credit_slots, header.credit_bytes});
    return true;
  }
  std::uint64_t bytes_of(std::size_t slots) const {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < slots && i < kept_.size(); ++i) bytes += kept_[i].payload->size();
    return bytes;
  }

  // ---- resuming

  // Writes into a version frame what has been taken. The credit for it counts as returned.
  void announce(VersionInfo& mine) {
    returned_ += receive_.give_back().slots;
    mine.taken = taken_;
    mine.consumed = returned_;
  }
  // The last number whose credit has been returned.
  std::uint32_t forgotten() const { return sent_ - static_cast<std::uint32_t>(kept_.size()); }
  // Whether all frames that the peer has not taken are still kept.
  bool fits(const VersionInfo& theirs) const {
    return sequence_step(forgotten(), theirs.consumed) >= 0 && sequence_step(theirs.consumed, theirs.taken) >= 0 &&
           sequence_step(theirs.taken, sent_) >= 0;
  }
  // Sends each frame that the peer has not taken again, by `send(header, payload)`. Call only if fits().
  template <typename Send>
  void resume(const VersionInfo& theirs, const Send& send) {
    forget(theirs.consumed - forgotten());
    send_ = SendCredits({peer_.slots - static_cast<std::uint32_t>(kept_.size()), peer_.bytes - kept_bytes_});
    for (const Sent& frame : kept_) {
      if (sequence_step(theirs.taken, frame.header.sequence) > 0) send(frame.header, frame.payload);
    }
  }

 private:
  void forget(std::uint32_t slots) {
    for (; slots > 0 && !kept_.empty(); --slots) {
      kept_bytes_ -= kept_.front().payload->size();
      kept_.pop_front();
    }
  }

  Credit peer_;  // the peer's window
  SendCredits send_{Credit{}};
  ReceiveCredits receive_;
  std::deque<Sent> kept_;  // frames whose credit the peer has not returned; they may have to be sent again
  std::uint64_t kept_bytes_ = 0;
  std::uint32_t sent_ = 0;      // last number that was used
  std::uint32_t taken_ = 0;     // last number that was taken
  std::uint32_t returned_ = 0;  // last number whose credit was returned
};

}  // namespace gicube::wire
