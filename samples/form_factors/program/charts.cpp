#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "form_factors/exchange/box_factor.h"
#include "form_factors/program/options.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/program/board_run.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

constexpr int kEdge = 40;                        // voxels of the volume of the closed forms
constexpr double kSide = 20;                     // voxels, of their squares
constexpr std::uint32_t kEstimates = 16;         // chosen: independent ones, whose errors are averaged
constexpr std::uint32_t kMinRays = 8;            // of an estimate
constexpr std::uint32_t kMinRaysInAll = 32'768;  // chosen: of a point of the trade
constexpr std::uint32_t kReference = 4096;       // rays a pair that the trade's errors are measured from

// A medium in which light falls by e^-kappa over a side.
void fill(Board& board, double kappa) {
  const std::vector<std::byte> samples(std::size_t{kEdge} * kEdge * kEdge, std::byte{100});
  board.load_volume({.samples = samples, .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kappa / kSide)}}});
}

// Two elements.
struct Form {
  Element a, b;
  double unit = 1;  // F of a mean of G of 1
};

const Element kFloor{ElementKind::kPatch, {5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}, {}};
const Element kCeiling{ElementKind::kPatch, {5, 5, 25}, {0, kSide, 0}, {kSide, 0, 0}, {}};
const Element kWall{ElementKind::kPatch, {5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}, {}};

// Estimates by so many rays each.
std::vector<double> estimates(Board& board, const Form& form, std::uint32_t rays) {
  std::vector<ElementPair> pairs;
  for (std::uint32_t e = 0; e < kEstimates; ++e) pairs.push_back({0, 1, e});
  std::vector<double> found;
  for (const PairFactor& factor : board.pair_factors(std::array{form.a, form.b}, pairs, {.rays = rays})) {
    found.push_back(factor.transported * form.unit);
  }
  return found;
}

bool wanted(const std::string& point, const std::string& name) { return point.empty() || point == name; }

// Words of a command have no blanks.
std::string point_of(const ErrorCurve& curve, std::uint32_t rays) {
  std::string name = fmt::format("error/{}/{}", curve.name, rays);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

ErrorCurve curve_of(Board& board, const std::string& name, const Form& form, double exact, std::uint32_t max_rays,
                    const std::string& point) {
  ErrorCurve curve{.name = name, .exact = exact, .rays = {}, .errors = {}};
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::uint32_t rays = kMinRays; rays <= max_rays; rays *= 2) {
    if (!wanted(point, point_of(curve, rays))) continue;
    double squares = 0;
    for (const double estimate : estimates(board, form, rays)) squares += std::pow(estimate / exact - 1, 2);
    curve.rays.push_back(rays);
    curve.errors.push_back(std::sqrt(squares / kEstimates));
    const double lx = std::log(curve.rays.back()), ly = std::log(curve.errors.back());
    n += 1, x += lx, y += ly, xx += lx * lx, xy += lx * ly;
  }
  curve.slope = (n * xy - x * y) / (n * xx - x * x);
  return curve;
}

// A table as a file, or as it is if it is of one point.
void write(const FormFactorChartOptions& options, const char* name, const std::string& text) {
  if (!options.point.empty()) {
    if (text.find(" --point " + options.point + "\n") == std::string::npos) {
      throw InputError("--point", "a point's name, as in the tables", in_quotes(options.point));
    }
    fmt::print("{}", text);
    return;
  }
  write_whole(options.folder / name, text);
}

void write_errors(const FormFactorChartOptions& options, ProgressLine& progress) {
  progress.show("closed forms");
  Board board = open_board(options.board);
  const std::vector<ErrorCurve> curves = closed_form_curves(board, options.max_rays, options.point);
  std::string errors = "form,rays,error,command\n", slopes = "form,exact,slope,error at most rays\n";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const ErrorCurve& curve = curves[i];
    for (std::size_t k = 0; k < curve.rays.size(); ++k) {
      errors += fmt::format("{},{},{:.4g},{} --point {}\n", curve.name, curve.rays[k], curve.errors[k], options.command,
                            point_of(curve, curve.rays[k]));
    }
    if (curve.rays.empty()) continue;
    if (i + 1 < curves.size() && options.point.empty()) errors += "\n\n";  // gnuplot's next block
    slopes += fmt::format("{},{:.7g},{:.2f},{:.3g}\n", curve.name, curve.exact, curve.slope, curve.errors.back());
  }
  write(options, "form_factors_error.csv", errors);
  if (options.point.empty()) write(options, "form_factors_slopes.csv", slopes);
}

// Of the difference of the reference's pairs.
double rms_of(const std::vector<double>& seen, const std::vector<double>& reference) {
  double squares = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) squares += (seen[i] - reference[i]) * (seen[i] - reference[i]);
  return std::sqrt(squares / static_cast<double>(reference.size()));
}

