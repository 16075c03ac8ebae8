#include "qemu_messages.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <bit>
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

void take_files(msghdr& message, std::vector<Fd>& files) {
  for (cmsghdr* each = CMSG_FIRSTHDR(&message); each != nullptr; each = CMSG_NXTHDR(&message, each)) {
    if (each->cmsg_level != SOL_SOCKET || each->cmsg_type != SCM_RIGHTS) continue;
    const std::span<const std::uint8_t> data(CMSG_DATA(each), each->cmsg_len - CMSG_LEN(0));
    for (std::size_t at = 0; at < data.size(); at += sizeof(int)) files.emplace_back(number_at<int>(data, at));
  }
}

// Whole, or false: the stream has ended. Files come with the first byte.
bool receive_bytes(int socket, std::span<std::uint8_t> bytes, std::vector<Fd>& files) {
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
    if (got <= 0) return false;
    take_files(message, files);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

std::optional<std::size_t> data_bytes(std::span<const std::uint8_t, kMessageHeaderBytes> header) {
  const auto size = number_at<std::uint64_t>(header, 8);
  return size <= kMaxMessageBytes ? std::optional(static_cast<std::size_t>(size)) : std::nullopt;
}

std::optional<Message> decode(std::span<const std::uint8_t, kMessageHeaderBytes> header,
                              std::span<const std::uint8_t> data, std::vector<Fd> files) {
  struct Shape {
    std::size_t bytes, min_files, max_files;
  };
  constexpr Shape kShapes[] = {{kMaxMessageBytes, 0, kMaxRegions},
                               {1, 0, 0},
                               {12, 0, 0},
                               {12, 0, 0},
                               {24, 0, 0},
                               {24, 0, 0},
                               {0, 2, 2},
                               {0, 0, 0}};
  const auto number = number_at<std::uint32_t>(header, 0);
  if (number >= std::size(kShapes)) return std::nullopt;
  Message message{static_cast<MessageKind>(number)};
  const auto& [bytes, min_files, max_files] = kShapes[number];
  const bool fits = data.size() == bytes && files.size() >= min_files && files.size() <= max_files;
  if (!fits || message.kind == MessageKind::kAnswer) return std::nullopt;
  switch (message.kind) {
    case MessageKind::kMemoryMap:
      for (std::size_t i = 0; i < files.size(); ++i) {  // three arrays of eight: addresses, sizes, offsets
        message.map.push_back({number_at<std::uint64_t>(data, 8 * i), number_at<std::uint64_t>(data, 64 + 8 * i),
                               number_at<std::uint64_t>(data, 128 + 8 * i), std::move(files[i])});
      }
      break;
    case MessageKind::kConfigWrite:
    case MessageKind::kConfigRead:
      message.address = number_at<std::uint32_t>(data, 0);
      message.value = number_at<std::uint32_t>(data, 4);
      message.size = number_at<std::uint32_t>(data, 8);
      break;
    case MessageKind::kBarWrite:
    case MessageKind::kBarRead:
      message.address = number_at<std::uint64_t>(data, 0);
      message.value = number_at<std::uint64_t>(data, 8);
      message.size = number_at<std::uint32_t>(data, 16);
      message.is_memory = data[20] != 0;
      break;
    default: message.files = std::move(files);
  }
  return message;
}

std::array<std::uint8_t, kMessageHeaderBytes + 8> answer(std::uint64_t value) {
  struct {
    MessageKind kind = MessageKind::kAnswer;
    std::uint32_t padding = 0;
    std::uint64_t size = 8, value;
  } const message{.value = value};
  return std::bit_cast<std::array<std::uint8_t, kMessageHeaderBytes + 8>>(message);
}

std::optional<Message> receive(int socket) {
  std::array<std::uint8_t, kMessageHeaderBytes> header{};
  std::array<std::uint8_t, kMaxMessageBytes> data{};
  std::vector<Fd> files;
  if (!receive_bytes(socket, header, files)) return std::nullopt;
  const auto size = data_bytes(header);
  if (size && !receive_bytes(socket, std::span(data).first(*size), files)) return std::nullopt;
  auto message = size ? decode(header, std::span(data).first(*size), std::move(files)) : std::nullopt;
  if (!message) {
    throw std::runtime_error(fmt::format(
        "expected a message of QEMU's x-pci-proxy-dev, got command {} with {} bytes; it was written for QEMU 7.2",
        number_at<std::uint32_t>(header, 0), number_at<std::uint64_t>(header, 8)));
  }
  return message;
}

}  // namespace gicube::pci
