#include "scene/label_map.h"

#include "test.h"
#include "voxels.h"

namespace gicube::scene {
namespace {

// Cells of `edge` voxels with labels of their own, 0 outside of the middle.
SceneSetup checkers(int dims, int edge, int step) {
  SceneSetup setup;
  setup.volume.dims = {dims, dims, dims};
  for_each_voxel({dims, dims, dims}, [&](int x, int y, int z) {
    const bool inside = std::min({x, y, z}) > 0 && std::max({x, y, z}) < dims - 1;
    const int cell = (x / edge) + 4 * (y / edge) + 16 * (z / edge);
    setup.volume.samples.push_back(static_cast<std::byte>(inside ? 1 + step * cell : 0));
  });
  return setup;
}

TEST(LabelMap, GivesFourLabelsAColourEach) {
  SceneSetup setup;
  setup.volume.dims = {5, 1, 1};
  for (const int label : {0, 9, 2, 7, 40}) setup.volume.samples.push_back(static_cast<std::byte>(label));
  colour_labels(setup);
  EXPECT_EQ(setup.label_values, (std::vector<double>{0, 2, 7, 9, 40}));
  EXPECT_EQ(setup.labels, (std::vector<std::uint16_t>{0, 3, 1, 2, 4}));
  EXPECT_EQ(setup.built_in.materials.size(), 4u);
  EXPECT_EQ(setup.tags, (std::vector<std::uint8_t>{2, 2, 0, 1, 3}));  // the background has that of its neighbour
  EXPECT_EQ(setup.volume.samples[0], std::byte{0});
  EXPECT_EQ(setup.volume.samples[4], std::byte{255});
  EXPECT_THAT(setup.look_why, HasSubstr("2 orange, 7 sky blue, 9 green, 40 purple"));
}

TEST(LabelMap, GivesLabelsThatTouchOtherColours) {
  // Cells of a 4 x 4 x 4 lattice touch six others at most, and two colours would do.
  SceneSetup setup = checkers(16, 4, 3);
  colour_labels(setup);
  const Dims& dims = setup.volume.dims;
  std::size_t alike = 0, other = 0;
  for (int z = 1; z < dims[2] - 1; ++z) {
    for (int y = 1; y < dims[1] - 1; ++y) {
      for (int x = 1; x < dims[0] - 2; ++x) {
        const auto i = static_cast<std::size_t>(x + 16 * (y + 16 * z));
        if (setup.labels[i] == setup.labels[i + 1]) continue;
        ++(setup.tags[i] == setup.tags[i + 1] ? alike : other);
      }
    }
  }
  EXPECT_EQ(alike, 0u);
  EXPECT_EQ(other, 14u * 14 * 3);
}

TEST(LabelMap, ShowsALabelInsideOfAnother) {
  SceneSetup setup;
  setup.volume.dims = {9, 9, 9};
  for_each_voxel({9, 9, 9}, [&](int x, int y, int z) {
    const int out = std::max({std::abs(x - 4), std::abs(y - 4), std::abs(z - 4)});
    setup.volume.samples.push_back(static_cast<std::byte>(out > 3 ? 0 : out > 1 ? 1 : 2));
  });
  colour_labels(setup);
  const auto opacity = [&](std::size_t tag) { return setup.built_in.materials[tag].function.opacity_at(255); };
  EXPECT_LT(opacity(0), 0.2);
  EXPECT_EQ(opacity(1), 1);
  EXPECT_THAT(setup.look_why, HasSubstr("1 orange (translucent), 2 sky blue"));
}

TEST(LabelMap, KeepsNegativeAndFloatLabels) {
  SceneSetup setup;
  setup.volume.dims = {2, 1, 1};
  setup.volume.type = SampleType::kInt16;
  for (const int byte : {0xff, 0xff, 0x05, 0x00}) setup.volume.samples.push_back(static_cast<std::byte>(byte));
  colour_labels(setup);
  EXPECT_EQ(setup.label_values, (std::vector<double>{-1, 5}));  // without a 0 the least is the background
}

}  // namespace
}  // namespace gicube::scene
