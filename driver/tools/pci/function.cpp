#include "function.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <bit>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "transport/event.h"

namespace gicube::pci {
namespace {

namespace reg = wire::function;
using reg::Error;
using reg::State;

constexpr std::uint64_t kAllOnes = ~std::uint64_t{0};

std::uint64_t rings_bytes(std::uint32_t ring_bytes) { return reg::kIndexBytes + 2 * std::uint64_t{ring_bytes}; }

bool is_ring_size(std::uint32_t bytes) {
  return std::has_single_bit(bytes) && bytes >= reg::kMinRingBytes && bytes <= reg::kMaxRingBytes;
}

// Whoever waits for a process or a peer to end, it is not the guest's processor.
void release_elsewhere(Connection connection) {
  if (connection.owner) std::thread([released = std::move(connection)] {}).detach();
}

}  // namespace

// Shared with the thread that connects, which may take longer than the session lasts.
struct Function::Opening {
  std::mutex mutex;  // guards the connection
  Connection made;
  Event done;
};

Function::Function(const GuestMemory& memory, std::function<Connection()> connect)
    : memory_(memory), connect_(std::move(connect)) {}

std::uint64_t Function::read(std::uint64_t offset, std::uint64_t size) {
  if (size == 4) {
    switch (offset) {
      case reg::kIdentity: return reg::kIdentityValue;
      case reg::kVersion: return reg::kVersionValue;
      case reg::kState: return static_cast<std::uint32_t>(state_);
      case reg::kError: return static_cast<std::uint32_t>(error_);
      case reg::kRingLow: return static_cast<std::uint32_t>(ring_address_);
      case reg::kRingHigh: return ring_address_ >> 32;
      case reg::kRingBytes: return ring_bytes_;
      case reg::kInterruptStatus: return interrupt_status_;
      case reg::kInterruptMask: return interrupt_mask_;
      default: break;
    }
  }
  note(Error::kBadAccess);
  return kAllOnes;
}

void Function::write(std::uint64_t offset, std::uint64_t size, std::uint64_t given) {
  const auto value = static_cast<std::uint32_t>(given);
  if (size != 4) return note(Error::kBadAccess);
  switch (offset) {
    // A session keeps the rings with which it was opened.
    case reg::kRingLow: ring_address_ = (ring_address_ & ~std::uint64_t{0xFFFF'FFFF}) | value; return;
    case reg::kRingHigh: ring_address_ = (ring_address_ & 0xFFFF'FFFF) | std::uint64_t{value} << 32; return;
    case reg::kRingBytes: ring_bytes_ = value; return;
    case reg::kControl:
      if (value == reg::kOpenSession) return open();
      if (value != reg::kCloseSession) return note(Error::kBadAccess);
      if (state_ == State::kOpen) move_down();  // a driver's goodbye
      return close(State::kClosed, Error::kNone);
    case reg::kBell: return move();
    case reg::kInterruptStatus: interrupt_status_ &= ~value; return;
    case reg::kInterruptMask: interrupt_mask_ = value & (reg::kMoved | reg::kEnded); return;
    default: return note(Error::kBadAccess);
  }
}

void Function::reset() {
  close(State::kClosed, Error::kNone);
  error_ = Error::kNone;
  ring_address_ = 0;
  ring_bytes_ = interrupt_status_ = interrupt_mask_ = 0;
}

void Function::let_master_bus(bool may) {
  may_master_bus_ = may;
  if (!may && !rings_.empty()) fail(Error::kNoBusMaster);
}

void Function::memory_changed() {
  if (rings_.empty()) return;
  const std::size_t bytes = rings_.size();
  rings_ = {};  // gone with the former mapping
  if (const auto found = memory_.find(session_address_, bytes); !found.empty()) {
    rings_ = found;
  } else {
    fail(Error::kBadRing);
  }
}

short Function::board_events() const {
  return static_cast<short>((ring_is_full_ ? 0 : POLLIN) | (board_is_full_ ? POLLOUT : 0));
}

int Function::connected_event() const { return opening_ ? opening_->done.get() : -1; }

void Function::note(Error error) {
  if (error_ == Error::kNone) error_ = error;
}

void Function::open() {
  close(State::kClosed, Error::kNone);
  error_ = Error::kNone;
  interrupt_status_ = 0;
  if (!may_master_bus_) return fail(Error::kNoBusMaster);
  if (!is_ring_size(ring_bytes_) || ring_address_ % reg::kRingAlignment != 0) return fail(Error::kBadRing);
  session_address_ = ring_address_;
  rings_ = memory_.find(session_address_, rings_bytes(ring_bytes_));
  if (rings_.empty()) return fail(Error::kBadRing);
  for (const std::uint32_t index : {reg::kDownTaken, reg::kUpPut, reg::kUpWaits, reg::kStreamEnded}) {
    reg::index_at(rings_.data(), index).store(0);
  }
  taken_ = put_ = 0;
  board_is_full_ = ring_is_full_ = false;
  state_ = State::kOpening;
  opening_ = std::make_shared<Opening>();
  std::thread([opening = opening_, connect = connect_] {
    Connection made;
    try {
      made = connect();
    } catch (const std::exception& error) {
      fmt::print(stderr, "gicube-pci: {}\n", error.what());
    }
    {
      const std::lock_guard lock(opening->mutex);
      opening->made = std::move(made);
    }
    opening->done.happen();
  }).detach();
}

void Function::connection_is_made() {
  if (!opening_) return;
  {
    const std::lock_guard lock(opening_->mutex);
    board_ = std::move(opening_->made);
  }
  opening_.reset();
  if (board_.socket.get() < 0) return fail(Error::kNoBoard);
  state_ = State::kOpen;
  move();
}

void Function::close(State state, Error error) {
  if (state == State::kFailed) note(error);
  if (!rings_.empty()) {
    reg::index_at(rings_.data(), reg::kStreamEnded).store(1, std::memory_order_release);
    interrupt_status_ |= reg::kEnded;
  }
  rings_ = {};
  opening_.reset();
  board_is_full_ = ring_is_full_ = false;
  state_ = state;
  board_.socket.reset();
  release_elsewhere(std::exchange(board_, {}));
}

void Function::board_is_ready() { move(); }

void Function::move() {
  if (state_ != State::kOpen) return;
  const std::uint32_t taken = taken_, put = put_;
  const bool open = move_down() && move_up();
  if (open && (taken != taken_ || put != put_)) interrupt_status_ |= reg::kMoved;
}

// False: the session has ended.
bool Function::move_down() {
  const auto ring = rings_.subspan(reg::kIndexBytes, (rings_.size() - reg::kIndexBytes) / 2);
  const std::uint32_t put = reg::index_at(rings_.data(), reg::kDownPut).load(std::memory_order_acquire);
  std::uint32_t count = put - taken_;
  if (count > ring.size()) return fail(Error::kBadIndex), false;
  board_is_full_ = false;
  while (count > 0) {
    const auto piece = reg::piece_of(ring, taken_, count);
    const ssize_t sent = ::send(board_.socket.get(), piece.data(), piece.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    board_is_full_ = sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    if (sent <= 0) break;  // of a closed connection, move_up() has the last words
    taken_ += static_cast<std::uint32_t>(sent);
    count -= static_cast<std::uint32_t>(sent);
  }
  reg::index_at(rings_.data(), reg::kDownTaken).store(taken_, std::memory_order_release);
  return true;
}

bool Function::move_up() {
  const auto ring = rings_.subspan(reg::kIndexBytes + (rings_.size() - reg::kIndexBytes) / 2);
  auto waits = reg::index_at(rings_.data(), reg::kUpWaits);
  const auto taken = reg::index_at(rings_.data(), reg::kUpTaken);
  bool ended = false;
  // Twice: between the look at a full ring and the wish for a bell, bytes may have been taken.
  for (int round = 0; round < 2 && !ended; ++round) {
    const std::uint32_t held = put_ - taken.load();
    if (held > ring.size()) return fail(Error::kBadIndex), false;
    auto space = static_cast<std::uint32_t>(ring.size()) - held;
    ring_is_full_ = space == 0;
    while (space > 0) {
      const auto piece = reg::piece_of(ring, put_, space);
      const ssize_t got = ::recv(board_.socket.get(), piece.data(), piece.size(), MSG_DONTWAIT);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
      ended = got <= 0;
      if (ended) break;
      put_ += static_cast<std::uint32_t>(got);
      space -= static_cast<std::uint32_t>(got);
      ring_is_full_ = space == 0;
    }
    reg::index_at(rings_.data(), reg::kUpPut).store(put_, std::memory_order_release);
    waits.store(ring_is_full_ ? 1 : 0);
    if (!ring_is_full_) break;
  }
  if (ended) fail(Error::kBoardGone);
  return !ended;
}

}  // namespace gicube::pci
