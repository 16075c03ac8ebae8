// Materials that trap: on the board's routines, on a user's of the board's start, and on the application's.
#include "test.h"
#include "test_board.h"
#include "voxels.h"

namespace gicube {
namespace {

constexpr int kSize = 40;

// A ball with a soft edge, 0 outside and 255 inside; radius 10 about the middle, where its value is 128.
std::vector<std::byte> ball() {
  std::vector<std::byte> voxels;
  constexpr double kMiddle = (kSize - 1) / 2.0;
  for_each_voxel({kSize, kSize, kSize}, [&](int x, int y, int z) {
    const double radius = length(Vec3{x - kMiddle, y - kMiddle, z - kMiddle});
    voxels.push_back(static_cast<std::byte>(std::lround(std::clamp(128 + 100 * (10 - radius), 0.0, 255.0))));
  });
  return voxels;
}

// The ball's skin alone is seen, so that a ray meets it on its way in and again on its way out.
TransferFunction skin() {
  return {.colours = {{0, {0.8, 0.9, 1}}}, .opacities = {{40, 0}, {40, 1}, {215, 1}, {215, 0}}};
}
// All of the ball, thin.
TransferFunction fog(double opacity) {
  return {.colours = {{0, {1, 0.7, 0.4}}}, .opacities = {{100, 0}, {100, opacity}}};
}

Material trap(int routine, std::vector<float> parameters = {}, bool surface = false) {
  return {.scattering = 1,
          .bsdf = Bsdf::kTrap,
          .seen_through_scattering = true,
          .routine = routine,
          .surface = surface,
          .parameters = std::move(parameters)};
}

// The same physics as the board's routine 1, in the application.
ScatterAnswer henyey_greenstein(const ScatterEvent& event) {
  const double g = event.parameters[0], chance = event.random[0];
  const double root = (1 - g * g) / (1 - g + 2 * g * chance);
  const double cosine = std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
  const Vec3 d = event.direction;
  const double sign = std::copysign(1.0, d.z), a = -1 / (sign + d.z), b = d.x * d.y * a;
  const Vec3 u{1 + sign * d.x * d.x * a, sign * b, -sign * d.x}, v{b, sign + d.y * d.y * a, -d.y};
  const double sine = std::sqrt(std::fmax(0.0, 1 - cosine * cosine)), angle = 2 * std::numbers::pi * event.random[1];
  const auto along = [&](double Vec3::*axis) {
    return cosine * d.*axis + sine * (std::cos(angle) * u.*axis + std::sin(angle) * v.*axis);
  };
  return {{along(&Vec3::x), along(&Vec3::y), along(&Vec3::z)}};
}

ScatterAnswer back(const ScatterEvent& event) { return {-1.0 * event.direction}; }

class Scattering : public ::testing::Test {
 protected:
  void SetUp() override { load({1, 1, 1}); }

  void load(Vec3 spacing) {
    board_.load_volume(
        {.samples = voxels_, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}, .spacing = spacing});
    board_.set_transfer_function(fog(0.2));
  }

  LightingReport light(Albedo albedo = Albedo::kLow) {
    const std::vector<Light> lights{PointLight{{8, 12, 5}}, DirectionalLight{{0, 1, -1}}};
    Illumination settings;
    settings.albedo = albedo;
    settings.rays_per_face_voxel = 2;
    settings.seed = 5;
    return board_.illuminate(lights, settings);
  }

  View view() {
    View view = front_view(kSize);
    view.width = view.height = 40;
    view.scatter = true;
    view.seed = 9;
    return view;
  }

