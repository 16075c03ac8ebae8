#include "gicube/scene/voxeliser.h"

#include "test.h"
#include "voxels.h"

namespace gicube::scene {
namespace {

// value(x, y, z) = x + 10 y + 100 z, in floats.
Volume linear_scan(const Dims& dims, Vec3 spacing) {
  Volume scan;
  scan.type = SampleType::kFloat32;
  scan.dims = dims;
  scan.spacing = spacing;
  for_each_voxel(dims, [&](int x, int y, int z) {
    const float value = static_cast<float>(x + 10 * y + 100 * z);
    const std::size_t at = scan.samples.size();
    scan.samples.resize(at + sizeof value);
    std::memcpy(&scan.samples[at], &value, sizeof value);
  });
  return scan;
}

TEST(Scan, LiesAroundTheOriginWithItsLongestEdgeOneLong) {
  const Affine space = scan_space(linear_scan({11, 5, 3}, {1, 2, 10}));  // 11 x 10 x 30
  const Vec3 first = space.point({-0.5, -0.5, -0.5}), last = space.point({10.5, 4.5, 2.5});
  EXPECT_NEAR(first.x, -11.0 / 60, 1e-12);
  EXPECT_NEAR(first.y, -10.0 / 60, 1e-12);
  EXPECT_NEAR(first.z, -0.5, 1e-12);
  EXPECT_NEAR(last.z, 0.5, 1e-12);
}

TEST(Scan, IsInterpolatedWhereItIsPlaced) {
  const Volume scan = linear_scan({8, 8, 8}, {1, 1, 1});
  const Affine map = compose(translation({30, 20, 10}), scaling({16, 16, 16}));  // two voxels of the world each
  const PlacedScan placed = place_scan(scan, {0, 1000}, map);
  const Vec3 corner = compose(map, scan_space(scan)).point({0, 0, 0});
  EXPECT_NEAR(placed.density(corner + Vec3{2 * 1.5, 2 * 2.25, 2 * 3}), (1.5 + 22.5 + 300) / 1000, 1e-6);
  EXPECT_LT(placed.density(corner - Vec3{0.1, 0, 0}), 0);
  EXPECT_NEAR(placed.low.x, corner.x, 1e-9);
  EXPECT_NEAR(placed.high.z, corner.z + 14, 1e-9);
}

TEST(Scan, ThatIsFinerThanTheWorldIsAveraged) {
  Volume scan = linear_scan({16, 16, 16}, {1, 1, 1});
  const Affine map = scaling({4, 4, 4});  // four voxels of the scan a voxel
  const PlacedScan placed = place_scan(scan, {0, 2000}, map);
  // The middle of the first cube of 4: the mean of 0..3 on every axis.
  const Vec3 p = compose(map, scan_space(scan)).point({1.5, 1.5, 1.5});
  EXPECT_NEAR(placed.density(p), 1.5 * 111 / 2000, 1e-6);
}

}  // namespace
}  // namespace gicube::scene
