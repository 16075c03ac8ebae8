// Lamps in a mirror, held against geometry.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr int kSize = 48;
constexpr int kFloor = 10;         // the last layer of voxels that are solid
constexpr double kSurface = 10.5;  // where rays meet it, to within a quarter of a step: opaque from 100 on, 10.6
constexpr double kPi = std::numbers::pi;

// A floor across the whole volume.
std::vector<std::byte> floor_voxels() {
  std::vector<std::byte> voxels;
  for (int z = 0; z < kSize; ++z) {
    voxels.insert(voxels.end(), kSize * kSize, z <= kFloor ? std::byte{255} : std::byte{0});
  }
  return voxels;
}

// A white square, which shines to -y; as bright as `colour`.
Lamp square(Colour colour) { return {RectangleLight{{14, 70, 46}, {20, 0, 0}, {0, 0, 14}, 20 * 14}, colour}; }
Lamp ball(Colour colour) { return {SphereLight{{24, 70, 52}, 8, 4 * kPi * 8 * 8}, colour}; }

struct Line {
  Vec3 from, along;
};

// The flight of a pixel's ray after the mirror; nothing if it does not meet it.
std::optional<Line> mirrored(const View& view, int x, int y) {
  const Vec3 forward = normalise(view.look_at - view.eye), right = normalise(cross(forward, view.up));
  const Vec3 up = cross(right, forward);
  const double pixel = 2 * std::tan(view.fov_degrees * kPi / 360) / view.height;
  const Vec3 d =
      forward + ((x + 0.5 - view.width / 2.0) * pixel) * right + ((view.height / 2.0 - y - 0.5) * pixel) * up;
  const Vec3 met = view.eye + ((kSurface - view.eye.z) / d.z) * d;
  if (d.z >= 0 || met.x < 1 || met.x > kSize - 2 || met.y < 1 || met.y > kSize - 2) return std::nullopt;
  return Line{met, normalise({d.x, d.y, -d.z})};
}

// How far the line is within the shape's outline, in voxels; below 0: it passes.
double depth_in(const Line& line, const RectangleLight& square) {
  const double t = (square.corner.y - line.from.y) / line.along.y;
  if (t < 0) return -100;
  const Vec3 at = line.from + t * line.along - square.corner;
  return std::min({at.x, square.edge_u.x - at.x, at.z, square.edge_v.z - at.z});
}
double depth_in(const Line& line, const SphereLight& ball) {
  return ball.radius - length(cross(ball.centre - line.from, line.along));
}

class Lamps : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    board_.set_gradient_codebook(
        std::vector<Vec3>{{0, 0, 0}, {0, 0, -1}});  // the default one is off by up to 2 degrees
    load({1, 1, 1});
  }
  void load(Vec3 spacing) {
    board_.load_volume(
        {.samples = voxels_, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}, .spacing = spacing});
    board_.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {100, 1}}});
    board_.set_material({.scattering = 1, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true});
  }

  View view() const {
    View view;
    view.eye = {24, -20, 50};
    view.look_at = {24, 24, 10};
    view.up = {0, 0, 1};
    view.width = view.height = 64;
    view.shade = false;
    view.scatter = true;
    return view;
  }

  // Every pixel has the lamp's colour or nothing, as geometry says, but for those whose ray passes close to the
  // outline.
  template <typename Shape>
  void expect_where_geometry_says(const Image& image, const View& view, const Lamp& lamp) {
    constexpr double kNear =
        1;  // voxels: the ray's start is off by a half, across and along, and its direction by 2^-14
    int within = 0, without = 0, near = 0;
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        const auto line = mirrored(view, x, y);
        if (!line) continue;
        const double depth = depth_in(*line, std::get<Shape>(lamp.light));
        const Pixel pixel = image.at(x, y);
        if (std::abs(depth) < kNear) {
          ++near;
        } else if (depth > 0) {
          ++within;
          const auto byte = [&lamp](std::size_t c) { return std::min(255 * lamp.colour[c], 255.0); };
          ASSERT_EQ(pixel.alpha, 4095) << x << ' ' << y;
          ASSERT_NEAR(pixel.red, byte(0), 0.6);
          ASSERT_NEAR(pixel.green, byte(1), 0.6);
          ASSERT_NEAR(pixel.blue, byte(2), 0.6);
        } else {
          ++without;
          ASSERT_EQ(pixel, Pixel()) << x << ' ' << y << ": " << depth;
        }
      }
    }
    EXPECT_GT(within, 100);
    EXPECT_GT(without, 1000);
    EXPECT_LT(near, 200);
  }

  std::vector<std::byte> voxels_ = floor_voxels();
  Board board_ = Board::open(std::string(kSmallBlocks) + GetParam());
};