  std::vector<std::byte> voxels_ = ball();
  Board board_ = Board::open(kSmallBlocks);
};

void expect_exact(const LightingReport& report) {
  const double all = report.deposited + report.escaped + report.scattered_away + report.clipped;
  EXPECT_NEAR(report.emitted / report.unit, all / report.unit, 1e-3) << "in whole units";
}

TEST_F(Scattering, ByTheApplicationGivesTheBitsOfTheBoardsOwnRoutine) {
  for (const Vec3 spacing : {Vec3{1, 1, 1}, Vec3{1, 1.5, 2}}) {
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      SCOPED_TRACE(testing::Message() << "spacing " << spacing.z << ", albedo " << static_cast<int>(albedo));
      load(spacing);
      board_.set_scattering_routine(henyey_greenstein);
      board_.set_material(trap(kHenyeyGreensteinRoutine, {0.6f}));
      const LightingReport by_board = light(albedo);
      const std::vector<float> expected = board_.read_irradiance();
      View gathering = view();
      gathering.irradiance = true;
      gathering.high_albedo = albedo == Albedo::kHigh;
      const Image picture = board_.render(gathering);

      board_.set_material(trap(kHostRoutine, {0.6f}));
      const Counters before = board_.counters();
      const LightingReport by_host = light(albedo);
      EXPECT_EQ(board_.read_irradiance(), expected);
      EXPECT_EQ(by_host.rays, by_board.rays);
      for (double LightingReport::*const part : {&LightingReport::emitted, &LightingReport::deposited,
                                                 &LightingReport::escaped, &LightingReport::scattered_away}) {
        EXPECT_EQ(std::llround(by_host.*part / by_host.unit), std::llround(by_board.*part / by_board.unit));
      }
      expect_exact(by_host);
      EXPECT_EQ(board_.render(gathering), picture);
      EXPECT_GT((board_.counters() - before).value("dsp.host_traps"), 1000u);
    }
  }
}

TEST_F(Scattering, ByTheApplicationGivesTheSameBitsAtCycleLevel) {
  const auto run = [this](const std::string& options) {
    board_ = Board::open(kSmallBlocks + options);
    load({1, 1.5, 1});
    board_.set_scattering_routine(henyey_greenstein);
    board_.set_material(trap(kHostRoutine, {0.5f}));
    const LightingReport report = light();
    expect_exact(report);
    View gathering = view();
    gathering.irradiance = true;
    const Image picture = board_.render(gathering);
    EXPECT_GT(board_.counters().value("dsp.host_traps"), 1000u);
    return std::tuple(board_.read_irradiance(), picture, std::llround(report.deposited / report.unit),
                      std::llround(report.escaped / report.unit), report.rays);
  };
  const auto expected = run("");
  EXPECT_EQ(run("&fidelity=cycle"), expected);
  EXPECT_EQ(run("&fidelity=cycle&set=asic.processors=2&set=asic.queue_rays=16"), expected);
}

TEST_F(Scattering, ByTheApplicationPaysForTheBusAndForItsOwnWork) {
  board_.set_material(trap(kHostRoutine));
  board_.set_scattering_routine(back);
  board_.render_to_framebuffer(view());  // the tables are there
  const Counters before = board_.counters();
  const Picoseconds begin = board_.now();
  board_.render_to_framebuffer(view());
  const Picoseconds quick = board_.now() - begin;
  const Counters window = board_.counters() - before;
  const std::uint64_t traps = window.value("dsp.host_traps");
  ASSERT_GT(traps, 100u);
  EXPECT_GE(window.value("bus.up.bytes"), 64 * traps);
  EXPECT_GE(window.value("bus.down.bytes"), 32 * traps);
  EXPECT_LT(window.value("bus.rays.bytes"), 98 * traps);

  constexpr Picoseconds kWork = 2'000'000;
  board_.set_scattering_routine(back, kWork);
  const Picoseconds again = board_.now();
  board_.render_to_framebuffer(view());
  EXPECT_EQ(board_.now() - again, quick + traps * kWork);
}

TEST_F(Scattering, TellsTheApplicationWhereItsRaysAre) {
  board_.set_transfer_function(skin());
  board_.set_material(trap(kHostRoutine, {3, 4}, true));
  const Vec3 middle{(kSize - 1) / 2.0, (kSize - 1) / 2.0, (kSize - 1) / 2.0};
  int events = 0;
  board_.set_scattering_routine([&](const ScatterEvent& event) {
    ++events;
    const Vec3 out = event.position - middle;
    EXPECT_NEAR(length(out), 10, 1.2);
    if (length(event.normal) > 0.5) {
      EXPECT_GT(dot(event.normal, normalise(out)), 0.9);
    }
    EXPECT_NEAR(length(event.direction), 1, 1e-3);
    EXPECT_THAT(event.parameters, ElementsAre(3, 4));
    EXPECT_FALSE(event.lighting);
    EXPECT_EQ(event.tag, 0);
    EXPECT_GT(event.opacity, 0.9);
    for (const double number : event.random) EXPECT_TRUE(number >= 0 && number < 1);
    return ScatterAnswer{event.direction};
  });
  board_.render(view());
  EXPECT_GT(events, 200);
}

