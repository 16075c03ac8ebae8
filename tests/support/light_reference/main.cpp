// gicube-light-reference: a scene's light by the path tracer of tests/support/reference/paths, as gicube-light writes
// it: a picture, and with --pixels the radiance of each pixel and its standard error.
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "light/program/radiance_report.h"
#include "light_reference/path_scene_of.h"
#include "light_reference/tiles.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"

namespace {

using namespace gicube;
using namespace gicube::samples;

int draw(int argc, char** argv) {
  CLI::App app("The light of a scene in double precision.", "gicube-light-reference");
  LightInput input;
  std::uint64_t paths = 64, seed = 1;
  int max_scatterings = 1 << 20;
  unsigned threads = 0;
  add_light_input(app, input);
  OptionGroup method(app, "Method");
  method.number("--paths", paths, CLI::Range(2, 100'000'000), "a pixel");
  method.number("--max-scatterings", max_scatterings, CLI::Range(0, 1 << 20), "of a path: longer ones are missing");
  method.number("--seed", seed, CLI::Range(0, 1'000'000'000), "of the random numbers");
  method.number("--threads", threads, CLI::Range(0, 1024), "0: one a core; the picture does not depend on it");
  if (!parsed(app, argc, argv, std::cout)) return 0;
  if (!input.output.empty()) check_picture_name(input.output);

  const SceneSetup setup = set_up_light(light_scene(input), input, 0);
  reference::paths::PathScene scene = to_paths(setup);
  scene.max_scatterings = max_scatterings;
  // White is what the board's lamps in mirrors show at most.
  if (input.exposure == 0) input.exposure = setup.lighting.exposure;
  if (input.exposure > 0) scene.max_seen = 1 / (std::numbers::pi * input.exposure);
  const auto start = std::chrono::steady_clock::now();
  const reference::paths::RadiancePicture found =
      reference::paths::PathTracer(scene, true).render(paths, seed, threads);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;

  nlohmann::ordered_json errors;
  for (const int edge : {1, 4, 8}) errors[std::to_string(edge)] = light_reference::relative_error(found, edge);
  const nlohmann::ordered_json stats{
      {"seconds", took.count()}, {"exposure", input.exposure}, {"relative_error_of_tiles", errors}};
  std::cout << stats.dump() << '\n';
  RadiancePicture picture{found.width, found.height, paths, {}, {}};
  for (const auto& pixel : found.pixels) {
    picture.mean.push_back({pixel[0].mean, pixel[1].mean, pixel[2].mean});
    picture.error.push_back({pixel[0].error, pixel[1].error, pixel[2].error});
  }
  write_pictures(picture, input, this_run());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-light-reference", [&] { return draw(argc, argv); });
}
