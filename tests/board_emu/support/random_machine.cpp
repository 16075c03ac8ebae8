#include "random_machine.h"

#include <algorithm>
#include <numeric>

namespace gicube::emu {

void draw(Scene& scene, Dice& dice) {
  struct Ball {
    std::array<int, 3> centre;
    int radius;
    std::uint8_t tag;
  };
  const std::array<int, 3>& size = scene.volume.size();
  std::vector<Ball> balls;
  for (int i = dice.number(0, 4); i >= 0; --i) {
    balls.push_back({{dice.number(0, size[0]), dice.number(0, size[1]), dice.number(0, size[2])},
                     dice.number(2, 14),
                     static_cast<std::uint8_t>(dice.number(0, 3))});
  }
  scene.fill([&](int x, int y, int z) {
    wire::Voxel voxel;
    for (const Ball& ball : balls) {
      const int dx = x - ball.centre[0], dy = y - ball.centre[1], dz = z - ball.centre[2];
      const int inside = ball.radius * ball.radius - dx * dx - dy * dy - dz * dz;
      if (inside <= 0) continue;
      voxel.density = static_cast<std::uint16_t>(std::min(4095, voxel.density + 900 + inside * 20));
      voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31) % 2048);
      voxel.tag = ball.tag;
    }
    return voxel;
  });
  if (wire::has_colours(scene.volume.format()) && dice.chance(90)) {
    const int period = dice.number(1, 300);
    const auto byte = [period](int x) { return static_cast<std::uint8_t>(x % period * 37); };
    scene.paint([&](int x, int y, int z) { return std::array{byte(x + 3 * y), byte(y + 5 * z), byte(z + 7 * x)}; });
  }
  const int clear = dice.number(200, 1500), peak = dice.one_of({300, 6000, 65535});
  for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
    const int density = static_cast<int>(i & 4095);
    wire::SegmentationEntry& entry = scene.segmentation[i];
    entry.opacity = static_cast<std::uint16_t>(density < clear ? 0 : std::min(65535, peak * (density - clear) / 2048));
    entry.colour = {static_cast<std::uint16_t>(density), static_cast<std::uint16_t>(4095 - density / 2),
                    static_cast<std::uint16_t>(1000 * (i >> 12))};
    entry.ambient = 40;
    entry.knee = 128;
    entry.reflect = 128;
  }
  scene.frame.shade = dice.chance(70);
  scene.frame.jitter = dice.chance(40);
  scene.frame.skip_empty = dice.chance(60);
  scene.frame.step = static_cast<std::uint32_t>(dice.one_of({20'000, 32'768, 65'536, 150'000}));
  scene.frame.opacity_threshold = dice.one_of<std::uint32_t>({wire::kOpacityOne, wire::kOpacityOne / 2, 0});
  if (dice.chance(80)) scene.frame.opacity_threshold = wire::kOpacityOne / 16 * 15;
  if (dice.chance(25)) {
    scene.frame.cut_planes.push_back(
        {{wire::kVoxel, 0, dice.number(-5000, 5000)}, std::int64_t{dice.number(-4, 12)} << kPlaneFractionBits});
  }
  // A flag only promises that nothing is visible; a wrong one changes both levels alike.
  for (auto& flag : scene.frame.empty) flag = dice.chance(25) ? 1 : 0;
}

namespace {

// Any value but 0, which stands for none: what is added to the schema is drawn too.
const char* any_of(const google::protobuf::EnumDescriptor& values, Dice& dice) {
  return values.value(dice.number(1, values.value_count() - 1))->name().c_str();
}

}  // namespace

