// gicube-render: pictures of a volume or a scene from a GI-Cube board.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "gicube/scene/image_file.h"
#include "render/hosts.h"
#include "render/pixel_life.h"
#include "render/planning.h"
#include "render/renderer.h"
#include "scene/common/whole_file.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace {

using namespace gicube::samples;
using gicube::LightingReport;

// Prints the energies of the lighting pass.
void print_lighting(const LightingStatistics& lighting) {
  const LightingReport& report = lighting.report;
  const auto percent = [&report](double energy) { return report.emitted > 0 ? 100 * energy / report.emitted : 0; };
  fmt::print(
      "light ({}): {} rays, {:.3f} ms simulated; {:.1f}% stayed, {:.1f}% escaped, {:.1f}% lost, {:.2f}% clipped{}\n",
      lighting.channel, report.rays, gicube::to_ms(lighting.duration), percent(report.deposited),
      percent(report.escaped), percent(report.scattered_away), percent(report.clipped),
      lighting.reused ? " (reused)" : "");
  for (const std::string& warning : report.warnings) warn(warning);
}

// Prints how several boards spend their time, on average.
void print_boards(const FrameStatistics& statistics) {
  gicube::BoardTime sum;
  for (const gicube::BoardTime& time : statistics.boards) {
    sum = {sum.bus + time.bus, sum.work + time.work, sum.bus_wait + time.bus_wait, sum.skew + time.skew};
  }
  const auto percent = [&](gicube::Picoseconds time) {
    return 100 * static_cast<double>(time) /
           static_cast<double>(std::max<gicube::Picoseconds>(sum.bus + sum.work + sum.bus_wait + sum.skew, 1));
  };
  fmt::print(
      "{} boards, {}: each works {:.1f}% of the frame, transfers {:.1f}%, waits {:.1f}% for the bus and {:.1f}% for "
      "the last one\n",
      statistics.boards.size(), statistics.own_buses ? "own buses" : "a shared bus", percent(sum.work),
      percent(sum.bus), percent(sum.bus_wait), percent(sum.skew));
}

void print_detail(const FrameStatistics& statistics) {
  if (!statistics.detail) return;
  const gicube::BrickDetail& detail = *statistics.detail;
  const auto& [whole, of_2, of_4, of_8] = detail.blocks;
  fmt::print(
      "blocks: {} as they are, {} in cells of 2^3 voxels, {} of 4^3, {} of 8^3; densities within {:.0f} of 4095, "
      "opacities of a "
      "voxel within {:.4f}\n",
      whole, of_2, of_4, of_8, detail.largest_density, detail.largest_opacity);
}

// Prints the work of the ranks of a job.
void print_ranks(const std::vector<RankStatistics>& ranks) {
  const auto [least, most] = std::ranges::minmax_element(ranks, {}, &RankStatistics::work);
  std::uint64_t rays = 0, bytes = 0;
  for (const RankStatistics& rank : ranks) rays += rank.rays_sent, bytes += rank.bytes_sent;
  fmt::print(
      "{} hosts: each works {:.3f} to {:.3f} ms simulated, one takes {:.2f} times the mean of samples; {} rays and {} "
      "bytes between them\n",
      ranks.size(), gicube::to_ms(least->work), gicube::to_ms(most->work), imbalance(ranks), rays, bytes);
}

void print_summary(const std::filesystem::path& file, const FrameStatistics& statistics) {
  for (const LightingStatistics& lighting : statistics.lighting) {
    if (!lighting.reused) print_lighting(lighting);
  }
  const double frame_ms = gicube::to_ms(statistics.frame);
  const double boards = static_cast<double>(std::max<std::size_t>(statistics.boards.size(), 1));
  const double share = frame_ms > 0 ? 100 * bus_ms(statistics.counters) / frame_ms / boards : 0;
  fmt::print("{}: frame {:.3f} ms simulated, bus {:.1f}% of it, {}x{} pixels\n", file.string(), frame_ms, share,
             statistics.width, statistics.height);
  if (!statistics.boards.empty()) print_boards(statistics);
  if (const std::string bound = bound_of(statistics); !bound.empty()) fmt::print("{}\n", bound);
  print_detail(statistics);
  if (statistics.ranks.size() > 1) print_ranks(statistics.ranks);
  const auto json = to_json(statistics);
  if (json.at("hit_ratio").is_null()) return;  // no time in the pipelines, or no sample taken
  fmt::print(
      "{:.1f} frames a second, {:.0f} M samples a second, hit ratio {:.1f}%, memory {:.2f} GB/s, DSP {:.0f}% busy\n",
      1e3 / frame_ms, json.at("samples_per_second").get<double>() * 1e-6, json.at("hit_ratio").get<double>() * 100,
      json.at("memory_gb_s").get<double>(), json.at("dsp_utilisation").get<double>() * 100);
  const std::string energy = energy_line(statistics.counters, statistics.frame, statistics.boards.size());
  if (!energy.empty()) fmt::print("energy of the frame: {}\n", energy);
}

