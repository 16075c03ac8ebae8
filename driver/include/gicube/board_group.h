// Several boards in one host that make pictures and trace rays together, with the bits of one board.
// docs/guide/boards.md.
//
//   auto boards = gicube::BoardGroup::open("emu:?boards=4");
//   boards.on_all([&](gicube::Board& board) { board.load_volume(volume); });   // the same on each
//   gicube::Image image = boards.render(view);                                  // each makes strips of it
//
// Times are simulated, as a Board's; the host begins a call at the same time on all boards, and continues when the last
// one is done.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/board.h"

namespace gicube {

enum class HostBuses {  // whether the boards of a group share a bus
  kShared,              // all boards are on one PCI bus, which serves them in turn
  kOwn,                 // each has a bus of its own
};

struct GroupOptions {  // how a group is opened
  HostBuses buses = HostBuses::kShared;
  OpenOptions board{};  // of each; `while_waiting` is called for the first
};

// Where the simulated time of a board has gone. The parts add up to BoardGroup::now().
struct BoardTime {
  Picoseconds bus = 0;       // its own transfers
  Picoseconds work = 0;      // what it did meanwhile without the bus: DSP, ASIC, and what the host did for it alone
  Picoseconds bus_wait = 0;  // on a shared bus: for other boards' transfers
  Picoseconds skew = 0;      // done, until the last board was

  friend constexpr bool operator==(const BoardTime&, const BoardTime&) = default;
};

inline constexpr std::size_t kMaxBoards = 64;

// One caller at a time. An exception of one board is thrown once the others have done their part, with the board's
// number and address in the message; the others' results are kept, and BoardGroup::board(i).reopen() restores a lost
// board. BadArgument is thrown unchanged, because each board would throw the same.
class GICUBE_API BoardGroup {
 public:
  // Opens a board at each address, as Board::open() does. Throws what that throws, and BadArgument (`addresses`: 1 to
  // kMaxBoards; `buses`: boards for an AGP port, which takes one card, can't share a bus).
  static BoardGroup open(std::span<const std::string> addresses, const GroupOptions& options = {});
  // One address. That of emulated boards may have the options boards=N and buses=shared or own besides those of a
  // Board: "emu:?boards=4&buses=own". They are N boards of the same configuration.
  static BoardGroup open(std::string_view address, const GroupOptions& options = {});

  BoardGroup(BoardGroup&&) noexcept;
  BoardGroup& operator=(BoardGroup&&) noexcept;
  ~BoardGroup();

  std::size_t size() const;
  HostBuses buses() const;
  // For calls that concern one board. The time that it takes is its own; the others wait for it in the next call of the
  // group.
  Board& board(std::size_t index);

  // Calls `work` for each board: loading a volume, tables, materials, light. In simulated time this is at once; in the
  // process one board after the other, so that `work` needs no locks.
  void on_all(const std::function<void(Board& board, std::size_t index)>& work);
  void on_all(const std::function<void(Board& board)>& work);

  // The picture that each board would make of the view, if all have the same volume, tables and light: each makes
  // strips of its rows. Throws as Board::render(), and Unsupported if there is a board before protocol 2.3. `progress`
  // is that of the first board.
  Image render(const View& view, const Progress& progress = {});

  // Rays that come back are dealt to the boards; the batch has them in the order in which they were given. Those that
  // leave energy are traced by each board, so that all have the same irradiance and sums; the reports are the first
  // board's. Throws as Board::submit() and receive().
  RayBatch trace(std::span<const HostRay> rays, const RayRequest& request = {});

  // The simulated host's clock.
  Picoseconds now() const;
  // One for each board.
  std::vector<BoardTime> times() const;
  // Sums over all boards.
  Counters counters();

 private:
  struct State;
  explicit BoardGroup(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace gicube
