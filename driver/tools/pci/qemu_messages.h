// The messages between QEMU's device x-pci-proxy-dev and the process that is the device.
//
// Source: QEMU 7.2, include/hw/remote/mpqemu-link.h (records and numbers), hw/remote/proxy.c and
// proxy-memory-listener.c (what is sent when). A message is a header of 16 bytes (command, 4 bytes of padding, size of
// the data) and the data, in the machine's byte order; files come beside the header. QEMU waits for an answer to
// configuration, BAR and reset messages, not to the other two.
#pragma once

#include <array>
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
  kMemoryMap = 0,  // a file each region
  kAnswer = 1,
  kConfigWrite = 2,
  kConfigRead = 3,
  kBarWrite = 4,
  kBarRead = 5,
  kInterruptFiles = 6,  // two eventfds: raises INTx; INTx was acknowledged
  kReset = 7
};

struct Message {
  MessageKind kind{};
  std::uint64_t address = 0;  // in the configuration space; of the guest's memory or I/O ports
  std::uint64_t value = 0;
  std::uint64_t size = 0;           // bytes of an access
  bool is_memory = false;           // kBarRead, kBarWrite: else I/O ports
  std::vector<MemoryRegion> map{};  // kMemoryMap
  std::vector<Fd> files{};          // kInterruptFiles
};

// The size of the data that a header announces; nothing if it is more than any message has.
std::optional<std::size_t> data_bytes(std::span<const std::uint8_t, kMessageHeaderBytes> header);

// Nothing if it is no message that QEMU sends.
std::optional<Message> decode(std::span<const std::uint8_t, kMessageHeaderBytes> header,
                              std::span<const std::uint8_t> data, std::vector<Fd> files);

// The answer with one value.
std::array<std::uint8_t, kMessageHeaderBytes + 8> answer(std::uint64_t value);

// Waits for the next message. Nothing at the end of the stream. Throws std::runtime_error for something that is no
// message.
std::optional<Message> receive(int socket);

}  // namespace gicube::pci
