// Counters on the data plane: a list of (name, unit, value), sent in response to kCounters.
//
// The format is a u32 count, then for each counter: u8 name length, name, u8 unit length, unit, u64 value. Names are
// dotted paths such as "bus.down.busy_ps", truncated to 255 bytes. Counters never decrease within a session, so the
// value for an interval is the difference of two readings.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

struct Counter {
  std::string name;
  std::string unit;
  std::uint64_t value = 0;

  friend bool operator==(const Counter&, const Counter&) = default;
};

inline std::vector<std::uint8_t> encode(std::span<const Counter> counters) {
  std::vector<std::uint8_t> out(4);
  store(std::span(out), 0, static_cast<std::uint32_t>(counters.size()));
  const auto put_text = [&out](const std::string& text) {
    const auto length = static_cast<std::uint8_t>(std::min<std::size_t>(text.size(), 255));
    out.push_back(length);
    out.insert(out.end(), text.begin(), text.begin() + length);
  };
  for (const Counter& counter : counters) {
    put_text(counter.name);
    put_text(counter.unit);
    const std::size_t at = out.size();
    out.resize(at + 8);
    store(std::span(out), at, counter.value);
  }
  return out;
}

// Returns nothing if the list is truncated.
inline std::optional<std::vector<Counter>> decode_counters(std::span<const std::uint8_t> in) {
  if (in.size() < 4) return std::nullopt;
  const auto count = load<std::uint32_t>(in, 0);
  std::size_t at = 4;
  std::vector<Counter> counters;
  const auto get_text = [&in, &at](std::string& text) {
    if (at >= in.size() || in.size() - at - 1 < in[at]) return false;
    const std::size_t length = in[at];
    text.assign(in.begin() + static_cast<std::ptrdiff_t>(at + 1),
                in.begin() + static_cast<std::ptrdiff_t>(at + 1 + length));
    at += 1 + length;
    return true;
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    Counter counter;
    if (!get_text(counter.name) || !get_text(counter.unit) || in.size() - at < 8) return std::nullopt;
    counter.value = load<std::uint64_t>(in, at);
    at += 8;
    counters.push_back(std::move(counter));
  }
  return counters;
}

}  // namespace gicube::wire
