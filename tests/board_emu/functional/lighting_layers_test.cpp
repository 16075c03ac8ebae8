// Shares of a sun's light that come through layers and back from them, wherever their faces lie, against closed forms
// and a Monte Carlo method without voxels.
#include "lighting_rig.h"
#include "reference/photons.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::Albedo;
using wire::Bsdf;

// A layer of one medium between two places along z; its densities go through the medium's least one over `blur` voxels,
// as a scan's do, or from one voxel to the next.
struct Layer {
  double begin, end, blur;

  std::uint16_t density(int z) const {
    constexpr double kLeast = 2000, kInside = 4000;
    const double depth = std::min(z - begin, end - z);  // signed
    return static_cast<std::uint16_t>(std::lround(std::clamp(kLeast + depth * kInside / blur, 0.0, kInside)));
  }
};

// What of a sun's light along `towards` comes through and back from a layer of optical thickness `depth`, as shares.
struct LayerLight {
  static constexpr int kThick = 17;

  // The volume has faces of `wide` x `wide` voxels, `edge` apart. `depth`: of the whole layer, in or outside of the
  // volume.
  LayerLight(const Layer& layer, double depth, double albedo, double step, Albedo rays, int wide, double edge)
      : lit({wide, wide, kThick}, 16, true, {edge, edge, 1}) {
    lit.scene.fill([&](int, int, int z) { return wire::Voxel{.density = layer.density(z)}; });
    lit.medium(depth / (layer.end - layer.begin), albedo, albedo > 0 ? Bsdf::kIsotropic : Bsdf::kNone);
    for (std::size_t i = 0; i < 2000; ++i) lit.scene.segmentation[i].opacity = 0;
    lit.scene.frame.step = static_cast<std::uint32_t>(std::lround(step * wire::kStepOne));
    const double units = 1e6;  // of a ray
    const EnergyCounters energy = lit.light(sun(units / (edge * edge), {0, 0, -1}, 1, rays)).energy;
    std::tie(back, through, sideways) = shares_along_z(energy);
    photons = static_cast<double>(energy.emitted) / units;
  }

  LitScene lit;
  double back = 0, through = 0, sideways = 0, photons = 0;
};

TEST(LightingPass, PassesALayersShareWhereverItsFacesLieBetweenVoxels) {
  for (const double step : {0.4, 0.45, 0.5, 0.8}) {
    for (const Layer& layer :
         {Layer{-9, 7.5, 1}, {-9, 7.1, 4}, {-9, 9.83, 4}, {3.3, 30, 4}, {2.6, 11.2, 6}, {4.5, 6.5, 1}}) {
      for (const double depth : {0.3, 2.0}) {
        const double length = std::min(layer.end, 16.0) - std::max(layer.begin, 0.0);
        const LayerLight light(layer, depth * (layer.end - layer.begin) / length, 0, step, Albedo::kLow, 9, 1);
        EXPECT_NEAR(light.through / std::exp(-depth), 1, 0.003)
            << layer.begin << " to " << layer.end << ", step " << step << ", depth " << depth;
      }
    }
  }
}

TEST(LightingPass, ReflectsAndPassesAScatteringLayersSharesWhereverItsFacesLie) {
  constexpr std::array<Layer, 4> kLayers{{{-9, 7.5, 1}, {3.3, 30, 4}, {2.6, 11.2, 6}, {4.5, 12.5, 1}}};
  constexpr std::array<std::pair<double, double>, 6> kMedia{
      {{4, 0.95}, {0.3, 0.2}, {0.5, 0.99}, {1, 0.5}, {8, 0.99}, {6, 0.2}}};
  constexpr std::array kSteps{0.4, 0.45, 0.5, 0.8};
  std::size_t run = 0;
  for (const auto& [depth, albedo] : kMedia) {
    const reference::Fates expected = reference::slab(depth, albedo, 2'000'000, 1);
    for (const Albedo rays : {Albedo::kLow, Albedo::kHigh}) {
      const double step = kSteps[run % 4];
      const Layer& layer = kLayers[(run + run / 4) % 4];
      ++run;
      const double length = std::min(layer.end, 16.0) - std::max(layer.begin, 0.0);
      const LayerLight light(layer, depth * (layer.end - layer.begin) / length, albedo, step, rays, 257, 64);
      for (const auto& [share, right] : {std::pair{light.back, expected.back}, {light.through, expected.through}}) {
        const double error = std::hypot(std::sqrt(right.mean * (1 - right.mean) / light.photons), right.error);
        EXPECT_NEAR(share, right.mean, std::max(3 * error, 0.005 * right.mean))
            << layer.begin << " to " << layer.end << ", step " << step << ", depth " << depth << ", albedo " << albedo
            << (rays == Albedo::kLow ? ", weighted photons" : ", photons");
      }
      EXPECT_LT(light.sideways, 2e-3);
    }
  }
}

