#include "encode/camera.h"
#include "test.h"

namespace gicube {
namespace {

using Words = std::array<std::uint32_t, 4>;

std::uint32_t word(std::int32_t value) { return static_cast<std::uint32_t>(value); }

TEST(CutPlaneWords, AxisPlanesAreExact) {
  EXPECT_EQ(cut_plane_words({{1, 0, 0}, 12.5}), (Words{16384, 0, 0, 12800}));
  EXPECT_EQ(cut_plane_words({{0, -1, 0}, -3}), (Words{0, word(-16384), 0, word(-3072)}));
}

TEST(CutPlaneWords, TheNormalsLengthDoesNotMoveThePlane) {
  const Words expected{word(9830), 0, word(-13107), 20480};  // 0.6, 0, -0.8 at 20 voxels
  for (const double size : {1.0, 7.0, 1e200, 1e-200}) {
    EXPECT_EQ(cut_plane_words({{0.6 * size, 0, -0.8 * size}, 20 * size}), expected) << size;
  }
}

TEST(CutPlaneWords, TheFarthestOffsetFits) {
  EXPECT_EQ(cut_plane_words({{0, 0, 1}, -1048575.5})[3], word(-1073741312));
}

// A plane through three points by its words: at most the normal's rounding away at the far corner of a 1024^3 volume.
TEST(CutPlaneWords, APlaneStaysInItsPlace) {
  const CutPlane plane{{1, 2, 3}, 1000};
  const Words words = cut_plane_words(plane);
  const auto normal = [&](std::size_t i) { return static_cast<std::int32_t>(words[i]) / 16384.0; };
  for (const Vec3 p : {Vec3{1000, 0, 0}, Vec3{0, 500, 0}, Vec3{100, 150, 200}}) {
    const double side =
        normal(0) * p.x + normal(1) * p.y + normal(2) * p.z - static_cast<std::int32_t>(words[3]) / 1024.0;
    EXPECT_NEAR(side, 0, 1000 * 0.5 / 16384 + 0.5 / 1024);
  }
}

}  // namespace
}  // namespace gicube
