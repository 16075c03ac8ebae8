#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render/options.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"

namespace gicube::samples {

void add_checkpoint_options(CLI::App& app, RenderOptions& options) {
  OptionGroup group(app, "Checkpoints");
  group.parsed(
      "--checkpoint-at", "WHEN",
      "write a checkpoint of the board, with volume and light, between two pictures: frame=N, before picture N, "
      "from 0;\ntime=MS, before the first picture that begins at that simulated time or later; ray=N, before "
      "the picture with the run's viewing ray N, from 0",
      [&checkpoint = options.checkpoint](const std::string& name, const std::string& text) {
        using Unit = CheckpointOptions::Unit;
        static const std::map<std::string, Unit> kUnits{
            {"frame", Unit::kFrame}, {"time", Unit::kMilliseconds}, {"ray", Unit::kRay}};
        const std::size_t equals = std::min(text.find('='), text.size());
        const auto unit = kUnits.find(text.substr(0, equals));
        const auto number = parse_number<double>(equals < text.size() ? text.substr(equals + 1) : "");
        const bool is_good = unit != kUnits.end() && number && std::isfinite(*number) && *number >= 0 &&
                             (unit->second == Unit::kMilliseconds || *number == std::floor(*number));
        if (!is_good) {
          throw CLI::ValidationError(name, "expected frame=N, time=MS or ray=N, from 0, got " + in_quotes(text));
        }
        checkpoint.unit = unit->second;
        checkpoint.at = *number;
      });
  group.file("--checkpoint", options.checkpoint.file, "the checkpoint's file, with --checkpoint-at");
  group
      .file("--restore", options.board.restore,
            "continue from a checkpoint of this program with the same scene, including its volume and light")
      ->check(CLI::ExistingFile);
  group
      .value("--first-frame", options.checkpoint.first_frame,
             "with --restore: the picture with which the run continues (0)")
      ->check(CLI::Range(0, 100'000));
}

void check_checkpoint_options(const RenderOptions& options) {
  const CheckpointOptions& checkpoint = options.checkpoint;
  const bool writes = !checkpoint.file.empty(), restores = !options.board.restore.empty();
  if (writes != checkpoint.unit.has_value()) {
    throw UsageError(writes ? "--checkpoint: expected --checkpoint-at WHEN beside it, got none"
                            : "--checkpoint-at: expected --checkpoint FILE beside it, got none");
  }
  if (checkpoint.first_frame > 0 && !restores) {
    throw UsageError("--first-frame: expected --restore FILE beside it, got none");
  }
  if (checkpoint.first_frame >= options.animation.frames) {
    throw UsageError("--first-frame: expected less than --frames, " + std::to_string(options.animation.frames) +
                     ", got " + std::to_string(checkpoint.first_frame));
  }
  const bool has_frame = checkpoint.at >= checkpoint.first_frame && checkpoint.at < options.animation.frames;
  if (checkpoint.unit == CheckpointOptions::Unit::kFrame && !has_frame) {
    throw UsageError("--checkpoint-at: expected one of the pictures " + std::to_string(checkpoint.first_frame) +
                     " to " + std::to_string(options.animation.frames - 1) + ", got " +
                     fmt::format("{}", checkpoint.at));
  }
  if (!writes && !restores) return;
  expect_without(options, writes ? "--checkpoint" : "--restore",
                 {"--max-error or --time-budget", "--crop", "--level-of-detail", "--colour-passes", "--irradiance"});
}

}  // namespace gicube::samples
