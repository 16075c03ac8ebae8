#include <fmt/format.h>

#include <algorithm>

#include "polygon_gi/program/options.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"
#include "transport/program/radiance_report.h"

namespace gicube::samples {

void run(const PolygonGiOptions& options, ProgressLine& progress) {
  check_outputs(
      {{"--output", options.light.output}, {"--pixels", options.light.pixels}, {"--stats", options.board.stats}});
  progress.show("reading the scene");
  Scene scene = light_scene(options.light);
  std::vector<PolygonSurface> surfaces = take_polygons(scene);
  const SceneSetup setup = set_up_light(scene, options.light, options.board.threads);
  Board board = open_board(options.board);
  check_renders(setup.volume.dims, board.info(), setup.volume.source);
  const Medium medium(board, setup, progress.parts("loading the volume"));
  refine(surfaces, options.edge, [&](Vec3 point) { return medium.place_of(setup.grid.voxel_of(point)); });
  PolygonGi light(board, medium, std::move(surfaces), options.settings);

  RunWindow window(board);
  light.solve(progress.parts("rows"));
  progress.show("the picture");
  const double unit = setup.grid.voxel * setup.grid.voxel;  // power in the scene's units; of a voxel edge's square
  const auto power = [&](const Rgb& p) { return Rgb{p[0] * unit, p[1] * unit, p[2] * unit}; };
  RadiancePicture picture = light.picture(setup.view, options.passes);
  for (std::vector<Rgb>* values : {&picture.mean, &picture.error})
    std::ranges::transform(*values, values->begin(), power);
  const nlohmann::ordered_json cost = cost_json(board.info(), window);
  progress.clear();

  const PolygonGiStatistics s = light.statistics();
  if (!options.board.quiet) {
    fmt::print("{} sides of triangles, {} zones; {} rays, {} iterations; board {:.3f} ms simulated; {:.1f} s\n",
               s.sides, s.zones, s.rays, s.iterations, cost["board_ms"].get<double>(),
               cost["host_seconds"].get<double>());
    fmt::print("of the red light: {:.1f}% to surfaces, {:.1f}% to the medium, {:.1f}% escaped\n",
               100 * s.absorbed_by_surfaces[0] / s.emitted[0], 100 * s.absorbed_by_medium[0] / s.emitted[0],
               100 * s.escaped[0] / s.emitted[0]);
    print(noise_of(picture));
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  nlohmann::ordered_json json{{"sides", s.sides},
                              {"zones", s.zones},
                              {"rays", s.rays},
                              {"iterations", s.iterations},
                              {"emitted", power(s.emitted)},
                              {"absorbed_by_surfaces", power(s.absorbed_by_surfaces)},
                              {"absorbed_by_medium", power(s.absorbed_by_medium)},
                              {"escaped", power(s.escaped)},
                              {"passes", picture.passes},
                              {"settings",
                               {{"edge", options.edge},
                                {"zone", options.settings.zone},
                                {"rays", options.settings.rays},
                                {"lamp_rays", options.settings.lamp_rays},
                                {"convergence", options.settings.convergence},
                                {"step", options.settings.step},
                                {"seed", options.settings.seed}}}};
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
