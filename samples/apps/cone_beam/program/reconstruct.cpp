#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

#include "cone_beam/algebraic.h"
#include "cone_beam/centre.h"
#include "cone_beam/facing.h"
#include "cone_beam/plan/plan.h"
#include "cone_beam/program/options.h"
#include "scene/program/board_run.h"
#include "scene/program/option_group.h"
#include "scene/program/plan_options.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

// Names of settings, on the command line and in --stats.
const std::map<std::string, Window> kWindows{
    {"ram-lak", Window::kRamLak}, {"shepp-logan", Window::kSheppLogan}, {"hann", Window::kHann}};
const std::map<std::string, Accumulator> kAccumulators{{"sums", Accumulator::kSums},
                                                       {"irradiance", Accumulator::kIrradiance}};
const std::map<std::string, Method> kMethods{{"sart", Method::kSart}, {"os-sart", Method::kOsSart},
                                             {"sirt", Method::kSirt}, {"cgls", Method::kCgls},
                                             {"osem", Method::kOsem}, {"tv", Method::kTv}};

struct ReconstructOptions {
  ScanOptions scan;
  std::string method = "fdk";  // or one of kMethods
  bool find_centre = false;
  std::filesystem::path mask;
  FdkSettings filtered;
  AlgebraicSettings algebraic;
  std::filesystem::path output;
  SliceOptions slices;
  PlanOptions plan;  // of fdk
  BoardOptions board;

  bool fdk() const { return method == "fdk"; }
};

using Json = nlohmann::ordered_json;

Json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

template <typename Value>
std::string name_of(const std::map<std::string, Value>& names, Value value) {
  return std::ranges::find(names, value, &std::pair<const std::string, Value>::second)->first;
}

Json scan_json(const Scan& scan) {
  const auto& [to_axis, to_detector, detector, volume, angles, poses] = scan.geometry;
  const Json pixels{{"columns", detector.columns}, {"rows", detector.rows},         {"pitch_u", detector.pitch_u},
                    {"pitch_v", detector.pitch_v}, {"offset_u", detector.offset_u}, {"offset_v", detector.offset_v}};
  return {{"views", angles.size()},
          {"views_read", scan.views_read},
          {"repeated", scan.repeated},
          {"arc_degrees", (angles.back() - angles.front()) * 180 / std::numbers::pi},
          {"circular", scan.geometry.circular()},
          {"source_to_axis", to_axis},
          {"source_to_detector", to_detector},
          {"detector", pixels},
          {"absorbed", scan.flat_field.absorbed},
          {"dead", scan.flat_field.dead},
          {"unlit", scan.flat_field.unlit},
          {"stuck", scan.dead.stuck},
          {"named_dead", scan.dead.named}};
}

Json fdk_json(const FdkSettings& fdk, const Scan& scan) {
  const ConeGeometry& geometry = scan.geometry;
  const PixelRays rays = rays_of(fdk, geometry);
  const char* const lines = is_displaced(geometry, scan.projections) ? "displaced"
                            : is_short_scan(geometry)                ? "short"
                                                                     : "turn";
  Json json{{"window", name_of(kWindows, fdk.window)},
            {"lines", lines},
            {"rays", {rays.u, rays.v}},
            {"step", fdk.step},
            {"sharpen", sharpening_of(fdk, geometry)},
            {"normalise", fdk.normalise},
            {"accumulator", name_of(kAccumulators, fdk.accumulator)}};
  if (fdk.accumulator == Accumulator::kIrradiance) {
    json.update(Json{{"read_every", fdk.read_every}, {"bits", fdk.bits}, {"headroom", fdk.headroom}});
  }
  return json;
}