TEST_F(Scattering, CountsWhatTheApplicationDropsAsScatteredAway) {
  board_.set_material(trap(kHostRoutine));
  board_.set_scattering_routine([](const ScatterEvent& event) { return ScatterAnswer{event.direction, 0.5}; });
  const LightingReport half = light();
  expect_exact(half);
  EXPECT_GT(half.scattered_away, 0);
  board_.set_scattering_routine([](const ScatterEvent& event) { return ScatterAnswer{event.direction, 0}; });
  const LightingReport none = light();
  expect_exact(none);
  EXPECT_GT(none.scattered_away, half.scattered_away);
}

TEST_F(Scattering, BouncesNoRayForEver) {
  board_.set_transfer_function(fog(0.95));
  board_.set_material(trap(kHostRoutine));
  int calls = 0;
  board_.set_scattering_routine([&](const ScatterEvent& event) { return ++calls, back(event); });
  const LightingReport report = light(Albedo::kHigh);
  expect_exact(report);
  EXPECT_GT(report.given_up, 0);
  EXPECT_LE(static_cast<std::uint64_t>(calls), 32 * report.rays);
}

TEST_F(Scattering, WithoutARoutineOfTheApplicationIsRejectedBeforeAnythingIsSent) {
  board_.set_material(trap(kHostRoutine));
  EXPECT_THROWS(Rejected, "set_scattering_routine", light());
  EXPECT_THROWS(Rejected, "tag 0", board_.render(view()));
  View still = view();
  still.scatter = false;
  EXPECT_NO_THROW(board_.render(still));
}

TEST_F(Scattering, OutlivesAnApplicationThatThrows) {
  board_.set_material(trap(kHostRoutine));
  board_.set_scattering_routine(back);
  const Image good = board_.render(view());
  int left = 50;
  board_.set_scattering_routine([&](const ScatterEvent& event) {
    if (--left == 0) throw std::runtime_error("no more");
    return back(event);
  });
  EXPECT_THAT([&] { board_.render(view()); }, ThrowsMessage<std::runtime_error>("no more"));
  EXPECT_THROW(board_.read_framebuffer(), Rejected) << "there is no whole picture";
  left = 100;
  EXPECT_THROW(light(), std::runtime_error);
  board_.set_scattering_routine(back);
  EXPECT_EQ(board_.render(view()), good);
  expect_exact(light());
}

