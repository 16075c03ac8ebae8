#include "compose/picture.h"

#include "../meshes/meshes.h"
#include "small_stage.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr Dims kDims{24, 24, 32};
constexpr Vec3 kEye{11.5, 11.5, -10};
const Colour kRed{1, 0, 0}, kBlue{0, 0, 1};

// A square at z that covers the whole picture.
PlacedSurface wall(double z, const Colour& colour, double opacity) {
  Mesh mesh = square(20, z);
  for (Vec3& p : mesh.points) p = p + Vec3{11.5, 11.5, 0};
  return {"wall", mesh, colour, opacity};
}

double transmittance(double opacity, double voxels) { return std::pow(1 - opacity, voxels); }

void expect_near(const Premultiplied& pixel, const Premultiplied& expected, double error) {
  EXPECT_NEAR(pixel.opacity, expected.opacity, error);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel.colour[c], expected.colour[c], error) << c;
}

// A perspective view of the buckyball, shaded.
Stage buckyball() {
  Composition composition;
  PlacedVolume& ball = composition.volumes.emplace_back();
  ball.name = "ball";
  ball.scene.volume.builtin = "buckyball";
  ball.scene.volume.size = 32;
  composition.view.width = 40, composition.view.height = 30;
  composition.view.opacity_threshold = 0.98;
  return set_up(composition);
}

TEST(ComposedPicture, WithoutASurfaceIsThatOfWholeSegments) {
  const Stage stage = buckyball();
  std::vector<Board> boards = open_boards();
  std::vector<MediumCost> costs;
  const Picture picture = compose(stage, boards, costs);
  // The board still has the volume and the light.
  const StageMedium& ball = stage.media[0];
  const RayRequest request{.type = RayType::kSegment,
                           .opacity = 0.98,
                           .sampling = {.shade = ball.setup.view.shade,
                                        .looking = ball.to_voxels.vector(stage.view.look_at - stage.view.eye)}};
  int met = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const EyeRay eye = eye_ray(stage.view, x + 0.5, y + 0.5);
      const auto part = clip_to_volume({.id = 0,
                                        .position = ball.to_voxels.point(eye.origin),
                                        .direction = ball.to_voxels.vector(eye.direction),
                                        .length = 1e6},
                                       ball.setup.volume.dims);
      const Premultiplied& pixel = picture.pixels[static_cast<std::size_t>(y * picture.width + x)];
      if (!part) {
        EXPECT_EQ(pixel, Premultiplied{});
        continue;
      }
      const TracedRay ray = boards[0].receive(boards[0].submit(std::vector{*part}, request)).rays[0];
      // Its length in the other's arithmetic may be the next word.
      ASSERT_NEAR(pixel.opacity, ray.opacity, 2e-3) << x << " " << y;
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(pixel.colour[c], ray.colour[c], 2e-3) << x << " " << y;
      met += ray.opacity > 0.5 ? 1 : 0;
    }
  }
  EXPECT_GT(met, 100);
}

TEST(ComposedPicture, LooksAsTheBoardsOwn) {
  const Stage stage = buckyball();
  std::vector<Board> boards = open_boards();
  std::vector<MediumCost> costs;
  const Image picture = compose(stage, boards, costs).image();
  View view = stage.view;
  view.eye = stage.media[0].to_voxels.point(view.eye);
  view.look_at = stage.media[0].to_voxels.point(view.look_at);
  const Image own = boards[0].render(view);
  double off = 0, light = 0;
  for (std::size_t i = 0; i < own.pixels.size(); ++i) {
    off += std::abs(picture.pixels[i].red - own.pixels[i].red);
    light += own.pixels[i].red;
  }
  // Samples lie elsewhere, so surfaces differ by parts of a step.
  EXPECT_LT(off, 0.04 * light);
  EXPECT_GT(light, 0);
}