Json algebraic_json(const AlgebraicSettings& settings) {
  const Method method = settings.method;
  Json json{{"iterations", settings.iterations}};
  if (method == Method::kOsSart || method == Method::kOsem || method == Method::kTv) json["subsets"] = settings.subsets;
  if (method == Method::kTv) json.update(Json{{"tv_steps", settings.tv_steps}, {"tv_weight", settings.tv_weight}});
  if (method != Method::kCgls && method != Method::kOsem) json["relaxation"] = settings.relaxation;
  json.update(Json{{"non_negative", settings.non_negative && method != Method::kCgls},
                   {"masked", !settings.mask.empty()},
                   {"stop", settings.stop},
                   {"noise_level", settings.noise},
                   {"step", settings.step}});
  return json;
}

Json point_json(const FdkPlanPoint& point) {
  return {{"every", point.every},
          {"rays", point.rays},
          {"step", point.step},
          {"error", point.error},
          {"error_bound", point.error_bound},
          {"deposits", point.deposits},
          {"board_ms", to_ms(point.time)}};
}

Json plan_json(const FdkPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json.update(Json{{"chosen", point_json(plan.chosen)},
                   {"finest", point_json(plan.finest)},
                   {"slices", plan.slices},
                   {"pilots", plan.pilots},
                   {"pilot_deposits", plan.pilot_deposits},
                   {"host_seconds", plan.host_seconds}});
  for (const FdkPlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

// Keys: scan, volume, method and its settings, rays, rays_ms (simulated, from the first ray to the last value read),
// deposits, overflowed, clipped, iterations, residuals, diverged, warnings, those of `cost` (cost_json()), and plan
// (null without one).
Json statistics_of(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result, const Json& cost,
                   const std::optional<FdkPlan>& plan) {
  const Grid& volume = scan.geometry.volume;
  const Json grid{{"dims", volume.dims}, {"spacing", numbers(volume.spacing)}, {"centre", numbers(scan.centre)}};
  Json json{{"scan", scan_json(scan)},
            {"volume", grid},
            {"method", options.method},
            {"settings", options.fdk() ? fdk_json(options.filtered, scan) : algebraic_json(options.algebraic)},
            {"rays", result.rays},
            {"rays_ms", to_ms(result.board_time)},
            {"deposits", result.deposits},
            {"overflowed", result.overflowed},
            {"clipped", result.clipped},
            {"iterations", result.iterations},
            {"residuals", result.residuals},
            {"diverged", result.diverged},
            {"warnings", scan.warnings}};
  json.update(cost);
  json["plan"] = plan ? plan_json(*plan) : nullptr;
  return json;
}

std::vector<std::string> warnings_of(const Scan& scan, const Reconstruction& result,
                                     const AlgebraicSettings& settings) {
  std::vector<std::string> out = scan.warnings;
  if (result.overflowed > 0) {
    out.push_back(fmt::format("sums: {} times a voxel's sum was full; values are wrong there", result.overflowed));
  }
  if (result.clipped > 0) {
    out.push_back(
        fmt::format("irradiance words: full ones lost {:.3g} of all deposits; values are wrong by it "
                    "(use a larger --headroom or a smaller --read-every)",
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

// A functional board if the user's is an emulated one of another level: there deposits are slow, and have the same
// bits.
std::optional<Board> board_for_pilots(const BoardOptions& options, const Board& board) {
  if (board.info().fidelity == Fidelity::kFunctional || !options.board.starts_with("emu:")) return std::nullopt;
  if (options.board.find("fidelity=") != std::string::npos) return std::nullopt;
  BoardOptions sooner = options;
  sooner.set_level("functional");
  return open_board(sooner);
}

void print_summary(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result,
                   const nlohmann::ordered_json& cost) {
  const Dims& dims = scan.geometry.volume.dims;
  fmt::print("{}: {} x {} x {} voxels from {} views by {}, {:.1f} ms simulated, {:.1f} s\n", options.output.string(),
             dims[0], dims[1], dims[2], scan.geometry.angles.size(), options.method, cost["board_ms"].get<double>(),
             cost["host_seconds"].get<double>());
  fmt::print("{}\n", cost["bound"].get<std::string>());
  if (options.find_centre) {
    const Detector& detector = scan.geometry.detector;
    fmt::print("the axis is {:.2f} pixels from the detector's middle: offset_u {:.6g}\n",
               -detector.offset_u / detector.pitch_u, detector.offset_u);
  }
  if (scan.repeated > 0) {
    fmt::print("{} views were read; {} of them repeat an angle, and are averaged\n", scan.views_read, scan.repeated);
  }
  if (!options.fdk() && !result.residuals.empty()) {
    fmt::print("{} iterations, residual {:.4g}\n", result.iterations, *std::ranges::min_element(result.residuals));
  }
}

std::vector<Output> outputs_of(const ReconstructOptions& options) {
  std::vector<Output> out = options.slices.outputs();
  out.insert(out.end(), {{"--output", options.output}, {"--stats", options.board.stats}});
  return out;
}

void check(const CLI::App& app, ReconstructOptions& options) {
  AlgebraicSettings& algebraic = options.algebraic;
  if (!options.fdk()) algebraic.method = kMethods.at(options.method);
  algebraic.step = options.filtered.step;
  check_plan(options.plan);
  check_volume_name("--output", options.output);
  if (options.plan.wanted()) {
    if (!options.fdk()) {
      throw UsageError("--method: expected fdk with --max-error and --time-budget, got " + options.method);
    }
    for (const char* chosen : {"--rays", "--step"}) refuse_with_plan(app, chosen);
  }
  check_outputs(outputs_of(options));
}

std::vector<std::uint8_t> mask_of(const ReconstructOptions& options, const Grid& grid) {
  const GridValues read = read_values(options.mask, options.scan.allow_outside);
  if (read.grid.dims != grid.dims) {
    const auto text = [](const Dims& dims) { return fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]); };
    throw FileError(options.mask, "size", text(grid.dims) + " voxels, as the volume has", text(read.grid.dims));
  }
  std::vector<std::uint8_t> mask;
  for (const float value : read.values) mask.push_back(value == 0 ? 0 : 1);
  return mask;
}

void run_reconstruct(ReconstructOptions& options) {
  ProgressLine progress(!options.board.quiet);
  progress.show("reading");
  const ScanDescription description = description_of(options.scan);
  std::vector<std::filesystem::path> inputs = description.inputs();
  inputs.push_back(options.mask);
  check_inputs_stay(outputs_of(options), inputs);
  Scan scan = load_scan(description);
  if (options.find_centre) scan.geometry.detector.offset_u = find_offset_u(scan.geometry, scan.projections);
  if (!options.mask.empty()) options.algebraic.mask = mask_of(options, scan.geometry.volume);
  if (options.fdk() && !scan.geometry.circular()) {
    FacingViews views = facing(scan.geometry, scan.projections);
    scan.geometry = std::move(views.geometry);
    scan.projections = std::move(views.projections);
  }
  const std::uint64_t projection_hash = hash_of(scan.projections.values);  // as read, before a plan leaves views out
  if (options.fdk() && options.filtered.rays == 0) {
    constexpr double kFarApart = 1.25 * 4;  // of the most rays that there are
    if (const double pixel = voxels_of_a_pixel(scan.geometry); pixel > kFarApart) {
      scan.warnings.push_back(fmt::format(
          "volume: pixels at the axis are {:.1f} times as large as voxels; rays miss voxels between them", pixel));
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
  const Provenance provenance = provenance_of(board.info(), projection_hash);
  write_values(grid, scan.centre, result.values, provenance, options.output);
  write_slices(options.slices, grid, result.values, provenance);
  scan.warnings = warnings_of(scan, result, options.algebraic);
  if (!options.board.stats.empty()) {
    write_json(statistics_of(options, scan, result, cost, plan), provenance, options.board.stats);
  }
  progress.clear();
  if (plan && options.plan.explain) print_plan(plan->explain());
  if (!options.board.quiet) print_summary(options, scan, result, cost);
  for (const std::string& text : scan.warnings) warn(text);
}

void add_fdk(CLI::App& app, FdkSettings& fdk) {
  OptionGroup group(app, "FDK");
  group.choice("--window", fdk.window, kWindows, "window of the ramp filter (ram-lak)");
  group.number("--rays", fdk.rays, CLI::Range(0, 4),
               "rays per pixel along each detector axis; 0: chosen by the sizes of pixels and voxels, 1 to 4");
  group
      .value("--sharpen", fdk.sharpen,
             "sharpen against the blur of splatting: part of each neighbour to subtract (by pixels and rays)")
      ->check(CLI::Range(0.0, 0.25));
  group.flag("--normalise,!--no-normalise", fdk.normalise,
             "divide out ripples from varying distances between rays and voxels (on)");
  group.choice("--accumulator", fdk.accumulator, kAccumulators,
               "words on the board: sums (signed, 36 bits) or irradiance (the paper's, two passes) (sums)");
  group.number("--read-every", fdk.read_every, CLI::Range(1, 100'000),
               "views between reads, with --accumulator irradiance");
  group.number("--bits", fdk.bits, CLI::Range(0, 32), "used bits of irradiance words; 0: all");
  group.number("--headroom", fdk.headroom, CLI::PositiveNumber,
               "value of full irradiance words, relative to a voxel's bound; less is finer, and clips");
}

void add_algebraic(CLI::App& app, AlgebraicSettings& settings) {
  OptionGroup group(app, "Iterative methods");
  group.number("--iterations", settings.iterations, CLI::Range(1, 10'000), "iterations over all views, at most");
  group.number("--subsets", settings.subsets, CLI::Range(2, 100'000),
               "number of subsets of views for os-sart, osem and tv");
  group.number("--relaxation", settings.relaxation, CLI::PositiveNumber,
               "factor of a correction; best about 1.9 for sirt, 2.2 for os-sart; more diverges; not for cgls, osem");
  app.add_flag_callback(
         "--allow-negative", [&settings] { settings.non_negative = false; }, "keep values below 0")
      ->group("Iterative methods");
  group.number("--tv-steps", settings.tv_steps, CLI::Range(1, 1000),
               "steps that reduce the total variation after an iteration; tv");
  group.number("--tv-weight", settings.tv_weight, CLI::Range(0.0, 1.0),
               "size of such a step, relative to the iteration's change; tv");
  group.number("--stop", settings.stop, CLI::Range(0.0, 1.0),
               "stop when an iteration lowers the residual by less than this part of it; 0: never");
  group.number("--noise-level", settings.noise, CLI::Range(0.0, 1.0),
               "stop at this residual, the noise of the projections; 0: never");
}

}  // namespace

void add_reconstruct(CLI::App& program) {
  CLI::App& app = *program.add_subcommand("reconstruct", "reconstruct a volume from the projections of a scan");
  const auto options = std::make_shared<ReconstructOptions>();
  add_input(app, options->scan);
  OptionGroup method(app, "Method");
  method.number("--method", options->method, CLI::IsMember({"fdk", "sart", "os-sart", "sirt", "cgls", "osem", "tv"}),
                "reconstruction method");
  method.flag("--find-centre", options->find_centre,
              "find the position of the axis, the detector's offset_u, from the views");
  method.number("--step", options->filtered.step, CLI::Range(1.0 / 64, 16.0), "step of the rays, voxels");
  add_fdk(app, options->filtered);
  add_algebraic(app, options->algebraic);
  OptionGroup(app, "Iterative methods")
      .file("--mask", options->mask, "a volume that is 0 outside the object; there voxels stay 0");
  OptionGroup(app, "Output")
      .file("-o,--output", options->output,
            "write the volume here, with spacing and origin: .nrrd .mhd .mha .nii .nii.gz")
      ->required();
  add_slices(app, options->slices, "it");
  add_plan_options(app, options->plan, "the volume");
  add_board_options(app, options->board);
  app.callback([options, &app] {
    check(app, *options);
    run_reconstruct(*options);
  });
}

}  // namespace gicube::samples
