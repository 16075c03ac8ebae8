// gicube-render: one picture of a volume from a GI-Cube board.
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "common/image_file.h"
#include "common/input_error.h"
#include "render/frame.h"

namespace {

using namespace gicube::samples;

constexpr int kFailed = 1, kWrongUsage = 2;  // exit codes

// An EXR has alpha instead; a colour asked for is passed on, and refused by write_image.
std::optional<gicube::Colour> background_of(const RenderOptions& options, const Frame& frame) {
  if (options.background) return options.background;
  return options.no_background || options.output.extension() == ".exr" ? std::nullopt : frame.background;
}

// Found before the work, not behind it.
void check_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw InputError(file.string(), "a folder that is there", "none");
}

void print_summary(const RenderOptions& options, const FrameStatistics& statistics) {
  const double frame_ms = gicube::to_ms(statistics.frame);
  const double share = frame_ms > 0 ? 100 * bus_ms(statistics.counters) / frame_ms : 0;
  fmt::print("{}: frame {:.3f} ms simulated, bus {:.1f}% of it, {}x{} pixels\n", options.output.string(), frame_ms,
             share, statistics.width, statistics.height);
  const auto json = to_json(statistics);
  if (json.at("hit_ratio").is_null()) return;  // no time in the pipelines, or no sample taken
  fmt::print(
      "{:.1f} frames a second, {:.0f} M samples a second, hit ratio {:.1f}%, memory {:.2f} GB/s, DSP {:.0f}% busy\n",
      1e3 / frame_ms, json.at("samples_per_second").get<double>() * 1e-6, json.at("hit_ratio").get<double>() * 100,
      json.at("memory_gb_s").get<double>(), json.at("dsp_utilisation").get<double>() * 100);
}

int run(int argc, char** argv) {
  const auto options = parse_options(argc, argv, std::cout);
  if (!options) return 0;
  check_folder(options->output);
  if (!options->board.stats.empty()) check_folder(options->board.stats);
  Frame frame;
  {
    ProgressLine progress(!options->board.quiet);
    frame = render_frame(*options, progress);
  }
  write_image(frame.image, options->output, background_of(*options, frame));
  if (!options->board.stats.empty()) write_statistics(frame.statistics, options->board.stats);
  if (!options->board.quiet) print_summary(*options, frame.statistics);
  return 0;
}

int report(const std::exception& error, int code) {
  std::cerr << "gicube-render: " << error.what() << '\n';
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    return report(error, kWrongUsage);
  } catch (const std::bad_alloc&) {
    std::cerr << "gicube-render: out of memory\n";
    return kFailed;
  } catch (const std::exception& error) {
    return report(error, kFailed);
  }
}
