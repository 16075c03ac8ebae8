#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "cone_beam/algebraic.h"
#include "cone_beam/plan/plan.h"
#include "cone_beam/program/commands.h"
#include "cone_beam/program/object.h"
#include "cone_beam/program/slices.h"
#include "cone_beam/program/statistics.h"
#include "cone_beam/scan/scan.h"
#include "scene/formats/volume_output.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

void warn(const std::string& text) { fmt::print(stderr, "gicube-cone-beam: warning: {}\n", text); }

// Rays must not leave voxels out between them: 1.25 voxels apart at the axis costs no error that shows beside the edges' [C].
double rays_needed(const ConeGeometry& geometry) {
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  const double pixel = std::max(geometry.detector.pitch_u, geometry.detector.pitch_v) * at_axis;
  const Vec3 edge = geometry.volume.spacing;
  return pixel / (1.25 * std::min({edge.x, edge.y, edge.z}));
}

std::vector<std::string> warnings_of(const Scan& scan, const Reconstruction& result,
                                     const AlgebraicSettings& settings) {
  std::vector<std::string> out = scan.warnings;
  if (result.overflowed > 0) {
    out.push_back(fmt::format("sums: {} times a voxel's sum was full; values are wrong there", result.overflowed));
  }
  if (result.clipped > 0) {
    out.push_back(
        fmt::format("irradiance words: full ones lost {:.3g} of what was left in all; values are wrong by it "
                    "(a larger --headroom, a smaller --read-every)",
                    result.clipped));
  }
  if (result.diverged) {
    out.push_back(
        fmt::format("--relaxation {}: diverged, the residual grew to {:.4g} after {:.4g}; the volume is that of "
                    "the least residual",
                    settings.relaxation, result.residuals.back(), *std::ranges::min_element(result.residuals)));
  }
  return out;
}

// A functional one beside an emulated board of another level: deposits are slow there, and have the same bits.
std::optional<Board> board_for_pilots(const BoardOptions& options, const Board& board) {
  if (board.info().fidelity == Fidelity::kFunctional || !options.board.starts_with("emu:")) return std::nullopt;
  if (options.board.find("fidelity=") != std::string::npos) return std::nullopt;
  BoardOptions sooner = options;
  sooner.fidelity = "functional";
  return open_board(sooner);
}

void print_summary(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result,
                   const nlohmann::ordered_json& cost) {
  const Dims& dims = scan.geometry.volume.dims;
  fmt::print("{}: {} x {} x {} voxels from {} views by {}, {:.1f} ms simulated, {:.1f} s\n", options.output.string(),
             dims[0], dims[1], dims[2], scan.geometry.angles.size(), options.method, cost["board_ms"].get<double>(),
             cost["host_seconds"].get<double>());
  if (scan.repeated > 0) {
    fmt::print("{} views were read; {} of them repeat an angle, and are averaged with it\n", scan.views_read,
               scan.repeated);
  }
  if (!options.fdk() && !result.residuals.empty()) {
    fmt::print("{} iterations, residual {:.4g}\n", result.iterations, *std::ranges::min_element(result.residuals));
  }
}

}  // namespace

void reconstruct(const ReconstructOptions& wanted) {
  ReconstructOptions options = wanted;
  for (const auto& file : {options.output, options.board.stats, std::filesystem::path(options.slices.name)}) {
    check_folder(file);
  }
  ProgressLine progress(!options.board.quiet);
  progress.show("reading");
  Scan scan = load_scan(description_of(options.scan));
  if (const double rays = rays_needed(scan.geometry); options.fdk() && options.filtered.rays == 0) {
    options.filtered.rays = static_cast<int>(std::clamp(std::ceil(rays), 1.0, 4.0));
    if (rays > 4) {
      scan.warnings.push_back(fmt::format(
          "volume: voxels are {:.1f} times as small as pixels seen at the axis; rays leave some out between them",
          1.25 * rays));
    }
  }
  progress.show("starting the board");
  Board board = open_board(board_for(options.plan, options.board));
  const Grid& grid = scan.geometry.volume;
  check_fits(grid.dims, board.info(), "--size");
  std::optional<FdkPlan> plan;
  if (options.plan.wanted()) {
    std::optional<Board> sooner = board_for_pilots(options.board, board);
    plan = plan_fdk(sooner ? *sooner : board, scan.geometry, scan.projections, options.filtered, options.plan.target(),
                    progress.parts("planning"), &board);
    options.filtered = plan->settings(options.filtered);
    scan.projections = some_views(scan.projections, scan.geometry.angles.size(), plan->chosen.every);
    scan.geometry = some_views(scan.geometry, plan->chosen.every);
  }
  RunWindow window(board);
  const Progress parts = progress.parts("reconstructing");
  const Reconstruction result =
      options.fdk() ? reconstruct_fdk(board, scan.geometry, scan.projections, options.filtered, parts)
                    : reconstruct_algebraic(board, scan.geometry, scan.projections, options.algebraic, parts);
  const auto cost = cost_json(board.info(), window);
  progress.show("writing");
  write_volume({grid.dims, grid.spacing, origin_of(grid, scan.centre), result.values}, options.output);
  write_slices(options.slices, grid, result.values);
  const auto warnings = warnings_of(scan, result, options.algebraic);
  if (!options.board.stats.empty()) {
    auto json = to_json(options, scan, result, cost);
    json["warnings"] = warnings;
    json["plan"] = plan ? to_json(*plan) : nullptr;
    write_json(json, options.board.stats);
  }
  progress.clear();
  if (plan && options.plan.explain) print_plan(plan->explain());
  if (!options.board.quiet) print_summary(options, scan, result, cost);
  for (const std::string& text : warnings) warn(text);
}

}  // namespace gicube::samples
