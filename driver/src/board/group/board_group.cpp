// Calls of all boards of a group: their shares of the work, their errors and their simulated times.
#include "gicube/board_group.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "board/picture_parts.h"
#include "board/state.h"
#include "encode/argument.h"
#include "group_address.h"
#include "shared_bus.h"

namespace gicube {
namespace {

Picoseconds bus_busy(Device& board) {
  const Counters counters = board.counters();
  return counters.value("bus.down.busy_ps") + counters.value("bus.up.busy_ps");
}

// Records one board's work in a call, in phases of its own simulated time.
class Recorder {
 public:
  explicit Recorder(Device& board) : board_(board), begin_(board.clock().now()), busy_(bus_busy(board)) {}

  // Ends a phase.
  void mark() {
    const Picoseconds now = board_.clock().now(), busy = bus_busy(board_);
    const Picoseconds more = busy >= busy_ ? busy - busy_ : busy;  // a reopened board counts from 0
    phases_.push_back({now - begin_, std::min(now - begin_, more)});
    begin_ = now;
    busy_ = busy;
  }
  // Like mark(), for a board that may be lost: then the bus counts as idle.
  void end() {
    try {
      mark();
    } catch (const Error&) {
      phases_.push_back({board_.clock().now() - begin_, 0});
    }
  }
  const std::vector<BusPhase>& phases() const { return phases_; }

 private:
  Device& board_;
  Picoseconds begin_;
  Picoseconds busy_;
  std::vector<BusPhase> phases_;
};

template <typename Kind>
void throw_if(const Error& error, const std::string& board) {
  if (dynamic_cast<const Kind*>(&error) != nullptr) throw Kind(board + error.what());
}

template <typename... Kinds>
void throw_as(const Error& error, const std::string& board) {
  (throw_if<Kinds>(error, board), ...);
}

// Rethrows `error`, with the board's name in front if the board threw it.
[[noreturn]] void rethrow(const std::exception_ptr& error, const std::string& board) {
  try {
    std::rethrow_exception(error);
  } catch (const DeviceLost& lost) {
    throw DeviceLost(board + lost.what(), lost.cause());
  } catch (const Error& named) {
    throw_as<TimedOut, OpenFailed, BoardBusy, VersionMismatch, Rejected, ScatteringFailed, MemoryFault, Unsupported,
             DeadlinePassed, WouldBlock, Cancelled>(named, board);
    throw;
  }
}

// Number of consecutive rays that go to one board, before the next one's turn.
std::size_t rays_at_once(std::size_t rays, std::size_t boards) {
  constexpr std::size_t kRuns = 4, kMost = 1024;  // chosen: as strip_rows()
  return std::clamp<std::size_t>(rays / (boards * kRuns), 1, kMost);
}

bool leaves_energy(RayType type) { return type == RayType::kDeposit || type == RayType::kBackproject; }

}  // namespace

struct GICUBE_HIDDEN BoardGroup::State {
  HostBuses buses = HostBuses::kShared;
  std::vector<Board> boards;
  std::vector<std::string> names;  // for error messages: "board 2 of 4 (emu:): "
  std::vector<BoardTime> times;
  Picoseconds now = 0;

  using Work = std::function<void(std::size_t index, Recorder& recorder)>;
  // All boards do their parts of a call, which begins at the same simulated time on all. `at_once`: each on a thread of
  // its own.
  void call(bool at_once, const Work& work);
  void render(std::size_t index, const View& view, const BoardState::PicturePart& part, const Progress& progress,
              Recorder& recorder);
  void align();
  void account(std::span<const std::vector<BusPhase>> phases);
};

// Sets all boards' clocks to the latest of them.
void BoardGroup::State::align() {
  Picoseconds latest = now;
  for (const Board& board : boards) latest = std::max(latest, board.now());
  for (std::size_t i = 0; i < boards.size(); ++i) {
    times[i].work += std::max(boards[i].now(), now) - now;  // of this board alone
    times[i].skew += latest - std::max(boards[i].now(), now);
    boards[i].state_->device.clock().wait_until(latest);
  }
  now = latest;
}

void BoardGroup::State::account(std::span<const std::vector<BusPhase>> phases) {
  std::vector<Picoseconds> alone(boards.size()), busy(boards.size());
  for (std::size_t i = 0; i < boards.size(); ++i) {
    for (const BusPhase& phase : phases[i]) {
      alone[i] += phase.elapsed;
      busy[i] += phase.busy;
    }
  }
  std::vector<Picoseconds> done = alone;
  if (buses == HostBuses::kShared) done = done_on_shared_bus(phases);
  for (std::size_t i = 0; i < done.size(); ++i) done[i] = std::max(done[i], alone[i]);  // those are rounded
  const Picoseconds last = *std::ranges::max_element(done);
  now += last;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    times[i].bus += busy[i];
    times[i].work += alone[i] - busy[i];
    times[i].bus_wait += done[i] - alone[i];
    times[i].skew += last - done[i];
    boards[i].state_->device.clock().wait_until(now);
  }
}

