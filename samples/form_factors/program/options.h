// The command line of gicube-form-factors.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "form_factors/radiosity/radiosity.h"
#include "scene/program/board_options.h"
#include "scene/program/plan_options.h"
#include "scene/scene.h"

namespace gicube::samples {

// The names of settings, on the command line and in --stats.
inline const std::map<std::string, PairRays> kPairRays{{"board", PairRays::kByBoard}, {"host", PairRays::kByHost}};
inline const std::map<std::string, Solver> kSolvers{{"gathering", Solver::kGathering}, {"shooting", Solver::kShooting}};

// What is solved or looked through.
struct InputOptions {
  std::string input;
  std::optional<int> volume_size;
  std::string transfer_function;
};

struct SolveOptions {
  InputOptions input;
  struct ByTag {
    int tag = 0;
    Power value{};
  };
  std::vector<ByTag> emissions, albedos;  // in place of the scene's
  RadiositySettings settings;
  std::filesystem::path factors, solution, picture;  // empty: none
  std::string camera_name;
  std::optional<std::array<int, 2>> size;
  double exposure = 0;  // 0 = the scene's or chosen
  PlanOptions plan;     // in place of the settings' error, rays and leaf_voxels
  BoardOptions board;
};

struct VisibilityOptions {
  InputOptions input;
  std::uint32_t pairs = 100'000;
  int rays = 16;  // a pair
  double step = 0.5;
  PairRays made = PairRays::kByBoard;
  BoardOptions board;
};

struct FormFactorChartOptions {
  std::filesystem::path folder;     // of the tables; or
  std::string point;                // one point's name, whose row is printed
  std::string command;              // that asked for them, without --output and --point
  std::uint32_t max_rays = 65'536;  // of an estimate of a closed form
  InputOptions trade{.input = "builtin:buckyball", .volume_size = 128, .transfer_function = {}};
  std::uint32_t pairs = 500;                                                   // of random voxels, in the trade
  std::uint32_t max_rays_a_pair = 256;                                         // there
  InputOptions hierarchy;                                                      // scene, and its resolution
  int leaf_voxels = 1;                                                         // there
  std::vector<double> errors{1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6};  // thresholds of its links
  BoardOptions board;
};

using FormFactorOptions = std::variant<SolveOptions, VisibilityOptions, FormFactorChartOptions>;

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<FormFactorOptions> parse_form_factor_options(int argc, const char* const* argv, std::ostream& out);

// The input as a scene. Throws UsageError, InputError.
Scene scene_of(const InputOptions& options);

// The scene's materials with the options' emissions and albedos in their place; materials are made for tags that have none.
void set_materials(const SolveOptions& options, Scene& scene);

}  // namespace gicube::samples
