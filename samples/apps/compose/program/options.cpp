#include "compose/program/options.h"

#include <ostream>

#include "scene/program/option_group.h"
#include "scene/program/program.h"

namespace gicube::samples {

std::optional<ComposeOptions> parse_compose_options(int argc, const char* const* argv, std::ostream& out) {
  constexpr int kMaxBoards = 16, kMaxSamples = 4;  // chosen: of boards that the program opens itself; as View
  ComposeOptions options;
  CLI::App app("Render several volumes and surfaces in one picture with GI-Cube boards.", "gicube-compose");
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Method, limits and figures: docs/guide/compose.md.");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.add_option("COMPOSITION", options.composition,
                 "a text file of volumes and surfaces (gicube/v1/composition.proto)")
      ->required();
  OptionGroup(app, "Options")
      .flag("--allow-outside", options.allow_outside, "let it and its scenes name files outside their folders");
  OptionGroup picture(app, "Picture");
  picture.file("-o,--output", options.picture, "write the picture here, PNG or EXR");
  picture.size("--size", options.size, "size of the picture, pixels (the composition's)");
  picture.value("--samples", options.samples_per_axis, "rays per pixel and axis: 1, 2 or 4 (the composition's)")
      ->check(CLI::IsMember({1, 2, kMaxSamples}));
  picture.value("--step", options.step, "distance of samples, voxels (the composition's)")
      ->check(CLI::Range(1.0 / 64, 16.0));
  picture
      .value("--overlap-step", options.overlap_step,
             "longest piece of a ray in overlapping volumes, voxels (the composition's)")
      ->check(CLI::Range(1.0 / 64, 4096.0));
  picture.number("--boards", options.boards, CLI::Range(1, kMaxBoards),
                 "number of boards that share the volumes, each with its own bus; above 1 only with emu:");
  add_board_options(app, options.board);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  if (!options.picture.empty()) check_picture_name(options.picture);
  if (options.boards > 1 && !options.board.board.starts_with("emu:")) {
    throw UsageError("--boards: expected 1 with a running board, got " + std::to_string(options.boards));
  }
  return options;
}

}  // namespace gicube::samples
