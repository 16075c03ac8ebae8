#include "gicube/scene/marks.h"

#include "test.h"

namespace gicube::scene {
namespace {

View from(Vec3 eye, Vec3 up) {
  View view;
  view.eye = eye;
  view.up = up;
  view.width = view.height = 128;
  return view;
}

Image drawn(const WorldPlacement& placement, const View& view) {
  Image image{view.width, view.height, std::vector<Pixel>(static_cast<std::size_t>(view.width * view.height))};
  draw_marks(placement, {1, 1, 1}, view, image);
  return image;
}

// Bright pixels of a box round (x, y) from the corner's middle, in shares of the arm.
long bright_near(const Image& image, double x, double y) {
  const double arm = 0.055 * image.width, middle = 0.1 * image.width;
  long count = 0;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const bool near =
          std::abs(column - middle - x * arm) < 5 && std::abs(row - (image.height - middle) + y * arm) < 5;
      if (near && image.at(column, row).red > 200) ++count;
    }
  }
  return count;
}

TEST(AxisMarks, AreThePatientsWhereThereIsOne) {
  WorldPlacement placement;
  EXPECT_THAT(axis_marks(placement), ElementsAre("-x", "x", "-y", "y", "-z", "z"));
  placement.axes = WorldAxes::kPatient;
  EXPECT_THAT(axis_marks(placement), ElementsAre("R", "L", "A", "P", "I", "S"));
}

TEST(DrawMarks, PutsThemWhereTheAxesEnd) {
  // A reader in front of the patient: his left is on the right, his head on top.
  WorldPlacement patient;
  patient.axes = WorldAxes::kPatient;
  const Image image = drawn(patient, from({0, -100, 0}, {0, 0, 1}));
  for (const auto& [x, y] : {std::pair(1.2, 0.0), {-1.2, 0.0}, {0.0, 1.2}, {0.0, -1.2}})
    EXPECT_GT(bright_near(image, x, y), 8);
  // Without one, the high ends alone.
  const Image axes = drawn({}, from({0, -100, 0}, {0, 0, 1}));
  EXPECT_GT(bright_near(axes, 1.2, 0), 5);
  EXPECT_EQ(bright_near(axes, -1.2, 0), 0);
  // The letter L has its stroke on the left and at the bottom, as drawn by hand.
  EXPECT_FALSE(image == axes);
}

TEST(DrawMarks, LeavesSmallPicturesAndTheirRestAlone) {
  View view = from({0, -100, 0}, {0, 0, 1});
  view.width = view.height = 63;
  const Image small = drawn({}, view);
  EXPECT_TRUE(std::ranges::all_of(small.pixels, [](const Pixel& pixel) { return pixel == Pixel{}; }));
  view.width = view.height = 256;
  const Image large = drawn({}, view);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      if (x > 64 || y < 192) {
        EXPECT_EQ(large.at(x, y), Pixel{});
      }
    }
  }
}

}  // namespace
}  // namespace gicube::scene
