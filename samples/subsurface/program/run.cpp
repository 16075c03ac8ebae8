#include <fmt/format.h>

#include <algorithm>

#include "scene/common/whole_file.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"
#include "subsurface/program/options.h"
#include "subsurface/surface.h"
#include "transport/program/radiance_report.h"

namespace gicube::samples {
namespace {

// Radii in the slab's units, of `voxel` each.
void write_profile(const Profile& profile, double voxel, const std::filesystem::path& file) {
  std::string text = "inner,outer,red,green,blue,red_error,green_error,blue_error\n";
  for (const Profile::Ring& ring : profile.rings) {
    text +=
        fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.3g},{:.3g},{:.3g}\n", ring.inner * voxel, ring.outer * voxel,
                    ring.share[0], ring.share[1], ring.share[2], ring.error[0], ring.error[1], ring.error[2]);
  }
  write_whole(file, text);
}

std::size_t surface_of(const std::vector<PolygonSurface>& surfaces, const std::string& node) {
  if (node.empty()) return 0;
  const auto found = std::ranges::find(surfaces, node, &PolygonSurface::name);
  if (found == surfaces.end()) throw UsageError("--node: expected a node of boxes or meshes, got " + in_quotes(node));
  return static_cast<std::size_t>(found - surfaces.begin());
}

}  // namespace

void run(const SubsurfaceOptions& options, ProgressLine& progress) {
  check_outputs({{"--output", options.light.output},
                 {"--pixels", options.light.pixels},
                 {"--profile", options.profile},
                 {"--stats", options.board.stats}});
  progress.show("reading the scenes");
  Scene scene = light_scene(options.light);
  std::vector<PolygonSurface> surfaces = take_polygons(scene);
  const std::size_t of_material = surface_of(surfaces, options.node);
  const SceneSetup slab =
      set_up(at_time(read_scene(options.material, options.light.allow_outside), 0), options.board.threads);
  const SceneSetup setup = set_up_light(scene, options.light, options.board.threads);
  Board board = open_board(options.board);
  check_renders(slab.volume.dims, board.info(), slab.volume.source);
  RunWindow window(board);
  Profile profile;
  {
    const Medium medium(board, slab, progress.parts("loading the slab"));
    progress.show("photons");
    profile = measure_profile(board, medium, options.settings);
  }
  if (!options.profile.empty()) write_profile(profile, slab.grid.voxel, options.profile);
  const nlohmann::ordered_json cost = cost_json(board.info(), window);

  const Medium medium(board, setup, progress.parts("loading the scene"));
  const Lights lights(setup, medium);
  refine(surfaces, options.edge, [&](Vec3 point) { return medium.place_of(setup.grid.voxel_of(point)); });
  const double scale = options.scale * slab.grid.voxel / setup.grid.voxel;  // voxels of the scene for one of the slab
  progress.show("the picture");
  const SubsurfacePicture drawn(medium, lights, std::move(surfaces), profile, of_material, scale, options.lamp_rays,
                                options.settings.seed);
  const RadiancePicture picture = drawn.picture(setup.view, options.passes);
  progress.clear();

  if (!options.board.quiet) {
    fmt::print("{} photons, {} rays; board {:.3f} ms simulated; {:.1f} s\n", profile.photons, profile.rays,
               cost["board_ms"].get<double>(), cost["host_seconds"].get<double>());
    fmt::print(
        "of the red light {:.2f} ± {:.2f}% comes back ({:.2f}% within the rings), {:.2f} ± {:.2f}% goes through, "
        "{:.2f} ± {:.2f}% out at the sides (standard errors)\n",
        100 * profile.reflected[0], 100 * profile.reflected_error[0],
        100 * profile.within(profile.rings.back().outer)[0], 100 * profile.transmitted[0],
        100 * profile.transmitted_error[0], 100 * profile.sideways[0], 100 * profile.sideways_error[0]);
    warn_if_black(noise_of(picture));
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  nlohmann::ordered_json json{{"photons", profile.photons},
                              {"rays", profile.rays},
                              {"reflected", profile.reflected},
                              {"reflected_error", profile.reflected_error},
                              {"transmitted", profile.transmitted},
                              {"transmitted_error", profile.transmitted_error},
                              {"sideways", profile.sideways},
                              {"sideways_error", profile.sideways_error},
                              {"settings",
                               {{"straight", options.settings.straight},
                                {"rings", options.settings.rings},
                                {"scale", options.scale},
                                {"edge", options.edge},
                                {"lamp_rays", options.lamp_rays},
                                {"step", options.settings.step},
                                {"seed", options.settings.seed}}}};
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
