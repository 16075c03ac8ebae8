// The board's fixed-point pictures against the reference, through the public driver: PSNR at least 40 dB.
#include "measure.h"
#include "reference/march.h"
#include "test.h"

namespace gicube::accuracy {
namespace {

constexpr double kMinPsnr = 40;  // dB, jitter off
constexpr int kImage = 96;       // pixels; small, since the reference is slow
constexpr int kBuckyball = 64;   // voxels an edge

constexpr double kMinExplained = 70;  // dB; 84 measured, one grazing ray that misses its surface would cost down to 61

StudyScene find(const std::string& name) {
  for (StudyScene& study : study_scenes(GICUBE_SOURCE_DIR "/../shared/data", kBuckyball)) {
    if (study.name == name) {
      study.scene.view.width = study.scene.view.height = kImage;
      return study;
    }
  }
  throw std::invalid_argument(name);
}

// A private board with what the scene needs. This program does not stand beside gicube-board.
Board open_for(const StudyScene& study) { return Board::open(uri_for(study, "emu:")); }

class FixedPointPicture : public testing::TestWithParam<std::string> {};

TEST_P(FixedPointPicture, IsWithinFortyDecibelOfTheReference) {
  const StudyScene study = find(GetParam());
  if (!study.available()) GTEST_SKIP() << study.scene.volume.file << " is not there";
  const samples::SceneSetup setup = samples::set_up(study.scene);
  Board board = open_for(study);
  const reference::Difference difference =
      compare(render_on_board(setup, board), reference::render(to_reference(setup)));
  EXPECT_GT(difference.covered, 0.05);  // there is something to see
  EXPECT_GE(difference.psnr_db, kMinPsnr);
  RecordProperty("psnr_db", std::to_string(difference.psnr_db));
}

INSTANTIATE_TEST_SUITE_P(Of, FixedPointPicture, testing::Values("buckyball", "engine", "mouse", "brain"),
                         [](const auto& test) { return test.param; });

// An error that the quantisers do not explain would be a difference of meaning: camera, sampling, shading, order.
TEST(BoardsPicture, DiffersFromTheReferenceByTheQuantisersAlone) {
  const StudyScene study = find("buckyball");
  const samples::SceneSetup setup = samples::set_up(study.scene);
  Board board = open_for(study);
  const reference::Picture quantised = reference::render(to_reference(setup), reference::Quantisers::all());
  EXPECT_GE(compare(render_on_board(setup, board), quantised).psnr_db, kMinExplained);
}

// A camera inside, cut planes, oblong voxels, parallel rays and a tent filter all at once, by the same rule.
TEST(BoardsPicture, KeepsItsMeaningInTheViewsThatFewScenesUse) {
  const StudyScene study = find("buckyball");
  samples::SceneSetup setup = samples::set_up(study.scene);
  setup.volume.spacing = {1, 1, 1.5};
  setup.view.samples_per_axis = 2;
  setup.view.filter = PixelFilter::kTent;
  setup.view.step = 0.75;
  setup.view.width = 64;
  setup.view.height = 48;
  setup.view.cut_planes = {{{0.3, 1, 0.2}, 20}};
  View inside = setup.view, parallel = setup.view;
  inside.eye = {30, 28, 40};
  inside.look_at = {10, 50, 20};
  inside.fov_degrees = 80;
  parallel.orthographic_height = 50;
  Board board = open_for(study);
  for (const View& view : {inside, parallel}) {
    setup.view = view;
    const reference::Picture quantised = reference::render(to_reference(setup), reference::Quantisers::all());
    const reference::Difference difference = compare(render_on_board(setup, board), quantised);
    EXPECT_GE(difference.psnr_db, 55);  // the reference keeps the cut plane's place exactly
    EXPECT_GT(difference.covered, 0.2);
  }
}

}  // namespace
}  // namespace gicube::accuracy
