// One function of a guest: takes QEMU's messages, answers them, and raises INTx.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "config_space.h"
#include "function.h"
#include "qemu_messages.h"

namespace gicube::pci {

class Bridge {
 public:
  // `connect` as for Function.
  explicit Bridge(std::function<Connection()> connect) : function_(memory_, std::move(connect)) {}

  // The value of the answer; nothing if QEMU does not wait for one.
  std::optional<std::uint64_t> take(Message message);

  // Waits for the board, INTx's acknowledgement or, if it is not -1, the socket of QEMU, for the given time at most
  // (-1: no limit). True: there is a message from QEMU.
  bool wait(int qemu, int milliseconds);

  // Serves QEMU until it closes the socket. Throws what receive() does.
  void serve(int qemu);

 private:
  void update_interrupt();

  GuestMemory memory_;
  ConfigSpace config_;
  Function function_;
  Fd raise_, acknowledged_;  // eventfds
  bool raised_ = false;
};

}  // namespace gicube::pci
