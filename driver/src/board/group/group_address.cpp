#include "group_address.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

#include "gicube/error.h"

namespace gicube {
namespace {

std::size_t boards_of(std::string_view value) {
  std::size_t boards = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), boards);
  if (error == std::errc{} && end == value.data() + value.size() && boards >= 1 && boards <= kMaxBoards) return boards;
  throw BadArgument("URI option boards", fmt::format("a number from 1 to {}", kMaxBoards),
                    fmt::format("\"{}\"", value));
}

HostBuses buses_of(std::string_view value) {
  if (value == "shared") return HostBuses::kShared;
  if (value == "own") return HostBuses::kOwn;
  throw BadArgument("URI option buses", "shared or own", fmt::format("\"{}\"", value));
}

// Options that name a file which each board would write.
constexpr std::array<std::string_view, 4> kFilesOfOne{"trace=", "events=", "capture=", "fault_log="};

}  // namespace

GroupAddress parse_group(std::string_view address) {
  GroupAddress group;
  std::string one(address);
  std::optional<std::size_t> boards;
  if (address.starts_with("emu:?")) {
    one = "emu:";
    for (std::string_view rest = address.substr(5); !rest.empty();) {
      const std::string_view option = rest.substr(0, rest.find('&'));
      rest.remove_prefix(std::min(rest.size(), option.size() + 1));
      const bool is_boards = option.starts_with("boards="), is_buses = option.starts_with("buses=");
      if ((is_boards && boards) || (is_buses && group.buses)) {
        throw BadArgument("URI option " + std::string(option.substr(0, option.find('='))), "to be given once",
                          "it twice");
      }
      if (is_boards) {
        boards = boards_of(option.substr(7));
      } else if (is_buses) {
        group.buses = buses_of(option.substr(6));
      } else {
        one += (one.ends_with(':') ? '?' : '&') + std::string(option);
      }
    }
  }
  for (const std::string_view file : kFilesOfOne) {
    const bool asked = one.find("?" + std::string(file)) != std::string::npos ||
                       one.find("&" + std::string(file)) != std::string::npos;
    if (asked && boards.value_or(1) > 1) {
      throw BadArgument("URI option " + std::string(file.substr(0, file.size() - 1)),
                        "one board, since it writes the file", fmt::format("{}", *boards));
    }
  }
  group.boards.assign(boards.value_or(1), one);
  return group;
}

}  // namespace gicube
