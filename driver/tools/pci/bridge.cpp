#include "bridge.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace gicube::pci {

std::optional<std::uint64_t> Bridge::take(Message message) {
  std::uint64_t value = 0;
  const bool is_asked = message.kind != MessageKind::kMemoryMap && message.kind != MessageKind::kInterruptFiles;
  // Addresses of BAR accesses are those of the guest's memory.
  const std::uint64_t in_bar = message.address % wire::kBar0Bytes;
  switch (message.kind) {
    case MessageKind::kMemoryMap:
      memory_.map(message.map);
      function_.memory_changed();
      break;
    case MessageKind::kInterruptFiles:
      raise_ = std::move(message.files[0]);
      acknowledged_ = std::move(message.files[1]);
      raised_ = false;
      break;
    case MessageKind::kConfigRead: value = config_.read(message.address, message.size); break;
    case MessageKind::kConfigWrite:
      if (config_.write(message.address, message.size, message.value)) function_.reset();
      break;
    case MessageKind::kBarRead: value = function_.read(in_bar, message.size); break;
    case MessageKind::kBarWrite: function_.write(in_bar, message.size, message.value); break;
    default:  // kReset
      config_.reset();
      function_.reset();
  }
  function_.let_master_bus(config_.may_master_bus());
  update_interrupt();
  return is_asked ? std::optional(value) : std::nullopt;
}

// INTx is a level. KVM holds it until the guest acknowledges it, and then asks whether it is still set.
void Bridge::update_interrupt() {
  const bool pending = function_.interrupt_is_pending();
  config_.show_interrupt(pending);
  const bool level = pending && !config_.interrupts_are_disabled();
  if (level && !raised_ && raise_.get() >= 0) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(raise_.get(), &one, sizeof one);
  }
  raised_ = level;
}

bool Bridge::wait(int qemu, int milliseconds) {
  // poll() ignores a negative file; without events it still reports that the peer has closed.
  std::array<pollfd, 3> files{
      {{qemu, POLLIN, 0}, {function_.board_socket(), function_.board_events(), 0}, {acknowledged_.get(), POLLIN, 0}}};
  // While the guest's ring is full and the board takes bytes, only a bell changes the state: poll() would report a
  // closed peer each time.
  if (files[1].events == 0) files[1].fd = -1;
  if (::poll(files.data(), files.size(), milliseconds) <= 0) return false;
  if (files[1].revents != 0) function_.move();
  if (files[2].revents != 0) {
    std::uint64_t count = 0;
    if (::read(acknowledged_.get(), &count, sizeof count) != sizeof count) acknowledged_.reset();
    raised_ = false;
  }
  update_interrupt();
  return files[0].revents != 0;
}

void Bridge::serve(int qemu) {
  for (;;) {
    if (!wait(qemu, -1)) continue;
    auto message = receive(qemu);
    if (!message) return;
    const auto value = take(std::move(*message));
    if (value && !send_answer(qemu, *value)) return;
  }
}

}  // namespace gicube::pci
