#include "brick_scenes.h"

#include "test.h"
#include "voxels.h"

namespace gicube::reference {

Blobs make_blobs(std::mt19937& random, int least, int most) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  Blobs out{};
  for (int& edge : out.dims) edge = std::uniform_int_distribution(least, most)(random);
  std::array<std::array<double, 4>, 5> balls{};
  for (auto& ball : balls) {
    for (std::size_t axis = 0; axis < 3; ++axis) ball[axis] = within(0, out.dims[axis]);
    ball[3] = within(4, 16);
  }
  for_each_voxel(out.dims, [&](int x, int y, int z) {
    double value = x % 32 < 20 ? 30 + 10 * std::sin(0.3 * y + 0.2 * z) : 0;
    for (const auto& ball : balls) {
      const double radius = length(Vec3{x - ball[0], y - ball[1], z - ball[2]});
      value = std::max(value, 60 + 20 * (ball[3] - radius));
    }
    out.samples.push_back(static_cast<std::byte>(std::clamp(value, 0.0, 255.0)));
  });
  return out;
}

View make_view(std::mt19937& random, const Dims& dims, int pixels) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const auto flip = [&] { return std::bernoulli_distribution(0.5)(random); };
  View view;
  view.width = pixels, view.height = pixels;
  const bool inside = flip();
  const double most = std::max({dims[0], dims[1], dims[2]});
  const auto place = [&](std::size_t axis) {
    return inside ? within(0, dims[axis] - 1) : dims[axis] / 2.0 + within(-1.5, 1.5) * most;
  };
  view.eye = {place(0), place(1), place(2)};
  view.look_at = {dims[0] * within(0.3, 0.7), dims[1] * within(0.3, 0.7), dims[2] * within(0.3, 0.7)};
  view.up = {0.1, 1, 0.2};
  view.fov_degrees = within(20, 100);
  if (flip() && flip()) view.orthographic_height = most * within(0.5, 1.5);
  view.samples_per_axis = flip() ? 1 : 2;
  view.filter = flip() ? PixelFilter::kBox : PixelFilter::kTent;
  view.step = flip() ? 0.5 : within(0.4, 12);
  view.jitter = flip();
  view.shade = flip();
  view.leap = flip() || flip();
  view.opacity_threshold = flip() ? 0.95 : 1;
  if (flip()) view.cut_planes.push_back({{within(-1, 1), within(-1, 1), 1}, dims[2] * within(0.1, 0.4)});
  return view;
}

TransferFunction fog_and_balls(double fog) {
  return {.colours = {{0, {0.2, 0.4, 1}}, {255, {1, 0.6, 0.2}}},
          .opacities = {{20, 0}, {21, fog}, {60, fog}, {200, 0.6}}};
}

std::vector<HostRay> random_rays(std::mt19937& random, const Dims& dims, std::uint32_t count, bool segments) {
  const auto point = [&] {
    const auto at = [&](int edge) { return std::uniform_real_distribution(0.0, edge - 1.0)(random); };
    return Vec3{at(dims[0]), at(dims[1]), at(dims[2])};
  };
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 from = point(), to = point();
    rays.push_back(segments ? ray_between(i, from, to) : HostRay{.id = i, .position = from, .direction = to - from});
    rays.back().energy = 3;
  }
  return rays;
}

Light make_light(std::mt19937& random, const Dims& dims) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const double most = std::max({dims[0], dims[1], dims[2]});
  const auto place = [&](std::size_t axis) { return dims[axis] / 2.0 + within(-0.8, 0.8) * most; };
  const Vec3 at{place(0), place(1), place(2)};
  switch (std::uniform_int_distribution(0, 3)(random)) {
    case 0: return PointLight{at, 1};
    case 1: return DirectionalLight{{within(-1, 1), within(-1, 1), 1.1}, 1 / most};
    case 2: return RectangleLight{at, {5, 1, 0}, {0, 1, 6}, 2};
    default: return SphereLight{at, 3, 1};
  }
}

Material make_material(std::mt19937& random) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  constexpr std::array kBsdfs{Bsdf::kNone,           Bsdf::kIsotropic, Bsdf::kDiffuse,
                              Bsdf::kDullScattering, Bsdf::kSpecular,  Bsdf::kTrap};
  Material out;
  out.bsdf = kBsdfs[std::uniform_int_distribution<std::size_t>(0, kBsdfs.size() - 1)(random)];
  out.scattering = out.bsdf == Bsdf::kNone ? 0 : within(0.2, 0.95);
  out.gloss = out.bsdf == Bsdf::kDullScattering ? 0.4 : 0;
  out.seen_through_scattering = std::bernoulli_distribution(0.6)(random);
  if (out.bsdf != Bsdf::kTrap) return out;
  const bool surface = std::bernoulli_distribution(0.5)(random);
  out.routine = surface ? kFresnelRoutine : kHenyeyGreensteinRoutine;
  out.surface = surface;
  out.parameters = {surface ? 1.4F : 0.6F};
  return out;
}

Illumination make_illumination(std::mt19937& random, std::uint32_t seed) {
  const auto flip = [&] { return std::bernoulli_distribution(0.5)(random); };
  Illumination settings;
  settings.albedo = flip() ? Albedo::kHigh : Albedo::kLow;
  settings.rules = flip() || flip() ? EnergyRules::kConserving : EnergyRules::kAsPrinted;
  settings.step = flip() ? 0.5 : 1.7;
  settings.jitter = flip();
  settings.leap = flip() || flip();
  settings.seed = seed;
  return settings;
}

void expect_same_accounts(const LightingReport& got, const LightingReport& expected) {
  EXPECT_EQ(got.rays, expected.rays);
  EXPECT_EQ(got.emitted, expected.emitted);
  EXPECT_EQ(got.deposited, expected.deposited);
  EXPECT_EQ(got.escaped, expected.escaped);
  EXPECT_EQ(got.escaped_by_face, expected.escaped_by_face);
  EXPECT_EQ(got.scattered_away, expected.scattered_away);
  EXPECT_EQ(got.given_up, expected.given_up);
  EXPECT_EQ(got.clipped, expected.clipped);
  EXPECT_EQ(got.unit, expected.unit);
  EXPECT_EQ(got.warnings, expected.warnings);
  const auto units = [&](double energy) { return std::llround(energy / got.unit); };
  EXPECT_EQ(units(got.emitted),
            units(got.deposited) + units(got.escaped) + units(got.scattered_away) + units(got.clipped));
}

}  // namespace gicube::reference
