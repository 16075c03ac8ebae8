#include "form_factors/radiosity/radiosity.h"

#include "test.h"

namespace gicube::samples {
namespace {

Leaf leaf(std::uint8_t facing) {
  Leaf out;
  out.facing = facing;
  out.cell = {3, 4, 5};
  return out;
}

TEST(Leaf, AFaceHasItsSolidVoxelBehindItsNormal) {
  EXPECT_EQ(voxel_behind(leaf(0)), (std::array{4, 4, 5}));
  EXPECT_EQ(voxel_behind(leaf(5)), (std::array{3, 4, 4}));
  EXPECT_EQ(voxel_behind(leaf(kMedium)), (std::array{3, 4, 5}));
}

}  // namespace
}  // namespace gicube::samples
