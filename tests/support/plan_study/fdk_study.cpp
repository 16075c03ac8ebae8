#include "fdk_study.h"

#include <numbers>

#include "scene/program/board_run.h"

namespace gicube::plan_study {
namespace {

// As samples/studies/cone_beam.py: the skull takes away 0.05 a millimetre; a whole turn around a volume of 90 mm a
// side.
samples::Phantom times(double value, samples::Phantom phantom) {
  for (samples::Ellipsoid& part : phantom) part.value *= value;
  return phantom;
}
samples::Phantom chart_head(double radius) { return times(0.05, samples::high_contrast_shepp_logan(radius)); }
samples::ConeGeometry chart_scan(int voxels, int pixels, int views) {
  return {.source_to_axis = 400,
          .source_to_detector = 800,
          .detector = {pixels, pixels, 200.0 / pixels, 200.0 / pixels},
          .volume = {{voxels, voxels, voxels}, (90.0 / voxels) * Vec3{1, 1, 1}},
          .angles = samples::even_angles(views, 0.1, 2 * std::numbers::pi)};
}

}  // namespace

std::vector<FdkScan> fdk_scans() {
  samples::ConeGeometry short_scan = chart_scan(48, 72, 91);
  short_scan.angles = samples::even_angles(91, 0.1, 220 * std::numbers::pi / 180 * 91 / 90);
  const samples::Phantom head = chart_head(42);
  return {{"head", head, chart_scan(64, 96, 120), 0, 0.1, 0},
          {"head, at 30%", head, chart_scan(64, 96, 120), 0, 0.3, 0},
          {"sphere", samples::uniform_sphere(38, 1), chart_scan(64, 64, 180), 0, 0.05, 1},
          {"Kak and Slaney's head", samples::shepp_logan(40), chart_scan(64, 96, 240), 0, 0.05, 1},
          {"discs", times(0.05, samples::discs(36)), chart_scan(64, 96, 120), 0, 0.1, 1},
          {"head, 3000 photons", head, chart_scan(64, 96, 240), 3000, 0.1, 1},
          {"head, short scan", head, short_scan, 0, 0.1, 1},
          {"head, coarse pixels", head, chart_scan(80, 64, 120), 0, 0.1, 1},
          {"small head, at 20%", chart_head(25), chart_scan(64, 96, 180), 0, 0.2, 1}};
}

FdkOutcome carry_out_fdk(const FdkScan& scan, const std::string& uri) {
  Board board = Board::open(uri);
  samples::Projections projections = project(scan.phantom, scan.geometry);
  if (scan.photons > 0) add_poisson_noise(projections, scan.photons, 1);
  const samples::FdkSettings asked;
  FdkOutcome outcome;
  outcome.plan = plan_fdk(board, scan.geometry, projections, asked, {scan.max_error, 0});
  const auto run = [&](const samples::FdkPlanPoint& point, double& deposits, double& seconds) {
    samples::FdkPlan plan = outcome.plan;
    plan.chosen = point;
    samples::RunWindow window(board);
    const auto made =
        reconstruct_fdk(board, some_views(scan.geometry, point.every),
                        some_views(projections, scan.geometry.angles.size(), point.every), plan.settings(asked));
    deposits = static_cast<double>(made.deposits);
    seconds = window.host_seconds();
    return made.values;
  };
  const auto values = run(outcome.plan.chosen, outcome.deposits, outcome.host_seconds);
  const auto finest = run(outcome.plan.finest, outcome.finest_deposits, outcome.finest_seconds);
  const samples::Grid& grid = scan.geometry.volume;
  const samples::FieldOfView& field = outcome.plan.field;
  const auto truth = samples::voxels(scan.phantom, grid);
  outcome.error = compare(grid, values, finest, field).relative_l2;
  outcome.truth = compare(grid, values, truth, field).relative_l2;
  outcome.finest_truth = compare(grid, finest, truth, field).relative_l2;
  return outcome;
}

}  // namespace gicube::plan_study