TEST_P(Lamps, AMirrorShowsARectangleWhereGeometrySays) {
  View view = this->view();
  view.lamps = {square({0.8, 0.4, 0.1})};
  expect_where_geometry_says<RectangleLight>(board_.render(view), view, view.lamps[0]);
}

TEST_P(Lamps, AMirrorShowsASphereWhereGeometrySaysAndNoBrighterThanWhite) {
  View view = this->view();
  view.lamps = {ball({0.25, 0.75, 30})};
  expect_where_geometry_says<SphereLight>(board_.render(view), view, view.lamps[0]);
}

TEST_P(Lamps, TheNearestOneIsSeenWhateverTheirOrder) {
  View view = this->view();
  view.lamps = {ball({1, 0, 0}), {RectangleLight{{4, 90, 40}, {40, 0, 0}, {0, 0, 40}, 1600}, {0, 1, 0}}};
  const Image image = board_.render(view);
  std::swap(view.lamps[0], view.lamps[1]);
  EXPECT_EQ(board_.render(view), image);
  const auto shows = [&image](auto colour) {
    return std::ranges::count_if(image.pixels, [&](const Pixel& pixel) { return pixel.*colour == 255; });
  };
  View alone = view;
  alone.lamps = {ball({1, 0, 0})};
  const Image of_ball = board_.render(alone);
  EXPECT_EQ(shows(&Pixel::red), std::ranges::count_if(of_ball.pixels, [](const Pixel& p) { return p.red == 255; }));
  EXPECT_GT(shows(&Pixel::green), 100);
}

TEST_P(Lamps, ARectangleIsNotSeenFromBehindNorIsASphereFromInside) {
  View view = this->view();
  view.lamps = {{RectangleLight{{14, 70, 46}, {0, 0, 14}, {20, 0, 0}, 280}, {1, 1, 1}},
                {SphereLight{{24, 24, 24}, 300, 1e6}, {1, 1, 1}}};
  for (const Pixel& pixel : board_.render(view).pixels) ASSERT_EQ(pixel, Pixel());
}

TEST_P(Lamps, RaysStraightFromTheEyeSeeNone) {
  View view = this->view();
  view.eye = {24, -20, 30};
  view.look_at = {24, 24, 30};  // over the floor, at a lamp as large as the image
  view.fov_degrees = 20;
  view.lamps = {{RectangleLight{{-50, 70, 20}, {150, 0, 0}, {0, 0, 60}, 9000}, {1, 1, 1}}};
  for (const Pixel& pixel : board_.render(view).pixels) ASSERT_EQ(pixel, Pixel());
}

// The lamp lies at the same place in physical lengths.
TEST_P(Lamps, AreWhereTheyAreInVolumesOfAnySpacing) {
  View view = this->view();
  view.lamps = {square({0.8, 0.4, 0.1})};
  load({2, 1, 1});
  View wide = view;
  wide.eye.x = wide.look_at.x = 12;
  wide.lamps[0] = {RectangleLight{{7, 70, 46}, {20, 0, 0}, {0, 0, 14}, 280}, {0.8, 0.4, 0.1}};
  expect_where_geometry_says<RectangleLight>(board_.render(wide), view, view.lamps[0]);
}

// Half of the mirror's light is its own colour, black; the rest is what it lets through.
TEST_P(Lamps, CountByWhatTheRayStillLetsThrough) {
  board_.set_material({.scattering = 0.5, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true});
  board_.set_transfer_function({.colours = {{0, {0, 0, 0}}}, .opacities = {{100, 0}, {100, 1}}});
  View view = this->view();
  view.lamps = {square({1, 0.5, 0})};
  const Image image = board_.render(view);
  int seen = 0;
  for (const Pixel& pixel : image.pixels) {
    if (pixel.red == 0) continue;
    ++seen;
    ASSERT_NEAR(pixel.red, 127.5, 1);
    ASSERT_NEAR(pixel.green, 63.75, 1);
    ASSERT_EQ(pixel.alpha, 4095);
  }
  EXPECT_GT(seen, 150);
}

