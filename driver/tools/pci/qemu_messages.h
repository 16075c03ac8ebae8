// The messages between QEMU's device x-pci-proxy-dev and the process that implements it.
//
// Source: QEMU 7.2, include/hw/remote/mpqemu-link.h (records and numbers), hw/remote/proxy.c and
// proxy-memory-listener.c (what is sent when). A message is a header of 16 bytes (command, 4 bytes of padding, size of
// the data) and the data, in the machine's byte order; files come beside the header. QEMU waits for an answer to
// configuration, BAR and reset messages, not to the other two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "guest_memory.h"
#include "transport/fd.h"

namespace gicube::pci {

inline constexpr std::size_t kMessageHeaderBytes = 16;
inline constexpr std::size_t kMaxMessageBytes = 192;  // of data: a map of the memory
inline constexpr std::size_t kMaxRegions = 8;

enum class MessageKind : std::uint32_t {
  kMemoryMap = 0,  // one file per region
  kAnswer = 1,     // to QEMU
  kConfigWrite = 2,
  kConfigRead = 3,
  kBarWrite = 4,
  kBarRead = 5,
  kInterruptFiles = 6,  // two eventfds: raises INTx; INTx was acknowledged
  kReset = 7
};

struct Message {
  MessageKind kind{};
  std::uint64_t address = 0;  // in the configuration space, or of the guest's memory
  std::uint64_t value = 0;
  std::uint64_t size = 0;           // bytes of an access
  std::vector<MemoryRegion> map{};  // kMemoryMap
  std::vector<Fd> files{};          // kInterruptFiles
};

// Nothing if QEMU sends no such message.
std::optional<Message> decode(std::span<const std::uint8_t, kMessageHeaderBytes> header,
                              std::span<const std::uint8_t> data, std::vector<Fd> files);

// Waits for the next message. Nothing at the end of the stream. Throws std::runtime_error for anything else than a
// message.
std::optional<Message> receive(int socket);
// Answers it. False: the stream has ended.
bool send_answer(int socket, std::uint64_t value);

}  // namespace gicube::pci