void BoardGroup::State::call(bool at_once, const Work& work) {
  align();
  std::vector<std::optional<Recorder>> recorders(boards.size());
  std::vector<std::exception_ptr> errors(boards.size());
  const auto attempt = [&](std::size_t i, const auto& what) {
    try {
      what();
    } catch (...) {
      errors[i] = std::current_exception();
    }
  };
  for (std::size_t i = 0; i < boards.size(); ++i) attempt(i, [&] { recorders[i].emplace(boards[i].state_->device); });
  const auto run = [&](std::size_t i) {
    if (!recorders[i]) return;
    attempt(i, [&] { work(i, *recorders[i]); });
    recorders[i]->end();
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; at_once && i < boards.size(); ++i) threads.emplace_back(run, i);
    for (std::size_t i = 0; i < (at_once ? 1 : boards.size()); ++i) run(i);
  }
  std::vector<std::vector<BusPhase>> phases;
  for (const auto& recorder : recorders) phases.push_back(recorder ? recorder->phases() : std::vector<BusPhase>());
  account(phases);
  for (std::size_t i = 0; i < boards.size(); ++i) {
    if (errors[i]) rethrow(errors[i], names[i]);
  }
}

void BoardGroup::State::render(std::size_t index, const View& view, const BoardState::PicturePart& part,
                               const Progress& progress, Recorder& recorder) {
  BoardState& board = *boards[index].state_;
  const auto lock = board.begin();
  if (part.parts > 0) board.device.need_minor(wire::kPartsMinor, "parts of a picture need");
  std::function<void()> mark;  // one board has no phases, and takes the time of a Board
  if (part.parts > 0) mark = [&recorder] { recorder.mark(); };
  board.render(view, part, index == 0 ? progress : Progress{}, mark);
  recorder.mark();
}

BoardGroup BoardGroup::open(std::span<const std::string> addresses, const GroupOptions& options) {
  expect(!addresses.empty() && addresses.size() <= kMaxBoards, "addresses", fmt::format("1 to {}", kMaxBoards),
         addresses.size());
  expect(addresses.size() == 1 || options.board.capture.empty(), "board.capture", "none for several boards",
         options.board.capture);
  auto state = std::make_unique<State>();
  state->buses = options.buses;
  state->times.resize(addresses.size());
  std::vector<std::vector<BusPhase>> phases;
  OpenOptions of_board = options.board;
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    const std::string place = addresses[i].substr(0, addresses[i].find('?'));
    state->names.push_back(fmt::format("board {} of {} ({}): ", i + 1, addresses.size(), place));
    try {
      state->boards.push_back(Board::open(addresses[i], of_board));
      const Picoseconds opened = state->boards.back().now();
      phases.push_back({{opened, std::min(opened, bus_busy(state->boards.back().state_->device))}});
    } catch (...) {
      rethrow(std::current_exception(), addresses.size() > 1 ? state->names.back() : "");
    }
    if (addresses.size() > 1 && state->buses == HostBuses::kShared && state->boards.back().info().agp) {
      throw BadArgument("buses", "own for boards with AGP, whose port has one card", "shared");
    }
    of_board.while_waiting = {};  // the other boards' threads must not call it
  }
  state->account(phases);
  return BoardGroup(std::move(state));
}

BoardGroup BoardGroup::open(std::string_view address, const GroupOptions& options) {
  const GroupAddress group = parse_group(address);
  GroupOptions how = options;
  how.buses = group.buses.value_or(options.buses);
  return open(group.boards, how);
}

std::size_t BoardGroup::size() const { return state_->boards.size(); }
HostBuses BoardGroup::buses() const { return state_->buses; }

Board& BoardGroup::board(std::size_t index) {
  expect(index < size(), "index", fmt::format("less than {}", size()), index);
  return state_->boards[index];
}

