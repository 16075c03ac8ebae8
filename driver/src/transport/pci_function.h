// A session with a board over a PCI function (gicube/wire/pci_function.h): this process is the function's driver, with
// its registers mapped and its rings in a huge page. A thread moves bytes between the rings and a socket, of which the
// link has the other end.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "fd.h"
#include "ring.h"

namespace gicube {

class PciFunction {
 public:
  // `address`: such as 0000:00:04.0. Throws OpenFailed with what is missing, and BoardBusy if another process has
  // opened it.
  explicit PciFunction(const std::string& address);
  // Ends the session. Waits up to a second for the board to take the link's last frames.
  ~PciFunction();

  PciFunction(const PciFunction&) = delete;
  PciFunction& operator=(const PciFunction&) = delete;

  // The link's end of the socket pair. Can be taken once.
  Fd take_socket() { return std::move(link_end_); }

 private:
  std::uint32_t read(std::uint32_t offset) const;
  void write(std::uint32_t offset, std::uint32_t value) const;
  std::uint32_t index(std::uint32_t of) const;
  // False if bits can't be changed.
  bool set_command(unsigned set, unsigned clear) const;

  void run();
  bool move_down();
  bool move_up();
  bool is_over(std::chrono::steady_clock::time_point now);
  void wait(std::chrono::nanoseconds idle);

  Fd registers_file_, config_, interrupts_;  // the last: -1 without uio_pci_generic
  Mapping registers_, rings_;
  std::span<std::byte> down_, up_;
  std::uint32_t put_ = 0, taken_ = 0;  // ours
  Fd socket_, link_end_;
  // When the thread must end, even if something is left to move.
  std::atomic<std::chrono::steady_clock::time_point> end_ = std::chrono::steady_clock::time_point::max();
  bool link_has_closed_ = false, has_ended_ = false, ring_is_full_ = false, socket_is_full_ = false;
  std::chrono::steady_clock::time_point looked_;  // when a register last said that the session is open
  std::thread thread_;
};

}  // namespace gicube
