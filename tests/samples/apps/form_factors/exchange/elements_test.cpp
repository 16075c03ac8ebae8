// Elements of hand-made rooms, and the trees over them.
#include "form_factors/exchange/elements.h"

#include "gicube/scene/error.h"
#include "test.h"
#include "test_room.h"

namespace gicube::samples {
namespace {

using reference::kAir;
using reference::kObstacle;
using reference::kWall;
using reference::Room;
using reference::setup_of;

std::vector<Leaf> leaves_of(const Room& room, const Emissions& emissions = {}) {
  const SceneSetup setup = setup_of(room);
  return make_leaves(make_medium(setup, 0.5), setup, emissions);
}

double weight_of(const std::vector<Leaf>& leaves, std::uint8_t facing) {
  double sum = 0;
  for (const Leaf& leaf : leaves) sum += leaf.facing == facing ? leaf.weight : 0;
  return sum;
}

TEST(Elements, OfARoomAreItsWallsAndItsFog) {
  const auto leaves = leaves_of({.size = 4, .kappa = 0.25, .wall_albedo = 0.5, .air_albedo = 0.75});
  EXPECT_EQ(leaves.size(), 6u * 16 + 64);
  for (std::uint8_t facing = 0; facing < kMedium; ++facing) EXPECT_DOUBLE_EQ(weight_of(leaves, facing), 16);
  EXPECT_NEAR(weight_of(leaves, kMedium), 4 * 0.25 * 64, 5e-3);  // 4 kappa V, of a table of 16 bits
  for (const Leaf& leaf : leaves) {
    const bool medium = leaf.facing == kMedium;
    EXPECT_EQ(leaf.tag, medium ? kAir : kWall);
    EXPECT_EQ(leaf.albedo[1], medium ? 0.75 : 0.5);
    EXPECT_NEAR(leaf.kappa, medium ? 0.25 : 0, 1e-5);
  }
}

TEST(Elements, AFaceLooksFromItsSolidIntoTheOpen) {
  Room room{.size = 3};
  room.tag = [&](int x, int y, int z) -> std::uint8_t {
    if (x == 2 && y == 2 && z == 2) return kObstacle;
    return reference::room_tag(room, x, y, z);
  };
  int obstacle = 0;
  for (const Leaf& leaf : leaves_of(room)) {
    const Vec3 normal = cross(leaf.element.u, leaf.element.v);
    const Vec3 middle = leaf.element.origin + 0.5 * (leaf.element.u + leaf.element.v);
    const auto behind = voxel_behind(leaf);
    const Vec3 open{double(leaf.cell[0]), double(leaf.cell[1]), double(leaf.cell[2])};
    const Vec3 solid{double(behind[0]), double(behind[1]), double(behind[2])};
    EXPECT_EQ(normal, open - solid);
    EXPECT_EQ(middle, 0.5 * (open + solid));
    obstacle += leaf.tag == kObstacle ? 1 : 0;
  }
  EXPECT_EQ(obstacle, 6);
}

TEST(Elements, OpenEndsOfTheVolumeAreBlackAndHalfAVoxelShorter) {
  Room room{.size = 2, .kappa = 0.1, .wall_albedo = 0.9, .air_albedo = 0.9};
  room.tag = [](int, int, int) { return std::uint8_t{kAir}; };
  const auto leaves = leaves_of(room);
  for (std::uint8_t facing = 0; facing < kMedium; ++facing) EXPECT_DOUBLE_EQ(weight_of(leaves, facing), 9);
  EXPECT_NEAR(weight_of(leaves, kMedium), 4 * 0.1 * 27, 1e-3);
  for (const Leaf& leaf : leaves) {
    if (leaf.facing == kMedium) continue;
    EXPECT_EQ(leaf.tag, kOutside);
    EXPECT_EQ(leaf.albedo, Power{});
  }
}

TEST(Elements, AreMeasuredInSpace) {
  const auto leaves = leaves_of({.size = 2, .kappa = 0.1, .spacing = {2, 2, 6}});  // edges 1, 1, 3
  EXPECT_DOUBLE_EQ(weight_of(leaves, 0), 4 * 3);
  EXPECT_DOUBLE_EQ(weight_of(leaves, 5), 4);
  EXPECT_NEAR(weight_of(leaves, kMedium), 4 * 0.1 * 24, 1e-3);
}

TEST(Elements, EmissionIsOfAreaAndOfVolume) {
  for (const Leaf& leaf : leaves_of({.size = 2, .kappa = 0.2}, {{{8, 8, 8}, {6, 0, 0}}, {{0, 3, 0}, {8, 8, 8}}})) {
    const double power = leaf.weight * (leaf.emission[0] + leaf.emission[1]);
    EXPECT_NEAR(power, leaf.facing == kMedium ? 6 : 3, 1e-9);
  }
}

TEST(Elements, ASolidIsWhatHidesEnoughAndItsRiseBringsNothingIntoTheOpen) {
  SceneSetup setup = setup_of({.size = 4, .kappa = 0.2});
  EXPECT_EQ(make_medium(setup, 0.5).solid, make_medium(setup, 0.99).solid);
  const Medium all = make_medium(setup, 0.15);  // fog hides 0.18 of a voxel length
  EXPECT_EQ(std::accumulate(all.solid.begin(), all.solid.end(), 0u), 6u * 6 * 6);
  const Medium medium = make_medium(setup, 0.5);
  for (const std::array<int, 3> voxel : {std::array{1, 1, 1}, std::array{1, 2, 3}, std::array{2, 2, 2}}) {
    EXPECT_NEAR(mean_kappa(medium, voxel), 0.2, 1e-5);
  }
  EXPECT_THROWS(InputError, "settings.solid_opacity: expected more than 0, at most 1, got 0", make_medium(setup, 0));
  setup.free_voxels();
  EXPECT_THROWS(InputError, "setup.volume: expected its voxels", make_medium(setup, 0.5));
}

TEST(Contents, OfABoxAreThoseOfItsVoxels) {
  const Contents contents(make_medium(setup_of({.size = 6, .kappa = 0.2}), 0.5));
  const Contents::Of open = contents.box({0.5, 0.5, 0.5}, {6.5, 6.5, 6.5});
  EXPECT_FALSE(open.solid);
  EXPECT_NEAR(open.mean_kappa, 0.2, 1e-5);
  EXPECT_NEAR(open.kappa_spread, 0, 1e-6);
  EXPECT_TRUE(contents.box({0.5, 0.5, 0.25}, {6.5, 6.5, 6.5}).solid);
  EXPECT_FALSE(contents.box({0.5, 2.5, 2.5}, {0.5, 3.5, 3.5}).solid);  // a face of the wall, and nothing before it
}

TEST(Forest, EachClusterHoldsTheLeavesOfItsChildren) {
  const SceneSetup setup = setup_of({.size = 5, .kappa = 0.1});
  const Forest forest = make_forest(make_leaves(make_medium(setup, 0.5), setup, {}), {1, 1, 1}, 1);
  EXPECT_EQ(forest.roots.size(), 7u);
  std::uint32_t ends = 0;
  for (std::uint32_t i = 0; i < forest.clusters.size(); ++i) {
    const Cluster& cluster = forest.clusters[i];
    if (cluster.child == kNone) {
      EXPECT_EQ(cluster.last - cluster.first, 1u);
      EXPECT_TRUE(cluster.full);
      ++ends;
      continue;
    }
    std::uint32_t at = cluster.first;
    double weight = 0;
    for (std::uint32_t c = cluster.child; c < cluster.child + cluster.children; ++c) {
      EXPECT_EQ(forest.clusters[c].parent, i);
      EXPECT_EQ(forest.clusters[c].first, at);
      at = forest.clusters[c].last;
      weight += forest.clusters[c].weight;
    }
    EXPECT_EQ(at, cluster.last);
    EXPECT_GE(cluster.children, 2u);
    EXPECT_NEAR(weight, cluster.weight, 1e-9);
  }
  EXPECT_EQ(ends, forest.leaves.size());
  for (const std::uint32_t root : forest.roots) EXPECT_TRUE(forest.clusters[root].full);  // whole walls, one even fog
}

TEST(Forest, LargerLeavesAreNotDivided) {
  const SceneSetup setup = setup_of({.size = 6, .kappa = 0.1});
  const Forest forest = make_forest(make_leaves(make_medium(setup, 0.5), setup, {}), {1, 1, 1}, 2);
  for (const Cluster& cluster : forest.clusters) {
    if (cluster.child != kNone) continue;
    EXPECT_LE(cluster.last - cluster.first, cluster.facing == kMedium ? 8u : 4u);
  }
}

TEST(Clusters, SeeOnlyWhatIsBeforeTheirFaces) {
  const auto face = [](std::uint8_t facing, double at) {
    Cluster cluster;
    cluster.facing = facing;
    cluster.high = {1, 1, 1};
    cluster.low[facing / 2u] = cluster.high[facing / 2u] = at;
    return cluster;
  };
  EXPECT_TRUE(may_see(face(1, 0), face(0, 1)));
  EXPECT_FALSE(may_see(face(1, 1), face(0, 0)));  // back to back
  EXPECT_FALSE(may_see(face(1, 0), face(1, 1)));  // of one facing
  EXPECT_TRUE(may_see(face(1, 0), face(5, 0)));
  EXPECT_FALSE(may_see(face(1, 1), face(5, 0)));
  EXPECT_TRUE(may_see(face(kMedium, 0), face(kMedium, 1)));
}

}  // namespace
}  // namespace gicube::samples