// The share of directions (R + gloss d) / |R + gloss d| that meet the ball, d even over the sphere.
TEST_P(Lamps, GlossShowsAHighlightWhoseMeanIsThatOfItsLobe) {
  constexpr double kGloss = 0.4;
  board_.set_material(
      {.scattering = 1, .bsdf = Bsdf::kDullReflection, .gloss = kGloss, .seen_through_scattering = true});
  View view = this->view();
  view.samples_per_axis = 4;
  view.lamps = {ball({0.5, 0.5, 0.5})};
  const Image image = board_.render(view);
  constexpr int kDirections = 2000;
  double expected = 0, variance = 0, got = 0;
  int pixels = 0;
  std::vector<double> highlight, beside;
  for (int y = 0; y < view.height; y += 2) {
    for (int x = 0; x < view.width; x += 2) {
      const auto line = mirrored(view, x, y);
      if (!line) continue;
      int hits = 0;
      for (int i = 0; i < kDirections; ++i) {
        const double z = 1 - (2 * i + 1.0) / kDirections, angle = 2 * kPi * std::fmod(i / std::numbers::phi, 1.0);
        const double radius = std::sqrt(1 - z * z);
        const Vec3 d{radius * std::cos(angle), radius * std::sin(angle), z};
        Vec3 out = normalise(line->along + kGloss * d);
        out.z = std::abs(out.z);
        hits += depth_in(Line{line->from, out}, std::get<SphereLight>(view.lamps[0].light)) > 0 ? 1 : 0;
      }
      const double share = 1.0 * hits / kDirections, seen = image.at(x, y).alpha / 4095.0;
      EXPECT_NEAR(image.at(x, y).red, 127.5 * seen, 1);
      expected += share;
      variance += share * (1 - share) / 16;
      got += seen;
      ++pixels;
      const double depth = depth_in(*line, std::get<SphereLight>(view.lamps[0].light));
      if (depth > 0) highlight.push_back(seen);
      if (depth < -20) beside.push_back(seen);
    }
  }
  ASSERT_GT(pixels, 500);
  EXPECT_GT(expected / pixels, 0.02);
  EXPECT_NEAR(got, expected, 4 * std::sqrt(variance) + 0.01 * expected);
  const auto mean = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  EXPECT_GT(mean(highlight), 2 * mean(beside));
}

// What a lamp outside shows is what the same ray had gathered before, and the lamp's light.
TEST_P(Lamps, TakeNothingFromPicturesInWhichNoRaySeesThem) {
  View view = this->view();
  const Image image = board_.render(view);
  view.lamps = {{SphereLight{{24, 24, -500}, 8, 1000}, {1, 1, 1}}};  // below the floor
  EXPECT_EQ(board_.render(view), image);
  view.scatter = false;
  const Image plain = board_.render(view);
  view.lamps.clear();
  EXPECT_EQ(board_.render(view), plain);
}

TEST_P(Lamps, AreSeenByRaysThatTheApplicationScatters) {
  View view = this->view();
  view.lamps = {square({0.8, 0.4, 0.1})};
  board_.set_scattering_routine([](const ScatterEvent& event) -> ScatterAnswer {
    const Vec3 d = event.direction;
    return {{d.x, d.y, std::abs(d.z)}};
  });
  board_.set_material({.scattering = 1,
                       .bsdf = Bsdf::kTrap,
                       .seen_through_scattering = true,
                       .routine = kHostRoutine,
                       .surface = true});
  expect_where_geometry_says<RectangleLight>(board_.render(view), view, view.lamps[0]);
}

INSTANTIATE_TEST_SUITE_P(Boards, Lamps, testing::Values("", "&set=asic.datapath=wide", "&set=fidelity=cycle"));

TEST(LampCheck, NamesWhatIsWrong) {
  Board board = Board::open(kSmallBlocks);
  const std::vector<std::byte> voxels = floor_voxels();
  board.load_volume({.samples = voxels, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}});
  View view = front_view(kSize);
  const auto refused = [&](const std::vector<Lamp>& lamps) {
    view.lamps = lamps;
    return [&] { board.render(view); };
  };
  EXPECT_THAT(refused({ball({1, 1, 1}), {PointLight{{1, 2, 3}}, {1, 1, 1}}}),
              ThrowsMessage<BadArgument>(HasSubstr("lamps[1].light: expected a RectangleLight or a SphereLight")));
  EXPECT_THAT(refused({{SphereLight{{1, 2, 3}, 0}, {1, 1, 1}}}),
              ThrowsMessage<BadArgument>(HasSubstr("lamps[0].light.radius")));
  EXPECT_THAT(refused({ball({1, -0.5, 1})}), ThrowsMessage<BadArgument>(HasSubstr("lamps[0].colour")));
  EXPECT_THAT(refused(std::vector<Lamp>(kMaxLamps + 1, ball({1, 1, 1}))),
              ThrowsMessage<BadArgument>(HasSubstr("lamps: expected at most 32, got 33")));
}

}  // namespace
}  // namespace gicube
