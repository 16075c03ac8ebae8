#include "qemu_messages.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace gicube::pci {
namespace {

// In the machine's byte order; the data has the bytes.
template <typename Number>
Number number_at(std::span<const std::uint8_t> data, std::size_t at) {
  Number number{};
  std::memcpy(&number, data.data() + at, sizeof number);
  return number;
}

constexpr std::size_t kConfigBytes = 12, kBarBytes = 24;

// Whole, or false: the stream has ended. Files may come with the first byte.
bool receive_bytes(int socket, std::span<std::uint8_t> bytes, std::vector<Fd>* files) {
  while (!bytes.empty()) {
    // One more than any message has, so that too many are seen.
    alignas(cmsghdr) std::array<char, CMSG_SPACE((kMaxRegions + 1) * sizeof(int))> control{};
    iovec part{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t got = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    if (got < 0 && errno == EINTR) continue;
    for (cmsghdr* each = CMSG_FIRSTHDR(&message); got >= 0 && each != nullptr; each = CMSG_NXTHDR(&message, each)) {
      if (each->cmsg_level != SOL_SOCKET || each->cmsg_type != SCM_RIGHTS) continue;
      const std::size_t count = (each->cmsg_len - CMSG_LEN(0)) / sizeof(int);
      for (std::size_t i = 0; i < count; ++i) {
        int file = -1;
        std::memcpy(&file, CMSG_DATA(each) + i * sizeof file, sizeof file);
        Fd owned(file);
        if (files != nullptr) files->push_back(std::move(owned));
      }
    }
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

std::optional<std::size_t> data_bytes(std::span<const std::uint8_t, kMessageHeaderBytes> header) {
  const auto size = number_at<std::uint64_t>(header, 8);
  if (size > kMaxMessageBytes) return std::nullopt;
  return static_cast<std::size_t>(size);
}

std::optional<Message> decode(std::span<const std::uint8_t, kMessageHeaderBytes> header,
                              std::span<const std::uint8_t> data, std::vector<Fd> files) {
  Message message;
  message.kind = static_cast<MessageKind>(number_at<std::uint32_t>(header, 0));
  const auto has = [&](std::size_t bytes, std::size_t count) { return data.size() == bytes && files.size() == count; };
  switch (message.kind) {
    case MessageKind::kMemoryMap:
      if (data.size() != kMaxMessageBytes || files.size() > kMaxRegions) return std::nullopt;
      for (std::size_t i = 0; i < files.size(); ++i) {  // three arrays of eight: addresses, sizes, offsets
        message.map.push_back({number_at<std::uint64_t>(data, 8 * i), number_at<std::uint64_t>(data, 64 + 8 * i),
                               number_at<std::uint64_t>(data, 128 + 8 * i), std::move(files[i])});
      }
      return message;
    case MessageKind::kConfigWrite:
    case MessageKind::kConfigRead:
      if (!has(kConfigBytes, 0)) return std::nullopt;
      message.address = number_at<std::uint32_t>(data, 0);
      message.value = number_at<std::uint32_t>(data, 4);
      message.size = number_at<std::uint32_t>(data, 8);
      return message;
    case MessageKind::kBarWrite:
    case MessageKind::kBarRead:
      if (!has(kBarBytes, 0)) return std::nullopt;
      message.address = number_at<std::uint64_t>(data, 0);
      message.value = number_at<std::uint64_t>(data, 8);
      message.size = number_at<std::uint32_t>(data, 16);
      message.is_memory = data[20] != 0;
      return message;
    case MessageKind::kInterruptFiles:
      if (!has(0, 2)) return std::nullopt;
      message.files = std::move(files);
      return message;
    case MessageKind::kReset: return has(0, 0) ? std::optional(std::move(message)) : std::nullopt;
    case MessageKind::kAnswer: break;
  }
  return std::nullopt;
}

std::array<std::uint8_t, kMessageHeaderBytes + 8> answer(std::uint64_t value) {
  std::array<std::uint8_t, kMessageHeaderBytes + 8> bytes{};
  const auto kind = static_cast<std::uint32_t>(MessageKind::kAnswer);
  const std::uint64_t size = sizeof value;
  std::memcpy(bytes.data(), &kind, sizeof kind);
  std::memcpy(bytes.data() + 8, &size, sizeof size);
  std::memcpy(bytes.data() + kMessageHeaderBytes, &value, sizeof value);
  return bytes;
}

std::optional<Message> receive(int socket) {
  std::array<std::uint8_t, kMessageHeaderBytes> header{};
  std::vector<Fd> files;
  if (!receive_bytes(socket, header, &files)) return std::nullopt;
  const auto size = data_bytes(header);
  std::array<std::uint8_t, kMaxMessageBytes> data{};
  if (size && !receive_bytes(socket, std::span(data).first(*size), nullptr)) return std::nullopt;
  auto message = size ? decode(header, std::span(data).first(*size), std::move(files)) : std::nullopt;
  if (!message) {
    throw std::runtime_error(fmt::format(
        "expected a message of QEMU's x-pci-proxy-dev, got command {} with {} bytes; it was written for QEMU 7.2",
        number_at<std::uint32_t>(header, 0), number_at<std::uint64_t>(header, 8)));
  }
  return message;
}

}  // namespace gicube::pci
