// gicube-plan-study: the tables of docs/guide/plan.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "fdk_study.h"
#include "lit_study.h"
#include "radiosity_study.h"
#include "study.h"

namespace {

using namespace gicube::plan_study;

struct Options {
  std::string board = "emu:";
  std::string data = GICUBE_SOURCE_DIR "/../shared/data";
  std::vector<std::string> scenes;
  int size = 512;
  std::vector<double> percents{1};
  double milliseconds = 0;
  bool explain = false, exact = false, lit = false, radiosity = false, fdk = false, steps = false;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--board", options.board, "URI of the emulated board")->capture_default_str();
  app.add_option("--data", options.data, "folder of the real scans; those that are not there are left out")
      ->capture_default_str();
  app.add_option("--scene", options.scenes, "only this scene (repeatable)");
  app.add_option("--size", options.size, "pixels an edge of the picture")->capture_default_str();
  app.add_option("--max-error", options.percents, "percent (repeatable)")->capture_default_str();
  app.add_option("--time-budget", options.milliseconds, "of board time, in place of an error; needs fidelity=cycle");
  app.add_flag("--exact", options.exact, "also against the double-precision march, which takes minutes");
  app.add_flag("--lit", options.lit, "plans of light too, of lit scenes with targets of their own");
  app.add_flag("--radiosity", options.radiosity, "plans of gicube-form-factors, with targets of their own");
  app.add_flag("--fdk", options.fdk, "plans of gicube-cone-beam reconstruct, with targets of their own");
  app.add_flag("--steps", options.steps,
               "no plan: each step of the board against the double-precision march, rays to their end");
  app.add_flag("--explain", options.explain, "each plan in words");
}

void print(const StudyScene& study, const PlanOutcome& outcome, const Options& options) {
  const gicube::PlanPoint& chosen = outcome.plan.chosen;
  fmt::print("| {} | {} | {:g} | {} | {:g} | {:g} | {:.2f} | {:.2f} | {:.2f} | {} | {:.1f} | {:.1f} |", study.name,
             study.look, 100 * outcome.plan.request.max_error, chosen.level, chosen.step, chosen.opacity_threshold,
             100 * outcome.error, 100 * chosen.error, 100 * chosen.error_bound, cheaper_and_kept(outcome.plan),
             outcome.finest.samples / outcome.chosen.samples,
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

void run_radiosity(const Options& options) {
  fmt::print(
      "| scene | target % | threshold | rays per link | leaf voxels | error % | predicted | bound | rays saved, times "
      "| "
      "all "
      "solutions' rays | plan, host s | reference |\n");
  for (const RadiosityScene& scene : radiosity_scenes(GICUBE_SOURCE_DIR)) {
    const auto& names = options.scenes;
    if (!names.empty() && std::find(names.begin(), names.end(), scene.name) == names.end()) continue;
    const RadiosityOutcome outcome = carry_out_radiosity(scene, options.board);
    const auto& plan = outcome.plan;
    fmt::print("| {} | {:g}{} | {:.2g} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.0f} | {} | {:.1f} | {:.1f} |\n",
               scene.name, 100 * scene.max_error, plan.kept ? "" : " not reached", plan.chosen.threshold,
               plan.chosen.rays, plan.chosen.leaf_voxels, 100 * outcome.error, 100 * plan.chosen.error,
               100 * plan.chosen.error_bound, plan.finest_rays / plan.chosen.all_rays,
               gicube::count_text(plan.all_rays), plan.host_seconds, outcome.host_seconds);
    std::fflush(stdout);
    if (!options.explain) continue;
    for (const auto& point : plan.points) {
      fmt::print("    {:.2g} {} {}: difference {:.2f}%, {} rays\n", point.threshold, point.rays, point.leaf_voxels,
                 100 * point.difference, gicube::count_text(point.all_rays));
    }
    for (const std::string& line : plan.explain()) fmt::print("    {}\n", line);
  }
}

void run_fdk(const Options& options) {
  fmt::print(
      "| scan | target % | views | rays per pixel | step | error % | predicted | bound | deposits saved, "
      "times | "
      "error against the phantom % | of the finest | plan, host s | planned | finest |\n");
  for (const FdkScan& scan : fdk_scans()) {
    const auto& names = options.scenes;
    if (!names.empty() && std::find(names.begin(), names.end(), scan.name) == names.end()) continue;
    const FdkOutcome outcome = carry_out_fdk(scan, options.board);
    const auto& plan = outcome.plan;
    const auto every = static_cast<std::size_t>(plan.chosen.every);
    fmt::print(
        "| {} | {:g} | {} of {} | {} | {:g} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | "
        "{:.1f} | {:.1f} |\n",
        scan.name, 100 * scan.max_error, (plan.views + every - 1) / every, plan.views, plan.chosen.rays,
        plan.chosen.step, 100 * outcome.error, 100 * plan.chosen.error, 100 * plan.chosen.error_bound,
        outcome.finest_deposits / outcome.deposits, 100 * outcome.truth, 100 * outcome.finest_truth, plan.host_seconds,
        outcome.host_seconds, outcome.finest_seconds);
    std::fflush(stdout);
    if (!options.explain) continue;
    for (const std::string& line : plan.explain()) fmt::print("    {}\n", line);
    for (const auto& point : plan.points) {
      fmt::print("    every {} rays {} step {:g}: error {:.2f}%, bound {:.2f}%\n", point.every, point.rays, point.step,
                 100 * point.error, 100 * point.error_bound);
    }
  }
}

void run_steps(const Options& options) {
  fmt::print("| scene | 1 | 1/2 | 1/4 | 1/8 | 1/16 | 1/32 | 1/64 |\n");
  for (const StudyScene& study : study_scenes(options.data, GICUBE_SOURCE_DIR)) {
    if (study.scene.lighting.on || !wanted(study, options)) continue;
    fmt::print("| {} |", study.name);
    for (const double error :
         errors_of_steps(study, options.size, options.board, {1, 0.5, 0.25, 0.125, 1.0 / 16, 1.0 / 32, 1.0 / 64})) {
      fmt::print(" {:.2f} |", 100 * error);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

std::vector<Target> targets_of(const Options& options) {
  if (options.milliseconds > 0) return {{0, static_cast<gicube::Picoseconds>(options.milliseconds * 1e9)}};
  std::vector<Target> targets;
  for (const double percent : options.percents) targets.push_back({percent / 100, 0});
  return targets;
}

void run(const Options& options) {
  fmt::print(
      "| scene | look | target % | level | step | threshold | error % | in the pilot | bound | cheaper ones within the "
      "target | samples saved, times | pilots, % "
      "of the finest's samples | finest, host s | chosen | plan |{}\n",
      options.board.find("cycle") != std::string::npos ? " finest, board ms | chosen | predicted |" : "");
  for (const StudyScene& study : study_scenes(options.data, GICUBE_SOURCE_DIR)) {
    if (!wanted(study, options)) continue;
    for (const Target& target : targets_of(options)) {
      const PlanOutcome outcome = carry_out(study, options.size, target, options.board, options.exact);
      print(study, outcome, options);
      if (!options.explain) continue;
      for (const std::string& line : outcome.plan.explain()) fmt::print("    {}\n", line);
    }
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
    if (options.lit) {
      run_lit(options);
    } else if (options.radiosity) {
      run_radiosity(options);
    } else if (options.fdk) {
      run_fdk(options);
    } else if (options.steps) {
      run_steps(options);
    } else {
      run(options);
    }
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "gicube-plan-study: " << error.what() << '\n';
    return 1;
  }
}
