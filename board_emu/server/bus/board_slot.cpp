#include "board_slot.h"

#include <algorithm>
#include <filesystem>
#include <future>
#include <stdexcept>
#include <utility>

#include <fmt/chrono.h>
#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>

#include "words/scope_exit.h"

namespace gicube::emu {
namespace {

// chosen: work checks its cancel flag many times per second, so a session that takes longer is stuck.
constexpr std::chrono::seconds kReleaseTimeout{10};
constexpr std::chrono::milliseconds kCancelCheck{50};  // chosen: latency for detecting a cancelled call

bool is_true(const Cancelled& cancelled) { return cancelled && cancelled(); }

SavedSurroundings surroundings_of(const Checkpoint& checkpoint) {
  SavedSurroundings saved;
  checkpoint.surroundings([&saved](Archive& archive) { archive("host", saved); });
  return saved;
}

constexpr const char* kNoMemory = "the system has no memory left for the board";

}  // namespace

BoardSlot::BoardSlot(std::uint32_t index, const v1::BoardConfig& config, const ObservationOptions& observation,
                     const RoutineTable* routines, std::uint64_t max_memory_bytes,
                     std::shared_ptr<const Checkpoint> start)
    : index_(index),
      config_(resolve(config)),
      routines_(routines != nullptr ? routines : &built_in_routines()),
      max_memory_bytes_(max_memory_bytes),
      start_(std::move(start)),
      observation_(std::make_unique<Observation>(observation, &debugger_)),
      board_(BoardSlot::build(config_, observation_.get())) {
  if (start_) faults_.restore(surroundings_of(*start_).faults);
}

BoardSlot::~BoardSlot() {
  debugger_.let_go();
  compute_.join();
  log_fault(observation_.get());
}

std::unique_ptr<Board> BoardSlot::build(const v1::BoardConfig& config, Observation* observation) const {
  return build_from(start_.get(), config, observation);
}

std::unique_ptr<Board> BoardSlot::build_from(const Checkpoint* start, const v1::BoardConfig& config,
                                             Observation* observation) const {
  auto board = std::make_unique<Board>(config, config_hash(config), observation, routines_, max_memory_bytes_);
  if (start != nullptr) start->restore(*board);
  return board;
}

void BoardSlot::save(std::vector<std::uint8_t> driver, const std::function<void(std::string_view)>& sink) {
  SavedSurroundings around{faults_.saved(), std::move(driver)};
  save_checkpoint(*board_, sink, [&around](Archive& archive) { archive("host", around); });
}

std::vector<std::uint8_t> BoardSlot::restore(const Checkpoint& checkpoint, bool takes_plan) {
  SavedSurroundings saved = surroundings_of(checkpoint);
  const bool same_plan = saved.faults.plan_text == faults_.info().plan_text;
  if (!same_plan && !takes_plan && !saved.faults.plan_text.empty()) {
    throw CheckpointFault("host.faults.plan", "the plan of this board process (gicube-board --faults)", "another");
  }
  auto fresh = build_from(&checkpoint, config_, observation_.get());
  if (same_plan || takes_plan) faults_.restore(saved.faults);
  replace(std::move(fresh));
  return std::move(saved.driver);
}

std::vector<std::uint8_t> BoardSlot::restore_start(bool is_new) {
  SavedSurroundings saved = surroundings_of(*start_);
  if (!is_new) replace(build(config_, observation_.get()));
  if (saved.faults.plan_text == faults_.info().plan_text) faults_.restore(saved.faults);
  return std::move(saved.driver);
}

void BoardSlot::renew(std::string& why) {
  why.clear();
  drop_board();
  try {
    replace(build(config_, observation_.get()));
  } catch (const std::bad_alloc&) {
    why = kNoMemory;
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (!why.empty()) spdlog::error("board {} could not be rebuilt: {}; the next session tries again", index_, why);
}

void BoardSlot::log_fault(const Observation* observation) const {
  const std::string fault = observation != nullptr ? observation->fault() : "";
  if (!fault.empty()) spdlog::error("board {}: {}", index_, fault);
}

Claim BoardSlot::claim(const Claimant& who) {
  const std::lock_guard lock(mutex_);
  if (!queue_.empty() && queue_.front() != who.place) return Claim::kBusy;
  if (owner_ == Owner::kManagement || releasing_) return Claim::kSoonFree;
  if (owner_ == Owner::kSession) {
    if (!who.force && !away_) return Claim::kBusy;
    const bool forces = !away_;
    ask_to_end(wire::ErrorCode::kTaken,
               who.name + (forces ? " took the board by force" : " took the board while its client was away"));
    return forces ? Claim::kForced : Claim::kSoonFree;
  }
  owner_ = Owner::kSession;
  owner_name_ = who.name;
  owner_since_ = std::chrono::system_clock::now();
  owner_began_ = std::chrono::steady_clock::now();
  ++sessions_;
  end_session_ = who.end_session;
  return Claim::kGranted;
}

void BoardSlot::ask_to_end(wire::ErrorCode error, const std::string& text) {
  if (!end_session_) return;  // it was already asked to end
  releasing_ = true;
  debugger_.let_go();
  std::exchange(end_session_, nullptr)(error, text);
}

bool BoardSlot::wait_until(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled,
                           const std::function<bool()>& free) {
  const auto end = std::chrono::steady_clock::now() + kReleaseTimeout;
  while (!free()) {
    if (is_true(cancelled) || std::chrono::steady_clock::now() > end) return false;
    released_.wait_for(lock, kCancelCheck);
  }
  return true;
}

// A session whose client is away yields the board.
bool BoardSlot::take_for_management(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled) {
  const auto is_free = [this] { return owner_ == Owner::kNone; };
  if (owner_ == Owner::kSession && away_) {
    ask_to_end(wire::ErrorCode::kCancelled, "the management plane has rebuilt the board");
    wait_until(lock, cancelled, is_free);
  }
  if (!is_free()) return false;
  owner_ = Owner::kManagement;
  return true;
}

BoardSlot::Configured BoardSlot::manage(std::unique_lock<std::mutex>& lock, std::string& reason,
                                        const Cancelled& cancelled, const std::function<Configured()>& work) {
  if (is_true(cancelled)) return Configured::kCancelled;
  if (!take_for_management(lock, cancelled)) return Configured::kInUse;
  lock.unlock();
  const ScopeExit released{[this] { release(); }};
  try {
    return work();
  } catch (const std::bad_alloc&) {
    reason = kNoMemory;
    return Configured::kFailed;
  } catch (const std::exception& error) {
    reason = error.what();
    return Configured::kFaulty;
  }
}

std::string BoardSlot::owner() const {
  const std::lock_guard lock(mutex_);
  if (owner_ == Owner::kNone) return {};
  if (owner_ == Owner::kManagement) return "the management plane";
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - owner_began_);
  return fmt::format("{} since {:%F %T} UTC, {} s ago", owner_name_,
                     fmt::gmtime(std::chrono::system_clock::to_time_t(owner_since_)), seconds.count());
}

void BoardSlot::settle() {
  const auto settled = std::make_shared<std::promise<void>>();
  boost::asio::post(compute_, [settled] { settled->set_value(); });
  settled->get_future().wait();
}

BoardSlot::Configured BoardSlot::configure(std::string_view text, std::string& reason, const Cancelled& cancelled) {
  ParsedConfig parsed = parse_config(text);
  std::unique_lock lock(mutex_);
  v1::BoardConfig merged = config_;
  merged.MergeFrom(parsed.config);
  std::vector<Diagnostic> found = std::move(parsed.diagnostics);
  for (Diagnostic& each : check(merged, parsed.lines)) found.push_back(std::move(each));
  if (start_) {
    for (Diagnostic& each : fork_faults(start_->header().config(), merged, start_->header().in_command()))
      found.push_back(std::move(each));
  }
  reason = to_string(found);
  if (!found.empty()) return Configured::kFaulty;
  if (wants_approximate(merged)) spdlog::warn("board {}: {}", index_, kApproximateIsCycle);
  merged = resolve(merged);
  return manage(lock, reason, cancelled, [&] {
    auto rebuilt = build(merged, observation_.get());
    if (is_true(cancelled)) return Configured::kCancelled;
    const std::scoped_lock swapping(saving_, mutex_);
    board_.swap(rebuilt);
    config_ = std::move(merged);
    return Configured::kDone;
  });
}

BoardSlot::Configured BoardSlot::set_trace_file(const std::string& file, std::string& reason,
                                                const Cancelled& cancelled) {
  std::unique_lock lock(mutex_);
  const ObservationOptions& now = observation_->options();
  for (const std::string& other : {now.vcd_file, now.event_file, now.observer_file}) {
    if (other.empty()) continue;
    reason = "trace: expected a board without --vcd, --events and --observer, got one with " + other;
    return Configured::kFaulty;
  }
  return manage(lock, reason, cancelled, [&] {
    ObservationOptions options;
    options.trace_file = file;
    options.trace_creation = Creation::kNew;
    auto observation = std::make_unique<Observation>(options, &debugger_);
    auto board = build(config_, observation.get());
    {
      const std::scoped_lock swapping(saving_, mutex_);
      board_.swap(board);
      observation_.swap(observation);
    }
    board.reset();  // before its observation
    log_fault(observation.get());
    return Configured::kDone;
  });
}

// The file is written on the board's own thread: between two transactions, within a command, or while the debugger
// pauses one. A caller that gives up before it is begun gets no file; once begun, it is written whole.
BoardSlot::Configured BoardSlot::save(const std::string& file, Saved& saved, std::string& reason,
                                      const Cancelled& cancelled) {
  struct Answer {
    std::atomic<bool> unwanted{false};
    std::atomic<bool> is_taken{false};  // set by the first of the three ways to the board's thread
    Saved saved;
    std::string reason;
    std::promise<Configured> done;
  };
  const auto answer = std::make_shared<Answer>();
  const auto job = [this, answer, file] {
    if (answer->unwanted || answer->is_taken.exchange(true)) return;
    const std::lock_guard here(saving_);
    Configured result = Configured::kDone;
    try {
      if (!board_) throw std::runtime_error("expected a board, got none because it could not be built");
      if (std::filesystem::exists(std::filesystem::symlink_status(file)))
        throw std::runtime_error("file: expected a new one, got " + file);
      SavedSurroundings around{faults_.saved()};
      save_checkpoint(*board_, std::filesystem::path(file), [&around](Archive& archive) { archive("host", around); });
      answer->saved = {board_->simulated_ps(), std::filesystem::file_size(file)};
    } catch (const std::exception& error) {
      answer->reason = error.what();
      result = Configured::kFaulty;
    }
    answer->done.set_value(result);
  };
  std::future<Configured> done = answer->done.get_future();
  boost::asio::post(compute_, job);
  {
    const std::lock_guard lock(mutex_);
    if (board_) board_->at_next_moment(job);
  }
  while (done.wait_for(kCancelCheck) != std::future_status::ready) {
    if (!answer->is_taken) debugger_.offer(job);
    if (!is_true(cancelled)) continue;
    answer->unwanted = true;
    return Configured::kCancelled;
  }
  saved = answer->saved;
  reason = answer->reason;
  return done.get();
}

BoardSlot::Configured BoardSlot::power_reset(std::string& reason, const Cancelled& cancelled) {
  std::unique_lock lock(mutex_);
  const std::uint64_t session = sessions_;
  if (owner_ == Owner::kSession) ask_to_end(wire::ErrorCode::kCancelled, "the management plane has reset the board");
  // A session that ends leaves a new board. A session that started after it already has that board.
  const auto ended = [this, session] { return owner_ == Owner::kNone || sessions_ != session; };
  if (!wait_until(lock, cancelled, ended)) return is_true(cancelled) ? Configured::kCancelled : Configured::kInUse;
  if (owner_ != Owner::kNone) return Configured::kDone;
  owner_ = Owner::kManagement;
  lock.unlock();
  const ScopeExit released{[this] { release(); }};
  renew(reason);
  return reason.empty() ? Configured::kDone : Configured::kFailed;
}

}  // namespace gicube::emu
