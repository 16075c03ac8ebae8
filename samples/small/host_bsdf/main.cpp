// A material whose scattering is the application's own: a ball of cat's eyes, each of which sends light back to where
// it came from, but for a little spread. The rays that meet it cross the bus to this program and back, and pay for it.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace {

// Within a cone of 5 degrees about the way back; a tenth of the light is lost.
gicube::ScatterAnswer cats_eye(const gicube::ScatterEvent& event) {
  const gicube::Vec3 back = -1.0 * event.direction;
  const gicube::Vec3 across = std::abs(back.x) < 0.7 ? gicube::Vec3{1, 0, 0} : gicube::Vec3{0, 1, 0};
  const gicube::Vec3 u = normalise(cross(back, across)), v = cross(back, u);
  const double sine = std::sqrt(event.random[0]) * std::sin(5 * std::numbers::pi / 180);
  const double angle = 2 * std::numbers::pi * event.random[1];
  return {back + sine * std::cos(angle) * u + sine * std::sin(angle) * v, 0.9};
}

}  // namespace

int main() {
  constexpr int n = 48;
  std::vector<std::byte> voxels;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const double radius = length(gicube::Vec3{x - 23.5, y - 23.5, z - 23.5});
        voxels.push_back(static_cast<std::byte>(std::clamp(128 + 60 * (12 - radius), 0.0, 255.0)));
      }
    }
  }
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = voxels, .type = gicube::SampleType::kUint8, .dims = {n, n, n}});
  board.set_transfer_function({.colours = {{0, {1.0, 0.9, 0.5}}}, .opacities = {{96, 0.0}, {160, 0.9}}});
  board.set_material({.scattering = 0.95,
                      .bsdf = gicube::Bsdf::kTrap,
                      .seen_through_scattering = true,
                      .routine = gicube::kHostRoutine,
                      .surface = true});
  long asked = 0;
  board.set_scattering_routine([&asked](const gicube::ScatterEvent& event) { return ++asked, cats_eye(event); },
                               1'000'000);  // the simulated host takes a microsecond for a ray
  const gicube::Light lamp = gicube::PointLight{{23.5, 60, -40}};
  gicube::Illumination settings;
  settings.rays_per_face_voxel = 4;
  const gicube::LightingReport report = board.illuminate({&lamp, 1}, settings);
  const auto percent = [&report](double part) { return 100 * part / report.emitted; };
  std::printf("%ld rays asked this program: %.1f%% of the light absorbed, %.1f%% escaped, %.1f%% dropped\n", asked,
              percent(report.deposited), percent(report.escaped), percent(report.scattered_away));
  const gicube::Counters counters = board.counters();
  std::printf("%.2f simulated ms, %.2f MB of rays over the bus\n", gicube::to_ms(board.now()),
              static_cast<double>(counters.value("bus.rays.bytes")) / 1e6);
}
