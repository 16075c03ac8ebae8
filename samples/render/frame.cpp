#include "render/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>

#include "common/input_error.h"

namespace gicube::samples {
namespace {

Board open_board(const BoardOptions& options) {
  const std::string uri = board_uri(options);
  try {
    return Board::open(uri);
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source) {
  const int longest = *std::max_element(dims.begin(), dims.end());
  if (longest <= info.max_volume_voxels) return;
  const unsigned needed = std::bit_ceil(static_cast<unsigned>(longest));
  throw InputError(
      source,
      fmt::format("at most {} voxels an edge, which this board holds (--set asic.max_volume_voxels={} makes an "
                  "emulated one larger)",
                  info.max_volume_voxels, needed),
      fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

// The volume, how it looks, and nothing of it left in the host's memory.
void load(Board& board, SceneSetup& setup, ProgressLine& progress) {
  board.set_shading(setup.shading);
  board.load_volume(setup.volume_view(), progress.parts("loading the volume"));
  setup.free_voxels();
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
}

}  // namespace

Frame render_frame(const RenderOptions& options, ProgressLine& progress) {
  const Scene scene = scene_of(options);
  Board board = open_board(options.board);
  progress.show("reading the scene");
  SceneSetup setup = set_up(scene, options.board.threads);
  set_phong(options, setup.shading.phong);
  check_fits(setup.volume.dims, board.info(), setup.volume.source);
  load(board, setup, progress);

  const Counters before = board.counters();
  const Picoseconds loaded = board.now();
  const auto start = std::chrono::steady_clock::now();
  Frame frame;
  frame.image = board.render(setup.view, progress.parts("rendering"));
  const std::chrono::duration<double> host = std::chrono::steady_clock::now() - start;

  FrameStatistics& statistics = frame.statistics;
  statistics.frame = board.now() - loaded;
  statistics.counters = board.counters() - before;
  statistics.board = board.info();
  statistics.load = loaded;
  statistics.host_seconds = host.count();
  statistics.width = frame.image.width;
  statistics.height = frame.image.height;
  statistics.dims = setup.volume.dims;
  statistics.seed = options.board.seed;
  frame.background = setup.background;
  return frame;
}

}  // namespace gicube::samples
