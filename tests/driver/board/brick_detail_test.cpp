// Blocks that are sent in cells of several voxels: a picture has the bits of a volume whose voxels have their cells'
// means.
#include "brick_scenes.h"
#include "gicube/level_of_detail.h"
#include "gicube/testing.h"
#include "test.h"
#include "voxels.h"

namespace gicube::reference {
namespace {

struct Densities {
  Dims dims;
  std::vector<std::uint16_t> voxels;

  VolumeView view() const {
    return {.samples = std::as_bytes(std::span(voxels)), .type = SampleType::kUint12, .dims = dims};
  }
  std::uint16_t& at(int x, int y, int z) { return voxels[static_cast<std::size_t>(x + dims[0] * (y + dims[1] * z))]; }
};

Densities waves(const Dims& dims) {
  Densities out{dims, {}};
  std::mt19937 random(3);
  for_each_voxel(dims, [&](int x, int y, int z) {
    const bool inside = (x / 16 + y / 16 + z / 16) % 3 != 0;
    out.voxels.push_back(inside ? std::uniform_int_distribution<std::uint16_t>(500, 3000)(random) : 0);
  });
  return out;
}

// In cells of `edge` voxels, the last of an axis smaller; `largest`: by which a voxel changed.
Densities in_cells(Densities of, int edge, int& largest) {
  const Densities from = of;
  largest = 0;
  for (int z = 0; z < of.dims[2]; z += edge) {
    for (int y = 0; y < of.dims[1]; y += edge) {
      for (int x = 0; x < of.dims[0]; x += edge) {
        const auto each = [&](const auto& use) {
          for (int c = z; c < std::min(z + edge, of.dims[2]); ++c) {
            for (int b = y; b < std::min(y + edge, of.dims[1]); ++b) {
              for (int a = x; a < std::min(x + edge, of.dims[0]); ++a) use(of.at(a, b, c));
            }
          }
        };
        int sum = 0, count = 0;
        each([&](std::uint16_t voxel) { sum += voxel, ++count; });
        const int mean = (sum + count / 2) / count;
        each([&](std::uint16_t& voxel) {
          largest = std::max(largest, std::abs(voxel - mean));
          voxel = static_cast<std::uint16_t>(mean);
        });
      }
    }
  }
  return of;
}

const TransferFunction kFog{.colours = {{0, {0.2, 0.4, 1}}, {4095, {1, 0.6, 0.2}}},
                            .opacities = {{200, 0}, {4095, 0.2}}};

View from_afar(const Dims& dims, double voxels_a_pixel) {
  View view;
  view.width = view.height = 24;
  view.eye = {dims[0] * 2.0, dims[1] * 1.5, -100};
  view.look_at = {dims[0] / 2.0, dims[1] / 2.0, dims[2] / 2.0};
  view.orthographic_height = 24 * voxels_a_pixel;
  view.shade = false;
  return view;
}

TEST(BrickDetail, GivesThePictureOfMeans) {
  for (const char* const level : {"functional", "cycle"}) {
    BrickBoards boards(std::string("emu:?set=asic.block_voxels=8&fidelity=") + level, "32");
    const Densities volume = waves({50, 44, 37});
    boards.small.set_transfer_function(kFog);
    boards.large.set_transfer_function(kFog);
    boards.small.load_volume(volume.view());
    boards.small.set_brick_detail(1);
    for (const auto& [voxels, edge] : {std::pair{1.9, 1}, {2.1, 2}, {4.1, 4}, {8.1, 4}}) {  // 8: over half a block
      int largest = 0;
      const Densities means = in_cells(volume, edge, largest);
      boards.large.load_volume(means.view());
      const View view = from_afar(volume.dims, voxels);
      ASSERT_EQ(boards.small.render(view).pixels, boards.large.render(view).pixels) << voxels;
      const BrickDetail detail = boards.small.brick_detail().value();
      EXPECT_EQ(detail.largest_density, largest);
      EXPECT_EQ(detail.largest_opacity > 0, edge > 1);
      EXPECT_LE(detail.largest_opacity, 0.2);
      EXPECT_GT(detail.blocks[edge == 1 ? 0 : edge == 2 ? 1 : 2], 0u);
    }
  }
}

TEST(BrickDetail, DependsOnTheViewAloneAndNotOnWhatTheCardHad) {
  Board board = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32");
  const Densities volume = waves({50, 44, 37});
  board.set_transfer_function(kFog);
  board.load_volume(volume.view());
  View near = from_afar(volume.dims, 1);
  const Image whole = board.render(near);
  board.set_brick_detail(1);
  const Image far = board.render(from_afar(volume.dims, 4));
  EXPECT_EQ(board.render(near).pixels, whole.pixels);
  EXPECT_EQ(board.render(from_afar(volume.dims, 4)).pixels, far.pixels);
  near.orthographic_height = 0;  // perspective: some blocks are nearer
  near.eye = {25, 22, -5};
  near.fov_degrees = 120;
  board.set_brick_detail(0);
  const Image exact = board.render(near);
  board.set_brick_detail(1);
  EXPECT_NE(board.render(near).pixels, exact.pixels);
  const BrickDetail detail = board.brick_detail().value();
  EXPECT_GT(detail.blocks[0], 0u);
  EXPECT_GT(detail.blocks[2], 0u);
}

// A ball of 4^3 means takes a 64th of the bytes.
TEST(BrickDetail, SendsFewerBytes) {
  const Densities volume = waves({96, 96, 96});
  std::array<std::uint64_t, 2> bytes{};
  std::array<Picoseconds, 2> time{};
  for (const std::size_t coarse : {0, 1}) {
    Board board = Board::open("emu:?set=asic.max_volume_voxels=64");
    board.set_transfer_function(kFog);
    board.load_volume(volume.view());
    board.set_brick_detail(coarse != 0 ? 1 : 0);
    const auto sent = [&] { return board.counters().value("bus.down.bytes"); };
    const std::uint64_t before = sent();
    const Picoseconds begin = board.now();
    board.render_to_framebuffer(from_afar(volume.dims, 4.1));
    bytes[coarse] = sent() - before;
    time[coarse] = board.now() - begin;
  }
  EXPECT_LT(bytes[1], bytes[0] / 40);
  EXPECT_LT(time[1], time[0] / 4);
}

TEST(BrickDetail, NamesWhatIsWrong) {
  Board board = Board::open("emu:");
  EXPECT_THROWS(BadArgument, "detail: expected 0..64", board.set_brick_detail(-1));
  EXPECT_THROW(board.brick_detail(), Rejected);
  const Densities volume = waves({20, 20, 20});
  board.load_volume(volume.view());
  EXPECT_THROWS(Rejected, "needs a picture", board.brick_detail());
  board.render(from_afar(volume.dims, 1));
  EXPECT_FALSE(board.brick_detail());
}

}  // namespace
}  // namespace gicube::reference
