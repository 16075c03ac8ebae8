// Use of the host computer by a run.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

namespace gicube::samples {

struct HostUsage {
  double cpu_seconds = 0;  // user and system, all threads
  double peak_mib = 0;     // most memory that was ever resident
};

// Usage of this process and of its boards so far. Boards are processes that this one started and that still run: their
// seconds and peaks are added (seconds in steps of 10 ms). None if there is no such board, or on a system that does not
// report it.
struct RunUsage {
  HostUsage program;
  std::optional<HostUsage> boards;
};
RunUsage host_usage();

// Keys: program_cpu_s program_peak_mib board_cpu_s board_peak_mib.
nlohmann::ordered_json to_json(const RunUsage& usage);

}  // namespace gicube::samples
