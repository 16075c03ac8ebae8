// The registers and rings of the function, and the connection to its board: moves bytes between the two without
// interpreting them.
//
// Whatever a guest writes, an access ends, reads and writes only mapped memory, and moves at most a ring's bytes in
// each direction.
#pragma once

#include <poll.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "gicube/wire/pci_function.h"
#include "guest_memory.h"
#include "transport/fd.h"

namespace gicube::pci {

// A connected board. `owner` ends the process of a private board when it is released.
struct Connection {
  Fd socket;
  std::shared_ptr<void> owner;
};

class Function {
 public:
  // `connect` is called for each session, and throws if the board can't be connected. `memory` outlives this.
  Function(const GuestMemory& memory, std::function<Connection()> connect);
  ~Function() { reset(); }
  Function(const Function&) = delete;
  Function& operator=(const Function&) = delete;

  // An access to BAR 0; `size` in bytes.
  std::uint64_t read(std::uint64_t offset, std::uint64_t size);
  void write(std::uint64_t offset, std::uint64_t size, std::uint64_t value);

  // Restores the state after power-up. Ends the session.
  void reset();
  void let_master_bus(bool may);
  // GuestMemory::map() was called: its bytes have moved.
  void memory_changed();

  bool interrupt_is_pending() const;

  // The board's socket, -1 without one, and the events of poll() to wait for. Call move() when one of them has
  // happened.
  int board_socket() const { return board_.socket.get(); }
  short board_events() const;
  void move();

 private:
  using Error = wire::function::Error;
  using State = wire::function::State;

  std::uint32_t& at(std::uint32_t offset) { return registers_[offset / 4]; }

  void open();
  // Ends the session.
  void close(State state);
  void fail(Error error);
  // Keeps the error if it is the first.
  void note(Error error);
  // False: the session has ended.
  bool move_down();
  bool move_up();

  const GuestMemory& memory_;
  const std::function<Connection()> connect_;
  std::array<std::uint32_t, wire::function::kInterruptMask / 4 + 1> registers_{};  // as they are read
  bool may_master_bus_ = false;

  // The session.
  Connection board_;
  std::span<std::byte> rings_;         // index page, down, up; empty without a session
  std::uint64_t session_address_ = 0;  // theirs
  std::uint32_t taken_ = 0, put_ = 0;  // ours, never read back from the guest's memory
  bool board_is_full_ = false, ring_is_full_ = false;
};

}  // namespace gicube::pci