// Steps with which a sample may lie in each half of a voxel's edge, and with which some have none.
constexpr std::array kTagSteps{0.4, 0.5, 0.62, 0.7, 0.85, 1.0};

// What comes through media along z, the voxel at z having the tag of `tags` and a density by `layer`.
template <class Tags>
struct TaggedLight {
  TaggedLight(const Tags& tags, const std::function<std::uint16_t(int)>& density, double step, int thick, int wide = 9,
              double edge = 1)
      : lit({wide, wide, thick}, 16, true, {edge, edge, 1}), pixel(edge) {
    lit.scene.fill(
        [&](int, int, int z) { return wire::Voxel{.density = density(z), .tag = static_cast<std::uint8_t>(tags(z))}; });
    lit.scene.frame.step = static_cast<std::uint32_t>(std::lround(step * wire::kStepOne));
  }
  void light(Albedo rays = Albedo::kLow) {
    const double units = 1e6;  // of a ray
    const EnergyCounters energy = lit.light(sun(units / (pixel * pixel), {0, 0, -1}, 1, rays)).energy;
    std::tie(back, through, sideways) = shares_along_z(energy);
    photons = static_cast<double>(energy.emitted) / units;
  }

  LitScene lit;
  double pixel, back = 0, through = 0, sideways = 0, photons = 0;
};

TEST(LightingPass, PassesTheShareOfALayerThatEndsByTag) {
  for (const int thick : {11, 16, 17}) {
    for (const double step : kTagSteps) {
      for (const auto& [first, last] : {std::pair{0, 7}, {3, thick - 1}, {4, 6}, {5, 5}}) {
        for (const double depth : {0.3, 2.0}) {
          TaggedLight light([&](int z) { return z >= first && z <= last ? 1 : 0; }, [](int) { return 3000; }, step,
                            thick);
          const double length = std::min(last + 0.5, thick - 1.0) - std::max(first - 0.5, 0.0);
          light.lit.medium(depth / length, 0, Bsdf::kNone, 1);
          light.light();
          EXPECT_NEAR(light.through / std::exp(-depth), 1, 0.003)
              << first << " to " << last << " of " << thick << ", step " << step << ", depth " << depth;
        }
      }
    }
  }
}

// A layer's density goes through its least one at `layer`'s ends, wherever they lie; its tag changes within.
TEST(LightingPass, PassesTheShareOfALayerOfTwoTags) {
  for (const double step : kTagSteps) {
    for (const Layer& layer : {Layer{-9, 7.5, 1}, {3.3, 30, 4}, {2.6, 11.2, 6}, {4.5, 9.5, 1}}) {
      for (const int border : {5, 6, 8}) {  // the first voxel of the second tag
        TaggedLight light([&](int z) { return z < border ? 1 : 2; }, [&](int z) { return layer.density(z); }, step, 17);
        for (const auto& [tag, extinction] : {std::pair{1u, 0.3}, {2u, 0.05}}) {
          light.lit.medium(extinction, 0, Bsdf::kNone, tag);
          for (std::size_t i = 0; i < 2000; ++i) light.lit.scene.segmentation[tag << 12 | i].opacity = 0;
        }
        light.light();
        const double begin = std::max(layer.begin, 0.0), end = std::min(layer.end, 16.0), between = border - 0.5;
        const double depth =
            0.3 * std::max(std::min(end, between) - begin, 0.0) + 0.05 * std::max(end - std::max(begin, between), 0.0);
        EXPECT_NEAR(light.through / std::exp(-depth), 1, 0.003)
            << layer.begin << " to " << layer.end << ", step " << step << ", border " << border;
      }
    }
  }
}

TEST(LightingPass, ReflectsAndPassesTheSharesOfAScatteringLayerThatEndsByTag) {
  constexpr double kDepth = 3, kAlbedo = 0.9;
  const reference::Fates expected = reference::slab(kDepth, kAlbedo, 2'000'000, 1);
  for (const double step : {0.5, 0.62, 0.85}) {
    for (const Albedo rays : {Albedo::kLow, Albedo::kHigh}) {
      TaggedLight light([](int z) { return z >= 4 && z <= 10 ? 1 : 0; }, [](int) { return 3000; }, step, 17, 257, 64);
      light.lit.medium(kDepth / 7, kAlbedo, Bsdf::kIsotropic, 1);
      light.light(rays);
      for (const auto& [share, right] : {std::pair{light.back, expected.back}, {light.through, expected.through}}) {
        const double error = std::hypot(std::sqrt(right.mean * (1 - right.mean) / light.photons), right.error);
        EXPECT_NEAR(share, right.mean, std::max(3 * error, 0.005 * right.mean))
            << "step " << step << (rays == Albedo::kLow ? ", weighted photons" : ", photons");
      }
      EXPECT_LT(light.sideways, 2e-3);
    }
  }
}

}  // namespace
}  // namespace gicube::emu