void write_trade(const FormFactorChartOptions& options, ProgressLine& progress) {
  const SceneSetup setup = set_up(scene_of(options.trade), options.board.threads);
  const RandomPairs pairs = random_pairs(setup.volume.dims, options.pairs, options.board.seed);
  std::string text =
      "bus,made,rays a pair,pairs,error,board_ms,bus_ms,rays_per_second,bus_down,bus_up,dsp,pipelines,sorter,memory,"
      "bound,command\n";
  const auto loaded = [&](const BoardOptions& chosen) {
    Board board = open_board(chosen);
    check_fits(setup.volume.dims, board.info(), setup.volume.source);
    load(board, setup, false);
    return board;
  };
  BoardOptions chosen = options.board;
  chosen.fidelity = "functional";
  Board exact = loaded(chosen);
  const auto reference = look(exact, pairs, {.rays = kReference, .seed = 1}).transmittances;
  chosen.fidelity = options.board.fidelity.empty() ? "cycle" : options.board.fidelity;
  for (const char* bus : {"pci33", "agp2x"}) {
    chosen.board = fmt::format("emu:?bus={}", bus);
    Board board = loaded(chosen);
    for (const PairRays made : {PairRays::kByHost, PairRays::kByBoard}) {
      for (std::uint32_t rays = 1; rays <= options.max_rays_a_pair; rays *= 4) {
        const std::string name = fmt::format("trade/{}/{}/{}", bus, name_of(made), rays);
        if (!wanted(options.point, name)) continue;
        progress.show(fmt::format("trade: {}, {} rays a pair", bus, rays));
        const PairRequest request{.rays = rays, .made = made};
        // Enough of them that the parts of the board overlap; the first ones tell the error.
        const std::uint32_t count = std::max(options.pairs, kMinRaysInAll / rays);
        const RandomPairs more = random_pairs(setup.volume.dims, count, options.board.seed);
        const Visibility seen = look(board, more, request);
        const Utilisation& u = seen.utilisation;
        const double ms = to_ms(seen.duration);
        text += fmt::format(
            "{},{},{},{},{:.4g},{:.4f},{:.4f},{:.0f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{},{} --point {}\n", bus,
            name_of(made), rays, seen.pairs, rms_of(seen.transmittances, reference), ms, bus_ms(seen.counters),
            static_cast<double>(seen.rays) / ms * 1e3, u.bus_down, u.bus_up, u.dsp, u.pipelines.value_or(0),
            u.sorter.value_or(0), u.memory.value_or(0), u.bound(), options.command, name);
      }
    }
    text += std::string(bus) == "pci33" && options.point.empty() ? "\n\n" : "";
  }
  write(options, "form_factors_trade.csv", text);
}

void write_hierarchy(const FormFactorChartOptions& options, ProgressLine& progress) {
  Scene scene = scene_of(options.hierarchy);
  scene.lighting.on = false;
  const SceneSetup setup = set_up(scene, options.board.threads);
  Board board = open_board(options.board);
  check_fits(setup.volume.dims, board.info(), setup.volume.source);
  RadiositySettings settings;
  settings.leaf_voxels = options.leaf_voxels;
  std::vector<double> errors = options.errors;
  std::erase_if(errors, [&](double error) { return !wanted(options.point, study_point(true, error)); });
  const bool full = wanted(options.point, study_point(false));
  const auto points = study_hierarchy(board, setup, emissions_of(scene, setup), settings, errors, full,
                                      [&progress](std::string_view what, double share) {
                                        progress.show(fmt::format("hierarchy: {} {:.0f}%", what, 100 * share));
                                      });
  write(options, "form_factors_hierarchy.csv", csv_of(points, options.command));
}

}  // namespace

std::vector<ErrorCurve> closed_form_curves(Board& board, std::uint32_t max_rays, const std::string& point) {
  const double area = kSide * kSide;
  const Element low{ElementKind::kBox, {5, 5, 5}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
  const Element high{ElementKind::kBox, {5, 5, 13}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
  std::vector<ErrorCurve> curves;
  for (const double kappa : {0.0, 1.0, 3.0}) {
    fill(board, kappa);
    curves.push_back(curve_of(board, kappa == 0 ? "parallel" : fmt::format("parallel kappa {:g}", kappa),
                              {kFloor, kCeiling, area}, parallel_squares(kappa), max_rays, point));
  }
  fill(board, 0);
  curves.push_back(
      curve_of(board, "boxes two apart", {low, high, 16 * std::numbers::pi}, mean_inverse_square(2), max_rays, point));
  curves.push_back(curve_of(board, "common edge", {kFloor, kWall, area}, perpendicular_squares(), max_rays, point));
  return curves;
}

void run(const FormFactorChartOptions& options, ProgressLine& progress) {
  bool any = false;
  const std::pair<const char*, void (*)(const FormFactorChartOptions&, ProgressLine&)> tables[] = {
      {"error/", write_errors}, {"trade/", write_trade}, {"hierarchy/", write_hierarchy}};
  for (const auto& [table, write_table] : tables) {
    if (!options.point.empty() && !options.point.starts_with(table)) continue;
    write_table(options, progress);
    any = true;
  }
  if (!any) {
    throw InputError("--point", "error/..., trade/... or hierarchy/..., as in the tables", in_quotes(options.point));
  }
}

}  // namespace gicube::samples
