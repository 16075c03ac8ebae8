#include "scene/program/board_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "gicube/scene/error.h"

namespace gicube::samples {

namespace {

OpenOptions open_options(const BoardOptions& options, const std::function<void()>& while_waiting) {
  OpenOptions how;
  how.watchdog = options.watchdog;
  how.while_waiting = while_waiting;
  return how;
}

// Of a running board; an emulated one begins with it.
void restore_running(const BoardOptions& options, Board& board) {
  if (!options.restore.empty() && !options.board.starts_with("emu:")) board.restore(options.restore.string());
}

}  // namespace

Board open_board(const BoardOptions& options, const std::function<void()>& while_waiting) {
  const std::string uri = board_uri(options);
  try {
    Board board = Board::open(uri, open_options(options, while_waiting));
    restore_running(options, board);
    return board;
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

BoardGroup open_boards(const BoardOptions& options, const std::function<void()>& while_waiting) {
  const std::vector<std::string> uris = board_uris(options);
  GroupOptions how{.buses = options.own_buses ? HostBuses::kOwn : HostBuses::kShared,
                   .board = open_options(options, while_waiting)};
  try {
    BoardGroup boards = uris.size() == 1 ? BoardGroup::open(uris[0], how) : BoardGroup::open(uris, how);
    restore_running(options, boards.board(0));
    return boards;
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

void check_renders(const Dims& dims, const BoardInfo& info, const std::string& source) {
  constexpr int kMaxEdge = 1024, kBricksMinor = 3;
  if (info.protocol_minor < kBricksMinor || info.max_volume_voxels < 2 * info.block_voxels) {
    return check_fits(dims, info, source);
  }
  if (*std::max_element(dims.begin(), dims.end()) <= kMaxEdge) return;
  throw InputError(source, fmt::format("at most {} voxels an edge", kMaxEdge),
                   fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source) {
  const int longest = *std::max_element(dims.begin(), dims.end());
  if (longest <= info.max_volume_voxels) return;
  const unsigned needed = std::bit_ceil(static_cast<unsigned>(longest));
  throw InputError(source,
                   fmt::format("at most {} voxels an edge, which this board holds (--set asic.max_volume_voxels={} "
                               "makes an emulated one larger)",
                               info.max_volume_voxels, needed),
                   fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

}  // namespace gicube::samples
