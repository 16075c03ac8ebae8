#include "function.h"

#include <fmt/format.h>

#include <bit>
#include <cstdio>
#include <exception>
#include <thread>
#include <utility>

namespace gicube::pci {
namespace {

namespace reg = wire::function;

bool is_readable(std::uint64_t offset) {
  return offset % 4 == 0 && offset <= reg::kInterruptMask && offset != reg::kControl && offset != reg::kBell;
}

}  // namespace

Function::Function(const GuestMemory& memory, std::function<Connection()> connect)
    : memory_(memory), connect_(std::move(connect)) {
  reset();
}

std::uint64_t Function::read(std::uint64_t offset, std::uint64_t size) {
  if (size == 4 && is_readable(offset)) return at(static_cast<std::uint32_t>(offset));
  note(Error::kBadAccess);
  return ~std::uint64_t{0};
}

void Function::write(std::uint64_t offset, std::uint64_t size, std::uint64_t given) {
  const auto value = static_cast<std::uint32_t>(given);
  if (size != 4) return note(Error::kBadAccess);
  switch (offset) {
    // A session keeps the rings with which it was opened.
    case reg::kRingLow:
    case reg::kRingHigh:
    case reg::kRingBytes: at(static_cast<std::uint32_t>(offset)) = value; return;
    case reg::kControl:
      if (value == reg::kOpenSession) return open();
      if (value != reg::kCloseSession) return note(Error::kBadAccess);
      if (!rings_.empty()) move_down();  // the last bytes of a driver
      return close(State::kClosed);
    case reg::kBell: return move();
    case reg::kInterruptStatus: at(reg::kInterruptStatus) &= ~value; return;
    case reg::kInterruptMask: at(reg::kInterruptMask) = value & (reg::kMoved | reg::kEnded); return;
    default: return note(Error::kBadAccess);
  }
}

void Function::reset() {
  close(State::kClosed);
  registers_ = {reg::kIdentityValue, reg::kVersionValue};
}

void Function::let_master_bus(bool may) {
  may_master_bus_ = may;
  if (!may && !rings_.empty()) fail(Error::kNoBusMaster);
}

void Function::memory_changed() {
  if (rings_.empty()) return;
  rings_ = memory_.find(session_address_, rings_.size());
  if (rings_.empty()) fail(Error::kBadRing);
}

bool Function::interrupt_is_pending() const {
  return (registers_[reg::kInterruptStatus / 4] & registers_[reg::kInterruptMask / 4]) != 0;
}

short Function::board_events() const {
  return static_cast<short>((ring_is_full_ ? 0 : POLLIN) | (board_is_full_ ? POLLOUT : 0));
}

void Function::open() {
  close(State::kClosed);
  at(reg::kError) = at(reg::kInterruptStatus) = 0;
  if (!may_master_bus_) return fail(Error::kNoBusMaster);
  session_address_ = at(reg::kRingLow) | std::uint64_t{at(reg::kRingHigh)} << 32;
  const std::uint32_t bytes = at(reg::kRingBytes);
  const bool fits = std::has_single_bit(bytes) && bytes >= reg::kMinRingBytes && bytes <= reg::kMaxRingBytes;
  if (fits && session_address_ % reg::kRingAlignment == 0)
    rings_ = memory_.find(session_address_, reg::kIndexBytes + 2 * std::uint64_t{bytes});
  if (rings_.empty()) return fail(Error::kBadRing);
  for (const std::uint32_t index : {reg::kDownTaken, reg::kUpPut, reg::kUpWaits, reg::kStreamEnded}) {
    reg::index_at(rings_.data(), index).store(0);
  }
  taken_ = put_ = 0;
  try {
    board_ = connect_();
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-pci: {}\n", error.what());
    return fail(Error::kNoBoard);
  }
  at(reg::kState) = static_cast<std::uint32_t>(State::kOpen);
  move();
}

void Function::close(State state) {
  if (!rings_.empty()) {
    reg::index_at(rings_.data(), reg::kStreamEnded).store(1, std::memory_order_release);
    at(reg::kInterruptStatus) |= reg::kEnded;
  }
  rings_ = {};
  board_is_full_ = ring_is_full_ = false;
  at(reg::kState) = static_cast<std::uint32_t>(state);
  board_.socket.reset();
  // Another thread waits for the board's process to end: the guest's processor must not.
  if (board_.owner) std::thread([released = std::move(board_.owner)] {}).detach();
}

void Function::fail(Error error) {
  note(error);
  close(State::kFailed);
}

void Function::note(Error error) {
  if (at(reg::kError) == 0) at(reg::kError) = static_cast<std::uint32_t>(error);
}

void Function::move() {
  if (rings_.empty()) return;
  const std::uint32_t taken = taken_, put = put_;
  const bool open = move_down() && move_up();
  if (open && (taken != taken_ || put != put_)) at(reg::kInterruptStatus) |= reg::kMoved;
}

bool Function::move_down() {
  const auto ring = rings_.subspan(reg::kIndexBytes, (rings_.size() - reg::kIndexBytes) / 2);
  const std::uint32_t count = reg::index_at(rings_.data(), reg::kDownPut).load(std::memory_order_acquire) - taken_;
  if (count > ring.size()) return fail(Error::kBadIndex), false;
  // move_up() reads the last bytes of a closed connection.
  board_is_full_ = ring_to_socket(ring, taken_, count, board_.socket.get()) == RingStop::kMustWait;
  reg::index_at(rings_.data(), reg::kDownTaken).store(taken_, std::memory_order_release);
  return true;
}

bool Function::move_up() {
  const auto ring = rings_.subspan(reg::kIndexBytes + (rings_.size() - reg::kIndexBytes) / 2);
  // Twice: bytes may have been taken between the check of the full ring and the request for a bell.
  for (int round = 0; round < 2; ++round) {
    const std::uint32_t held = put_ - reg::index_at(rings_.data(), reg::kUpTaken).load();
    if (held > ring.size()) return fail(Error::kBadIndex), false;
    const auto space = static_cast<std::uint32_t>(ring.size()) - held;
    const RingStop stop = socket_to_ring(board_.socket.get(), ring, put_, space);
    reg::index_at(rings_.data(), reg::kUpPut).store(put_, std::memory_order_release);
    if (stop == RingStop::kClosed) return fail(Error::kBoardGone), false;
    ring_is_full_ = stop == RingStop::kAllMoved;
    reg::index_at(rings_.data(), reg::kUpWaits).store(ring_is_full_ ? 1 : 0);
    if (!ring_is_full_) break;
  }
  return true;
}

}  // namespace gicube::pci
