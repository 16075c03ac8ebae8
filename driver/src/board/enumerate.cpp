#include "gicube/enumerate.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "transport/board_processes.h"
#include "transport/pci_devices.h"

namespace gicube {
namespace {

// Calls take(field, number, bytes) for each field of a protobuf message. Returns false if the message is malformed. The
// driver needs only six fields of gicube.v1.BoardProcess (proto/gicube/v1/management.proto), so it does not link
// Protobuf.
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

// The boards of a process; none if its answer is something else.
std::vector<FoundBoard> boards_of(std::uint32_t process, std::string_view answer) {
  std::vector<FoundBoard> boards;
  const bool whole = read_fields(answer, [&](std::uint64_t field, std::uint64_t, std::string_view bytes) {
    if (field != 3) return;
    FoundBoard& board = boards.emplace_back();
    board.process = process;
    read_fields(bytes, [&board](std::uint64_t of, std::uint64_t number, std::string_view text) {
      if (of == 2) board.product = text;
      if (of == 3) board.version = text;
      if (of == 4) board.uri = text;
      if (of == 5) board.in_use = number != 0;
      if (of == 9) board.owner = text;
    });
  });
  if (!whole) boards.clear();
  return boards;
}

}  // namespace

std::vector<FoundBoard> enumerate() {
  std::vector<FoundBoard> found;
  const auto listens = [](const FoundBoard& board) {
    return board.uri.starts_with("unix:") || board.uri.starts_with("tcp:") || board.uri.starts_with("tls:");
  };
  for (const BoardProcess& process : board_processes()) {
    std::ranges::copy_if(boards_of(process.id, process.answer.value_or("")), std::back_inserter(found), listens);
  }
  for (const auto& [address, in_use] : pci_devices()) {
    FoundBoard& board = found.emplace_back();
    board.uri = "pci:" + address;
    board.product = "GI-Cube (PCI function)";
    board.in_use = in_use;
  }
  return found;
}

}  // namespace gicube
