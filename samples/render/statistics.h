// What one frame cost, as the JSON file of --stats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "gicube/board.h"

namespace gicube::samples {

// The frame's window: from before the rendering until the image is on the host.
struct FrameStatistics {
  BoardInfo board;
  Counters counters;        // of the window
  Picoseconds frame = 0;    // simulated, rendering and framebuffer transfer
  Picoseconds load = 0;     // simulated, volume and tables
  double host_seconds = 0;  // wall clock, of the window
  int width = 0, height = 0;
  Dims dims{};  // voxels
  std::uint64_t seed = 0;
};

// Simulated milliseconds in which the bus was busy in the window, both directions added.
double bus_ms(const Counters& counters);

// Keys: frame_ms load_ms bus_ms host_seconds samples samples_per_second throughput hit_ratio memory_gb_s
// memory_utilisation load_balance dsp_utilisation config_hash fidelity seed image volume counters. Samples and memory
// traffic are per second of the ASIC's work, throughput is the share of pipeline cycles that took a sample, hit_ratio is
// of voxels, load_balance the share of the time in which a processor held rays. A figure that the board's fidelity level
// does not model is null.
nlohmann::ordered_json to_json(const FrameStatistics& statistics);

// Throws InputError if the file can't be written.
void write_statistics(const FrameStatistics& statistics, const std::filesystem::path& path);

}  // namespace gicube::samples
