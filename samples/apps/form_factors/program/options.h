// Commands of gicube-form-factors: their options and their parts.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "form_factors/plan/plan.h"
#include "scene/program/board_options.h"
#include "scene/program/plan_options.h"
#include "scene/program/progress.h"
#include "scene/program/scene_input.h"

namespace gicube::samples {

// Names of settings, on the command line and in --stats.
inline const std::map<std::string, PairRays> kPairRays{{"board", PairRays::kByBoard}, {"host", PairRays::kByHost}};
inline const std::map<std::string, Solver> kSolvers{{"gathering", Solver::kGathering}, {"shooting", Solver::kShooting}};

struct SolveOptions {
  SceneInput input;
  struct ByTag {
    int tag = 0;
    Power value{};
  };
  std::vector<ByTag> emissions, albedos;  // replace the scene's
  RadiositySettings settings;
  std::filesystem::path factors, elements, solution, picture;  // empty: none
  std::string camera_name;
  std::optional<std::array<int, 2>> size;
  double exposure = 0;  // 0 = the scene's or chosen
  PlanOptions plan;     // replaces the settings' error, rays and leaf_voxels
  BoardOptions board;
};

struct VisibilityOptions {
  SceneInput input;
  std::uint32_t pairs = 100'000;
  int rays = 16;  // per pair
  double step = 0.5;
  PairRays made = PairRays::kByBoard;
  std::filesystem::path pairs_file;  // empty: none
  BoardOptions board;
};

using FormFactorOptions = std::variant<SolveOptions, VisibilityOptions>;

// Empty after printing help or the version to `out`. Throws UsageError with one line.
std::optional<FormFactorOptions> parse_form_factor_options(int argc, const char* const* argv, std::ostream& out);

// Run the command. Throw UsageError, InputError, FileError, and what Board throws.
void run(const SolveOptions& options, ProgressLine& progress);
void run(const VisibilityOptions& options, ProgressLine& progress);

// Applies the options' emissions and albedos to the scene's materials. Adds materials for tags without one.
void set_materials(const SolveOptions& options, Scene& scene);

// Emission of the scene's materials for the solver: per unit of surface for solids, per unit of volume for fogs,
// converted from the scene's units to voxels, and both for scans. Powers stay per unit of the scene's area.
Emissions emissions_of(const SceneSetup& setup);

// Shares of a period in which the board's parts are busy. Empty for parts that the fidelity level does not model.
struct Utilisation {
  double bus_down = 0, bus_up = 0;  // of one bus for both directions
  double dsp = 0;
  std::optional<double> pipelines;  // cycles of the busiest processor with a sample
  std::optional<double> sorter;     // its cycles without a ray ready in its sorter
  std::optional<double> memory;     // data cycles of the busiest memory channel

  std::string bound() const;  // name of the busiest part
};
Utilisation utilisation_of(const Counters& counters, Picoseconds duration, const BoardInfo& board);
nlohmann::ordered_json to_json(const Utilisation& utilisation);

// Pairs of whole voxels (boxes from half a voxel below to half a voxel above their centres, cut off at the volume's
// ends) that are drawn from all alike, no voxel with itself. The same for a seed everywhere.
struct RandomPairs {
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;
};
RandomPairs random_pairs(const Dims& dims, std::uint32_t count, std::uint64_t seed);

struct Visibility {
  std::uint64_t pairs = 0, clear_pairs = 0, rays = 0;  // rays: with those that clear pairs would have had
  std::vector<double> transmittances;                  // of each pair: the mean over its rays by their weight
  double transmittance = 0;                            // mean over the pairs
  double standard_error = 0;                           // of that, over pairs
  std::uint64_t hidden = 0;                            // pairs with less than 1e-3
  Picoseconds duration = 0;                            // simulated
  double host_seconds = 0;
  Counters counters;
  Utilisation utilisation;
};
// The volume is on the board. Throws what Board throws.
Visibility look(Board& board, const RandomPairs& pairs, const PairRequest& request, const Progress& progress = {});

const char* name_of(PairRays made);  // as on the command line

// Keys: elements clusters links all_pairs pairs rays refinements iterations (links, residual) energy (powers of red,
// green and blue, in the scene's units; balance_error) closure_rms standard_error (of the incident light: mean,
// greatest, relative) bus_down_bytes bus_up_bytes board_ms bus_ms host_seconds utilisation settings board counters
// plan: null, or max_error time_budget_ms kept chosen (a point) full_matrix_rays all_rays host_seconds points, each
// with hierarchy threshold rays_a_link leaf_voxels difference error error_bound rays board_ms; fidelity_report: as of
// program/run_json.h.
nlohmann::ordered_json statistics_of(const RadiosityResult& result, const RadiositySettings& settings, double area_unit,
                                     const Counters& counters, const BoardInfo& board,
                                     const std::optional<RadiosityPlan>& plan);

}  // namespace gicube::samples
