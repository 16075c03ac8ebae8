#include "radiosity_study.h"

#include "form_factors/program/options.h"
#include "gicube/scene/scene.h"

namespace gicube::plan_study {
namespace {

samples::Scene world(const std::filesystem::path& file, int size) {
  samples::Scene scene = samples::read_scene(file);
  scene.world->size = size;
  scene.lighting.on = false;
  return scene;
}

}  // namespace

std::vector<RadiosityScene> radiosity_scenes(const std::filesystem::path& sources) {
  const auto room = sources / "samples/scenes/radiosity/glowing_room.scene";
  const auto head = sources / "samples/scenes/radiosity/lantern.scene";
  std::vector<RadiosityScene> scenes{
      {"glowing room, 10", world(room, 10), 0.1, 0},   {"glowing room, 14", world(room, 14), 0.1, 1},
      {"white room, 10", world(room, 10), 0.1, 1},     {"dark room without fog, 12", world(room, 12), 0.1, 1},
      {"lantern, 12", world(head, 12), 0.1, 1},        {"lantern, 12, at 5%", world(head, 12), 0.05, 1},
      {"fog that glows, 10", world(room, 10), 0.05, 1}};
  scenes.push_back({"glowing room, 10, at 3%", world(room, 10), 0.03, 0});
  scenes.push_back({"glowing room, 10, at 25%", world(room, 10), 0.25, 0});
  for (samples::SceneMaterial& material : scenes[2].scene.materials) material.optics.scattering = 0.9;
  auto& dark = scenes[3].scene.materials;
  for (samples::SceneMaterial& material : dark) material.optics.scattering = 0.2;
  std::erase_if(scenes[3].scene.world->root.children, [](const auto& node) { return node.name == "air"; });
  for (samples::SceneMaterial& material : scenes[6].scene.materials) {
    if (material.name == "fog") material.emission = 1;
    if (material.name == "lamp") material.emission = 0;
  }
  return scenes;
}

RadiosityOutcome carry_out_radiosity(const RadiosityScene& wanted, const std::string& uri) {
  const samples::SceneSetup setup = samples::set_up(wanted.scene);
  const samples::Emissions emissions = samples::emissions_of(setup);
  Board board = Board::open(uri);
  RadiosityOutcome outcome;
  outcome.plan = plan_radiosity(board, setup, emissions, {}, {wanted.max_error, 0});
  samples::RadiositySettings exact;
  exact.hierarchy = false;
  exact.rays = 64;
  exact.seed = 1000;
  const auto reference = solve_radiosity(board, setup, emissions, exact);
  outcome.error = difference(outcome.plan.result, reference);
  outcome.reference_rays = static_cast<double>(reference.statistics.rays);
  outcome.host_seconds = reference.statistics.host_seconds;
  return outcome;
}

}  // namespace gicube::plan_study
