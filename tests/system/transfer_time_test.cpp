// The whole way, host application to framebuffer and back, takes the closed-form bus time of every model.
#include <gicube/board.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

namespace gicube {
namespace {

// Written out apart from the board's own code [H1101-H1106]: a burst of n dwords, in
// picoseconds.
struct Model {
  std::string name;
  double down_burst_ps;       // of the longest burst of an upload
  std::uint64_t down_dwords;  // its dwords
  double up_burst_ps;         // of 256 dwords of an image

  friend void PrintTo(const Model& model, std::ostream* out) { *out << model.name; }
};

class TransferTime : public testing::TestWithParam<Model> {
 protected:
  static void SetUpTestSuite() { setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1); }

  Board open() { return Board::open("emu:?bus=" + GetParam().name); }
};

TEST_P(TransferTime, LoadsA256CubedVolumeWithinATenthOfAPercent) {
  Board board = open();
  constexpr int kEdge = 256;
  // Nothing is empty, so every block is sent: 75,497,472 bytes of packed 36-bit words.
  const std::vector<std::byte> samples(std::size_t{kEdge} * kEdge * kEdge, std::byte{100});
  const Picoseconds begin = board.now();
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {kEdge, kEdge, kEdge}});
  const double bursts = 75'497'472.0 / 4 / static_cast<double>(GetParam().down_dwords);
  const double expected = bursts * GetParam().down_burst_ps;
  EXPECT_NEAR(static_cast<double>(board.now() - begin) / expected, 1, 0.001);
}

TEST_P(TransferTime, ReadsA512SquaredFrameWithinATenthOfAPercent) {
  Board board = open();
  const std::vector<std::byte> samples(8, std::byte{100});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {2, 2, 2}});
  View view;
  view.eye = {0.5, 0.5, -10};
  view.look_at = {0.5, 0.5, 0.5};
  board.render_to_framebuffer(view);
  const Picoseconds begin = board.now();
  const Counters before = board.counters();
  EXPECT_EQ(board.read_framebuffer().pixels.size(), 512u * 512u);
  const double expected = 512.0 * 512 * 36 / 8 / 4 / 256 * GetParam().up_burst_ps;
  EXPECT_NEAR(static_cast<double>(board.now() - begin) / expected, 1, 0.001);
  const Counters window = board.counters() - before;
  EXPECT_EQ(window.value("bus.up.bytes"), 1'179'648u);
  EXPECT_NEAR(static_cast<double>(window.value("bus.up.busy_ps")) / expected, 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(EveryBusModel, TransferTime,
                         testing::Values(Model{"pci33", 259 * 30'000.0, 256, 259 * 30'000.0},
                                         Model{"agp1x", (64 + 2) * 15'000.0, 64, 259 * 15'000.0},
                                         Model{"agp2x", (32 + 2) * 15'000.0, 64, 259 * 15'000.0},
                                         Model{"agp4x", (16 + 2) * 15'000.0, 64, 259 * 15'000.0}),
                         [](const testing::TestParamInfo<Model>& model) { return model.param.name; });

}  // namespace
}  // namespace gicube
