#include "gicube/enumerate.h"

#include <poll.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "gicube/error.h"
#include "gicube/registry.h"
#include "transport/connect.h"
#include "transport/pci_devices.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience{2};  // chosen: a running board answers within milliseconds
constexpr std::size_t kLongestAnswer = std::size_t{16}
                                       << 20;  // chosen: with all counters of 64 boards it is a hundredth

// The answer is a gicube.v1.BoardProcess (proto/gicube/v1/management.proto). The driver reads six of its fields, and
// does without Protobuf for them: calls take(field, number, bytes) for each field of a message. False if that is none.
bool read_fields(std::string_view message,
                 const std::function<void(std::uint64_t, std::uint64_t, std::string_view)>& take) {
  const auto number = [&message]() -> std::optional<std::uint64_t> {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && !message.empty(); shift += 7) {
      const auto byte = static_cast<unsigned char>(message.front());
      message.remove_prefix(1);
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) return value;
    }
    return std::nullopt;
  };
  while (!message.empty()) {
    const auto tag = number();
    if (!tag) return false;
    std::optional<std::uint64_t> value = 0;
    std::uint64_t bytes = 0;
    switch (*tag & 7) {
      case 0: value = number(); break;
      case 1: bytes = 8; break;
      case 2:
        value = number();
        bytes = value.value_or(0);
        break;
      case 5: bytes = 4; break;
      default: return false;
    }
    if (!value || bytes > message.size()) return false;
    take(*tag >> 3, *value, message.substr(0, bytes));
    message.remove_prefix(bytes);
  }
  return true;
}

// The process's answer; nothing if none came in time.
std::optional<std::string> answer_of(const fs::path& socket, Clock::time_point end) {
  boost::system::error_code error;
  Uri uri;
  uri.scheme = UriScheme::kUnix;
  uri.path = socket.string();
  const Fd connected = try_to_connect(uri, kPatience, error);
  if (error) return std::nullopt;
  std::string answer;
  for (char part[4096]; answer.size() < kLongestAnswer;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd waits{connected.get(), POLLIN, 0};
    if (left <= 0 || ::poll(&waits, 1, static_cast<int>(left)) <= 0) return std::nullopt;
    const ssize_t count = ::read(connected.get(), part, sizeof part);
    if (count == 0) return answer;
    if (count < 0) return std::nullopt;
    answer.append(part, static_cast<std::size_t>(count));
  }
  return std::nullopt;
}

// By their processes.
void find_local(std::vector<FoundBoard>& found) {
  const std::string folder = registry_folder();
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder, error))) return;  // no board has run yet
  if (const std::string fault = registry_fault(folder); !fault.empty()) throw Error(fault);
  std::vector<std::pair<std::uint32_t, fs::path>> sockets;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::uint32_t process = 0;
    const auto [end, fault] = std::from_chars(name.data(), name.data() + name.size(), process);
    if (fault == std::errc{} && end == name.data() + name.size()) sockets.emplace_back(process, entry.path());
  }
  std::ranges::sort(sockets);
  const auto end = Clock::now() + kPatience;
  for (const auto& [process, socket] : sockets) {
    const auto answer = answer_of(socket, end);
    if (!answer) continue;
    std::vector<FoundBoard> boards;
    const bool whole =
        read_fields(*answer, [&, id = process](std::uint64_t field, std::uint64_t, std::string_view bytes) {
          if (field != 3) return;
          FoundBoard& board = boards.emplace_back();
          board.process = id;
          read_fields(bytes, [&board](std::uint64_t of, std::uint64_t number, std::string_view text) {
            if (of == 2) board.product = text;
            if (of == 3) board.version = text;
            if (of == 4) board.uri = text;
            if (of == 5) board.in_use = number != 0;
            if (of == 9) board.owner = text;
          });
        });
    if (!whole) continue;
    const auto listens = [](const FoundBoard& board) {
      return board.uri.starts_with("unix:") || board.uri.starts_with("tcp:") || board.uri.starts_with("tls:");
    };
    std::ranges::copy_if(std::move(boards), std::back_inserter(found), listens);
  }
}

}  // namespace

std::vector<FoundBoard> enumerate() {
  std::vector<FoundBoard> found;
  find_local(found);
  for (const auto& [address, in_use] : pci_devices()) {
    FoundBoard& board = found.emplace_back();
    board.uri = "pci:" + address;
    board.product = "GI-Cube (PCI function)";
    board.in_use = in_use;
  }
  return found;
}

}  // namespace gicube
