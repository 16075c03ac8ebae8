#include "encode/volume/block_order.h"

#include "encode/camera.h"
#include "test.h"

namespace gicube {
namespace {

constexpr int kEdge = 8;  // voxels of a block

View parallel_view(Vec3 eye, Vec3 look_at, double height) {
  View view;
  view.eye = eye, view.look_at = look_at;
  view.up = {0.1, 1, 0};
  view.orthographic_height = height;
  return view;
}

BlockOrder order_of(const Dims& blocks, const View& view) {
  return BlockOrder(blocks, kEdge, viewing_command(view, {1, 1, 1}), view.cut_planes);
}

TEST(BlockOrder, GoesAlongParallelRays) {
  const View up = parallel_view({4, 4, -9}, {4, 4, 0}, 4), down = parallel_view({4, 4, 40}, {4, 4, 0}, 4);
  const std::vector<wire::WaitingBlock> first{{0, 1}}, last{{3, 1}};
  EXPECT_THAT(order_of({1, 1, 4}, up).reached_from(first), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(order_of({1, 1, 4}, up).reached_from(last), ElementsAre(3));
  EXPECT_THAT(order_of({1, 1, 4}, down).reached_from(last), ElementsAre(3, 2, 1, 0));
}

TEST(BlockOrder, GoesAwayFromAnEyeInside) {
  View view;
  view.eye = {20, 4, 4}, view.look_at = {21, 4, 4};
  view.fov_degrees = 170;
  const std::vector<wire::WaitingBlock> own{{2, 1}};
  EXPECT_THAT(order_of({5, 1, 1}, view).reached_from(own), ElementsAre(2, 3, 4));
}

TEST(BlockOrder, LeavesOutWhatIsCutAway) {
  View view = parallel_view({4, 4, -9}, {4, 4, 0}, 4);
  view.cut_planes.push_back({{0, 0, -1}, -14});  // z up to 14 is kept
  const std::vector<wire::WaitingBlock> first{{0, 1}};
  EXPECT_THAT(order_of({1, 1, 4}, view).reached_from(first), ElementsAre(0, 1));
}

TEST(BlockOrder, LeavesOutWhatIsBesideThePicture) {
  const View narrow = parallel_view({4, 20, -9}, {4, 20, 0}, 2);
  const std::vector<wire::WaitingBlock> first{{2, 1}};  // y 16..23 of 0..39
  EXPECT_THAT(order_of({1, 5, 2}, narrow).reached_from(first), ElementsAre(2, 7));
}

// Rays in double precision: whatever block one comes to, it was reached, and comes later than those before it.
TEST(BlockOrder, HasEveryRaysBlocksFromFrontToBack) {
  std::mt19937 random(7);
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const Dims blocks{4, 5, 6};
  const Vec3 size{4 * kEdge - 1.0, 5 * kEdge - 1.0, 6 * kEdge - 1.0};
  std::size_t seen = 0;
  for (int scene = 0; scene < 40; ++scene) {
    View view = parallel_view({within(-40, 80), within(-40, 80), within(-40, 80)},
                              {within(0, size.x), within(0, size.y), within(0, size.z)}, scene % 2 == 0 ? 0 : 40);
    view.fov_degrees = within(20, 120);
    view.width = view.height = 24;
    const wire::RenderCommand camera = viewing_command(view, {1, 1, 1});
    std::vector<std::vector<std::size_t>> ways;
    std::vector<std::uint8_t> is_first(4 * 5 * 6);
    for (int pixel = 0; pixel < view.width * view.height; ++pixel) {
      const double x = pixel % view.width + 0.5, y = pixel / view.width + 0.5;
      const auto along = [&](std::size_t axis) { return x * camera.du[axis] + y * camera.dv[axis]; };
      const bool parallel = camera.projection == wire::Projection::kOrthographic;
      std::array<double, 3> at{}, step{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        at[axis] = camera.origin[axis] + (parallel ? along(axis) : 0);
        step[axis] = camera.forward[axis] + (parallel ? 0 : along(axis));
      }
      const double length = std::hypot(step[0], step[1], step[2]);
      std::vector<std::size_t> way;
      for (int i = 0; i < 1000; ++i) {
        const std::array<double, 3> most{size.x, size.y, size.z};
        std::size_t block = 0, stride = 1;
        bool inside = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double here = at[axis] + i * 0.25 * step[axis] / length;
          inside = inside && here >= 0 && here <= most[axis];
          if (inside) block += stride * static_cast<std::size_t>(here / kEdge);
          stride *= static_cast<std::size_t>(blocks[axis]);
        }
        if (inside && (way.empty() || way.back() != block)) way.push_back(block);
      }
      if (way.empty()) continue;
      is_first[way.front()] = 1;
      ways.push_back(std::move(way));
    }
    std::vector<wire::WaitingBlock> waiting;
    for (std::uint32_t block = 0; block < is_first.size(); ++block) {
      if (is_first[block] != 0) waiting.push_back({block, 1});
    }
    const auto reached = order_of(blocks, view).reached_from(waiting);
    for (const auto& way : ways) {
      auto last = reached.begin();
      for (const std::size_t block : way) {
        const auto place = std::find(last, reached.end(), block);
        ASSERT_NE(place, reached.end()) << "scene " << scene << ", block " << block;
        last = place;
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 10000u);
}

std::vector<std::size_t> blocks_sampled_in(std::size_t block, Dims blocks) {
  std::vector<std::size_t> out;
  for_each_sampled_in(block, blocks, [&out](std::size_t each) { out.push_back(each); });
  return out;
}

TEST(BlocksSampledIn, AreTheBlockAndThoseAboveIt) {
  EXPECT_THAT(blocks_sampled_in(0, {2, 2, 2}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(blocks_sampled_in(5, {2, 2, 2}), ElementsAre(5, 7));
  EXPECT_THAT(blocks_sampled_in(7, {2, 2, 2}), ElementsAre(7));
}

}  // namespace
}  // namespace gicube
