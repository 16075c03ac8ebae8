// The board's counters, as plain values. docs/reference/counters.md lists all of them: name, unit, level, meaning.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/export.h"

namespace gicube {

struct Counter {
  std::string name;  // dotted path, as "bus.down.busy_ps"
  std::string unit;
  std::uint64_t value = 0;
};

// Every counter only grows within a session: a window is its end minus its begin.
class Counters {
 public:
  Counters() = default;
  explicit Counters(std::vector<Counter> list) : list_(std::move(list)) {}

  const std::vector<Counter>& list() const { return list_; }

  // Null if the board has none of this name: its fidelity level does not keep it, nothing of its kind has happened yet
  // (parts of the ASIC are counted from the first command that their level carries out), or there is no such counter at
  // all.
  const Counter* find(std::string_view name) const {
    const auto found = std::ranges::find(list_, name, &Counter::name);
    return found == list_.end() ? nullptr : &*found;
  }
  bool has(std::string_view name) const { return find(name) != nullptr; }
  // 0 where find() is null, so that sums and shares hold on every level. A misspelt name also gives 0, so tests should
  // check has() first, or use gicube::test::counter_is().
  std::uint64_t value(std::string_view name) const { return has(name) ? find(name)->value : 0; }

  friend Counters operator-(const Counters& end, const Counters& begin) {
    Counters window = end;
    for (Counter& counter : window.list_) counter.value -= begin.value(counter.name);
    return window;
  }

 private:
  std::vector<Counter> list_;
};

}  // namespace gicube
