// Lists of records of the wire: in a checkpoint, and as memory that the host reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/record.h"

namespace gicube::emu {

// Saves or restores the bytes of the records, at most `max_bytes`.
template <typename List>
void records_state(Archive& archive, std::string_view name, List& list, std::uint64_t max_bytes) {
  using Record = typename List::value_type;
  std::vector<std::uint8_t> bytes;
  for (const Record& each : list) wire::append(bytes, each);
  archive.bytes(name, bytes, 0, max_bytes);
  if (!archive.loads()) return;
  list.clear();
  constexpr std::size_t kEach = wire::bytes_of<Record>();
  if constexpr (requires { list.reserve(0); }) list.reserve(bytes.size() / kEach);
  for (std::size_t at = 0; at + kEach <= bytes.size(); at += kEach) {
    list.push_back(wire::decode<Record>(std::span(bytes).subspan(at)));
  }
}

// The bytes of a range of whole records; nothing if it is no such range.
template <typename Record>
std::optional<std::vector<std::uint8_t>> read_records(const std::vector<Record>& list, std::uint64_t offset,
                                                      std::uint64_t length) {
  constexpr std::uint64_t kEach = wire::bytes_of<Record>();
  if (offset % kEach != 0 || length % kEach != 0 || (offset + length) / kEach > list.size()) return std::nullopt;
  std::vector<std::uint8_t> out;
  out.reserve(static_cast<std::size_t>(length));
  const auto first = static_cast<std::size_t>(offset / kEach);
  for (const Record& each : std::span(list).subspan(first, static_cast<std::size_t>(length / kEach))) {
    wire::append(out, each);
  }
  return out;
}

}  // namespace gicube::emu
