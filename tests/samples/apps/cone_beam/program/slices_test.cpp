#include "cone_beam/program/options.h"

#include "test.h"
#include "voxels.h"

namespace gicube::samples {
namespace {

// A grid of 2 x 3 x 4 voxels whose values are x + 10 y + 100 z.
struct Cube {
  Grid grid{{2, 3, 4}, {1, 1, 1}};
  std::vector<float> values;
  Cube() {
    for_each_voxel({2, 3, 4}, [&](int x, int y, int z) { values.push_back(static_cast<float>(x + 10 * y + 100 * z)); });
  }
};

TEST(Slices, HaveXToTheRightAndTheOtherAxisUp) {
  const Cube cube;
  const auto red = [](const Image& image, int x, int y) { return static_cast<int>(image.at(x, y).red); };
  const Image z = slice_of(cube.grid, cube.values, 2, 1, {0, 255});
  EXPECT_EQ(z.width, 2);
  EXPECT_EQ(z.height, 3);
  EXPECT_EQ(red(z, 0, 2), 100);  // the lower left corner is the first voxel
  EXPECT_EQ(red(z, 1, 2), 101);
  EXPECT_EQ(red(z, 0, 0), 120);
  const Image y = slice_of(cube.grid, cube.values, 1, 2, {0, 255});
  EXPECT_EQ(y.height, 4);
  EXPECT_EQ(red(y, 1, 3), 21);
  EXPECT_EQ(red(y, 0, 1), 220);
  const Image x = slice_of(cube.grid, cube.values, 0, 1, {0, 255});
  EXPECT_EQ(x.width, 3);
  EXPECT_EQ(red(x, 2, 3), 21);
  EXPECT_EQ(red(x, 0, 1), 201);
}

TEST(Slices, ClampToTheirGreyRange) {
  const Cube cube;
  const Image z = slice_of(cube.grid, cube.values, 2, 0, {10, 20});
  EXPECT_EQ(z.at(0, 2).red, 0);
  EXPECT_EQ(z.at(1, 1).red, 26);  // 11 of 10 to 20
  EXPECT_EQ(z.at(0, 0).red, 255);
  EXPECT_EQ(z.at(0, 0).alpha, 4095);
}

TEST(Slices, HaveARangeThatLeavesTheRarestValuesOut) {
  std::vector<float> values(10'000, 1);
  values[5] = -1000;
  values[77] = 1000;
  for (std::size_t i = 100; i < 200; ++i) values[i] = 0;
  for (std::size_t i = 300; i < 400; ++i) values[i] = 2;
  EXPECT_EQ(grey_range(values), (std::array<double, 2>{0, 2}));
  EXPECT_EQ(grey_range(std::vector<float>(10, 3)), (std::array<double, 2>{3, 4}));
}

}  // namespace
}  // namespace gicube::samples
