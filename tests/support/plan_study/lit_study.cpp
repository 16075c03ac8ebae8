#include "lit_study.h"

#include <array>
#include <cmath>
#include <vector>

#include "scene/program/board_run.h"

namespace gicube::plan_study {
namespace {

constexpr int kReferences = 8;
constexpr int kReferenceRays = 256;
constexpr std::uint32_t kReferenceSeed = 7'000'000;  // far from those of plans

// Sums of red, green, blue and alpha of several pictures, and of their squares.
struct Mean {
  std::vector<std::array<double, 4>> sums, squares;
  int pictures = 0;

  void add(const Image& image) {
    sums.resize(image.pixels.size());
    squares.resize(image.pixels.size());
    ++pictures;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const Pixel& p = image.pixels[i];
      const std::array<double, 4> channels{p.red / 255.0, p.green / 255.0, p.blue / 255.0, p.alpha / 4095.0};
      for (std::size_t c = 0; c < channels.size(); ++c) {
        sums[i][c] += channels[c];
        squares[i][c] += channels[c] * channels[c];
      }
    }
  }
  double power() const {
    double power = 0;
    for (const auto& pixel : sums) {
      for (const double sum : pixel) power += sum / pictures * sum / pictures;
    }
    return power;
  }
  // Of the mean, relative.
  double noise() const {
    double variance = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t c = 0; c < 4; ++c) variance += squares[i][c] / pictures - std::pow(sums[i][c] / pictures, 2);
    }
    return std::sqrt(variance / (pictures - 1) / power());
  }
  double error_of(const Image& image) const {
    Mean one;
    one.add(image);
    double error = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t c = 0; c < 4; ++c) error += std::pow(one.sums[i][c] - sums[i][c] / pictures, 2);
    }
    return std::sqrt(error / power());
  }
};

View best_of(View view) {
  view.step = 1.0 / 4;
  view.opacity_threshold = 1;
  return view;
}

}  // namespace

LitOutcome carry_out_lit(const LitScene& lit, int size, const std::string& uri) {
  samples::Scene scene = lit.study.scene;
  scene.view.width = scene.view.height = size;
  const samples::SceneSetup setup = samples::set_up(scene);
  Board board = Board::open(uri_for(lit.study, uri));
  board.set_shading(setup.shading);
  View view = setup.view;
  view.exposure = setup.lighting.exposure;
  samples::load(board, setup, scene.own_codebook);
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    board.set_material(setup.optics[tag], static_cast<int>(tag));
  }

  LitOutcome outcome;
  LightPlanRequest request;
  request.lights = setup.lights;
  request.settings = setup.lighting.settings;
  request.view = view;
  request.max_error = share_of_light(lit.max_error);
  outcome.light = plan_light(board, request);
  PlanRequest of_picture;
  of_picture.view = view;
  of_picture.max_error = left_for_picture(lit.max_error, outcome.light);
  outcome.picture = make_plan(board, of_picture);
  const Image planned = board.render(outcome.picture.view(view)), planned_light = board.render(best_of(view));
  outcome.bound = std::hypot(outcome.light.chosen.error_bound, outcome.picture.chosen.error_bound);

  Illumination settings = setup.lighting.settings;
  const Counters before = board.counters();
  board.illuminate(setup.lights, settings);
  outcome.asked_samples = static_cast<double>((board.counters() - before).value("pipeline.samples"));
  settings.albedo = settings.rules == EnergyRules::kConserving ? Albedo::kLow : settings.albedo;
  settings.step = 0.5;
  settings.rays_per_face_voxel = kReferenceRays;
  Mean mean;
  for (std::uint32_t i = 0; i < kReferences; ++i) {
    settings.seed = kReferenceSeed + i;
    board.illuminate(setup.lights, settings);
    mean.add(board.render(best_of(view)));
  }
  outcome.reference_noise = mean.noise();
  outcome.error = mean.error_of(planned);
  outcome.light_error = mean.error_of(planned_light);
  return outcome;
}

}  // namespace gicube::plan_study
