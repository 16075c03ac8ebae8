// Traces that the management plane begins and ends.
#include <exception>
#include <filesystem>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/bus/board_slot.h"

namespace gicube::emu {

std::string BoardSlot::trace_file() const {
  const std::lock_guard lock(mutex_);
  return observation_ ? observation_->options().trace_file : std::string();
}

BoardSlot::Configured BoardSlot::set_trace_file(const std::string& file, std::string& reason) {
  v1::BoardConfig config;
  {
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
    end_away(lock);
    if (owner_ != Owner::kNone) return Configured::kInUse;
    owner_ = Owner::kManagement;
    config = config_;
  }
  // As in configure(): the claim keeps everyone else out. The board is gone before what it speaks to.
  std::unique_ptr<Observation> observation;
  std::unique_ptr<Board> board;
  Configured result = Configured::kDone;
  try {
    if (!file.empty()) observation = std::make_unique<Observation>(ObservationOptions{file, {}, {}});
    board = std::make_unique<Board>(config, config_hash(config), observation.get(), routines_);
    const std::lock_guard lock(mutex_);
    board_.swap(board);
    observation_.swap(observation);
  } catch (const std::exception& error) {
    reason = error.what();
    result = Configured::kFaulty;
  }
  board.reset();
  const std::string incomplete = observation ? observation->fault() : "";
  if (!incomplete.empty()) spdlog::error("board {}: {}", index_, incomplete);
  observation.reset();
  release();
  return result;
}

}  // namespace gicube::emu