TEST_F(Scattering, RefusesWhatNoRayCanDo) {
  board_.set_material(trap(kHostRoutine));
  const auto answer_with = [&](ScatterAnswer answer) {
    board_.set_scattering_routine([answer](const ScatterEvent&) { return answer; });
    return [this] { board_.render(view()); };
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(answer_with({{0, 0, 0}}), ThrowsMessage<ScatteringFailed>(HasSubstr("direction")));
  EXPECT_THAT(answer_with({{kNan, 0, 1}}), ThrowsMessage<ScatteringFailed>(HasSubstr("nan")));
  EXPECT_THAT(answer_with({{0, 0, 1}, 1.5}), ThrowsMessage<ScatteringFailed>(HasSubstr("1.5")));
  board_.set_scattering_routine([this](const ScatterEvent& event) {
    EXPECT_GT(board_.now(), 0u);
    EXPECT_THROW(board_.counters(), Error) << "the board is not the callback's to use";
    return back(event);
  });
  board_.render(view());
}

TEST_F(Scattering, HostRaysAreNotTheApplicationsToScatter) {
  board_.set_material(trap(kHostRoutine));
  board_.set_scattering_routine(back);
  const std::vector<HostRay> rays{{.id = 1, .position = {1, 2, 3}, .direction = {1, 1, 1}}};
  const Ticket ticket = board_.submit(rays, {.sampling = sampling_of(view())});
  EXPECT_THROWS(Rejected, "routine 255", board_.receive(ticket));
}

TEST_F(Scattering, NamesARoutineThatTheBoardDoesNotHave) {
  board_.set_material(trap(kFirstUserRoutine));
  EXPECT_THROWS(Rejected, "got 8", light());
  board_.set_material(trap(kHenyeyGreensteinRoutine, {1}));
  EXPECT_THROWS(Rejected, "henyey_greenstein", light());
}

TEST(UserRoutine, IsGivenToTheBoardThatTheApplicationStarts) {
  Board board = Board::open(std::string(kSmallBlocks) + "&bsdf=" GICUBE_BIN_DIR "/brushed_metal.so");
  const std::vector<std::byte> voxels = ball();
  board.load_volume({.samples = voxels, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}});
  board.set_transfer_function(skin());
  board.set_material(trap(kFirstUserRoutine, {0, 1, 0, 0.3f, 0.01f, 0.8f}, true));
  const std::vector<Light> lights{PointLight{{20, 20, 0}}};
  const LightingReport report = board.illuminate(lights, {});
  expect_exact(report);
  EXPECT_GT(report.scattered_away, 0);
  EXPECT_GT(board.counters().value("dsp.trap_cycles"), 320u);
  board.set_material(trap(kFirstUserRoutine, {1}, true));
  EXPECT_THROWS(Rejected, "brushed metal", board.illuminate(lights, {}));
  EXPECT_THROW(Board::open("emu:?bsdf=/no/such.so"), BadArgument);
}

// A glass ball of index n focuses a parallel beam at nR / (2 (n - 1)) behind its centre: for n = 1.5 and R = 10, 15
// voxels, near the screen that stands at 17.
TEST_F(Scattering, AGlassBallGathersLightBehindIt) {
  std::vector<std::uint8_t> tags(voxels_.size(), 0);
  const auto at = [](int x, int y, int z) { return static_cast<std::size_t>(x + kSize * (y + kSize * z)); };
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      for (int z = 36; z < kSize; ++z) {
        voxels_[at(x, y, z)] = std::byte{128};
        tags[at(x, y, z)] = 1;
      }
    }
  }
  const auto spot = [&](bool glass) {
    board_.load_volume({.samples = voxels_, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}, .tags = tags});
    board_.set_transfer_function(glass ? skin() : TransferFunction{{{0, {0, 0, 0}}}, {{0, 0}}}, 0);
    board_.set_transfer_function({{{0, {1, 1, 1}}}, {{0, 0}, {100, 0}, {100, 1}}}, 1);
    board_.set_material(trap(kFresnelRoutine, {1.5f}, true), 0);
    board_.set_material({}, 1);
    const std::vector<Light> lights{DirectionalLight{{0, 0, -1}}};
    Illumination settings;
    settings.rays_per_face_voxel = 16;
    expect_exact(board_.illuminate(lights, settings));
    const std::vector<float> light = board_.read_irradiance();
    double middle = 0, edge = 0;  // 4 x 4 voxels behind the centre, and 4 x 4 where a solid ball would throw its shadow
    for (int z = 34; z < kSize; ++z) {
      for (int y = 18; y < 22; ++y) {
        for (int x = 0; x < 4; ++x) {
          middle += light[at(18 + x, y, z)];
          edge += light[at(25 + x, y, z)];
        }
      }
    }
    return std::pair(middle, edge);
  };
  const auto [open_middle, open_edge] = spot(false);
  const auto [glass_middle, glass_edge] = spot(true);
  EXPECT_NEAR(open_middle, open_edge, 0.1 * open_middle);
  EXPECT_GT(glass_middle, 2.5 * open_middle) << "the focus";
  EXPECT_LT(glass_edge, 0.4 * open_edge) << "the shadow";
}

}  // namespace
}  // namespace gicube
