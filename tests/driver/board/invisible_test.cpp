// Pictures in which nothing is visible say so, with what was done to them here.
#include "test.h"
#include "test_board.h"

namespace gicube::reference {
namespace {

class Invisible : public testing::Test {
 protected:
  // A box of 200 in 0, in blocks of 8 voxels.
  void load(std::uint8_t inside = 200) {
    for (std::byte& sample : box_.samples) sample = sample == std::byte{0} ? sample : std::byte{inside};
    board_.load_volume(box_.view());
  }
  std::string why(const View& view) { return board_.why_invisible(board_.render(view)); }

  Board board_ = Board::open(kSmallBlocks);
  BoxVolume box_{32, 8, 23};
  View view_ = front_view(32);
};

TEST_F(Invisible, NothingIsSaidOfAPictureWithSomethingInIt) {
  load();
  board_.set_transfer_function(step_function(0.5));
  EXPECT_EQ(why(view_), "");
  view_.orthographic_height = 4000;  // far wider than the box, which the one ray meets
  view_.width = view_.height = 1;
  EXPECT_EQ(why(view_), "");
}

TEST_F(Invisible, WithoutATransferFunction) {
  load();
  EXPECT_EQ(why(view_), "nothing is visible in the picture: no transfer function is set");
}

TEST_F(Invisible, ByATransferFunctionOfAnotherTagOrWithoutOpacity) {
  load();
  board_.set_transfer_function(step_function(0.5), 2);
  EXPECT_THAT(why(view_), HasSubstr("has no opacity, or none is set for them"));
  board_.set_transfer_function({.opacities = {{0, 0}}});
  EXPECT_THAT(why(view_), HasSubstr("has no opacity, or none is set for them"));
}

// Of bytes a density is 255/4095 = 0.06 of a value, so values are told to a tenth.
TEST_F(Invisible, ByAMaskAmongBytes) {
  load(1);
  board_.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{25.5, 0}, {255, 0.5}}});
  EXPECT_EQ(why(view_),
            "nothing is visible in the picture: voxels have values of 0 to 1, the transfer function has "
            "opacity at 25.5 to 255 alone (a mask? load it with its own range of values)");
}

TEST_F(Invisible, ByValuesThatTheTransferFunctionDoesNotShow) {
  load(90);
  board_.set_transfer_function(step_function(0.5));  // invisible below 100
  EXPECT_THAT(why(view_),
              AllOf(HasSubstr("voxels have values of 0 to 90, the transfer function has opacity at 100 to 255"),
                    EndsWith("alone")));
}

TEST_F(Invisible, ByEmptyFlagsThatWereSet) {
  load();
  board_.set_transfer_function(step_function(0.5));
  board_.set_empty_flags(std::vector<std::uint8_t>(board_.empty_flags().size(), 1));
  EXPECT_THAT(why(view_), HasSubstr("empty flags that were set hide"));
  view_.leap = false;
  EXPECT_EQ(why(view_), "");
}

TEST_F(Invisible, ByCutPlanes) {
  load();
  board_.set_transfer_function(step_function(0.5));
  view_.cut_planes = {{{1, 0, 0}, 15}};  // through the middle
  EXPECT_EQ(why(view_), "");
  view_.cut_planes.push_back({{0, 0, -2}, 6});  // and all above z = -3
  EXPECT_THAT(why(view_), EndsWith("all that is visible is cut away"));
  view_.cut_planes.back().offset = -10;  // above z = 5, in the block in which the box begins
  EXPECT_THAT(why(view_), EndsWith("or the cut planes leave nothing that is visible"));
}

TEST_F(Invisible, ByACameraThatLooksElsewhere) {
  load();
  board_.set_transfer_function(step_function(0.5));
  View behind = view_;
  behind.look_at = view_.eye + (view_.eye - view_.look_at);
  for (const double height : {0.0, 40.0}) {
    View aside = view_;
    aside.orthographic_height = height;
    aside.eye.x += 500, aside.look_at.x += 500;
    EXPECT_THAT(why(aside), EndsWith("the camera looks past all that is visible")) << height;
  }
  EXPECT_THAT(why(behind), EndsWith("the camera looks past all that is visible"));
}

TEST_F(Invisible, ByOpacitiesThatAreTooSmall) {
  load();
  // 16 voxels of 1e-4 are 6.6 of 4095.
  board_.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {101, 1e-4}}});
  EXPECT_THAT(why(view_), StartsWith("nothing is visible in the picture: opacities are too small"));
}

TEST_F(Invisible, CostsNoSimulatedTimeAndSaysNothingOfAnImageWithoutPixels) {
  load();
  const Image image = board_.render(view_);
  const Picoseconds before = board_.now();
  EXPECT_NE(board_.why_invisible(image), "");
  EXPECT_EQ(board_.now(), before);
  EXPECT_EQ(board_.why_invisible({}), "");
}

}  // namespace
}  // namespace gicube::reference
