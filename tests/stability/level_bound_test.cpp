// Level of detail: what rays of the board see of a coarser volume, against the bound that level_error() gives.
#include <cmath>
#include <random>
#include <vector>

#include "gicube/level_of_detail.h"
#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kSize = 32;
constexpr double kMax = 4095;  // values are densities

class StabilityOfLevelBounds : public testing::Test {
 protected:
  // A level's volume, and the bound of its distance from the full one.
  struct Level {
    LevelError bound;
    double integral = 0;  // largest difference of a ray's line integral, a voxel of its length
    double opacity = 0;   // largest difference of a ray's opacity
  };
  template <typename Field>
  Level level(const Field& field, int number) {
    std::vector<float> values;
    for (int i = 0; i < kSize * kSize * kSize; ++i)
      values.push_back(static_cast<float>(field(i % kSize, i / kSize % kSize, i / kSize / kSize)));
    const VolumeView fine{.samples = std::as_bytes(std::span(values)),
                          .type = SampleType::kFloat32,
                          .dims = {kSize, kSize, kSize},
                          .range = ValueRange{0, kMax}};
    const DerivedVolume coarse = coarser(fine, number);
    Level out{.bound = level_error(fine, coarse, std::span(&look_, 1))};
    const auto rays = random_rays();
    const auto on_fine = traced(fine, look_, rays, Placement{});
    const auto on_coarse = traced(coarse.view(), coarse.placement.look(look_, {0, kMax}), rays, coarse.placement);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double longer = rays[i].length;
      out.integral = std::max(out.integral, std::abs(on_fine[i].integral - on_coarse[i].integral) / longer);
      out.opacity = std::max(out.opacity, std::abs(on_fine[i].opacity - on_coarse[i].opacity));
    }
    return out;
  }

 private:
  // Well inside, so that coarse volumes hold them whole.
  static std::vector<HostRay> random_rays() {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> place(4, kSize - 5);
    std::vector<HostRay> rays;
    while (rays.size() < 300) {
      const Vec3 from{place(engine), place(engine), place(engine)}, to{place(engine), place(engine), place(engine)};
      if (length(to - from) > 8) rays.push_back(ray_between(static_cast<std::uint32_t>(rays.size()), from, to));
    }
    return rays;
  }
  // Rays of the original in a volume that stands for it; integrals in the original's voxels.
  std::vector<TracedRay> traced(const VolumeView& volume, const TransferFunction& look, std::vector<HostRay> rays,
                                const Placement& placement) {
    VolumeView view = volume;
    view.spacing = {1, 1, 1};
    board_.load_volume(view);
    board_.set_transfer_function(look);
    for (HostRay& ray : rays) {
      ray.position = (1 / placement.edge) * (ray.position - placement.low);
      ray.length /= placement.edge;
    }
    const double step = 0.25 / placement.edge;
    std::vector<TracedRay> all = board_.receive(board_.submit(rays, {.type = RayType::kIntegral, .step = step})).rays;
    const auto opacities = board_.receive(board_.submit(rays, {.type = RayType::kOpacity, .step = step})).rays;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].integral *= placement.edge;
      all[i].opacity = opacities[i].opacity;
    }
    return all;
  }

  Board board_ = Board::open(small_board());
  TransferFunction look_{{{0, {1, 1, 1}}}, {{0, 0}, {2500, 0}, {3000, 1}}};
};

TEST_F(StabilityOfLevelBounds, AThinSheetIsLostAndTheBoundSaysSo) {
  const Level sheet = level([](int x, int, int) { return x == 15 ? 4000 : 0; }, 1);
  EXPECT_EQ(sheet.opacity, 1);  // rays that met a wall meet none
  EXPECT_GT(sheet.integral, 30);
  EXPECT_EQ(sheet.bound.largest_opacity, 1);
  EXPECT_GE(sheet.bound.largest_density, 2000);
  EXPECT_LE(sheet.integral, sheet.bound.largest_density);
  record("density_bound_of_a_thin_sheet", sheet.bound.largest_density);
  record("opacity_lost_of_a_thin_sheet", sheet.opacity);
}

TEST_F(StabilityOfLevelBounds, OfAnyVolumeTheBoundHoldsAndOfASmoothOneItIsSmall) {
  const Level smooth = level([](int x, int y, int z) { return 20 * (x + y + z); }, 1);
  std::mt19937 engine(9);
  const Level noise = level([&](int, int, int) { return engine() % 4096; }, 2);
  for (const Level& each : {smooth, noise}) {
    // 12.3 bits of a sample are the board's own error.
    EXPECT_LE(each.integral, each.bound.largest_density + 1);
    EXPECT_LE(each.opacity, each.bound.largest_opacity + 1e-6);
  }
  EXPECT_LT(smooth.bound.largest_density, 35);
  EXPECT_LT(smooth.bound.largest_opacity, 0.1);
  EXPECT_GT(noise.integral, 100);
  record("density_bound_of_a_ramp", smooth.bound.largest_density);
  record("density_error_of_a_ramp", smooth.integral);
}

}  // namespace
}  // namespace gicube::stability
