#include "board_slot.h"

#include <filesystem>
#include <future>
#include <utility>

#include <fmt/chrono.h>
#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>

#include "words/finally.h"

namespace gicube::emu {
namespace {

// chosen: work looks at its cancel flag many times a second, so a session that takes longer hangs.
constexpr std::chrono::seconds kReleaseTimeout{10};

}  // namespace

BoardSlot::BoardSlot(std::uint32_t index, const v1::BoardConfig& config, std::unique_ptr<Observation> observation,
                     const RoutineTable* routines)
    : index_(index),
      config_(resolve(config)),
      routines_(routines != nullptr ? routines : &built_in_routines()),
      observation_(std::move(observation)),
      board_(std::make_unique<Board>(config_, config_hash(config_), observation_.get(), routines_)) {}

BoardSlot::~BoardSlot() {
  compute_.join();
  log_fault(observation_.get());
}

void BoardSlot::log_fault(const Observation* observation) const {
  const std::string fault = observation != nullptr ? observation->fault() : "";
  if (!fault.empty()) spdlog::error("board {}: {}", index_, fault);
}

Claim BoardSlot::claim(const Claimant& who) {
  const std::lock_guard lock(mutex_);
  if (!line_.empty() && line_.front() != who.place) return Claim::kBusy;
  if (owner_ == Owner::kManagement || releasing_) return Claim::kSoonFree;
  if (owner_ == Owner::kSession) {
    if (!who.force && !away_) return Claim::kBusy;
    ask_to_end(wire::ErrorCode::kTaken, who.name + (who.force ? " took the board by force" : " came for the board"));
    return Claim::kSoonFree;
  }
  owner_ = Owner::kSession;
  owner_name_ = who.name;
  owner_since_ = std::chrono::system_clock::now();
  ++sessions_;
  end_session_ = who.end_session;
  return Claim::kGranted;
}

void BoardSlot::ask_to_end(wire::ErrorCode error, const std::string& text) {
  if (!end_session_) return;  // it is asked already
  releasing_ = true;
  std::exchange(end_session_, nullptr)(error, text);
}

// A session whose client is away makes way.
bool BoardSlot::take_for_management(std::unique_lock<std::mutex>& lock) {
  if (owner_ == Owner::kSession && away_) {
    ask_to_end(wire::ErrorCode::kCancelled, "the management plane has rebuilt the board");
    released_.wait_for(lock, kReleaseTimeout, [this] { return owner_ == Owner::kNone; });
  }
  if (owner_ != Owner::kNone) return false;
  owner_ = Owner::kManagement;
  return true;
}

std::string BoardSlot::owner() const {
  const std::lock_guard lock(mutex_);
  if (owner_ == Owner::kNone) return {};
  if (owner_ == Owner::kManagement) return "the management plane";
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now() - owner_since_);
  return fmt::format("{} since {:%F %T} UTC, {} s ago", owner_name_,
                     fmt::gmtime(std::chrono::system_clock::to_time_t(owner_since_)), seconds.count());
}

void BoardSlot::settle() {
  const auto settled = std::make_shared<std::promise<void>>();
  boost::asio::post(compute_, [settled] { settled->set_value(); });
  settled->get_future().wait();
}

BoardSlot::Configured BoardSlot::configure(std::string_view text, std::vector<Diagnostic>& found) {
  ParsedConfig parsed = parse_config(text);
  std::unique_lock lock(mutex_);
  v1::BoardConfig merged = config_;
  merged.MergeFrom(parsed.config);
  found = std::move(parsed.diagnostics);
  for (Diagnostic& each : check(merged, parsed.lines)) found.push_back(std::move(each));
  if (!found.empty()) return Configured::kFaulty;
  if (!take_for_management(lock)) return Configured::kInUse;
  lock.unlock();
  // Allocating a large board takes a while, so the lock is not held; the claim keeps everyone else out.
  const Finally released{[this] { release(); }};
  auto rebuilt = std::make_unique<Board>(merged, config_hash(merged), observation_.get(), routines_);
  const std::lock_guard swapping(mutex_);
  board_.swap(rebuilt);
  config_ = std::move(merged);
  return Configured::kDone;
}

BoardSlot::Configured BoardSlot::set_trace_file(const std::string& file, std::string& reason) {
  std::unique_lock lock(mutex_);
  if (observation_ && !observation_->options().vcd_file.empty()) {
    reason = "trace: expected a board without --vcd, got one that writes " + observation_->options().vcd_file;
    return Configured::kFaulty;
  }
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) {
    reason = "file: expected the name of a new file, got " + file;
    return Configured::kFaulty;
  }
  if (!take_for_management(lock)) return Configured::kInUse;
  const v1::BoardConfig config = config_;
  lock.unlock();
  // As in configure(). The board is gone before what it speaks to, and both before the release.
  const Finally released{[this] { release(); }};
  std::unique_ptr<Observation> observation;
  std::unique_ptr<Board> board;
  try {
    if (!file.empty()) observation = std::make_unique<Observation>(ObservationOptions{file, {}, {}});
    board = std::make_unique<Board>(config, config_hash(config), observation.get(), routines_);
    const std::lock_guard swapping(mutex_);
    board_.swap(board);
    observation_.swap(observation);
  } catch (const std::exception& error) {
    reason = error.what();
    return Configured::kFaulty;
  }
  board.reset();
  log_fault(observation.get());
  return Configured::kDone;
}

bool BoardSlot::power_reset() {
  std::unique_lock lock(mutex_);
  const std::uint64_t session = sessions_;
  if (owner_ == Owner::kSession) ask_to_end(wire::ErrorCode::kCancelled, "the management plane has reset the board");
  // A session that ends resets the board; one that came after it has found it so.
  const auto ended = [this, session] { return owner_ == Owner::kNone || sessions_ != session; };
  if (!released_.wait_for(lock, kReleaseTimeout, ended)) return false;
  if (owner_ != Owner::kNone) return true;
  owner_ = Owner::kManagement;
  lock.unlock();
  board_->reset();
  release();
  return true;
}

}  // namespace gicube::emu
