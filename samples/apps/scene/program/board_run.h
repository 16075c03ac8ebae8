// Common work of all programs with a board: opening it by the user's options, loading a scene, and measuring a part of
// its work.
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

// `while_waiting`: as OpenOptions. Warns of fields of the board's configuration that are set and that its level does
// not model. Throws UsageError (options that make no URI) and what Board::open() throws.
Board open_board(const BoardOptions& options, const std::function<void()>& while_waiting = {});

// Opens one or several boards.
BoardGroup open_boards(const BoardOptions& options, const std::function<void()>& while_waiting = {});

// Warns if nothing is visible in a picture of the board.
void warn_if_invisible(const Board& board, const Image& image);

// Whether pictures can be taken of such a volume, which the card need not store whole (docs/guide/bricks.md). Throws
// InputError.
void check_renders(const Dims& dims, const BoardInfo& info, const std::string& source);
// Whether the card stores it. Throws InputError that says how an emulated board is made larger.
void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source);

// Whether a counter is a maximum since the session first read it (energy.<part>.peak): windows have it as it is.
inline bool is_maximum(const Counter& counter) { return counter.unit == "uW"; }

// Wall and simulated time of a part of the work, and what the board counted in it.
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
