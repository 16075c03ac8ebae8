// Cost of one frame, as the JSON file of --stats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/board_group.h"
#include "gicube/light_plan.h"
#include "gicube/plan.h"
#include "scene/program/host_usage.h"

namespace gicube::samples {

// An illumination pass, and whether a picture reused it.
struct LightingStatistics {
  std::string channel = "all";  // or red, green, blue
  Illumination settings;
  LightingReport report;
  std::size_t lights = 0;
  Picoseconds duration = 0;  // simulated
  double host_seconds = 0;   // wall clock
  Counters counters;         // of the pass
  bool reused = false;
};

// Work of one of several hosts for a frame.
struct RankStatistics {
  Picoseconds work = 0;  // simulated, of its board
  double bus_ms = 0;     // of that, on the host bus
  std::uint64_t samples = 0;
  std::uint64_t rays_sent = 0;   // to other ranks' boards, or back to their origin
  std::uint64_t bytes_sent = 0;  // to other ranks, in total
};

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
  std::uint64_t scene_hash = 0;
  double time = 0;                           // seconds, of the scene's engines
  std::vector<LightingStatistics> lighting;  // several with colour passes
  std::optional<Plan> plan;                  // of the picture
  std::vector<LightPlan> light_plans;        // of its light, one per pass
  std::vector<BoardTime> boards;             // with several boards: the parts of each one's simulated time
  std::optional<BrickDetail> detail;         // with --brick-detail, of a volume larger than the card
  bool own_buses = false;                    // with several boards: whether each has its own bus
  std::uint64_t bytes_sent = 0;              // with several hosts: by this one to others
  std::vector<RankStatistics> ranks;         // with several hosts: of each; the longest work is the frame's time
  std::optional<RunUsage> host;              // of the whole run until this frame
  std::string invisible;                     // the reason why nothing is visible; empty: something is
  std::string look;                          // the automatic look and its reason; empty: it is not automatic
  nlohmann::ordered_json pixel;              // of --explain-pixel (pixel_life.h); null without it
};

// Keys: frame_ms load_ms bus_ms host_seconds samples samples_per_second throughput hit_ratio memory_gb_s
// memory_utilisation load_balance dsp_utilisation energy power config_hash fidelity seed time image volume brick_detail
// lighting plan boards host look bound invisible pixel counters fidelity_report (of program/run_json.h, as energy and
// power, with the lighting passes that were made). Samples and memory traffic are per second of the ASIC's work,
// throughput is the share of pipeline cycles that took a sample, hit_ratio is of voxels, load_balance the share of the
// time in which a processor held rays. A figure that the board's fidelity level does not model is null. lighting: null
// without lighting rays, else passes, each with channel, reused, pass_ms, the energy report in units of the lights'
// power, and its own counters. plan: null without one; its `light` has that of each pass. boards: null for one, else
// buses (shared, own) and each board's bus_ms, work_ms, bus_wait_ms and skew_ms, which add up to frame_ms; counters are
// the sums of all boards, and figures per second those of one board's ASIC. ranks: null for one host, else each one's
// work_ms, bus_ms, samples, rays_sent and bytes_sent, and `imbalance`; the counters are the first one's. host: of
// program/host_usage.h. invisible: null, or why nothing is visible in the picture.
nlohmann::ordered_json to_json(const FrameStatistics& statistics);
// what_bounds() the frame.
std::string bound_of(const FrameStatistics& statistics);

// The sums of these windows' counters; of maxima the greatest.
Counters sum_of(const std::vector<const Counters*>& windows);
// Counters of these pictures and their lighting passes.
Counters counters_of(std::span<const FrameStatistics> frames);

// The largest number of samples of a rank relative to the mean.
double imbalance(const std::vector<RankStatistics>& ranks);

// With `provenance`, of the first picture. Throws InputError if the file can't be written.
void write_statistics(const FrameStatistics& statistics, const std::filesystem::path& path);
// Writes several pictures: keys frames (each as above, without the counters), illumination_passes (made, not reused)
// and volumes_loaded; counters and fidelity_report are those of all pictures and passes.
void write_statistics(const std::vector<FrameStatistics>& frames, const std::filesystem::path& path);

}  // namespace gicube::samples
