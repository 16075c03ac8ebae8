// Boards as Prometheus metrics, in its text format.
#pragma once

#include <string>
#include <vector>

#include "local_boards.h"

namespace gicube::smi {

inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

// Counters by Prometheus' rules: `bus.down.busy_ps` is gicube_bus_down_busy_seconds_total, in seconds;
// `processor0.sorter.issued` (unit ray) is gicube_processor_sorter_issued_rays_total{processor="0"}, and queries sum
// over processors. All have the labels pid and board.
std::string metrics_text(const std::vector<LocalProcess>& processes);

}  // namespace gicube::smi
