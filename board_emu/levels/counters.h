// Sums of counters over the parts of a level's machine, and over its runs.
#pragma once

#include <string>
#include <vector>

#include "gicube/archive.h"
#include "levels/level.h"

namespace gicube::emu {

// Appends the counters of each part, such as "processor0.samples", and after all parts of a kind their sum,
// "processor.samples". All parts of a kind put the same counters in the same order.
class PartCounters {
 public:
  explicit PartCounters(std::vector<wire::Counter>& list) : list_(list) {}
  PartCounters(const PartCounters&) = delete;
  PartCounters& operator=(const PartCounters&) = delete;
  ~PartCounters() { end_kind(); }

  void begin(const std::string& kind, std::size_t number);
  void put(const std::string& name, const char* unit, std::uint64_t value);

 private:
  void end_kind();

  std::vector<wire::Counter>& list_;
  std::string kind_, prefix_;
  std::vector<wire::Counter> sums_;
  std::size_t at_ = 0;  // index into sums_
};

// Adds counters to those of the same names.
void add_counters(const std::vector<wire::Counter>& from, std::vector<wire::Counter>& to);

// Saves or restores `list`: values as field `name`, names and units as field `name`_names.
void counters_state(Archive& archive, std::string_view name, std::vector<wire::Counter>& list);

// Adds the result of one run of the ASIC to the result of a command. `core_khz`: the ASIC's clock.
void add_run(RunResult& to, const RunResult& run, std::uint64_t core_khz);

}  // namespace gicube::emu