TEST(ComposedPicture, EndsAtAnOpaqueSurface) {
  for (const char* datapath : {"", kWide}) {
    const Stage stage = stage_of({fog(kDims, kRed, 0.03)}, {wall(10.25, kBlue, 1)}, kEye, 6, 4);
    const double through = transmittance(0.03, 10.25);
    for (const Premultiplied& pixel : picture_of(stage, datapath).pixels) {
      expect_near(pixel, {{1 - through, 0, through}, 1}, *datapath == 0 ? 0.003 : 1e-4);
    }
  }
}

TEST(ComposedPicture, PutsSurfacesInFrontOfBehindAndIntoAVolume) {
  const Stage stage = stage_of({fog(kDims, kRed, 0.03)},
                               {wall(40, {1, 1, 1}, 1), wall(-2, kBlue, 0.25), wall(12, kBlue, 0.5)}, kEye, 3, 3);
  const double first = transmittance(0.03, 12), second = transmittance(0.03, 19);
  Premultiplied expected{{0, 0, 0.25}, 0.25};
  expected = over(expected, {{1 - first, 0, 0}, 1 - first});
  expected = over(expected, {{0, 0, 0.5}, 0.5});
  expected = over(expected, {{1 - second, 0, 0}, 1 - second});
  expected = over(expected, {{1, 1, 1}, 1});
  for (const Premultiplied& pixel : picture_of(stage, kWide).pixels) expect_near(pixel, expected, 2e-4);
}

TEST(ComposedPicture, OrdersIntersectingSurfacesByThePixel) {
  // Two planes that cross at x = 11.5, and fog.
  const auto slope = [](double by, const Colour& colour) {
    Mesh mesh = square(30, 0);
    for (Vec3& p : mesh.points) p = {p.x + 11.5, p.y + 11.5, 15 + by * p.x};
    return PlacedSurface{"slope", mesh, colour, 0.5};
  };
  const Stage stage = stage_of({fog(kDims, {0, 1, 0}, 0.02)}, {slope(0.5, kRed), slope(-0.5, kBlue)}, kEye, 16, 2);
  const Picture picture = picture_of(stage, kWide);
  // +z is forward and y up, so x goes to the left.
  for (int x = 0; x < 16; ++x) {
    const double aside = -(x + 0.5 - 8), near = 15 - std::abs(aside) / 2, far = 15 + std::abs(aside) / 2;
    const auto green = [](double voxels) {
      const double opacity = 1 - transmittance(0.02, voxels);
      return Premultiplied{{0, opacity, 0}, opacity};
    };
    const Premultiplied red{{0.5, 0, 0}, 0.5}, blue{{0, 0, 0.5}, 0.5};
    Premultiplied expected = over(green(near), aside < 0 ? red : blue);
    expected = over(over(expected, green(far - near)), aside < 0 ? blue : red);
    expect_near(picture.pixels[static_cast<std::size_t>(x)], over(expected, green(31 - far)), 2e-4);
  }
}

TEST(ComposedPicture, OfOverlappingFogsIsTheClosedForm) {
  // The second is turned and twice as large, and its opacities stay those of its voxels.
  StageMedium turned = fog({40, 40, 40}, kBlue, 0.04);
  turned.to_voxels = inverse(compose(compose(translation({11.5, 11.5, 16}), rotation({0, 0, 1}, 30)),
                                     compose(scaling({0.5, 0.5, 0.5}), translation({-19.5, -19.5, -19.5}))));
  Stage stage = stage_of({fog(kDims, kRed, 0.03), turned}, {}, kEye, 3, 3);
  stage.overlap_step = 3;
  // Along z: red 0..31, blue 16 - 9.75..16 + 9.75, two voxels a unit.
  const double alone = transmittance(0.03, 6.25), behind = transmittance(0.03, 31 - 25.75);
  const double red = -19.5 * std::log1p(-0.03), blue = -39 * std::log1p(-0.04), both = std::exp(-red - blue);
  Premultiplied expected{{1 - alone, 0, 0}, 1 - alone};
  expected = over(expected, {{(1 - both) * red / (red + blue), 0, (1 - both) * blue / (red + blue)}, 1 - both});
  expected = over(expected, {{1 - behind, 0, 0}, 1 - behind});
  for (const Premultiplied& pixel : picture_of(stage, kWide).pixels) expect_near(pixel, expected, 3e-4);
  std::swap(stage.media[0], stage.media[1]);
  for (const Premultiplied& pixel : picture_of(stage, kWide).pixels) expect_near(pixel, expected, 3e-4);
}

