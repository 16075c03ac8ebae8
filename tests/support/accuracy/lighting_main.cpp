// gicube-lighting-study: what a pass of lighting rays costs the board, and how far its irradiance is from the closed form of a point
// source in an absorber. Makes docs/studies/charts/lighting.csv.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "reference/point_source.h"

namespace {

using namespace gicube;

constexpr int kSize = 25;
constexpr double kExtinction = 0.15;  // a voxel
const Vec3 kLamp{12.25, 11.5, 12};

struct Options {
  std::vector<std::string> albedos{"low", "high"}, rules{"conserving", "printed"}, datapaths{"paper", "wide"};
  std::vector<int> rays{1, 2, 4, 8, 16};
  std::vector<double> steps{0.5, 2};
  std::string fidelity = "cycle", output;
};

struct Point {
  std::string albedo, rules, datapath;
  int rays = 0;
  double step = 0;
  double pass_ms = 0, error = 0, clipped = 0;
  bool on_front = false;

  std::string command() const {
    return fmt::format("gicube-lighting-study --albedo {} --rules {} --datapath {} --rays {} --step {}", albedo, rules,
                       datapath, rays, step);
  }
};

Vec3 voxel_at(std::size_t index) {
  const auto at = static_cast<int>(index);
  const int x = at % kSize, y = at / kSize % kSize, z = at / kSize / kSize;
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

std::vector<double> closed_form() {
  std::vector<double> shares;
  const Vec3 last{kSize - 1, kSize - 1, kSize - 1};
  for (std::size_t i = 0; i < std::size_t{kSize} * kSize * kSize; ++i)
    shares.push_back(reference::absorbed_by_voxel(kExtinction, kLamp, voxel_at(i), {0, 0, 0}, last));
  return shares;
}

// The root mean square difference of each voxel's share of the light, relative to the root mean square share, over the voxels
// more than two from the lamp.
double error_of(const std::vector<float>& irradiance, double emitted, const std::vector<double>& exact) {
  double squares = 0, size = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (length(voxel_at(i) - kLamp) <= 2) continue;
    squares += std::pow(double{irradiance[i]} / emitted - exact[i], 2);
    size += exact[i] * exact[i];
  }
  return std::sqrt(squares / size);
}

void measure(Point& point, const Options& options, const std::vector<double>& exact) {
  Board board =
      Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&set=asic.datapath=" + point.datapath +
                  "&fidelity=" + options.fidelity);
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * kSize, std::byte{100});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, kSize}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, -std::expm1(-kExtinction)}}});
  const std::vector<Light> lamp{PointLight{kLamp, 1}};
  const Picoseconds begin = board.now();
  const LightingReport report =
      board.illuminate(lamp, {.albedo = point.albedo == "low" ? Albedo::kLow : Albedo::kHigh,
                              .rules = point.rules == "printed" ? EnergyRules::kAsPrinted : EnergyRules::kConserving,
                              .rays_per_face_voxel = point.rays,
                              .step = point.step});
  point.pass_ms = to_ms(board.now() - begin);
  // As printed a light sends out four times its power; what is compared is the share of its own.
  const double power = point.rules == "printed" ? 4 : 1;
  point.error = error_of(board.read_irradiance(), power, exact);
  point.clipped = report.clipped / report.emitted;
}

std::vector<Point> points_of(const Options& options) {
  std::vector<Point> points;
  for (const std::string& albedo : options.albedos) {
    for (const std::string& rules : options.rules) {
      for (const std::string& datapath : options.datapaths) {
        for (const double step : options.steps) {
          for (const int rays : options.rays) {
            points.push_back({.albedo = albedo, .rules = rules, .datapath = datapath, .rays = rays, .step = step});
          }
        }
      }
    }
  }
  return points;
}

void mark_front(std::vector<Point>& points) {
  for (Point& point : points) {
    point.on_front = true;
    for (const Point& other : points) {
      const bool beats = other.pass_ms <= point.pass_ms && other.error <= point.error &&
                         (other.pass_ms < point.pass_ms || other.error < point.error);
      if (beats) point.on_front = false;
    }
  }
}

std::string csv(const std::vector<Point>& points) {
  std::string text = "pass_ms,error,front,albedo,rules,datapath,k,step,clipped,command\n";
  for (const Point& point : points) {
    text +=
        fmt::format("{:.6g},{:.6g},{:d},{},{},{},{},{},{:.4g},{}\n", point.pass_ms, point.error, point.on_front,
                    point.albedo, point.rules, point.datapath, point.rays, point.step, point.clipped, point.command());
  }
  return text;
}

void run(const Options& options) {
  const std::vector<double> exact = closed_form();
  std::vector<Point> points = points_of(options);
  for (Point& point : points) {
    measure(point, options, exact);
    std::cerr << fmt::format("{}: {:.4g} ms, error {:.4g}\n", point.command(), point.pass_ms, point.error);
  }
  mark_front(points);
  if (options.output.empty()) {
    std::cout << csv(points);
    return;
  }
  std::ofstream file(options.output);
  if (!(file << csv(points)).flush()) throw std::runtime_error(options.output + ": can't be written");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Cost and error of lighting passes", "gicube-lighting-study");
  Options options;
  app.add_option("--albedo", options.albedos, "low, high")->check(CLI::IsMember({"low", "high"}));
  app.add_option("--rules", options.rules, "conserving, printed")->check(CLI::IsMember({"conserving", "printed"}));
  app.add_option("--datapath", options.datapaths, "paper, wide")->check(CLI::IsMember({"paper", "wide"}));
  app.add_option("--rays", options.rays, "k, of each face voxel")->check(CLI::Range(1, 4096));
  app.add_option("--step", options.steps, "voxels")->check(CLI::Range(1.0 / 64, 16.0));
  app.add_option("--fidelity", options.fidelity, "of the board")->capture_default_str();
  app.add_option("--output", options.output, "CSV file; the terminal if not given");
  try {
    app.parse(argc, argv);
    setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 0);  // this program does not stand beside it
    run(options);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "gicube-lighting-study: " << error.what() << '\n';
    return 1;
  }
}
