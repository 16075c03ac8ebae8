#include "qemu_messages.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace gicube::pci {
namespace {

// In the machine's byte order. `data` must be long enough.
template <typename Number>
Number number_at(std::span<const std::uint8_t> data, std::size_t at) {
  Number number{};
  std::memcpy(&number, data.data() + at, sizeof number);
  return number;
}

bool fits(MessageKind kind, std::size_t bytes, std::size_t files) {
  constexpr std::array<std::size_t, 8> kBytes{kMaxMessageBytes, 0, 12, 12, 24, 24, 0, 0};
  const auto number = static_cast<std::size_t>(kind);
  if (number >= kBytes.size() || bytes != kBytes[number] || kind == MessageKind::kAnswer) return false;
  if (kind == MessageKind::kMemoryMap) return files <= kMaxRegions;
  return files == (kind == MessageKind::kInterruptFiles ? 2 : 0);
}

}  // namespace

std::optional<Message> decode(std::span<const std::uint8_t, kMessageHeaderBytes> header,
                              std::span<const std::uint8_t> data, std::vector<Fd> files) {
  Message message{static_cast<MessageKind>(number_at<std::uint32_t>(header, 0))};
  if (!fits(message.kind, data.size(), files.size())) return std::nullopt;
  if (message.kind == MessageKind::kMemoryMap) {
    for (std::size_t i = 0; i < files.size(); ++i) {  // three arrays of eight: addresses, sizes, offsets
      const auto word = [&](std::size_t array) { return number_at<std::uint64_t>(data, 64 * array + 8 * i); };
      message.map.push_back({word(0), word(1), word(2), std::move(files[i])});
    }
    return message;
  }
  // An address, a value and a size, of 32 bits each; in messages of BARs address and value have 64. The next byte is 1
  // for memory and 0 for I/O ports, of which the function has none.
  if (data.size() == 12) {
    message.address = number_at<std::uint32_t>(data, 0);
    message.value = number_at<std::uint32_t>(data, 4);
    message.size = number_at<std::uint32_t>(data, 8);
  } else if (data.size() == 24) {
    message.address = number_at<std::uint64_t>(data, 0);
    message.value = number_at<std::uint64_t>(data, 8);
    message.size = number_at<std::uint32_t>(data, 16);
  }
  message.files = std::move(files);
  return message;
}

std::optional<Message> receive(int socket) {
  std::array<std::uint8_t, kMessageHeaderBytes> header{};
  std::array<std::uint8_t, kMaxMessageBytes> data{};
  // Room for one file more than any message has, to detect too many.
  alignas(cmsghdr) std::array<char, CMSG_SPACE((kMaxRegions + 1) * sizeof(int))> control{};
  iovec part{header.data(), header.size()};
  msghdr parts{nullptr, 0, &part, 1, control.data(), control.size(), 0};
  const ssize_t got = ::recvmsg(socket, &parts, MSG_CMSG_CLOEXEC | MSG_WAITALL);
  if (got < 0 && errno != ECONNRESET) {
    throw std::runtime_error(fmt::format("cannot receive from file {}: {}", socket, std::strerror(errno)));
  }
  if (got != static_cast<ssize_t>(header.size())) return std::nullopt;
  std::vector<Fd> files;
  if (const cmsghdr* const rights = CMSG_FIRSTHDR(&parts); rights != nullptr && rights->cmsg_type == SCM_RIGHTS) {
    const std::span<const std::uint8_t> numbers(CMSG_DATA(rights), rights->cmsg_len - CMSG_LEN(0));
    for (std::size_t at = 0; at < numbers.size(); at += sizeof(int)) files.emplace_back(number_at<int>(numbers, at));
  }
  const auto bytes = number_at<std::uint64_t>(header, 8);
  std::optional<Message> message;
  if (bytes <= data.size()) {
    const ssize_t more = bytes > 0 ? ::recv(socket, data.data(), bytes, MSG_WAITALL) : 0;
    if (more != static_cast<ssize_t>(bytes)) return std::nullopt;
    message = decode(header, std::span(data).first(bytes), std::move(files));
  }
  if (!message) {
    throw std::runtime_error(fmt::format(
        "expected a message of QEMU's x-pci-proxy-dev, got command {} with {} bytes; it was written for QEMU 7.2",
        number_at<std::uint32_t>(header, 0), bytes));
  }
  return message;
}

bool send_answer(int socket, std::uint64_t value) {
  static_assert(std::endian::native == std::endian::little, "the command is the first half of its word");
  const std::array<std::uint64_t, 3> words{static_cast<std::uint64_t>(MessageKind::kAnswer), sizeof value, value};
  return ::send(socket, words.data(), sizeof words, MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof words);
}

}  // namespace gicube::pci