void BoardGroup::on_all(const std::function<void(Board&, std::size_t)>& work) {
  state_->call(false, [&](std::size_t i, Recorder&) { work(state_->boards[i], i); });
}

void BoardGroup::on_all(const std::function<void(Board&)>& work) {
  on_all([&work](Board& board, std::size_t) { work(board); });
}

Image BoardGroup::render(const View& view, const Progress& progress) {
  auto& boards = state_->boards;
  const bool in_bricks =
      std::ranges::any_of(boards, [](const Board& board) { return board.state_->bricks != nullptr; });
  BoardState::PicturePart part;
  if (size() > 1) part = {strip_rows(view, size(), in_bricks), 0, static_cast<std::uint8_t>(size())};
  std::vector<Image> parts(size());
  state_->call(true, [&](std::size_t i, Recorder& recorder) {
    BoardState::PicturePart own = part;
    own.part = static_cast<std::uint8_t>(i);
    state_->render(i, view, own, progress, recorder);
    const bool has_rows = static_cast<int>(i) * part.strip_rows < view.height;
    if (has_rows) parts[i] = boards[i].read_framebuffer();
  });
  if (size() == 1) return std::move(parts[0]);
  return join_rows(view.width, view.height, part.strip_rows, parts);
}

RayBatch BoardGroup::trace(std::span<const HostRay> rays, const RayRequest& request) {
  struct Share {
    std::vector<std::span<const HostRay>> runs;
    std::vector<std::size_t> numbers;  // index of each run's first ray
    RayBatch batch;
  };
  std::vector<Share> shares(size());
  const bool all = leaves_energy(request.type);
  const std::size_t run = all ? std::max<std::size_t>(rays.size(), 1) : rays_at_once(rays.size(), size());
  for (std::size_t first = 0; first < rays.size(); first += run) {
    for (std::size_t i = 0; i < size(); ++i) {
      if (!all && first / run % size() != i) continue;
      shares[i].runs.push_back(rays.subspan(first, std::min(run, rays.size() - first)));
      shares[i].numbers.push_back(first);
    }
  }
  state_->call(true, [&](std::size_t i, Recorder&) {
    Share& share = shares[i];
    if (share.runs.empty() && i > 0) return;
    BoardState& board = *state_->boards[i].state_;
    const auto lock = board.begin();
    board.need_batches();
    const Ticket ticket = board.submit(share.runs, request, share.numbers);
    share.batch = board.batches.receive(ticket, kNoDeadline);
  });
  RayBatch batch = std::move(shares[0].batch);
  batch.completed = now();
  if (all || size() == 1) return batch;
  std::vector<TracedRay> traced(rays.size());
  for (std::size_t i = 0; i < size(); ++i) {
    auto from = (i == 0 ? batch : shares[i].batch).rays.begin();
    for (std::size_t k = 0; k < shares[i].runs.size(); ++k) {
      const auto count = static_cast<std::ptrdiff_t>(shares[i].runs[k].size());
      std::copy_n(from, count, traced.begin() + static_cast<std::ptrdiff_t>(shares[i].numbers[k]));
      from += count;
    }
  }
  batch.rays = std::move(traced);
  return batch;
}

Picoseconds BoardGroup::now() const {
  Picoseconds latest = state_->now;
  for (const Board& board : state_->boards) latest = std::max(latest, board.now());
  return latest;
}

std::vector<BoardTime> BoardGroup::times() const {
  state_->align();
  return state_->times;
}

Counters BoardGroup::counters() {
  std::vector<Counter> sum;
  for (std::size_t i = 0; i < size(); ++i) {
    try {
      const Counters own = state_->boards[i].counters();
      for (const Counter& counter : own.list()) {
        const auto known = std::ranges::find(sum, counter.name, &Counter::name);
        if (known == sum.end()) {
          sum.push_back(counter);
        } else {
          known->value += counter.value;
        }
      }
    } catch (const Error&) {
      rethrow(std::current_exception(), state_->names[i]);
    }
  }
  return Counters(std::move(sum));
}

BoardGroup::BoardGroup(std::unique_ptr<State> state) : state_(std::move(state)) {}
BoardGroup::BoardGroup(BoardGroup&&) noexcept = default;
BoardGroup& BoardGroup::operator=(BoardGroup&&) noexcept = default;
BoardGroup::~BoardGroup() = default;

}  // namespace gicube
