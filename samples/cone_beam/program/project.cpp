#include <fmt/format.h>

#include "cone_beam/phantom/noise.h"
#include "cone_beam/program/commands.h"
#include "cone_beam/program/object.h"
#include "cone_beam/projector.h"
#include "cone_beam/scan/projection_matrices.h"
#include "cone_beam/scan/scan.h"
#include "cone_beam/scan/scan_file.h"
#include "cone_beam/scan/stack.h"
#include "cone_beam/scan/views.h"
#include "scene/formats/header_lines.h"
#include "scene/formats/volume_output.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

struct Made {
  Projections projections;
  nlohmann::ordered_json stats;
};

// By the board: `values` on the geometry's own grid.
Made by_board(const ProjectOptions& options, const ConeGeometry& geometry, std::span<const float> values,
              ProgressLine& progress) {
  progress.show("starting the board");
  Board board = open_board(options.board);
  check_fits(geometry.volume.dims, board.info(), options.object.name);
  RunWindow window(board);
  Made made;
  made.projections = project_by_board(board, geometry, values, options.step, progress.parts("projecting"));
  made.stats = cost_json(board.info(), window);
  return made;
}

void write_files(const ProjectOptions& options, ScanDescription description, const Projections& projections) {
  // What is written is line integrals in the geometry's own order of pixels, but for plastimatch's matrices: there rows run downwards.
  const bool matrices = lower_case(options.output.extension().string()) == ".pfm";
  description.columns_reversed = false;
  description.rows_reversed = matrices;
  const Stack stack{projections.columns, projections.rows, as_stored(projections, description), false};
  const auto files = write_stack(stack, options.output);
  description.projections = {files, {}};
  if (lower_case(options.output.extension().string()) == ".raw") {
    description.projections.raw = RawLayout{};
    description.projections.raw->type = SampleType::kFloat32;
  }
  description.intensities = false;
  description.flats = description.darks = {};
  description.full = 0;
  for (std::size_t view = 0; matrices && view < files.size(); ++view) {
    write_projection_matrix(description.geometry, description.geometry.angles[view],
                            std::filesystem::path(files[view]).replace_extension(".txt"));
  }
  write_scan_file(description, std::filesystem::path(options.output).replace_extension(".textproto"));
}

}  // namespace

void project(const ProjectOptions& options) {
  for (const auto* file : {&options.output, &options.voxels, &options.board.stats}) check_folder(*file);
  ProgressLine progress(!options.board.quiet);
  ScanDescription description = description_of(options.scan);
  description.geometry.angles = sorted_views(description.geometry.angles).angles;
  ConeGeometry& geometry = description.geometry;
  Made made;
  if (is_phantom(options.object)) {
    const Phantom phantom = phantom_of(options.object);
    check(geometry);
    std::vector<float> values;
    if (options.by_board || !options.voxels.empty()) values = voxels(phantom, geometry.volume);
    if (!options.voxels.empty()) {
      write_volume(
          {geometry.volume.dims, geometry.volume.spacing, origin_of(geometry.volume, description.centre), values},
          options.voxels);
    }
    progress.show("projecting");
    if (options.by_board) {
      made = by_board(options, geometry, values, progress);
    } else {
      made.projections = project(phantom, geometry);
    }
  } else {
    progress.show("reading");
    GridValues object = read_values(options.object.name);
    geometry.volume = object.grid;
    check(geometry);
    made = by_board(options, geometry, object.values, progress);
  }
  std::size_t unseen = 0;
  if (options.photons > 0) unseen = add_poisson_noise(made.projections, options.photons, options.board.seed);
  progress.show("writing");
  write_files(options, description, made.projections);
  made.stats.update(nlohmann::ordered_json{{"views", geometry.angles.size()},
                                           {"photons", options.photons},
                                           {"seed", options.board.seed},
                                           {"unseen", unseen}});
  if (!options.board.stats.empty()) write_json(made.stats, options.board.stats);
  progress.clear();
  if (options.board.quiet) return;
  fmt::print("{}: {} views of {} x {} pixels{}\n", options.output.string(), geometry.angles.size(),
             made.projections.columns, made.projections.rows,
             made.stats.contains("board_ms")
                 ? fmt::format(", {:.1f} ms simulated", made.stats["board_ms"].get<double>())
                 : ", in closed form");
  if (unseen > 0) fmt::print("{} pixels were reached by no photon, and count as half a one\n", unseen);
}

}  // namespace gicube::samples