std::vector<std::string> draw_machine(Dice& dice, int block_voxels) {
  const auto set = [](const char* field, auto value) { return std::string(field) + '=' + std::to_string(value); };
  const auto name = [](const char* field, const char* value) { return std::string(field) + '=' + value; };
  const bool in_cells = dice.chance(30);
  const bool tags_of_voxels = dice.chance(15);  // direct mapped, and not written back
  return {
      set("asic.block_voxels", block_voxels),
      set("asic.max_volume_voxels", 128),  // so that one channel stores it in every voxel format
      set("asic.processors", dice.number(1, 16)),
      name("asic.voxel_format", in_cells ? "density" : any_of(*v1::VoxelFormat_descriptor(), dice)),
      set("asic.queue_rays", dice.one_of({1, 2, 3, 8, 40, 256})),
      name("asic.partition", dice.one_of({"simple_slab", "repeated_slab", "skewed_block"})),
      set("asic.skew_x", dice.number(0, 15)),
      set("asic.skew_y", dice.number(0, 15)),
      set("asic.skew_z", dice.number(0, 15)),
      name("sorter.policy", any_of(*v1::QueuePolicy_descriptor(), dice)),
      name("sorter.queues", dice.chance(15) ? "single" : "per_block"),
      set("pipeline.prefetch_stages", dice.one_of({1, 3, 16, 40})),
      set("pipeline.compute_stages", dice.one_of({1, 5, 16})),
      set("cache.ways", tags_of_voxels ? 1 : dice.one_of({1, 1, 2, 8})),
      name("cache.tags", tags_of_voxels ? "of_voxels" : "of_tiles"),
      set("cache.miss_packets", dice.one_of({in_cells ? 16 : 8, 32, 100})),
      name("cache.irradiance", in_cells ? "in_cells" : "with_voxels"),
      set("cache.ports", dice.number(1, 2)),
      name("cache.splat_rule", any_of(*v1::SplatRule_descriptor(), dice)),
      name("cache.write_policy",
           tags_of_voxels ? dice.one_of({"combining", "write_through"}) : any_of(*v1::WritePolicy_descriptor(), dice)),
      set("link.bits", dice.one_of({1, 8, 32, 256})),
      set("link.rays", dice.one_of({2, 4})),
      set("rdram.processors_per_rdram", dice.number(1, 2)),
      set("rdram.clock_khz", dice.one_of({100'000, 400'000, 533'000})),
      set("rdram.refresh_interval", dice.one_of({0, 100, 781})),
      set("dsp.overflow_rays", dice.one_of({1, 7, 300, 65'536})),
      set("sdram.clock_khz", dice.one_of({100'000, 200'000, 30'000})),
      set("sdram.t_rcd", dice.one_of({1, 2, 9})),
      set("ideal.dsp", dice.one_of({0, 0, 1})),
      set("dsp.run_rays", dice.one_of({0, 0, 4, 64})),
      set("dsp.run_error", dice.one_of({1, 1'024, 16'384})),
      set("ideal.memory", dice.chance(10) ? 1 : 0),
      set("ideal.queues", dice.chance(10) ? 1 : 0),
      set("ideal.sorter", dice.chance(10) ? 1 : 0),
      name("memory", any_of(*v1::MemoryStandard_descriptor(), dice)),
      set("ddr.processors_per_channel", dice.number(1, 2)),
      set("ddr.clock_khz", dice.one_of({100'000, 133'000, 400'000})),
      set("ddr.refresh_interval", dice.one_of({0, 100, 1562})),
      set("asic.irradiance_words", in_cells ? 1 : dice.one_of({1, 3})),
  };
}

wire::RenderCommand draw_view(const Scene& scene, Dice& dice) {
  wire::RenderCommand view = corner_view(scene.volume.size(), dice.number(5, 24));
  if (dice.chance(30)) {  // straight along an axis, where all rays of a row stay together
    const double extent = scene.volume.size()[1];
    view.projection = wire::Projection::kOrthographic;
    view.origin = {-5, -1, -1};
    view.forward = {1, 0, 0};
    view.du = {0, (extent + 2) / view.width, 0};
    view.dv = {0, 0, (extent + 2) / view.height};
  }
  view.samples_per_axis = dice.chance(20) ? 2 : 1;
  return view;
}

std::vector<wire::Lamp> draw_lamps(const Scene& scene, Dice& dice) {
  std::vector<wire::Lamp> lamps(static_cast<std::size_t>(dice.one_of({0, 1, 5, 32})));
  for (wire::Lamp& lamp : lamps) {
    const bool sphere = dice.chance(50);
    lamp.kind = sphere ? wire::LightKind::kSphere : wire::LightKind::kRectangle;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int size = scene.volume.size()[axis];
      lamp.position[axis] = dice.number(-2 * size, 3 * size) + 0.3;
      lamp.colour[axis] = static_cast<std::uint32_t>(dice.number(0, 1 << 18));
      lamp.u[axis] = dice.number(-200, 200) + 0.5;
      lamp.v[axis] = dice.number(-200, 200) * (axis == 2 ? -1.25 : 1) + 0.25;
    }
    if (sphere) lamp.u = {dice.number(1, 600) / 10.0, 0, 0};
  }
  return lamps;
}

std::vector<wire::Ray> draw_rays(const Scene& scene, Dice& dice) {
  std::vector<wire::Ray> rays;
  for (int i = dice.number(0, 60); i > 0; --i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = dice.number(0, (scene.volume.size()[axis] - 1) * 100) / 100.0;
      direction[axis] = dice.number(-100, 100) + 0.5;
    }
    rays.push_back(host_ray(static_cast<std::uint32_t>(dice.number(0, 1 << 20)), position, direction));
    rays.back().opacity =
        static_cast<std::uint32_t>(dice.chance(20) ? dice.number(0, 1 << 24) - 1 : 0) & wire::kOpacityOne;
  }
  return rays;
}

wire::VoxelFormat format_of(const v1::BoardConfig& config) {
  return static_cast<wire::VoxelFormat>(config.asic().voxel_format());
}

std::uint32_t packets_of_tile(const v1::BoardConfig& config) {
  const std::uint32_t packets = wire::has_colours(format_of(config)) ? 2 : 1;  // 4 x 60 bits in packets of 144
  return packets + (config.asic().irradiance_words() == 3 ? 1 : 0);            // 22 more a voxel
}

std::string text(const std::vector<std::string>& assignments) {
  return std::accumulate(assignments.begin(), assignments.end(), std::string(),
                         [](const std::string& all, const std::string& one) { return all + " --set " + one; });
}

std::vector<std::string> counter_texts(const Machine& machine) {
  std::vector<wire::Counter> counters;
  count(machine, counters);
  std::vector<std::string> texts;
  for (const auto& counter : counters) texts.push_back(counter.name + ' ' + std::to_string(counter.value));
  return texts;
}

}  // namespace gicube::emu
