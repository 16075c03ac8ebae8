#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "cone_beam/program/options.h"
#include "cone_beam/scan/formats.h"
#include "cone_beam/view_rays.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/program/board_run.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

struct ProjectOptions {
  ObjectOptions object;
  ScanOptions scan;
  bool by_board = false;  // a phantom's voxels instead of its closed form
  double step = 0.5;      // of the board's rays, voxels
  double photons = 0;     // a pixel, of Poisson noise; 0: none
  std::filesystem::path output, voxels;
  BoardOptions board;

  std::string extension() const { return lower_case(output.extension().string()); }
};

// The scan file beside the views, and the matrix beside each view.
std::filesystem::path scan_of(std::filesystem::path views) { return views.replace_extension(".textproto"); }
std::filesystem::path matrix_of(std::filesystem::path view) { return view.replace_extension(".txt"); }

// The output files for so many views.
std::vector<Output> outputs_of(const ProjectOptions& options, std::size_t views) {
  std::vector<Output> out{
      {"--output", scan_of(options.output)}, {"--voxels", options.voxels}, {"--stats", options.board.stats}};
  for (const std::filesystem::path& file : stack_files(options.output, views)) {
    out.push_back({"--output", file});
    if (options.extension() == ".pfm") out.push_back({"--output", matrix_of(file)});
  }
  return out;
}

void check(const ProjectOptions& options) {
  constexpr std::array kKnown{".nrrd", ".mhd", ".mha", ".raw", ".pfm", ".tif", ".tiff"};
  if (std::ranges::find(kKnown, options.extension()) == kKnown.end()) {
    throw UsageError("--output: expected a name that ends in .nrrd, .mhd, .mha, .raw, .pfm or .tif, got " +
                     in_quotes(options.output.string()));
  }
  check_volume_name("--voxels", options.voxels);
  check_outputs(outputs_of(options, 1));
}

void write_files(const ProjectOptions& options, ScanDescription description, const Projections& projections,
                 const Provenance& provenance) {
  // The files contain line integrals in the geometry's own order of pixels, except for plastimatch's matrices, whose
  // rows run downwards.
  const bool matrices = options.extension() == ".pfm";
  description.columns_reversed = false;
  description.rows_reversed = matrices;
  const Stack stack{projections.columns, projections.rows, as_stored(projections, description), false};
  const auto files = write_stack(stack, options.output, provenance);
  description.projections = {files, {}};
  if (options.extension() == ".raw") description.projections.raw = RawLayout{.type = SampleType::kFloat32};
  description.intensities = false;
  description.flats = description.darks = description.dead = {};
  description.full = 0;
  for (std::size_t view = 0; matrices && view < files.size(); ++view) {
    write_projection_matrix(description.geometry, description.geometry.angles[view], matrix_of(files[view]));
  }
  write_scan_file(description, scan_of(options.output));
}

void run_project(const ProjectOptions& options) {
  check(options);
  ProgressLine progress(!options.board.quiet);
  ScanDescription description = description_of(options.scan);
  ConeGeometry& geometry = description.geometry;
  if (!geometry.circular() && options.extension() == ".pfm") {
    throw UsageError("--output: expected .nrrd, .mhd, .mha, .raw or .tif for views that lie on no circle, got .pfm");
  }
  if (geometry.circular()) geometry.angles = sorted_views(geometry.angles).angles;
  std::vector<std::filesystem::path> inputs = description.inputs();
  inputs.emplace_back(options.object.name);
  check_inputs_stay(outputs_of(options, geometry.angles.size()), inputs);
  Phantom phantom;
  std::vector<float> values;  // on the geometry's own grid
  if (is_phantom(options.object)) {
    phantom = phantom_of(options.object);
    check(geometry);
    if (options.by_board || !options.voxels.empty()) values = voxels(phantom, geometry.volume);
    write_values(geometry.volume, description.centre, values, this_run(), options.voxels);
  } else {
    progress.show("reading");
    GridValues object = read_values(options.object.name, options.object.allow_outside);
    geometry.volume = object.grid;
    values = std::move(object.values);
    check(geometry);
  }
  Projections projections;
  nlohmann::ordered_json stats;
  std::string cost = "in closed form";
  Provenance provenance = this_run();  // of a phantom, which the command line names
  if (!phantom.empty() && !options.by_board) {
    progress.show("projecting");
    projections = project(phantom, geometry);
  } else {
    progress.show("starting the board");
    Board board = open_board(options.board);
    check_renders(geometry.volume.dims, board.info(), options.object.name);
    RunWindow window(board);
    projections = project_by_board(board, geometry, values, options.step, progress.parts("projecting"));
    stats = cost_json(board.info(), window);
    provenance = provenance_of(board.info(), hash_of(values));
    cost = fmt::format("{:.1f} ms simulated, {}", stats["board_ms"].get<double>(), stats["bound"].get<std::string>());
  }
  std::size_t unseen = 0;
  if (options.photons > 0) unseen = add_poisson_noise(projections, options.photons, options.board.seed);
  progress.show("writing");
  write_files(options, description, projections, provenance);
  stats.update(nlohmann::ordered_json{{"views", geometry.angles.size()},
                                      {"photons", options.photons},
                                      {"seed", options.board.seed},
                                      {"unseen", unseen}});
  if (!options.board.stats.empty()) write_json(stats, provenance, options.board.stats);
  progress.clear();
  if (options.board.quiet) return;
  fmt::print("{}: {} views of {} x {} pixels, {}\n", options.output.string(), geometry.angles.size(),
             projections.columns, projections.rows, cost);
  if (unseen > 0) fmt::print("{} pixels received no photon, and count as half a one\n", unseen);
}

}  // namespace

void add_project(CLI::App& program) {
  CLI::App& app = *program.add_subcommand("project", "compute projections of a phantom or a volume");
  const auto options = std::make_shared<ProjectOptions>();
  add_object(app, options->object, "OBJECT", "the object to project");
  add_own_scan(app, options->scan);
  OptionGroup group(app, "Projections"), output(app, "Output");
  group.flag("--by-board", options->by_board, "project a phantom's voxels with the board, not by closed form");
  group.number("--step", options->step, CLI::Range(1.0 / 64, 16.0), "step of the board's rays, voxels");
  group.number("--photons", options->photons, CLI::Range(0.0, 1e15),
               "photons per pixel without an object, for Poisson noise by --seed; 0: no noise");
  output
      .file("-o,--output", options->output,
            "write the views here: .nrrd .mhd .mha .raw, or a file per view: .tif .pfm (with plastimatch's matrices); "
            "NAME.textproto beside them is the SCAN for reconstruct")
      ->required();
  output.file("--voxels", options->voxels, "also write a phantom's voxels: .nrrd .mhd .mha .nii");
  add_board_options(app, options->board);
  app.callback([options] { run_project(*options); });
}

}  // namespace gicube::samples