// Prints the plan, unless it is that of the previous picture.
void explain_once(const RenderOptions& options, const FrameStatistics& statistics, std::vector<std::string>& last) {
  if (!statistics.plan) return;
  const std::vector<std::string> lines = explain(options.plan, *statistics.plan, statistics.light_plans);
  if (lines != last) print_plan(lines);
  last = lines;
}

// Warns, unless the previous picture had the same warning.
void warn_once(const std::string& text, std::string& last) {
  if (!text.empty() && text != last) warn(text);
  last = text;
}

void explain_pixel(const RenderOptions& options, const FrameStatistics& statistics) {
  if (statistics.pixel.is_null()) return;
  if (!options.board.quiet) fmt::print("{}", pixel_table(statistics.pixel));
  if (!options.explain_svg.empty()) write_whole(options.explain_svg, pixel_svg(statistics.pixel));
}

// Renders the pictures that `options` ask for, in their order, and calls `done` for each. `ranks`: of the job, null if
// there is one host.
void render_frames(const RenderOptions& options, ProgressLine& progress, const std::function<void(const Frame&)>& done,
                   gicube::MpiExchange* ranks) {
  const Steps steps = [&progress](const std::string& what) {
    progress.show(what);
    return progress.parts(what);
  };
  std::optional<Renderer> renderer;
  together(ranks, [&] { renderer.emplace(options, steps, std::function<void()>(), ranks); });
  const std::vector<double> times = frame_times(options.animation);
  for (auto first = static_cast<std::size_t>(options.checkpoint.first_frame); first < times.size();) {
    const std::size_t length = renderer->run_length(times, first);
    renderer->run(times, first, first + length, done);
    first += length;
  }
  if (!renderer->checkpoint_is_written()) {
    throw gicube::scene::InputError("--checkpoint-at", "a time or a ray before the last picture",
                                    "a later one: no checkpoint is written");
  }
}

// Nothing if help or the version was requested.
std::optional<RenderOptions> options_of(int argc, char** argv, const gicube::MpiExchange* ranks) {
  std::ostringstream unsaid;
  auto options = parse_options(argc, argv, ranks != nullptr && ranks->rank() > 0 ? unsaid : std::cout);
  if (!options) return options;
  if (ranks != nullptr) choose_part(*ranks, *options);
  std::vector<Output> outputs;
  for (int i = options->checkpoint.first_frame; i < options->animation.frames; ++i) {
    outputs.push_back({"--output", frame_file(options->output, options->animation, i)});
  }
  outputs.push_back({"--stats", options->board.stats});
  outputs.push_back({"--checkpoint", options->checkpoint.file});
  outputs.push_back({"--explain-svg", options->explain_svg});
  check_outputs(outputs, {options->input, options->transfer_function, options->lighting.field});
  return options;
}

int run(int argc, char** argv, gicube::MpiExchange* ranks) {
  std::optional<RenderOptions> options;
  if (ranks != nullptr && ranks->rank() > 0) gicube::scene::set_warning_handler({});  // rank 0 reads the same files
  together(ranks, [&] { options = options_of(argc, argv, ranks); });
  if (!options) return 0;
  std::vector<FrameStatistics> statistics;
  std::vector<std::string> plan;
  std::string invisible, look;
  {
    ProgressLine progress(!options->board.quiet);
    const auto done = [&](const Frame& frame) {
      if (ranks != nullptr && ranks->rank() > 0) return;
      const std::filesystem::path file = frame_file(options->output, options->animation, frame.number);
      write_image(frame.image, file, frame.background,
                  provenance_of(frame.statistics.board, frame.statistics.scene_hash));
      statistics.push_back(frame.statistics);
      progress.clear();
      if (options->plan.explain) explain_once(*options, frame.statistics, plan);
      if (!options->board.quiet && frame.statistics.look != look) fmt::print("{}\n", frame.statistics.look);
      look = frame.statistics.look;
      if (!options->board.quiet) print_summary(file, frame.statistics);
      if (!options->board.quiet) warn_once(frame.statistics.invisible, invisible);
      explain_pixel(*options, frame.statistics);
    };
    render_frames(*options, progress, done, ranks);
  }
  if (options->board.stats.empty()) return 0;
  if (options->animation.frames == 1) {
    write_statistics(statistics.front(), options->board.stats);
  } else {
    write_statistics(statistics, options->board.stats);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-render", [&] {
    if (!asks_for_hosts(argc, argv)) return run(argc, argv, nullptr);
    const auto ranks = open_hosts();
    return run_rank(*ranks, [&] { return run(argc, argv, ranks.get()); });
  });
}
