// Common code of all programs with a board: opening it with the user's options, checks, and measurements.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gicube/board.h"
#include "gicube/board_group.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

// `while_waiting`: as OpenOptions. Warns of fields of the configuration that are set but not modelled at the board's
// level. Throws UsageError for invalid options, and the exceptions of Board::open().
Board open_board(const BoardOptions& options, const std::function<void()>& while_waiting = {});

// Opens one or several boards.
BoardGroup open_boards(const BoardOptions& options, const std::function<void()>& while_waiting = {});

// Warns if nothing is visible in a picture of the board.
void warn_if_invisible(const Board& board, const Image& image);

// Checks that the board can render such a volume, of which the card may store only a part (docs/guide/bricks.md).
// Throws InputError.
void check_renders(const Dims& dims, const BoardInfo& info, const std::string& source);
// Checks that the card can store the volume. The InputError names the setting that enlarges an emulated board.
void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source);

// Whether a counter is a maximum since the session first read it (energy.<part>.peak), and so is not subtracted in
// windows.
inline bool is_maximum(const Counter& counter) { return counter.unit == "uW"; }

// Wall-clock time, simulated time and counters of a part of the work.
class RunWindow {
 public:
  // `boards`: a Board or a BoardGroup, which must outlive this.
  template <typename Boards>
  explicit RunWindow(Boards& boards)
      : now_([&boards] { return boards.now(); }),
        count_([&boards] { return boards.counters(); }),
        counters_(count_()),
        begin_(now_()),
        start_(std::chrono::steady_clock::now()) {}

  Picoseconds simulated() const { return now_() - begin_; }
  double host_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Counters counters() {
    const Counters end = count_();
    std::vector<Counter> window = (end - counters_).list();
    for (std::size_t i = 0; i < window.size(); ++i) {
      if (is_maximum(window[i])) window[i].value = end.list()[i].value;
    }
    return Counters(std::move(window));
  }

 private:
  std::function<Picoseconds()> now_;
  std::function<Counters()> count_;
  Counters counters_;
  Picoseconds begin_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace gicube::samples