TEST(ComposedPicture, IsTheSameOnSeveralBoardsAndAtAllLevels) {
  StageMedium second = fog({20, 20, 20}, kBlue, 0.05);
  second.to_voxels = translation({-3, -1, -8});
  const Stage stage = stage_of({fog(kDims, kRed, 0.03), second}, {wall(14, {0, 1, 0}, 0.5)}, kEye, 8, 8);
  std::vector<MediumCost> costs;
  std::vector<Board> one = open_boards("&fidelity=functional"), two = open_boards("&fidelity=cycle", 2);
  const Picture picture = compose(stage, one, costs);
  EXPECT_EQ(costs[1].board, 0u);
  EXPECT_EQ(compose(stage, two, costs).pixels, picture.pixels);
  EXPECT_EQ(costs[1].board, 1u);
}

TEST(ComposedPicture, IsChargedForLoadsAndRays) {
  const Stage stage = stage_of({fog(kDims, kRed, 0.03), fog(kDims, kBlue, 0.03)}, {}, kEye, 16, 16);
  std::vector<Board> boards = open_boards();
  std::vector<MediumCost> costs;
  const Picoseconds begin = boards[0].now();
  compose(stage, boards, costs);
  Picoseconds all = 0;
  for (const MediumCost& cost : costs) {
    // 4.5 bytes a voxel on a bus of 132 MB/s at most, and 31 pieces of 32 bytes for each of 256 rays down and up.
    EXPECT_GT(cost.load, 4.5 * 24 * 24 * 32 / 132e6 * 1e12);
    EXPECT_EQ(cost.rays, 256u);
    EXPECT_EQ(cost.segments, 256u * 31u);
    EXPECT_GT(cost.trace, 2 * 32 * 256 * 31 / 132e6 * 1e12);
    all += cost.load + cost.trace;
  }
  EXPECT_EQ(boards[0].now() - begin, all);
}

TEST(ComposedPicture, AveragesTheRaysOfAPixel) {
  Stage stage = stage_of({}, {wall(5, kRed, 1)}, kEye, 4, 2);
  // Its edge at x = 11.75 cuts one column of pixels: of 16 rays each, those at 1/8 and 3/8 and so on from the left.
  std::vector<Mesh> half{square(20, 5)};
  for (Vec3& p : half[0].points) p = {p.x + 11.75 - 20, p.y, p.z};
  stage.meshes = std::make_shared<const MeshCaster>(std::move(half));
  stage.view.samples_per_axis = 4;
  const Picture picture = picture_of(stage);
  for (int y = 0; y < 2; ++y) {
    const double expected[] = {0, 0.25, 1, 1};
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(picture.pixels[static_cast<std::size_t>(4 * y + x)].opacity, expected[x]) << x;
    }
  }
}

TEST(ComposedPicture, SaysWhichVolumeIsWrong) {
  Composition composition;
  PlacedVolume& flat = composition.volumes.emplace_back();
  flat.name = "flat";
  flat.scene.volume.builtin = "buckyball";
  flat.scene.volume.size = 16;
  flat.to_space = scaling({1, 1e-200, 1e-200});
  EXPECT_THROWS(InputError, "flat: transform: expected one that keeps a volume", set_up(composition));
}

}  // namespace
}  // namespace gicube::samples
