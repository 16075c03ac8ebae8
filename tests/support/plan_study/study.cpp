#include "study.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <vector>

#include "reference/march.h"
#include "scene/program/board_run.h"

namespace gicube::plan_study {
namespace {

// Voxels; written here anew, not taken from the plan that is checked.
constexpr double kFinestStep = 1.0 / 16;
double best_step(const Board& board) { return board.info().wide ? kFinestStep : 1.0 / 4; }

std::array<double, 4> channels(const Pixel& pixel) {
  return {pixel.red / 255.0, pixel.green / 255.0, pixel.blue / 255.0, pixel.alpha / 4095.0};
}

Image render(Board& board, const View& view, Cost& cost) {
  samples::RunWindow window(board);
  Image image = board.render(view);
  cost.time = window.simulated();
  cost.host_seconds = window.host_seconds();
  cost.samples = static_cast<double>(window.counters().value("pipeline.samples"));
  return image;
}

void light(Board& board, const samples::SceneSetup& setup) {
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    board.set_material(setup.optics[tag], static_cast<int>(tag));
  }
  board.illuminate(setup.lights, setup.lighting.settings);
}

std::vector<TransferFunction> looks_of(const samples::SceneSetup& setup) {
  const ValueRange range = samples::value_range_of(setup.volume);
  std::vector<TransferFunction> looks;
  for (const auto& material : setup.materials) looks.push_back(samples::in_values_of(range, material));
  return looks;
}

// The same scene marched in doubles, nothing quantised.
reference::Picture exact_picture(const samples::SceneSetup& setup, std::span<const TransferFunction> looks) {
  reference::Scene scene;
  scene.volume = setup.volume_view();
  std::copy(looks.begin(), looks.end(), scene.functions.begin());
  scene.shading = setup.shading;
  scene.view = setup.view;
  scene.view.step = kFinestStep;
  scene.view.opacity_threshold = 1;
  return reference::Renderer(scene).render();
}

double relative_error(const Image& image, const reference::Picture& exact) {
  double error = 0, picture = 0;
  for (std::size_t i = 0; i < exact.pixels.size(); ++i) {
    const reference::Rgba& pixel = exact.pixels[i];
    const std::array<double, 4> a = channels(image.pixels[i]),
                                b{pixel.colour[0], pixel.colour[1], pixel.colour[2], pixel.opacity};
    for (std::size_t c = 0; c < a.size(); ++c) {
      error += (a[c] - b[c]) * (a[c] - b[c]);
      picture += b[c] * b[c];
    }
  }
  return std::sqrt(error / picture);
}

}  // namespace

double relative_error(const Image& image, const Image& best) {
  double error = 0, picture = 0;
  for (std::size_t i = 0; i < best.pixels.size(); ++i) {
    const auto a = channels(image.pixels[i]), b = channels(best.pixels[i]);
    for (std::size_t c = 0; c < a.size(); ++c) {
      error += (a[c] - b[c]) * (a[c] - b[c]);
      picture += b[c] * b[c];
    }
  }
  return std::sqrt(error / picture);
}

std::string uri_for(const StudyScene& study, const std::string& uri) {
  if (study.max_volume_voxels == 0) return uri;
  const char* separator = uri.find('?') == std::string::npos ? "?" : "&";
  return uri + separator + "set=asic.max_volume_voxels=" + std::to_string(study.max_volume_voxels);
}

std::vector<Plan> plans_for(const StudyScene& study, int size, const std::vector<double>& max_errors,
                            const std::string& uri) {
  samples::Scene scene = study.scene;
  scene.view.width = scene.view.height = size;
  const samples::SceneSetup setup = samples::set_up(scene);
  Board board = Board::open(uri_for(study, uri));
  board.set_shading(setup.shading);
  const std::vector<TransferFunction> looks = looks_of(setup);
  PlanRequest request;
  request.view = setup.view;
  request.volume = setup.volume_view();
  request.looks = looks;
  std::vector<Plan> plans;
  for (const double error : max_errors) {
    request.max_error = error;
    plans.push_back(make_plan(board, request));
  }
  return plans;
}

int cheaper_and_kept(const Plan& plan) {
  int count = 0;
  for (const PlanPoint& point : plan.points) {
    count += point.error_bound <= plan.request.max_error && point.samples < plan.chosen.samples;
  }
  return count;
}

PlanOutcome carry_out(const StudyScene& study, int size, const Target& target, const std::string& uri, bool exact) {
  samples::Scene scene = study.scene;
  scene.view.width = scene.view.height = size;
  const samples::SceneSetup setup = samples::set_up(scene);
  Board board = Board::open(uri_for(study, uri));
  board.set_shading(setup.shading);
  View view = setup.view;
  view.exposure = setup.lighting.exposure;

  const std::vector<TransferFunction> looks = looks_of(setup);
  PlanRequest request;
  request.view = view;
  request.max_error = target.max_error;
  request.time_budget = target.time_budget;
  if (scene.lighting.on) {
    samples::load(board, setup, scene.own_codebook);
    light(board, setup);
  } else {
    request.volume = setup.volume_view();
    request.looks = looks;
  }
  PlanOutcome outcome;
  outcome.plan = make_plan(board, request);
  const Image image = render(board, outcome.plan.view(view), outcome.chosen);
  if (!scene.lighting.on) samples::load(board, setup, false);
  view.opacity_threshold = 1;
  view.step = best_step(board);
  const Image best = render(board, view, outcome.best);
  view.step = kFinestStep;
  const Image finest = render(board, view, outcome.finest);
  outcome.error = relative_error(image, best);
  if (!exact || scene.lighting.on) return outcome;
  const reference::Picture truth = exact_picture(setup, looks);
  outcome.exact_error = relative_error(image, truth);
  outcome.exact_error_of_best = relative_error(best, truth);
  outcome.exact_error_of_finest = relative_error(finest, truth);
  return outcome;
}

std::vector<double> errors_of_steps(const StudyScene& study, int size, const std::string& uri,
                                    const std::vector<double>& steps) {
  samples::Scene scene = study.scene;
  scene.view.width = scene.view.height = size;
  const samples::SceneSetup setup = samples::set_up(scene);
  Board board = Board::open(uri_for(study, uri));
  board.set_shading(setup.shading);
  samples::load(board, setup, scene.own_codebook);
  const reference::Picture truth = exact_picture(setup, looks_of(setup));
  View view = setup.view;
  view.opacity_threshold = 1;
  std::vector<double> errors;
  for (const double step : steps) {
    view.step = step;
    errors.push_back(relative_error(board.render(view), truth));
  }
  return errors;
}

}  // namespace gicube::plan_study
