// Use of the host computer by a run.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

namespace gicube::samples {

struct HostUsage {
  double cpu_seconds = 0;  // user and system, all threads
  double peak_mib = 0;     // the largest resident memory
};

// Usage of this process and of its boards so far. Boards are running processes that this one has started; their seconds
// (in steps of 10 ms) and peaks are added. Nothing if there is no such board, or if the system does not report it.
struct RunUsage {
  HostUsage program;
  std::optional<HostUsage> boards;
};
RunUsage host_usage();

// Keys: program_cpu_s program_peak_mib board_cpu_s board_peak_mib.
nlohmann::ordered_json to_json(const RunUsage& usage);

}  // namespace gicube::samples
