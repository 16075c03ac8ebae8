// gicube-plan-study: the tables of docs/PLAN.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "plan_study/lit_study.h"
#include "plan_study/study.h"

namespace {

using namespace gicube::plan_study;

struct Options {
  std::string board = "emu:";
  std::string data = GICUBE_SOURCE_DIR "/../shared/data";
  std::vector<std::string> scenes;
  int size = 512;
  double percent = 1;
  double milliseconds = 0;
  bool explain = false, exact = false, lit = false;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--board", options.board, "URI of the emulated board")->capture_default_str();
  app.add_option("--data", options.data, "folder of the real scans; those that are not there are left out")
      ->capture_default_str();
  app.add_option("--scene", options.scenes, "only this scene (repeatable)");
  app.add_option("--size", options.size, "pixels an edge of the picture")->capture_default_str();
  app.add_option("--max-error", options.percent, "percent")->capture_default_str();
  app.add_option("--time-budget", options.milliseconds,
                 "of board time, in place of an error; needs fidelity=approximate");
  app.add_flag("--exact", options.exact, "also against the double-precision march, which takes minutes");
  app.add_flag("--lit", options.lit, "plans of light too, of lit scenes with targets of their own");
  app.add_flag("--explain", options.explain, "each plan in words");
}

void print(const StudyScene& study, const Outcome& outcome, const Options& options) {
  const gicube::PlanPoint& chosen = outcome.plan.chosen;
  fmt::print("| {} | {} | {} | {:g} | {:g} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} |", study.name, study.look,
             chosen.level, chosen.step, chosen.opacity_threshold, 100 * outcome.error, 100 * chosen.error,
             100 * chosen.error_bound, outcome.finest.samples / outcome.chosen.samples,
             100 * outcome.plan.pilot_samples / outcome.finest.samples);
  fmt::print(" {:.2f} | {:.2f} | {:.2f} |", outcome.finest.host_seconds, outcome.chosen.host_seconds,
             outcome.plan.pilot_host_seconds);
  if (chosen.time > 0) {
    fmt::print(" {:.1f} | {:.1f} | {:.1f} |", gicube::to_ms(outcome.finest.time), gicube::to_ms(outcome.chosen.time),
               gicube::to_ms(chosen.time));
  }
  if (options.exact) {
    fmt::print(" {:.2f} | {:.2f} | {:.2f} |", 100 * outcome.exact_error, 100 * outcome.exact_error_of_best,
               100 * outcome.exact_error_of_finest);
  }
  fmt::print("\n");
  std::fflush(stdout);
}

bool wanted(const StudyScene& study, const Options& options) {
  const auto& names = options.scenes;
  if (!names.empty() && std::find(names.begin(), names.end(), study.name) == names.end()) return false;
  if (study.available()) return true;
  std::cerr << study.name << ": left out, " << study.scene.volume.file.string() << " is not there\n";
  return false;
}

void run_lit(const Options& options) {
  fmt::print(
      "| scene | target % | albedo | rays | light's error % | predicted | bound | error of all % | bound | light's "
      "samples "
      "saved, times | picture's | reference's noise % | plan, host s |\n");
  for (const LitScene& lit : lit_scenes(options.data, GICUBE_SOURCE_DIR)) {
    if (!wanted(lit.study, options)) continue;
    const LitOutcome outcome = carry_out_lit(lit, options.size, options.board);
    const gicube::LightPoint& light = outcome.light.chosen;
    const gicube::PlanPoint& picture = outcome.picture.chosen;
    fmt::print(
        "| {} | {:g}{} | {} | {} of {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.2f} | "
        "{:.1f} |\n",
        lit.study.name, 100 * lit.max_error, outcome.bound <= lit.max_error ? "" : " not reached",
        light.albedo == gicube::Albedo::kLow ? "low" : "high", light.rays_per_face_voxel,
        lit.study.scene.lighting.settings.rays_per_face_voxel, 100 * outcome.light_error, 100 * light.error,
        100 * light.error_bound, 100 * outcome.error, 100 * outcome.bound, outcome.asked_samples / light.samples,
        outcome.picture.finest.samples / picture.samples, 100 * outcome.reference_noise,
        outcome.light.host_seconds + outcome.picture.pilot_host_seconds);
    std::fflush(stdout);
    if (!options.explain) continue;
    for (const std::string& line : outcome.light.explain()) fmt::print("    {}\n", line);
    for (const std::string& line : outcome.picture.explain()) fmt::print("    {}\n", line);
  }
}

void run(const Options& options) {
  fmt::print(
      "| scene | look | level | step | threshold | error % | in the pilot | bound | samples saved, times | pilots, % "
      "of the finest's samples | finest, host s | chosen | plan |{}\n",
      options.board.find("approximate") != std::string::npos ? " finest, board ms | chosen | predicted |" : "");
  for (const StudyScene& study : study_scenes(options.data, GICUBE_SOURCE_DIR)) {
    if (!wanted(study, options)) continue;
    Target target{options.percent / 100, 0};
    if (options.milliseconds > 0) target = {0, static_cast<gicube::Picoseconds>(options.milliseconds * 1e9)};
    const Outcome outcome = carry_out(study, options.size, target, options.board, options.exact);
    print(study, outcome, options);
    if (!options.explain) continue;
    for (const std::string& line : outcome.plan.explain()) fmt::print("    {}\n", line);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Plans against the pictures that they are about");
  Options options;
  add_options(app, options);
  try {
    app.parse(argc, argv);
    setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 0);  // this program does not stand beside it
    options.lit ? run_lit(options) : run(options);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "gicube-plan-study: " << error.what() << '\n';
    return 1;
  }
}
